//! Tiers 1 to 4 on one axis: exact for one pair of operators, certified over a range of them.

use super::operators::{OperatorBox, OperatorPair, OperatorPoint, operator_points};
use super::ranges::{CertifiedBound, Crossing, Family};
use super::tightness::is_tight;
use super::{Network, Tier, Unavailable, any_network_range, bounded_delay};
use crate::criteria::{
    critical_stiffness, is_delay_independent, is_in_any, maximum_delay, maximum_stiffness, stable_delays,
};
use crate::error::Result;
use crate::model::DyadAxis;

/// One tier on one axis, for the worst operators.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisTier {
    /// Which tier.
    pub tier: Tier,
    /// The largest stiffness, N/m; `None` if the tier has no rule for this dyad. Over a range of operators it
    /// holds for all of them.
    pub stiffness_bound: Option<f64>,
    /// True if that stiffness itself is allowed.
    pub attained: bool,
    /// True if the given stiffness is proven to satisfy the tier's rule for every operator of the range.
    pub satisfied: bool,
    /// False if the search over the range was cut off, or the bound may be more than 5 % below the truth or is not
    /// known. A bound that is given holds all the same.
    pub proven: bool,
    /// The smallest bound found for a single pair of operators, N/m: no bound over the range is larger.
    pub least_found: Option<f64>,
    /// The operators with that bound.
    pub operators: [OperatorPoint; 2],
    /// Why the tier has no bound, where it has none.
    pub unavailable: Option<Unavailable>,
}

/// Tiers 3 and 4 on one axis, and what else the search for them tells.
pub(super) struct ConstantDelayTiers {
    pub tiers: [AxisTier; 2],
    /// The operators with the smallest bound of tier 4.
    pub worst: OperatorPair,
    pub maximum_delay: MaximumDelay,
}

/// The end of the first stable delay interval, for every operator.
pub(super) struct MaximumDelay {
    /// Every shorter one-way delay is stable, s.
    pub bound: f64,
    /// The smallest end found for a single pair of operators, s.
    pub least_found: f64,
    /// False if the search was cut off, or the bound may be more than 5 % low.
    pub is_proven: bool,
}

impl MaximumDelay {
    /// The exact end for one pair of operators, or for all of them.
    fn exact(delay: f64) -> Self {
        Self { bound: delay, least_found: delay, is_proven: true }
    }

    /// The end over a range at a stiffness (N/m), given operators that are the worst elsewhere.
    fn over_range(region: &OperatorBox, family: &Family, k: f64, worst: &[OperatorPair]) -> Result<Self> {
        let certified = family.first_round_trip(k, f64::INFINITY);
        let found = certified.sides.as_ref().map(|sides| region.operators_of(sides));
        let mut least_found = f64::INFINITY;
        for at in found.iter().chain(worst).chain(&[region.weakest_corner(), region.middle()]) {
            least_found = least_found.min(maximum_delay(&region.axis(at), k)?);
        }
        let bound = (0.5 * certified.value).min(least_found);
        Ok(Self { bound, least_found, is_proven: certified.is_finished && is_tight(bound, least_found) })
    }
}

/// For some operators, true if the first positive root of F appears at ξ = 0 when k reaches `critical`: the
/// dyad is then stable at that stiffness.
fn is_attained(axis: &DyadAxis, critical: f64) -> bool {
    let [first, second] = axis.sides;
    let (b1, b2, c) = (first.damping, second.damping, axis.coupling_damping);
    let entry = (b1 * b1 + b2 * b2 + 2.0 * c * (b1 + b2)) / (2.0 * (first.mass + second.mass));
    // A tangency comes before this root; 1e-12 separates the two in rounding.
    axis.is_free() && (entry - critical).abs() <= 1e-12 * entry
}

/// Tiers 3 and 4 for one pair of operators, by the exact criteria.
fn at_one_pair(region: &OperatorBox, delay: f64, k: f64) -> Result<ConstantDelayTiers> {
    let worst = region.middle();
    let axis = region.axis(&worst);
    let operators = operator_points(&worst);
    let critical = critical_stiffness(&axis);
    let attained = is_attained(&axis, critical);
    let third = AxisTier {
        tier: Tier::AnyConstantDelay,
        stiffness_bound: Some(critical),
        attained,
        // With grounded operators there may be bands above the first destabilised stiffness.
        satisfied: k < critical || attained && k == critical || is_delay_independent(&axis, k)?,
        proven: true,
        least_found: Some(critical),
        operators,
        unavailable: None,
    };
    let largest = maximum_stiffness(&axis, delay)?;
    let fourth = AxisTier {
        tier: Tier::ConstantDelay,
        stiffness_bound: Some(largest),
        attained: false,
        // Above the bound the delay may lie in a later stable interval.
        satisfied: k < largest || is_in_any(&stable_delays(&axis, k, 2.0 * delay + 1.0)?, delay),
        proven: true,
        least_found: Some(largest),
        operators,
        unavailable: None,
    };
    Ok(ConstantDelayTiers {
        tiers: [third, fourth],
        worst,
        maximum_delay: MaximumDelay::exact(maximum_delay(&axis, k)?),
    })
}

