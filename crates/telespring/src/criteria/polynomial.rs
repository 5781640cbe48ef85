//! The crossing polynomial F: its positive roots are the squared crossing frequencies (the paper's Eq. 8,
//! with operators and coupling damping).

use twofloat::TwoFloat;

use crate::model::DyadAxis;
use crate::poly::{Polynomial, Real, Roots, positive_roots};

/// The number of coefficients of F: degree 4 if an operator has stiffness.
pub(super) const LENGTH: usize = 5;

/// The crossing polynomial F(y) = |P₁(jω)/k|² |P₂(jω)/k|² − (1 + c² y/k)² with y = ω²/k, formed without
/// cancellation: with free handles its constant term is exactly zero.
pub(super) fn crossing_polynomial<R: Real>(axis: &DyadAxis, stiffness: f64) -> Polynomial<R, LENGTH> {
    let number = R::from;
    let compliance = number(1.0).divided_by(number(stiffness));
    let q = compliance.to_f64();
    let c = axis.coupling_damping;
    let [first, second] = axis.sides.map(|side| {
        let m = number(side.mass);
        let b = number(side.damping);
        let ground = number(side.ground_stiffness) * compliance;
        let kappa = number(1.0) + ground;
        // |P/k|² = κ² + (f + g) y + m² y² with g = c²/k.
        let loss = (b * b + number(2.0) * b * number(c)) * compliance;
        let inertia = number(2.0) * m * kappa;
        NormalisedSide { m2: m * m, ground, kappa, f: loss - inertia, f_size: (loss + inertia).to_f64() }
    });
    let g = number(c) * number(c) * compliance;

    let (k1, k2) = (first.kappa * first.kappa, second.kappa * second.kappa);
    let (e1, e2) = (first.f + g, second.f + g);
    let both = first.ground + second.ground + first.ground * second.ground;
    let a0 = both * (number(2.0) + both);
    // e₁κ₂² + e₂κ₁² − 2g, without the g that cancels.
    let excess = |side: &NormalisedSide<R>| side.ground * (number(2.0) + side.ground);
    let damper = g * (excess(&first) + excess(&second));
    let a1 = first.f * k2 + second.f * k1 + damper;
    // e₁e₂ − g², likewise.
    let stiffness_terms = k1 * second.m2 + k2 * first.m2;
    let a2 = stiffness_terms + first.f * second.f + g * (first.f + second.f);
    let a3 = e1 * second.m2 + e2 * first.m2;
    let a4 = first.m2 * second.m2;

    let (k1, k2) = (k1.to_f64(), k2.to_f64());
    let (s1, s2) = (first.f_size, second.f_size);
    let size = g.to_f64().max(c * c * q);
    Polynomial {
        coefficient: [a0, a1, a2, a3, a4],
        magnitude: [
            a0.to_f64(),
            s1 * k2 + s2 * k1 + damper.to_f64(),
            stiffness_terms.to_f64() + s1 * s2 + size * (s1 + s2),
            (s1 + size) * second.m2.to_f64() + (s2 + size) * first.m2.to_f64(),
            a4.to_f64(),
        ],
    }
}

/// One side divided by the spring stiffness.
struct NormalisedSide<R> {
    m2: R,
    ground: R,
    kappa: R,
    f: R,
    f_size: f64,
}

/// The positive roots of the crossing polynomial F in y = ω²/k, ascending.
pub(super) fn crossing_roots(axis: &DyadAxis, stiffness: f64) -> Roots<f64, LENGTH> {
    positive_roots(&crossing_polynomial::<f64>(axis, stiffness), || {
        crossing_polynomial::<TwoFloat>(axis, stiffness)
    })
}
