//! Newton's method on the characteristic function of one axis.
//!
//! The function is [normalised](Characteristic::normalised): both masses are 1.

use num_complex::Complex64;

use super::contour::{Probe, Winding, taylor_step};
use crate::characteristic::Characteristic;

/// The result of Newton's method.
#[derive(Debug, Clone, Copy)]
pub(super) enum RefinedRoot {
    Simple(Complex64),
    /// Two roots so close together that they are found as a pair: centre and half distance.
    Pair(Complex64, Complex64),
}

impl Characteristic {
    /// The value of χ, with the rigid-body root, on the real axis, and its rounding error, for Newton's method.
    pub(super) fn value_on_real_axis(&self, x: f64) -> (f64, f64) {
        let polynomial = self.remainder.iter().rev().fold(0.0, |sum, c| sum * x + c);
        let size = self.remainder.iter().rev().fold(0.0, |sum, c| sum * x.abs() + c);
        let q = self.stiffness + self.coupling_damping * x;
        let delayed = q * q * (-self.round_trip * x).exp_m1();
        (polynomial - delayed, 8.0 * f64::EPSILON * (size + delayed.abs()))
    }

    /// For Newton's method, the value and first two derivatives of χ, with the rigid-body root, and the
    /// rounding error of the value.
    fn value_and_derivatives(&self, s: Complex64) -> ([Complex64; 3], f64) {
        let jet = self.with_rigid_body().jet(s);
        let (t, q, g) = (self.round_trip, self.coupling(s), self.coupling_damping);
        let e = (-s * t).exp();
        let [one, two] = self.sides;
        let (p1, p2) = (one.value(s), two.value(s));
        let delayed = q * q * e;
        let bend = (p1 * two.mass + p2 * one.mass + one.slope(s) * two.slope(s)) * 2.0 - e * (2.0 * g * g)
            + (q * (4.0 * g) - q * q * t) * e * t;
        let size = s.norm();
        let noise = p1.norm() * two.bounds(size)[0]
            + p2.norm() * one.bounds(size)[0]
            + delayed.norm() * (1.0 + t * size);
        ([jet.value, jet.slope, bend], 4.0 * f64::EPSILON * noise)
    }

    /// The derivative of −log(q² e^(−T s) / (P₁ P₂)), for Newton's method.
    pub(super) fn log_slope(&self, s: Complex64) -> Complex64 {
        let [one, two] = self.sides.map(|side| side.slope(s) / side.value(s));
        one + two - self.coupling(s).inv() * (2.0 * self.coupling_damping) + self.round_trip
    }

    /// Newton's method from `start` to a characteristic root; `None` if it does not converge.
    ///
    /// Far to the left, where the delayed term dominates, Newton's method on χ moves only 1/T per step.
    /// There the step is that of Newton's method on log(q² e^(−Ts) / (P₁ P₂)) = 2πjn for the nearest n.
    pub(super) fn refine_root(&self, start: Complex64) -> Option<RefinedRoot> {
        let mut s = start;
        let mut previous = f64::INFINITY;
        for iteration in 0..60 {
            let jet = self.jet(s);
            if jet.value == Complex64::ZERO {
                return Some(RefinedRoot::Simple(s));
            }
            let mut step = jet.value / jet.slope;
            let mut creeping = false;
            if iteration < 30 {
                let q = self.coupling(s);
                let product = self.sides[0].value(s) * self.sides[1].value(s);
                if (-self.round_trip * s.re).exp() * q.norm_sqr() > 4.0 * product.norm() {
                    let ratio = q * q * (-s * self.round_trip).exp() / product;
                    let leap = -ratio.ln() / self.log_slope(s);
                    // Next to a zero of P₁ P₂ the logarithmic step is the worse one.
                    creeping = leap.norm() > step.norm();
                    if creeping {
                        step = leap;
                    }
                }
            }
            let size = step.norm();
            if !size.is_finite() {
                return None;
            }
            s -= step;
            let scale = s.norm();
            if !creeping
                && (size <= 2.0 * f64::EPSILON * scale || (size <= 1e-11 * scale && size >= 0.25 * previous))
            {
                return Some(RefinedRoot::Simple(s));
            }
            if iteration >= 12 && size < 1e-4 * scale && size > 0.3 * previous {
                // Newton's method halves its error per step: a double root, or two very close roots.
                if let Some(pair) = self.double_root_near(s) {
                    return Some(pair);
                }
            }
            previous = size;
        }
        None
    }

    /// By Newton's method, the two characteristic roots next to a zero of χ′ near `s`, if there are two.
    pub(super) fn double_root_near(&self, s: Complex64) -> Option<RefinedRoot> {
        let mut centre = s;
        for _ in 0..20 {
            let ([_, slope, bend], _) = self.value_and_derivatives(centre);
            let step = slope / bend;
            if !step.norm().is_finite() {
                return None;
            }
            centre -= step;
            if step.norm() <= 4.0 * f64::EPSILON * centre.norm() {
                break;
            }
        }
        let ([value, _, bend], noise) = self.value_and_derivatives(centre);
        let half = if value.norm() <= noise { Complex64::ZERO } else { (-value * 2.0 / bend).sqrt() };
        // Two close roots, not two of a chain: much closer than 1/T, and `s` is one of them.
        let reach = (1e-3 * s.norm()).min(0.02 / self.round_trip);
        let off = (s - centre - half).norm().min((s - centre + half).norm());
        let near = half.norm() <= reach && off <= 0.3 * half.norm() + (1e-5 * s.norm()).min(reach);
        near.then_some(RefinedRoot::Pair(centre, half))
    }
}

/// Follows χ with the rigid-body root.
impl Winding for Characteristic {
    /// A safe step for χ from bounds on its second derivative, next to Newton's method.
    fn probe(&self, s: Complex64, direction: Complex64, longest: f64) -> Probe {
        let ([value, slope, _], _) = self.value_and_derivatives(s);
        let step = taylor_step(
            value.norm(),
            slope.norm(),
            |radius| {
                let growth = (-self.round_trip * (s.re + radius * direction.re.min(0.0))).exp();
                self.with_rigid_body().curvature(0.0, s.norm() + radius, growth)
            },
            longest,
        );
        Probe { value, step }
    }
}
