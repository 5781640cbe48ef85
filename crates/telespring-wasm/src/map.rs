//! What is stable over stiffness and delay.

use serde_json::{Value, json};
use telespring::criteria::{paper_critical_stiffness, paper_maximum_delay, stable_delays};
use telespring::decision::{Question, stiffness_limit};
use telespring::study::Study;
use telespring::verdicts::{Network, Tier, delay_limit, sampled_stable_delays};
use telespring::{InvalidInput, Result};

use crate::answer::{at_mean, cases};
use crate::mean_delay;

/// A stiffness to ask the verdicts for their bounds, which do not depend on it, N/m.
const PROBE: f64 = 1.0;
/// Up to this multiple of the largest delay drawn the intervals are listed, so that a boundary may leave the map.
const HORIZON: f64 = 1.25;
/// The most columns of a map.
const MOST_COLUMNS: usize = 2000;

/// Intervals of the mean one-way delay, s, ascending.
type Intervals = Vec<(f64, f64)>;

/// The stable delays, s, of each of `columns` stiffnesses up to `stiffness` N/m: at a constant delay, for the handles as
/// they are held and free, with the study's controllers. Jitter and gaps are taken up by a buffer; the delay of the map is
/// the shortest one. Also the paper's longest delay at each stiffness.
///
/// # Errors
///
/// [`InvalidInput`] if the extent is not positive, or as [`stable_delays`].
pub fn map(study: &Study, stiffness: f64, delay: f64, columns: usize) -> Result<Value> {
    let is_extent = stiffness.is_finite() && stiffness > 0.0 && delay.is_finite() && delay > 0.0;
    if !is_extent || !(1..=MOST_COLUMNS).contains(&columns) {
        return Err(InvalidInput::new(
            "map",
            format!("{stiffness} N/m, {delay} s, {columns} columns"),
            "a map has a positive extent and up to 2000 columns",
            "Give other ones.",
        ));
    }
    let cases = cases(study, Some(at_mean(study, mean_delay(study))?))?;
    let at: Vec<f64> = (1..=columns).map(|column| stiffness * column as f64 / columns as f64).collect();
    let mut stable = Vec::with_capacity(columns);
    for &k in &at {
        stable.push(stable_at(&cases, k, delay)?);
    }
    // The paper has formulas for free handles only.
    let free = cases.last();
    let paper: Vec<Option<f64>> = at.iter().map(|&k| free.and_then(|free| paper_delay(free, k))).collect();
    Ok(json!({
        "stiffness": at,
        "stable": stable,
        "paper": paper,
        "paper_critical": free.and_then(paper_critical),
        "extra": cases.iter().map(extra).fold(0.0, f64::max),
    }))
}

/// What jitter and gaps add to the mean delay behind a buffer, s.
fn extra(question: &Question) -> f64 {
    question.network.buffered_mean() - question.network.delay().mean()
}

/// The stable intervals of the shortest mean delay in all cases and on all axes, s.
fn stable_at(cases: &[Question], k: f64, longest: f64) -> Result<Intervals> {
    let mut all = vec![(0.0, f64::MAX)];
    for question in cases {
        let extra = extra(question);
        let horizon = HORIZON * longest + extra;
        let shifted = |found: Intervals| -> Intervals {
            found.into_iter().map(|(start, end)| (start - extra, end - extra)).collect()
        };
        if question.operator_ranges.is_some() {
            let limit = delay_limit(&question.dyad, question.operator_ranges.as_ref(), k, &question.network)?;
            all = both(&all, &shifted(vec![(0.0, limit.delay.min(horizon))]));
            continue;
        }
        let network = behind_buffer(&question.network)?;
        for axis in question.dyad.axes() {
            all = both(&all, &shifted(stable_delays(&axis, k, horizon)?));
            if network.sample_period() > 0.0 && !all.is_empty() {
                // A list that is cut at a whole period must end beyond the map.
                let farther = horizon + 2.0 * network.sample_period();
                all = both(&all, &shifted(sampled_stable_delays(&axis, k, &network, farther)?));
            }
        }
    }
    Ok(all.into_iter().filter(|(_, end)| *end > 0.0).map(|(start, end)| (start.max(0.0), end)).collect())
}

/// The same controllers over the constant delay behind a buffer.
fn behind_buffer(network: &Network) -> Result<Network> {
    let [forward, backward] = network.buffered();
    let delay = telespring::Delay::new(forward, backward)?;
    Network::new(delay, 0.0, 0.0, network.sample_period(), network.computing_time())
}

/// What lies in both lists of intervals.
fn both(one: &Intervals, other: &Intervals) -> Intervals {
    let pairs = one.iter().flat_map(|first| other.iter().map(move |second| (first, second)));
    pairs
        .map(|(first, second)| (first.0.max(second.0), first.1.min(second.1)))
        .filter(|(start, end)| start < end)
        .collect()
}

/// The paper's longest delay on any axis, s; `None` if it has none, or no formula.
fn paper_delay(question: &Question, k: f64) -> Option<f64> {
    let delays: Option<Vec<f64>> =
        question.dyad.axes().map(|axis| paper_maximum_delay(&axis, k).ok()).collect();
    delays?.into_iter().reduce(f64::min).filter(|delay| delay.is_finite())
}

/// The paper's critical stiffness over all axes, N/m.
fn paper_critical(question: &Question) -> Option<f64> {
    let bounds: Option<Vec<f64>> =
        question.dyad.axes().map(|axis| paper_critical_stiffness(&axis).ok()).collect();
    bounds?.into_iter().reduce(f64::min)
}

/// The largest stiffness, N/m, that each verdict proves at one mean delay (s) of the study's network, over the handles as
/// they are held and free: `allowed` while the delay varies, `age` and `bounded` by the verdicts of those names, and
/// `constant` behind a buffer. `null` is no limit, 0 no rule.
///
/// # Errors
///
/// As [`verdicts`](telespring::verdicts::verdicts()).
pub fn bounds(study: &Study, delay: f64) -> Result<Value> {
    let (mut allowed, mut constant) = (f64::INFINITY, f64::INFINITY);
    let mut tiers = [f64::INFINITY; 5];
    for question in cases(study, Some(at_mean(study, delay)?))? {
        let judged = question.judge(PROBE)?;
        allowed = allowed.min(question.allowed(&judged).map_or(0.0, |allowed| allowed.stiffness));
        constant = constant.min(stiffness_limit(&judged));
        for (least, verdict) in tiers.iter_mut().zip(&judged.tiers) {
            *least = least.min(verdict.stiffness_bound.unwrap_or(0.0));
        }
    }
    let of = |tier: Tier| tiers[tier as usize];
    Ok(json!({
        "delay": delay,
        "allowed": allowed,
        "age_in_a_range": of(Tier::AgeInRange),
        "bounded_varying_delay": of(Tier::BoundedVaryingDelay),
        "any_network": of(Tier::AnyNetwork),
        "any_constant_delay": of(Tier::AnyConstantDelay),
        "constant_delay": constant,
    }))
}
