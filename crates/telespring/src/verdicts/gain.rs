//! The gain of one side under a continuous controller, and the stiffness at which the loop gain is 1.
//!
//! The gain is the L¹ norm of the map from partner position to own position.

use std::f64::consts::PI;

use crate::model::Side;

/// ln γ of one side at a stiffness, where γ = k/(k + k_h) coth(πB/(2√(4M(k + k_h) − B²))) is the L¹ norm of
/// the impulse response of k/(M s² + B s + k + k_h). The coth is 1 if the side is overdamped.
pub(super) fn log_gain(side: &Side, stiffness: f64) -> f64 {
    let total = stiffness + side.ground_stiffness;
    let discriminant = 4.0 * side.mass * total - side.damping * side.damping;
    // Logarithms keep small terms: k_h relative to k, and coth − 1.
    let static_gain = -(side.ground_stiffness / stiffness).ln_1p();
    if discriminant <= 0.0 {
        return static_gain;
    }
    let argument = PI * side.damping / discriminant.sqrt();
    static_gain + (2.0 / argument.exp_m1()).ln_1p()
}

/// The stiffness at which the loop gain γ₁ γ₂ reaches 1. Both gains grow with k, from below 1 to infinity.
pub(super) fn unit_gain_stiffness(sides: &[Side; 2]) -> f64 {
    largest_holding(|k| sides.iter().map(|side| log_gain(side, k)).sum::<f64>() < 0.0)
}

/// The largest stiffness with a property, such as gain below 1, that holds up to a threshold, by bisection on
/// the bits of the number; 0 if it never holds.
pub(super) fn largest_holding(holds: impl Fn(f64) -> bool) -> f64 {
    // Wider than any allowed stiffness.
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
