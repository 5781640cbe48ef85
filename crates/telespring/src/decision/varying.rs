//! What is proven while the delay varies, where no playout buffer makes it constant.

use super::{Knowledge, Question, RESERVE, Status, WITHIN, is_instability_proven};
use crate::error::Result;
use crate::model::Delay;
use crate::quantity;
use crate::verdicts::{Assumption, Network, Tier, Verdicts};

/// A stiffness to ask the verdicts for their bounds, which do not depend on it, N/m.
const PROBE: f64 = 1.0;

/// The answer without a playout buffer: the age of a sample varies within the jitter and the gaps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VaryingDelay {
    /// Stable if a tier proves it for every variation, with the reserve of stiffness and, where the robots have errors,
    /// probably enough; marginal without one of these; unstable if one of the constant delays that the network may keep is;
    /// else not proven.
    pub status: Status,
    /// Every smaller stiffness is proven to be stable, N/m; infinite if there is no limit, 0 if no tier has a rule.
    pub stiffness_limit: f64,
    /// Whether this stiffness is itself proven.
    pub is_attained: bool,
    /// The largest stiffness with the reserve and, where the robots have errors, probable enough, N/m: it is called stable.
    pub usable_stiffness: f64,
    /// The tier that proves it; `None` if none has a rule.
    pub tier: Option<Tier>,
    /// At this stiffness, N/m, a network was found that varies the delay so and makes the motion grow; infinite if the search
    /// found none, `None` if none was searched.
    pub attack: Option<f64>,
}

impl VaryingDelay {
    /// The usable stiffness as far as laboratories use one, N/m: no question is asked about its unit.
    pub fn recommended_stiffness(&self) -> f64 {
        let (softest, stiffest) = quantity::STIFFNESS.usual_range().unwrap_or((0.0, f64::INFINITY));
        if self.usable_stiffness < softest { 0.0 } else { self.usable_stiffness.min(stiffest) }
    }
}

/// Judges a question without a playout buffer.
///
/// In tiers 1 and 2 more delay needs no judgement of its own: the stiffness that a tier allows falls with it no faster
/// than in proportion, so that the reserve of stiffness is one of delay, too. Where the age in a range allows more, it must
/// allow the stiffness with 5 % more and 5 % less delay, too.
pub(super) fn varying_delay(
    question: &Question,
    judged: &Verdicts,
    known: &Knowledge,
) -> Result<VaryingDelay> {
    let allowed = question.allowed(judged);
    let limit = allowed.map_or(0.0, |allowed| allowed.stiffness);
    let mut usable = (limit / (1.0 + RESERVE)).min(known.varying_stiffness_limit.unwrap_or(limit));
    if allowed.is_some_and(|allowed| allowed.tier == Tier::AgeInRange) {
        for factor in [1.0 - RESERVE, 1.0 + RESERVE] {
            let nearby = question.over(with_delay(&question.network, factor)?);
            usable =
                usable.min(nearby.allowed(&nearby.judge(PROBE)?).map_or(0.0, |allowed| allowed.stiffness));
        }
    }
    let is_attack_searched = known.is_attack_searched && question.is_bounded();
    let attack = judged.tier(Tier::AgeInRange).attack;
    Ok(VaryingDelay {
        status: status(question, judged, usable)?,
        stiffness_limit: limit,
        is_attained: allowed.is_some_and(|allowed| allowed.attained),
        usable_stiffness: WITHIN * usable,
        tier: allowed.map(|allowed| allowed.tier),
        attack: is_attack_searched.then(|| attack.unwrap_or(f64::INFINITY)),
    })
}

/// The network with this multiple of its delay, jitter and gaps unchanged.
fn with_delay(network: &Network, factor: f64) -> Result<Network> {
    let delay = Delay::new(factor * network.delay().forward(), factor * network.delay().backward())?;
    let (period, computing) = (network.sample_period(), network.computing_time());
    Network::with_jitters(delay, network.jitters(), network.max_gap(), period, computing)
}

/// The answer in one word.
fn status(question: &Question, judged: &Verdicts, usable: f64) -> Result<Status> {
    let k = judged.stiffness;
    if is_proven(question, judged) {
        return Ok(if k <= usable { Status::Stable } else { Status::Marginal });
    }
    // A constant delay is one of the ways in which the delay may vary.
    let (period, computing) = (question.network.sample_period(), question.network.computing_time());
    for delay in question.lasting() {
        let constant = question.over(Network::new(delay, 0.0, 0.0, period, computing)?);
        if is_instability_proven(&constant.judge(k)?) {
            return Ok(Status::Unstable);
        }
    }
    Ok(Status::NotProven)
}

/// Whether a tier proves the stiffness for every variation of the delay.
fn is_proven(question: &Question, judged: &Verdicts) -> bool {
    if !question.is_bounded() {
        return judged.tier(Tier::AnyNetwork).satisfied;
    }
    judged.tiers.iter().any(|tier| tier.satisfied && tier.assumption == Assumption::Met)
}
