//! The characteristic function of one axis, evaluated without cancellation, and Newton on it.

use num_complex::Complex64;

use super::contour::{Probe, Winding, taylor_step};
use crate::DyadAxis;

/// χ(s) / (m₁ m₂) = p₁(s) p₂(s) − q(s)² e^(−T s) with pᵢ = s² + βᵢ s + κᵢ and q = γ₀ + γ₁ s.
///
/// Written as r(s) − q(s)² (e^(−T s) − 1), where r = p₁ p₂ − q² is a polynomial whose coefficients
/// are sums of nonnegative terms: nothing cancels near s = 0, where the rigid-body root lies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Characteristic {
    /// βᵢ, 1/s.
    pub(super) beta: [f64; 2],
    /// κᵢ, 1/s².
    pub(super) kappa: [f64; 2],
    /// γ₀ and γ₁.
    pub(super) gamma: [f64; 2],
    /// Coefficients of r, constant first.
    pub(super) remainder: [f64; 5],
    /// T, both one-way delays together, s.
    pub(super) delay: f64,
    /// Whether s = 0 is a root for every stiffness and delay, and is left out.
    pub(super) rigid_body: bool,
}

/// A function value with its derivative.
#[derive(Debug, Clone, Copy)]
pub(super) struct Jet {
    pub value: Complex64,
    pub slope: Complex64,
}

/// What Newton found.
#[derive(Debug, Clone, Copy)]
pub(super) enum Refined {
    Simple(Complex64),
    /// Two roots so close together that they must be found as a pair: centre and half distance.
    Pair(Complex64, Complex64),
}

/// e^z − 1 without cancellation near 0.
fn exp_m1(z: Complex64) -> Complex64 {
    let grown = z.re.exp_m1();
    let (sin, cos) = (0.5 * z.im).sin_cos();
    let versine = 2.0 * sin * sin;
    Complex64::new(grown * (1.0 - versine) - versine, (grown + 1.0) * 2.0 * sin * cos)
}

impl Characteristic {
    pub(crate) fn new(axis: &DyadAxis, stiffness: f64, round_trip: f64) -> Self {
        let [one, two] = axis.sides;
        let (k, c) = (stiffness, axis.coupling_damping);
        let (b1, b2) = (one.damping, two.damping);
        let (kh1, kh2) = (one.ground_stiffness, two.ground_stiffness);
        let product = one.mass * two.mass;
        let root = product.sqrt();
        let beta = [(b1 + c) / one.mass, (b2 + c) / two.mass];
        let kappa = [(k + kh1) / one.mass, (k + kh2) / two.mass];
        Self {
            beta,
            kappa,
            gamma: [k / root, c / root],
            remainder: [
                (k * (kh1 + kh2) + kh1 * kh2) / product,
                (b1 * (k + kh2) + b2 * (k + kh1) + c * (kh1 + kh2)) / product,
                kappa[0] + kappa[1] + (b1 * b2 + c * (b1 + b2)) / product,
                beta[0] + beta[1],
                1.0,
            ],
            delay: round_trip,
            rigid_body: axis.is_free(),
        }
    }

    /// pᵢ(s).
    pub(super) fn side(&self, i: usize, s: Complex64) -> Complex64 {
        s * (s + self.beta[i]) + self.kappa[i]
    }

    /// q(s).
    pub(super) fn coupling(&self, s: Complex64) -> Complex64 {
        s * self.gamma[1] + self.gamma[0]
    }

    /// The function without the rigid-body root: χ/(m₁ m₂), divided by s where both handles are free.
    ///
    /// Two forms of the value lose different digits: r − q² (e^(−Ts) − 1) near a resonance, where p₁
    /// or p₂ is small, and p₁ p₂ − q² e^(−Ts) near s = 0. The one that loses fewer is taken.
    pub(super) fn jet(&self, s: Complex64) -> Jet {
        let (t, q) = (self.delay, self.coupling(s));
        let less_one = exp_m1(-s * t);
        let q2 = q * q;
        let size = s.norm();
        let whole = self.remainder.iter().rev().fold(0.0, |sum, c| sum * size + c);
        let (p1, p2) = (self.side(0, s), self.side(1, s));
        let bulk = |i: usize| (size + self.beta[i]) * size + self.kappa[i];
        let delayed = q2 * (less_one + 1.0);
        let factored = p1.norm() * bulk(1) + p2.norm() * bulk(0) + delayed.norm();
        let slope = (s * 2.0 + self.beta[0]) * p2 + (s * 2.0 + self.beta[1]) * p1
            - q * (less_one + 1.0) * (2.0 * self.gamma[1])
            + delayed * t;
        if factored < whole + (q2 * less_one).norm() {
            let value = p1 * p2 - delayed;
            if !self.rigid_body {
                return Jet { value, slope };
            }
            let value = value / s;
            return Jet { value, slope: (slope - value) / s };
        }
        let shift = usize::from(self.rigid_body);
        let coefficients = &self.remainder[shift..];
        let value = coefficients.iter().rev().fold(Complex64::ZERO, |sum, &c| sum * s + c);
        if !self.rigid_body {
            return Jet { value: value - q2 * less_one, slope };
        }
        // w = −(e^(−Ts) − 1)/s.
        let z = s * t;
        let (w, w_slope) = if z.norm() < 1e-4 {
            let series = |a: f64, b: f64, c: f64| (z * c + b) * z + a;
            (series(1.0, -0.5, 1.0 / 6.0) * t, series(-0.5, 1.0 / 3.0, -0.125) * t * t)
        } else {
            let w = -less_one / s;
            (w, ((less_one + 1.0) * t - w) / s)
        };
        let polynomial_slope = (1..coefficients.len())
            .rev()
            .fold(Complex64::ZERO, |sum, i| sum * s + i as f64 * coefficients[i]);
        Jet { value: value + q2 * w, slope: polynomial_slope + q * w * (2.0 * self.gamma[1]) + q2 * w_slope }
    }

