//! Tier 1, "any network": whatever the network does, as long as its gaps are bounded.
//!
//! Each side alone, fed by an arbitrary past of its partner, must not amplify: the L¹ norm γᵢ of the
//! map from partner position to own position is 1 for a free, overdamped side, and the loop of both
//! is safe where γ₁ γ₂ < 1. With a coupling damper the hull of x and x + v/λ takes the place of the norm.

use std::f64::consts::PI;

use super::held::HeldSide;
use super::{Network, local_loop};
use crate::model::{DyadAxis, Side};

/// The largest stiffness (N/m) of the tier for one axis and whether it is itself allowed; `None` where
/// no rule is known (a coupling damper with a grounded operator, or with a computing time).
pub(super) fn stiffness_bound(axis: &DyadAxis, network: &Network) -> Option<(f64, bool)> {
    let damper = axis.coupling_damping;
    if damper > 0.0 && (!axis.is_free() || network.computing_time() > 0.0) {
        return None;
    }
    if network.sample_period() > 0.0 {
        let held =
            axis.sides.map(|side| HeldSide::new(&side, network.sample_period(), network.computing_time()));
        return Some(if axis.is_free() {
            (local_loop::free_bound(&held, damper), true)
        } else {
            (local_loop::grounded_bound(axis, &held), false)
        });
    }
    Some(if axis.is_free() {
        let [first, second] = axis.sides.map(|side| free_side(&side, damper));
        (first.min(second), true)
    } else {
        (grounded_bound(&axis.sides), false)
    })
}

/// The stiffness up to which a free side's hull never grows.
fn free_side(side: &Side, damper: f64) -> f64 {
    let b = side.damping;
    if damper <= b { (b + damper) * (b + damper) / (4.0 * side.mass) } else { b * damper / side.mass }
}

/// ln γ of one side at a stiffness: γ = k/(k + k_h) coth(πB/(2√(4M(k + k_h) − B²))), the L¹ norm of
/// the impulse response of k/(M s² + B s + k + k_h). The coth is 1 where the side is overdamped.
pub(super) fn log_gain(side: &Side, stiffness: f64) -> f64 {
    let total = stiffness + side.ground_stiffness;
    let discriminant = 4.0 * side.mass * total - side.damping * side.damping;
    // Logarithms keep what is small: k_h beside k, and coth − 1.
    let static_gain = -(side.ground_stiffness / stiffness).ln_1p();
    if discriminant <= 0.0 {
        return static_gain;
    }
    let argument = PI * side.damping / discriminant.sqrt();
    static_gain + (2.0 / argument.exp_m1()).ln_1p()
}

/// The stiffness at which γ₁ γ₂ reaches 1. Both factors grow with k, from below 1 to infinity.
fn grounded_bound(sides: &[Side; 2]) -> f64 {
    last_true(|k| sides.iter().map(|side| log_gain(side, k)).sum::<f64>() < 0.0)
}

/// The largest positive number for which a property that only ever turns false holds: bisection on
/// the bits, so to the last one. 0 where it never holds.
pub(super) fn last_true(holds: impl Fn(f64) -> bool) -> f64 {
    // Wider than any stiffness that may be asked for.
    let (mut low, mut high) = (1e-12_f64.to_bits(), 1e13_f64.to_bits());
    if !holds(f64::from_bits(low)) {
        return 0.0;
    }
    if holds(f64::from_bits(high)) {
        return f64::from_bits(high);
    }
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if holds(f64::from_bits(middle)) { low = middle } else { high = middle }
    }
    f64::from_bits(low)
}
