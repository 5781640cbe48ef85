//! A dyad over a network, for one pair of operators or for ranges of them.

use std::sync::Arc;

use super::varying::varying_delay;
use super::{
    Decision, Knowledge, RESERVE, Status, VaryingDelay, constant_delay, is_stable, is_within, status,
    stiffness_limit,
};
use crate::error::Result;
use crate::model::{Delay, Dyad, Operator};
use crate::quantity;
use crate::rig::Trace;
use crate::study::{JudgedNetwork, Study};
use crate::verdicts::{
    Allowed, Assumption, DelayLimit, Network, OperatorRange, Tier, Verdict, Verdicts, delay_limit,
    is_stable_over_delays, is_stable_over_stiffnesses, verdicts,
};

/// What is asked about a dyad and its network, judged at any stiffness.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// The robots, and their operators unless these are ranges.
    pub dyad: Dyad,
    /// The ranges of both operators; `None` for the dyad's own.
    pub operator_ranges: Option<[OperatorRange; 2]>,
    /// The network and the timing of the controllers.
    pub network: Network,
    /// Whether both sides promise to hold every sample until it is as old as the latest one, which makes the delay constant.
    pub has_playout_buffer: bool,
    /// The robots' own springs to the ground, which the operators include and which stay when hands let go.
    pub robot_springs: Option<[Operator; 2]>,
    /// What a study's network and session make of the ages in use; `None` where the network alone makes them.
    pub ages: Option<JudgedNetwork>,
}

impl Question {
    /// The question about a dyad with its own operators over a network without anything else.
    pub fn of_network(dyad: Dyad, network: Network) -> Self {
        Self {
            dyad,
            operator_ranges: None,
            network,
            has_playout_buffer: false,
            robot_springs: None,
            ages: None,
        }
    }