    /// The whole χ/(m₁ m₂) (the rigid-body root left in) on the real axis, and its rounding error.
    pub(super) fn on_real_axis(&self, x: f64) -> (f64, f64) {
        let polynomial = self.remainder.iter().rev().fold(0.0, |sum, c| sum * x + c);
        let size = self.remainder.iter().rev().fold(0.0, |sum, c| sum * x.abs() + c);
        let q = self.gamma[0] + self.gamma[1] * x;
        let delayed = q * q * (-self.delay * x).exp_m1();
        (polynomial - delayed, 8.0 * f64::EPSILON * (size + delayed.abs()))
    }

    /// Value and first two derivatives of the whole χ/(m₁ m₂), and the rounding error of the value.
    fn derivatives(&self, s: Complex64) -> ([Complex64; 3], f64) {
        let jet = Self { rigid_body: false, ..*self }.jet(s);
        let (t, q) = (self.delay, self.coupling(s));
        let e = (-s * t).exp();
        let (p1, p2) = (self.side(0, s), self.side(1, s));
        let (d1, d2) = (s * 2.0 + self.beta[0], s * 2.0 + self.beta[1]);
        let g = self.gamma[1];
        let delayed = q * q * e;
        let bend = (p1 + p2 + d1 * d2) * 2.0 - e * (2.0 * g * g) + (q * (4.0 * g) - q * q * t) * e * t;
        let size = s.norm();
        let bulk = |i: usize| (size + self.beta[i]) * size + self.kappa[i];
        let noise = p1.norm() * bulk(1) + p2.norm() * bulk(0) + delayed.norm() * (1.0 + t * size);
        ([jet.value, jet.slope, bend], 4.0 * f64::EPSILON * noise)
    }

    /// Newton from `start` to the root it leads to; `None` where it leads nowhere.
    ///
    /// Far to the left, where the delayed term dominates, Newton on χ creeps by 1/T a step; there
    /// the step is the one of Newton on log(q² e^(−Ts) / (p₁ p₂)) = 2πjn for the nearest n.
    pub(super) fn refine(&self, start: Complex64) -> Option<Refined> {
        let mut s = start;
        let mut previous = f64::INFINITY;
        for iteration in 0..60 {
            let jet = self.jet(s);
            if jet.value == Complex64::ZERO {
                return Some(Refined::Simple(s));
            }
            let mut step = jet.value / jet.slope;
            let mut creeping = false;
            if iteration < 30 {
                let q = self.coupling(s);
                let (p1, p2) = (self.side(0, s), self.side(1, s));
                let product = p1 * p2;
                if (-self.delay * s.re).exp() * q.norm_sqr() > 4.0 * product.norm() {
                    let ratio = q * q * (-s * self.delay).exp() / product;
                    let log_slope = (s * 2.0 + self.beta[0]) / p1 + (s * 2.0 + self.beta[1]) / p2
                        - q.inv() * (2.0 * self.gamma[1])
                        + self.delay;
                    let leap = -ratio.ln() / log_slope;
                    // Next to a zero of p1 p2 the logarithm is the worse of the two.
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
                return Some(Refined::Simple(s));
            }
            if iteration >= 12 && size < 1e-4 * scale && size > 0.3 * previous {
                // Newton halves its error a step: a double root, or two very near each other.
                if let Some(pair) = self.pair(s) {
                    return Some(pair);
                }
            }
            previous = size;
        }
        None
    }

    /// The two roots next to a zero of χ′ near `s`, where there are two.
    pub(super) fn pair(&self, s: Complex64) -> Option<Refined> {
        let mut centre = s;
        for _ in 0..20 {
            let ([_, slope, bend], _) = self.derivatives(centre);
            let step = slope / bend;
            if !step.norm().is_finite() {
                return None;
            }
            centre -= step;
            if step.norm() <= 4.0 * f64::EPSILON * centre.norm() {
                break;
            }
        }
        let ([value, _, bend], noise) = self.derivatives(centre);
        let half = if value.norm() <= noise { Complex64::ZERO } else { (-value * 2.0 / bend).sqrt() };
        // Two roots, not two of a chain: far nearer each other than 1/T, and `s` is one of them.
        let reach = (1e-3 * s.norm()).min(0.02 / self.delay);
        let off = (s - centre - half).norm().min((s - centre + half).norm());
        let near = half.norm() <= reach && off <= 0.3 * half.norm() + (1e-5 * s.norm()).min(reach);
        near.then_some(Refined::Pair(centre, half))
    }
}

/// The whole function, the rigid-body root left in.
impl Winding for Characteristic {
    fn probe(&self, s: Complex64, direction: Complex64, longest: f64) -> Probe {
        let ([value, slope, _], _) = self.derivatives(s);
        let step = taylor_step(
            value.norm(),
            slope.norm(),
            |radius| {
                let reach = s.norm() + radius;
                let polynomial = (12.0 * reach + 6.0 * (self.beta[0] + self.beta[1])) * reach
                    + 2.0 * (self.kappa[0] + self.kappa[1] + self.beta[0] * self.beta[1]);
                let (t, q) = (self.delay, self.gamma[0] + self.gamma[1] * reach);
                let g = self.gamma[1];
                polynomial
                    + (2.0 * g * g + (4.0 * g + q * t) * q * t)
                        * (-t * (s.re + radius * direction.re.min(0.0))).exp()
            },
            longest,
        );
        Probe { value, step }
    }
}
