//! Tier 1, "any network": any network behaviour with bounded gaps.
//!
//! Each side alone, driven by an arbitrary past of its partner, must not amplify. The L¹ norm γᵢ of the map
//! from partner position to own position is 1 for a free, overdamped side, and the loop of both sides is
//! stable if γ₁ γ₂ < 1. With a coupling damper the convex hull of x and x + v/λ replaces the norm.

use super::gain::unit_gain_stiffness;
use super::zero_order_hold::SampledPlant;
use super::{Network, Unavailable, sampled_gain};
use crate::model::{DyadAxis, Side};

/// The bound of tier 1 for one axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct AxisBound {
    /// Every smaller stiffness (N/m) satisfies the rule.
    pub proven: f64,
    /// True if this stiffness itself does.
    pub attained: bool,
    /// The rule fails at this stiffness (N/m) at the latest.
    pub found: f64,
}

/// Why tier 1 has no rule for an axis, if it has none; `is_grounded` is whether an operator is, or may be.
pub(super) fn unavailable(
    coupling_damping: f64,
    is_grounded: bool,
    network: &Network,
) -> Option<Unavailable> {
    if coupling_damping == 0.0 {
        None
    } else if is_grounded {
        Some(Unavailable::CouplingDampingWithGroundedOperator)
    } else {
        (network.computing_time() > 0.0).then_some(Unavailable::CouplingDampingWithComputingTime)
    }
}

/// The largest stiffness of tier 1, any network, for one axis that it has a rule for.
pub(super) fn stiffness_bound(axis: &DyadAxis, network: &Network) -> AxisBound {
    let exact = |bound: f64, attained: bool| AxisBound { proven: bound, attained, found: bound };
    let damper = axis.coupling_damping;
    if network.sample_period() > 0.0 {
        let held = axis
            .sides
            .map(|side| SampledPlant::new(&side, network.sample_period(), network.computing_time()));
        return if axis.is_free() {
            exact(sampled_gain::free_stiffness(&held, damper), true)
        } else {
            let unit = sampled_gain::grounded_stiffness(axis, &held);
            AxisBound { proven: unit.proven, attained: false, found: unit.found }
        };
    }
    if axis.is_free() {
        let [first, second] = axis.sides.map(|side| free_side_stiffness(&side, damper));
        exact(first.min(second), true)
    } else {
        exact(unit_gain_stiffness(&axis.sides), false)
    }
}

/// The stiffness up to which the hull of a free side never grows on any network (tier 1).
fn free_side_stiffness(side: &Side, damper: f64) -> f64 {
    let b = side.damping;
    if damper <= b { (b + damper) * (b + damper) / (4.0 * side.mass) } else { b * damper / side.mass }
}
