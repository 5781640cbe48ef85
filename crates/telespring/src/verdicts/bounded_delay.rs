//! Tier 2, "bounded varying delay": any variation, jumps, losses with hold and reordering, as long as no
//! sample in use is older than a bound.
//!
//! A Lyapunov–Krasovskii condition in the form of Nuño, Basañez and Ortega (Automatica 2011, sec. 3), with
//! the age h of the own sample subtracted from the damping: k < 2√((B₁ − k h)(B₂ − k h))/(T₁ + T₂), Bᵢ > k
//! h.

/// The stiffness bound (N/m) of tier 2, bounded delay: the Lyapunov–Krasovskii condition solved for k.
///
/// `damping` in N·s/m; `partner_age` = [T₁, T₂] and `own_age` = h in s. Infinite without delay.
pub(super) fn stiffness_bound(damping: [f64; 2], partner_age: [f64; 2], own_age: f64) -> f64 {
    let [b1, b2] = damping;
    if b1 == 0.0 || b2 == 0.0 {
        return 0.0;
    }
    let total = partner_age[0] + partner_age[1];
    // The smaller root of (T²/4 − h²) k² + h (B₁ + B₂) k − B₁ B₂ = 0, without cancellation.
    // Square roots of B keep the products of extreme dampings in range.
    let root = (own_age * (b1 - b2)).hypot(total * b1.sqrt() * b2.sqrt());
    2.0 * b1 * b2 / (own_age * (b1 + b2) + root)
}

/// The round trip (s) below which no constant delay destabilises a dyad at a stiffness (N/m), whatever passive operators
/// hold it: the same rule under continuous controllers, solved for T.
pub(super) fn round_trip_bound(damping: [f64; 2], stiffness: f64) -> f64 {
    let [b1, b2] = damping;
    2.0 * b1.sqrt() * b2.sqrt() / stiffness
}

/// The damping (N·s/m), added to both robots, above which that rule holds at a stiffness (N/m) and a round trip (s).
pub(super) fn added_damping(damping: [f64; 2], stiffness: f64, round_trip: f64) -> f64 {
    let [b1, b2] = damping;
    // (b₁ + d)(b₂ + d) = (k T/2)².
    let root = (0.5 * (b1 - b2)).hypot(0.5 * stiffness * round_trip);
    (root - 0.5 * (b1 + b2)).max(0.0)
}
