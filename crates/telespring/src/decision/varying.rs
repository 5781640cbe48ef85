//! What is proven while the delay varies, where no playout buffer makes it constant.

use super::{Question, RESERVE, Status, is_instability_proven};
use crate::error::Result;
use crate::model::Delay;
use crate::verdicts::{Assumption, Network, Tier, Verdicts};

/// A factor that keeps rounding on the safe side of a limit.
const WITHIN: f64 = 1.0 - 1e-9;
/// A stiffness to ask the verdicts for their bounds, which do not depend on it, N/m.
const PROBE: f64 = 1.0;

/// The answer without a playout buffer: the age of a sample varies within the jitter and the gaps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VaryingDelay {
    /// Stable if a tier proves it for every variation, with the reserve of stiffness; marginal without the reserve; unstable
    /// if one of the constant delays that the network may keep is; else not proven.
    pub status: Status,
    /// Every smaller stiffness is proven to be stable, N/m; infinite if there is no limit, 0 if no tier has a rule.
    pub stiffness_limit: f64,
    /// Whether this stiffness is itself proven.
    pub is_attained: bool,
    /// The largest stiffness with the reserve, N/m: it is called stable.
    pub usable_stiffness: f64,
    /// The tier that proves it; `None` if none has a rule.
    pub tier: Option<Tier>,
}

/// Judges a question without a playout buffer.
///
/// In tiers 1 and 2 more delay needs no judgement of its own: the stiffness that a tier allows falls with it no faster
/// than in proportion, so that the reserve of stiffness is one of delay, too. Where the age in a range allows more, it must
/// allow the stiffness with 5 % more and 5 % less delay, too.
pub(super) fn varying_delay(question: &Question, judged: &Verdicts) -> Result<VaryingDelay> {
    let (limit, is_attained, tier) = allowed(question, judged);
    let mut usable = (limit / (1.0 + RESERVE)).min(limit);
    if tier == Some(Tier::AgeInRange) {
        for factor in [1.0 - RESERVE, 1.0 + RESERVE] {
            let nearby = question.over(with_delay(&question.network, factor)?);
            usable = usable.min(allowed(question, &nearby.judge(PROBE)?).0);
        }
    }
    Ok(VaryingDelay {
        status: status(question, judged, usable)?,
        stiffness_limit: limit,
        is_attained,
        usable_stiffness: WITHIN * usable,
        tier,
    })
}

/// The network with this multiple of its delay, jitter and gaps unchanged.
fn with_delay(network: &Network, factor: f64) -> Result<Network> {
    let delay = Delay::new(factor * network.delay().forward(), factor * network.delay().backward())?;
    let (period, computing) = (network.sample_period(), network.computing_time());
    Network::with_jitters(delay, network.jitters(), network.max_gap(), period, computing)
}

/// What the tiers allow whose assumption the ages in use meet: a stiffness (N/m), whether it is itself allowed, and the tier.
fn allowed(question: &Question, judged: &Verdicts) -> (f64, bool, Option<Tier>) {
    if !question.is_bounded {
        let anything = judged.tier(Tier::AnyNetwork);
        let bound = anything.stiffness_bound;
        return bound.map_or((0.0, false, None), |bound| (bound, anything.attained, Some(Tier::AnyNetwork)));
    }
    let allowed = judged.stiffness_allowed;
    allowed.map_or((0.0, false, None), |found| (found.stiffness, found.attained, Some(found.tier)))
}

/// The answer in one word.
fn status(question: &Question, judged: &Verdicts, usable: f64) -> Result<Status> {
    let k = judged.stiffness;
    if is_proven(question, judged) {
        return Ok(if k <= usable { Status::Stable } else { Status::Marginal });
    }
    // A constant delay is one of the ways in which the delay may vary.
    let (period, computing) = (question.network.sample_period(), question.network.computing_time());
    for delay in &question.lasting {
        let constant = question.over(Network::new(*delay, 0.0, 0.0, period, computing)?);
        if is_instability_proven(&constant.judge(k)?) {
            return Ok(Status::Unstable);
        }
    }
    Ok(Status::NotProven)
}

/// Whether a tier proves the stiffness for every variation of the delay.
fn is_proven(question: &Question, judged: &Verdicts) -> bool {
    if !question.is_bounded {
        return judged.tier(Tier::AnyNetwork).satisfied;
    }
    judged.tiers.iter().any(|tier| tier.satisfied && tier.assumption == Assumption::Met)
}
