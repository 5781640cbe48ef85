//! The answer to a study, in the words and keys of `telespring decide --json`.

use serde_json::{Value, json};
use telespring::decision::{
    Decision, Question, RESERVE, constant_delay, is_axis_stable, tier_stiffness_limit,
};
use telespring::study::Study;
use telespring::verdicts::{Assumption, Tier, Verdict};
use telespring::{Delay, Result};

/// The question about a study as it holds its handles and, where anything does, about free handles too.
///
/// # Errors
///
/// As [`Question::of_study`].
pub fn cases(study: &Study, delay: Option<Delay>) -> Result<Vec<Question>> {
    let stated = Question::of_study(study, delay, [None, None])?;
    let free = if stated.is_held() { Some(stated.released()?) } else { None };
    Ok([stated].into_iter().chain(free).collect())
}

/// The answer at the study's stiffness and delay. The keys are those of `telespring decide --json` (docs/study-json.md), as
/// far as a page shows them.
///
/// # Errors
///
/// [`InvalidInput`](telespring::InvalidInput) if the study has no stiffness or no delay, or as
/// [`verdicts`](telespring::verdicts::verdicts()).
pub fn decide(study: &Study) -> Result<Value> {
    let stiffness = study.coupling()?.stiffness;
    let stated = *study.network()?;
    let mut answers = cases(study, None)?
        .iter()
        .map(|question| Ok(decision_json(question, &question.decide(stiffness)?, stated.delay())))
        .collect::<Result<Vec<_>>>()?;
    let free = if answers.len() > 1 { answers.pop() } else { None };
    let mut answer = answers.pop().unwrap_or_default();
    answer["free"] = free.unwrap_or_default();
    Ok(answer)
}

/// The lowest stiffness at which an attack was found, with the study's network at this mean delay (s).
///
/// # Errors
///
/// As [`decide`].
pub fn attack(study: &Study, delay: f64, seed: u64) -> Result<Value> {
    let mut found: Option<f64> = None;
    for question in cases(study, Some(at_mean(study, delay)?))? {
        if question.is_bounded() && !question.network.is_constant() {
            let judged = question.judge(study.coupling()?.stiffness)?.with_attack(&question.dyad, seed);
            found = judged.tier(Tier::AgeInRange).attack.into_iter().chain(found).reduce(f64::min);
        }
    }
    Ok(json!({ "delay": delay, "stiffness": found }))
}

/// The delay of both ways with this mean (s), in the study's proportion.
///
/// # Errors
///
/// [`InvalidInput`](telespring::InvalidInput) if it is out of range.
pub fn at_mean(study: &Study, mean: f64) -> Result<Delay> {
    let own = study.network().map(|network| network.delay());
    match own {
        Ok(own) if own.mean() > 0.0 => {
            Delay::new(mean * (own.forward() / own.mean()), mean * (own.backward() / own.mean()))
        }
        _ => Delay::each_way(mean),
    }
}

fn decision_json(question: &Question, decision: &Decision, stated: Delay) -> Value {
    let verdicts = &decision.verdicts;
    let [forward, backward] = decision.constant_delay();
    let limit = decision.stiffness_limit();
    json!({
        "stiffness": verdicts.stiffness,
        "delay": { "forward": stated.forward(), "backward": stated.backward(), "mean": stated.mean() },
        "constant_delay": {
            "forward": forward,
            "backward": backward,
            "mean": 0.5 * (forward + backward),
            "buffered": constant_delay(verdicts) != [verdicts.network.delay().forward(), verdicts.network.delay().backward()],
            "status": decision.constant_delay_status.word(),
        },
        "playout_buffer": question.has_playout_buffer,
        "varying_delay": varying_json(decision),
        "status": decision.status.word(),
        "stable": decision.is_stable(),
        "reserve": {
            "required": RESERVE,
            "stiffness_kept": decision.keeps_stiffness_reserve,
            "delay_kept": decision.keeps_delay_reserve,
        },
        "sample_period": verdicts.network.sample_period(),
        "axes": axes_json(decision),
        "verdicts": verdicts_json(question, decision),
        "paper_agrees": verdicts.paper.agrees,
        "sampled_stable": verdicts.sampled_stable,
        "over_operator_ranges": question.operator_ranges.is_some(),
        "remedies": {
            "stiffness": finite(limit),
            "stiffness_unbounded": limit.is_infinite(),
            "delay": finite(decision.delay_limit.delay),
            "delay_unbounded": decision.delay_limit.delay.is_infinite(),
            "delay_attained": decision.delay_limit.attained,
            "delay_proven": decision.delay_limit.proven,
        },
    })
}

