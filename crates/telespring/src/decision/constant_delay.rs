//! What verdicts say about the constant delay, with the controllers in question.

use crate::verdicts::{Assumption, AxisVerdict, DelayLimit, SampledCertificate, Tier, Verdicts};

/// Whether the constant delay is stable for every operator, sampled controllers included.
pub fn is_stable(judged: &Verdicts) -> bool {
    judged.tier(Tier::ConstantDelay).satisfied && judged.sampled_stable != Some(false)
}

/// The same of one axis.
pub fn is_axis_stable(axis: &AxisVerdict) -> bool {
    axis.tiers[Tier::ConstantDelay as usize].satisfied && axis.sampled_stable != Some(false)
}

/// Whether some operator in question is unstable; if not, a search over ranges was cut off.
pub fn is_instability_proven(judged: &Verdicts) -> bool {
    let constant = judged.tier(Tier::ConstantDelay);
    (!constant.satisfied && constant.proven)
        || judged.axes.iter().filter_map(|axis| axis.sampled.as_ref()).any(|sampled| !sampled.is_stable())
}

/// Whether no root that sampled controllers give was left out of the count.
pub fn are_roots_counted(judged: &Verdicts) -> bool {
    let sampled = judged.axes.iter().filter_map(|axis| axis.sampled.as_ref());
    sampled.into_iter().all(|found| found.certificate != SampledCertificate::Incomplete)
}

/// The stiffness (N/m) below which every one is stable at the delay, sampled controllers included.
pub fn stiffness_limit(judged: &Verdicts) -> f64 {
    let sampled = judged.axes.iter().filter_map(|axis| axis.sampled_stiffness_bound);
    let constant = judged.tier(Tier::ConstantDelay).stiffness_bound;
    constant.into_iter().chain(sampled).reduce(f64::min).unwrap_or(f64::NAN)
}

/// The stiffness bound (N/m) of a tier with the controllers in question; `None` if it has no rule for them.
///
/// The bounds of constant delays are those of continuous controllers, even where those in question sample. For one known
/// delay the bound with sampled ones is [`stiffness_limit`], for any constant delay there is none.
pub fn tier_stiffness_limit(judged: &Verdicts, tier: Tier) -> Option<f64> {
    match tier {
        Tier::ConstantDelay if judged.sampled_stable.is_some() => Some(stiffness_limit(judged)),
        Tier::AnyConstantDelay if judged.sampled_stable.is_some() => None,
        _ => judged.tier(tier).stiffness_bound,
    }
}

/// The delay that is judged, s: the network's, or that behind a playout buffer.
pub fn constant_delay(judged: &Verdicts) -> [f64; 2] {
    match judged.tier(Tier::ConstantDelay).assumption {
        Assumption::MetBehindPlayoutBuffer { delay } => delay,
        Assumption::Met => [judged.network.delay().forward(), judged.network.delay().backward()],
    }
}

/// Whether a mean delay (s) is below a limit, or at one that is itself stable.
pub fn is_within(delay: f64, limit: &DelayLimit) -> bool {
    // A delay that is a whole number of periods remains one in spite of rounding.
    if limit.attained { delay <= limit.delay * (1.0 + 1e-9) } else { delay < limit.delay }
}