/// A certified stiffness bound of a tier, with the operators of the smallest bound among those found and the
/// corners.
fn over_range(
    region: &OperatorBox,
    tier: Tier,
    certified: &CertifiedBound,
    satisfied: Option<bool>,
    bound_at: impl Fn(&DyadAxis) -> Result<f64>,
) -> Result<(AxisTier, OperatorPair)> {
    let mut worst = (region.weakest_corner(), f64::INFINITY);
    let found = certified.sides.as_ref().map(|sides| region.operators_of(sides));
    for at in found.into_iter().chain([region.weakest_corner(), region.middle()]) {
        let bound = bound_at(&region.axis(&at))?;
        if bound < worst.1 {
            worst = (at, bound);
        }
    }
    let bound = certified.value.min(worst.1);
    let verdict = AxisTier {
        tier,
        stiffness_bound: Some(bound),
        attained: false,
        satisfied: satisfied == Some(true),
        proven: certified.is_finished && satisfied.is_some() && is_tight(bound, worst.1),
        least_found: Some(worst.1),
        operators: operator_points(&worst.0),
        unavailable: None,
    };
    Ok((verdict, worst.0))
}

/// The bound of tier 3 over a range.
fn any_delay_bound(family: &Family) -> CertifiedBound {
    let start = family.soft_stiffness();
    if !family.is_stable_without_delay() || family.has_lossless_side() || start == 0.0 {
        let is_finished = start > 0.0 || family.coupling_damping == 0.0;
        return CertifiedBound { value: 0.0, sides: None, is_finished };
    }
    family.first_stiffness(None, start, f64::INFINITY)
}

/// The bound of tier 4 over a range, given that of tier 3.
fn one_delay_bound(family: &Family, any_delay: f64, delay: f64) -> CertifiedBound {
    let bound = |value: f64, is_finished: bool| CertifiedBound { value, sides: None, is_finished };
    if delay == 0.0 {
        return bound(if family.is_stable_without_delay() { f64::INFINITY } else { 0.0 }, true);
    }
    // Undamped resonances need a rule for springs of no stiffness.
    if any_delay == 0.0 {
        bound(0.0, false)
    } else {
        family.first_stiffness(Some(2.0 * delay), any_delay, f64::INFINITY)
    }
}

/// Tiers 3 and 4 on one axis at a one-way delay (s) and a stiffness (N/m).
pub(super) fn constant_delay_tiers(region: &OperatorBox, delay: f64, k: f64) -> Result<ConstantDelayTiers> {
    if region.is_point() {
        return at_one_pair(region, delay, k);
    }
    let family = region.family();
    let damped = family.is_stable_without_delay();
    let third_bound = any_delay_bound(&family);
    let third_satisfied = if k < third_bound.value {
        Some(true)
    } else if !damped {
        Some(false)
    } else {
        match family.crossing(k, None) {
            Crossing::Excluded => Some(true),
            Crossing::Found => Some(false),
            Crossing::Unresolved => None,
        }
    };
    let (third, worst_of_any) =
        over_range(region, Tier::AnyConstantDelay, &third_bound, third_satisfied, |axis| {
            Ok(critical_stiffness(axis))
        })?;

    let fourth_bound = one_delay_bound(&family, third_bound.value, delay);
    let fourth_satisfied = if k < fourth_bound.value || third.satisfied {
        Some(true)
    } else if delay == 0.0 {
        Some(false)
    } else {
        match family.crossing(k, Some(2.0 * delay)) {
            // No member has a root on the axis: all are as stable as one of them.
            Crossing::Excluded => {
                let member = region.axis(&region.middle());
                Some(is_in_any(&stable_delays(&member, k, 2.0 * delay + 1.0)?, delay))
            }
            Crossing::Found => Some(false),
            Crossing::Unresolved => None,
        }
    };
    let (fourth, worst) = over_range(region, Tier::ConstantDelay, &fourth_bound, fourth_satisfied, |axis| {
        maximum_stiffness(axis, delay)
    })?;
    let maximum_delay = if third.satisfied {
        MaximumDelay::exact(f64::INFINITY)
    } else if !damped {
        MaximumDelay::exact(0.0)
    } else {
        MaximumDelay::over_range(region, &family, k, &[worst_of_any, worst])?
    };
    Ok(ConstantDelayTiers { tiers: [third, fourth], worst, maximum_delay })
}

/// Tier 2 on one axis, exact at the smallest damping of a range.
pub(super) fn bounded_delay_tier(region: &OperatorBox, network: &Network, k: f64) -> AxisTier {
    let worst = region.weakest_corner();
    let axis = region.axis(&worst);
    let bound = (axis.coupling_damping == 0.0).then(|| {
        let damping = axis.sides.map(|side| side.damping);
        bounded_delay::stiffness_bound(damping, network.oldest_partner_sample(), network.oldest_own_sample())
    });
    AxisTier {
        tier: Tier::BoundedVaryingDelay,
        stiffness_bound: bound,
        attained: false,
        satisfied: bound.is_some_and(|bound| k < bound),
        proven: true,
        least_found: bound,
        operators: operator_points(&worst),
        unavailable: bound.is_none().then_some(Unavailable::CouplingDamping),
    }
}

/// Tier 1 on one axis.
pub(super) fn any_network_tier(region: &OperatorBox, network: &Network, k: f64) -> AxisTier {
    let over = any_network_range::range_bound(region, network);
    let bound = over.bound.ok();
    AxisTier {
        tier: Tier::AnyNetwork,
        stiffness_bound: bound.map(|(bound, _)| bound),
        attained: bound.is_some_and(|(_, attained)| attained),
        satisfied: bound.is_some_and(|(bound, attained)| k < bound || attained && k == bound),
        proven: over.is_tight,
        least_found: over.least_found,
        operators: operator_points(&over.worst),
        unavailable: over.bound.err(),
    }
}