/// A number, or `None` if it is infinite or not a number.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn varying_json(decision: &Decision) -> Value {
    let Some(varying) = &decision.varying else { return Value::Null };
    json!({
        "status": varying.status.word(),
        "stiffness_limit": finite(varying.stiffness_limit),
        "stiffness_unbounded": varying.stiffness_limit.is_infinite(),
        "attained": varying.is_attained,
        "usable_stiffness": finite(varying.usable_stiffness),
        "verdict": varying.tier.map(Tier::name),
    })
}

fn axes_json(decision: &Decision) -> Vec<Value> {
    decision
        .verdicts
        .axes
        .iter()
        .map(|axis| {
            let bound = |tier: Tier| axis.tiers[tier as usize].stiffness_bound;
            let critical = bound(Tier::AnyConstantDelay);
            let most = bound(Tier::ConstantDelay);
            json!({
                "axis": axis.name,
                "critical_stiffness": critical.and_then(finite),
                "critical_stiffness_unbounded": critical.is_some_and(f64::is_infinite),
                "maximum_delay": finite(axis.maximum_delay),
                "maximum_delay_unbounded": axis.maximum_delay.is_infinite(),
                "maximum_stiffness": most.and_then(finite),
                "maximum_stiffness_unbounded": most.is_some_and(f64::is_infinite),
                "sampled_abscissa": axis.sampled.map(|sampled| sampled.abscissa_equivalent).and_then(finite),
                "stable": is_axis_stable(axis),
            })
        })
        .collect()
}

/// The keys of the verdicts in `telespring decide --json`.
fn key(tier: Tier) -> String {
    tier.name().replace(' ', "_")
}

fn verdicts_json(question: &Question, decision: &Decision) -> Value {
    let verdicts = &decision.verdicts;
    let mut found = serde_json::Map::new();
    for verdict in &verdicts.tiers {
        found.insert(key(verdict.tier), verdict_json(question, decision, verdict));
    }
    let paper = &verdicts.paper;
    found.insert(
        "paper".to_owned(),
        json!({
            "name": "paper",
            "stiffness_allowed": finite(paper.critical_stiffness),
            "satisfied": paper.stable,
            "maximum_delay": finite(paper.maximum_delay),
            "maximum_delay_unbounded": paper.maximum_delay.is_infinite(),
        }),
    );
    Value::Object(found)
}

/// Whether the ages in use meet the assumption of a tier, in a word.
fn assumption(question: &Question, verdict: &Verdict) -> &'static str {
    match question.assumption(verdict) {
        None => "not met",
        Some(Assumption::Met) => "met",
        Some(_) => "met behind playout buffer",
    }
}

fn verdict_json(question: &Question, decision: &Decision, verdict: &Verdict) -> Value {
    let own = tier_stiffness_limit(&decision.verdicts, verdict.tier);
    json!({
        "name": verdict.tier.name(),
        "stiffness_allowed": verdict.stiffness_bound.and_then(finite),
        "stiffness_unbounded": verdict.stiffness_bound.is_some_and(f64::is_infinite),
        "stiffness_limit": own.and_then(finite),
        "attained": verdict.attained,
        "axis": verdict.worst_axis.map(|axis| decision.verdicts.axes[axis].name.clone()),
        "satisfied": verdict.satisfied,
        "proven": verdict.proven,
        "assumption": assumption(question, verdict),
        "available": verdict.stiffness_bound.is_some(),
        "ages": verdict.ages,
    })
}
