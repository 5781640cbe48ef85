//! A dyad over a network, for one pair of operators or for ranges of them.

use std::sync::Arc;

use super::varying::varying_delay;
use super::{
    Decision, RESERVE, STIFFEST, Status, constant_delay, constant_delay_status, is_stable, is_within,
    stiffness_limit,
};
use crate::error::Result;
use crate::model::{Delay, Dyad, Operator};
use crate::rig::Trace;
use crate::study::Study;
use crate::verdicts::{
    DelayLimit, Network, OperatorRange, Verdicts, delay_limit, is_stable_over_delays,
    is_stable_over_stiffnesses, verdicts,
};

/// What holds the handles of a study's robots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holding {
    /// The study's operators.
    AsStated,
    /// Nothing but the robots' own springs to the ground.
    Free,
}

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
    /// Whether the ages of the motion in use have a bound.
    pub is_bounded: bool,
    /// Whether delay, jitter and gap are all that makes the ages: a playout buffer takes them up.
    pub is_as_stated: bool,
    /// Whether something is not judged, so that nothing is proven.
    pub has_unjudged: bool,
    /// Constant delays that the network may keep for long: one that is unstable is enough.
    pub lasting: Vec<Delay>,
}

impl Question {
    /// The question about a dyad with its own operators over a network without anything else.
    pub fn of_network(dyad: Dyad, network: Network) -> Self {
        let (delay, [forward, backward]) = (network.delay(), network.jitters());
        let latest = Delay::new(delay.forward() + forward, delay.backward() + backward);
        Self {
            dyad,
            operator_ranges: None,
            network,
            has_playout_buffer: false,
            is_bounded: true,
            is_as_stated: true,
            has_unjudged: false,
            lasting: [delay].into_iter().chain(latest.ok()).collect(),
        }
    }

    /// The question of a study, with the ages that its network and session make of each motion; see
    /// [`Study::judged_network`].
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) as [`Study::judged_network`].
    pub fn of_study(
        study: &Study,
        holding: Holding,
        delay: Option<Delay>,
        traces: [Option<Arc<Trace>>; 2],
    ) -> Result<Self> {
        let judged = study.judged_network(delay, traces)?;
        let (dyad, operator_ranges) = match holding {
            Holding::AsStated => (study.dyad().clone(), study.operator_ranges().cloned()),
            Holding::Free => (released(study)?, None),
        };
        Ok(Self {
            dyad,
            operator_ranges,
            network: judged.network,
            has_playout_buffer: judged.has_playout_buffer,
            is_bounded: judged.ages.is_some(),
            is_as_stated: judged.is_as_stated,
            has_unjudged: !judged.unjudged.is_empty(),
            lasting: judged.lasting,
        })
    }

    /// Whether the age of the motion in use varies, if nobody promises a playout buffer.
    pub fn is_varying(&self) -> bool {
        !(self.network.is_constant() && self.is_bounded)
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
        let verdicts = self.judge(stiffness)?;
        let delay_limit = delay_limit(&self.dyad, self.operator_ranges.as_ref(), stiffness, &self.network)?;
        let keeps_stiffness_reserve = self.keeps_stiffness_reserve(&verdicts)?;
        let keeps_delay_reserve = self.keeps_delay_reserve(&verdicts, &delay_limit)?;
        let varying = if self.is_varying() { Some(varying_delay(self, &verdicts)?) } else { None };
        let constant = constant_delay_status(&verdicts, keeps_stiffness_reserve && keeps_delay_reserve);
        let status = match &varying {
            _ if self.has_unjudged => Status::NotProven,
            Some(varying) if !self.has_playout_buffer => varying.status,
            _ => constant,
        };
        let constant_delay_status = if varying.is_some() && !self.is_as_stated { status } else { constant };
        Ok(Decision {
            verdicts,
            status,
            constant_delay_status,
            keeps_stiffness_reserve,
            keeps_delay_reserve,
            delay_limit,
            varying,
        })
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
        if most > STIFFEST || !is_stable(judged) {
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

/// The study's robots with free handles: only their own springs to the ground stay.
fn released(study: &Study) -> Result<Dyad> {
    let [one, two] = study.dyad().robots();
    let axes = one.axes().len();
    let spring = |values: &[f64]| Operator::new(vec![0.0; axes], vec![0.0; axes], values.to_vec());
    let [first, second] = study.ground_stiffness();
    let operators = [spring(first)?, spring(second)?];
    Dyad::new(one.clone(), two.clone(), Some(operators), study.dyad().coupling_damping())
}