    /// The question of a study, with the ages that its network and session make of each motion; see
    /// [`Study::judged_network`].
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) as [`Study::judged_network`].
    pub fn of_study(study: &Study, delay: Option<Delay>, traces: [Option<Arc<Trace>>; 2]) -> Result<Self> {
        let judged = study.judged_network(delay, traces)?;
        Ok(Self {
            dyad: study.dyad().clone(),
            operator_ranges: study.operator_ranges().cloned(),
            network: judged.network,
            has_playout_buffer: judged.has_playout_buffer,
            robot_springs: robot_springs(study)?,
            ages: Some(judged),
        })
    }

    /// Whether the ages of the motion in use have a bound.
    pub fn is_bounded(&self) -> bool {
        self.ages.as_ref().is_none_or(|judged| judged.ages.is_some())
    }

    /// Whether delay, jitter and gap are all that makes the ages: a playout buffer takes them up.
    pub fn is_as_stated(&self) -> bool {
        self.ages.as_ref().is_none_or(|judged| judged.is_as_stated)
    }

    /// Whether something is not judged, so that nothing is proven.
    pub fn has_unjudged(&self) -> bool {
        self.ages.as_ref().is_some_and(|judged| !judged.unjudged.is_empty())
    }

    /// Whether the age of the motion in use varies, if nobody promises a playout buffer.
    pub fn is_varying(&self) -> bool {
        !(self.network.is_constant() && self.is_bounded())
    }

    /// Constant delays that the network may keep for long: one that is unstable is enough.
    pub(super) fn lasting(&self) -> Vec<Delay> {
        if let Some(judged) = &self.ages {
            return judged.lasting.clone();
        }
        let (delay, [forward, backward]) = (self.network.delay(), self.network.jitters());
        let latest = Delay::new(delay.forward() + forward, delay.backward() + backward);
        [delay].into_iter().chain(latest.ok()).collect()
    }

    /// Whether anything holds a handle besides the robot's own spring.
    pub fn is_held(&self) -> bool {
        let free = || Operator::free(self.dyad.axis_names().len());
        let springs = self.robot_springs.clone().unwrap_or_else(|| [free(), free()]);
        let held = match &self.operator_ranges {
            Some(ranges) => ranges.each_ref().map(OperatorRange::high),
            None => self.dyad.operators().each_ref(),
        };
        held.into_iter().zip(&springs).any(|(operator, spring)| {
            operator.mass().iter().chain(operator.damping()).any(|value| *value != 0.0)
                || operator.stiffness() != spring.stiffness()
        })
    }

    /// The question with free handles: only the robots' own springs to the ground stay.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) if the springs do not have the dyad's axes.
    pub fn released(&self) -> Result<Self> {
        let [one, two] = self.dyad.robots();
        let springs = self.robot_springs.clone();
        let dyad = Dyad::new(one.clone(), two.clone(), springs, self.dyad.coupling_damping())?;
        Ok(Self { dyad, operator_ranges: None, ..self.clone() })
    }

    /// Whether the ages in use meet the assumption of a tier's verdict; `None` if they do not.
    pub fn assumption(&self, verdict: &Verdict) -> Option<Assumption> {
        if self.has_unjudged() {
            return None;
        }
        if !self.is_bounded() {
            return (verdict.tier == Tier::AnyNetwork).then_some(Assumption::Met);
        }
        // No buffer takes up what is lost, queued or forged.
        (verdict.assumption == Assumption::Met || self.is_as_stated()).then_some(verdict.assumption)
    }

    /// The largest stiffness of the tiers whose assumption the ages in use meet without a playout buffer; `None` if none of
    /// these has a rule. Where something is not judged, it proves nothing.
    pub fn allowed(&self, judged: &Verdicts) -> Option<Allowed> {
        if self.is_bounded() {
            return judged.stiffness_allowed;
        }
        let anything = judged.tier(Tier::AnyNetwork);
        let allowed = |stiffness| Allowed { stiffness, attained: anything.attained, tier: anything.tier };
        anything.stiffness_bound.map(allowed)
    }

    /// The verdicts on the question at a stiffness, N/m.
    ///
    /// # Errors
    ///
    /// As [`verdicts`](crate::verdicts::verdicts()).
    pub fn judge(&self, stiffness: f64) -> Result<Verdicts> {
        verdicts(&self.dyad, self.operator_ranges.as_ref(), stiffness, &self.network)
    }

    /// The answer to the question at a stiffness, N/m.
    ///
    /// # Errors
    ///
    /// As [`verdicts`](crate::verdicts::verdicts()).
    pub fn decide(&self, stiffness: f64) -> Result<Decision> {
        self.decision(self.judge(stiffness)?, Knowledge::default())
    }

    /// The answer that follows from the verdicts of [`judge`](Self::judge) and from what is known beside them.
    ///
    /// # Errors
    ///
    /// As [`verdicts`](crate::verdicts::verdicts()).
    pub fn decision(&self, verdicts: Verdicts, known: Knowledge) -> Result<Decision> {
        let delay_limit = self.delay_limit(&verdicts)?;
        let keeps_stiffness_reserve = self.keeps_stiffness_reserve(&verdicts)?;
        let keeps_delay_reserve = self.keeps_delay_reserve(&verdicts, &delay_limit)?;
        let varying = self.varying(&verdicts, &known)?;
        let keeps_reserve = keeps_stiffness_reserve && keeps_delay_reserve && known.is_probable();
        let constant = status::at_constant_delay(&verdicts, &known, keeps_reserve);
        let status = status::overall(self, &known, constant, varying.as_ref());
        let constant_delay_status = if varying.is_some() && !self.is_as_stated() { status } else { constant };
        Ok(Decision {
            verdicts,
            known,
            status,
            constant_delay_status,
            keeps_stiffness_reserve,
            keeps_delay_reserve,
            delay_limit,
            varying,
        })
    }

    /// The answer without a playout buffer; `None` if the delay does not vary.
    ///
    /// # Errors
    ///
    /// As [`verdicts`](crate::verdicts::verdicts()).
    pub fn varying(&self, judged: &Verdicts, known: &Knowledge) -> Result<Option<VaryingDelay>> {
        if self.is_varying() { varying_delay(self, judged, known).map(Some) } else { Ok(None) }
    }

    /// Whether the constant delay is stable with the reserve, masses and dampings exactly known and axes independent.
    ///
    /// # Errors
    ///
    /// As [`verdicts`](crate::verdicts::verdicts()).
    pub fn is_usable(&self, judged: &Verdicts) -> Result<bool> {
        // The reserve takes longest: it is asked last.
        if status::at_constant_delay(judged, &Knowledge::default(), true) != Status::Stable {
            return Ok(false);
        }
        Ok(self.keeps_stiffness_reserve(judged)?
            && self.keeps_delay_reserve(judged, &self.delay_limit(judged)?)?)
    }

    /// The first delay, the mean of both ways, that is unstable at the stiffness judged. Both ways grow in the proportion
    /// that they have in the network.
    ///
    /// # Errors
    ///
    /// As [`delay_limit`](crate::verdicts::delay_limit()).
    pub fn delay_limit(&self, judged: &Verdicts) -> Result<DelayLimit> {
        delay_limit(&self.dyad, self.operator_ranges.as_ref(), judged.stiffness, &self.network)
    }

    /// The same question over another network.
    pub(super) fn over(&self, network: Network) -> Self {
        Self { network, ..self.clone() }
    }

    /// Whether it is stable up to 5 % more stiffness; beyond a limit also down to 5 % less.
    fn keeps_stiffness_reserve(&self, judged: &Verdicts) -> Result<bool> {
        let (k, limit) = (judged.stiffness, stiffness_limit(judged));
        let most = (1.0 + RESERVE) * k;
        if most <= limit {
            return Ok(true);
        }
        if most > quantity::STIFFNESS.maximum() || !is_stable(judged) {
            return Ok(false);
        }
        // Above a limit it is stable in an island of stiffnesses.
        let least = if k < limit { k } else { (1.0 - RESERVE) * k };
        is_stable_over_stiffnesses(&self.dyad, self.operator_ranges.as_ref(), (least, most), &self.network)
    }

    /// Whether it is stable up to 5 % more delay; beyond a limit also down to 5 % less. Both ways grow by that share.
    fn keeps_delay_reserve(&self, judged: &Verdicts, limit: &DelayLimit) -> Result<bool> {
        let [forward, backward] = constant_delay(judged);
        let mean = 0.5 * (forward + backward);
        if is_within((1.0 + RESERVE) * mean, limit) {
            return Ok(true);
        }
        // Beyond a limit it is stable in an island of delays: a shorter delay may be unstable, too.
        let least = if is_within(mean, limit) { 1.0 } else { 1.0 - RESERVE };
        let factors = (least, 1.0 + RESERVE);
        is_stable_over_delays(
            &self.dyad,
            self.operator_ranges.as_ref(),
            judged.stiffness,
            &self.network,
            factors,
        )
    }
}

/// The springs of a study's robots to the ground; `None` if they have none.
fn robot_springs(study: &Study) -> Result<Option<[Operator; 2]>> {
    let springs = study.ground_stiffness();
    if springs.iter().all(|spring| spring.iter().all(|stiffness| *stiffness == 0.0)) {
        return Ok(None);
    }
    let operator = |stiffness: &[f64]| {
        let none = vec![0.0; stiffness.len()];
        Operator::new(none.clone(), none, stiffness.to_vec())
    };
    Ok(Some([operator(springs[0])?, operator(springs[1])?]))
}
