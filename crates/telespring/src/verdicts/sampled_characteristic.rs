//! The characteristic function of one axis under two sampled controllers.
//!
//! Both controllers read position and velocity every h, hold the force over one period and receive the
//! partner's sample N_f or N_b whole periods late. With qᵢ and nᵢ the exact plant under a zero-order hold
//! and the force it returns ([`SampledPlant`]), the multipliers z solve (q₁ + n₁)(q₂ + n₂) − n₁ n₂ z^(−N) =
//! 0 with N = N_f + N_b; no matrix with N delay lines is needed.

use num_complex::Complex64;

use super::Network;
use super::zero_order_hold::SampledPlant;
use crate::characteristic::exp_m1;
use crate::model::DyadAxis;

/// The characteristic function of one sampled axis in s, without the rigid-body root.
#[derive(Debug, Clone)]
pub(super) struct SampledCharacteristic {
    /// q₁ q₂ + q₁ n₂ + q₂ n₁ in w = z − 1 (divided by w for free handles), constant term first.
    pub undelayed: Vec<f64>,
    /// n₁ n₂ in w.
    pub delayed: Vec<f64>,
    /// N, the round trip in sample periods.
    pub ticks: f64,
    /// The sample period h, s.
    pub period: f64,
    /// True if w has been divided out.
    pub deflated: bool,
}

/// The product of two polynomials of a sampled characteristic function, constant term first.
fn multiply_polynomials(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            product[i + j] += x * y;
        }
    }
    product
}

/// The value and derivative of a polynomial in a sampled characteristic function, constant term first.
fn evaluate_polynomial(polynomial: &[f64], w: Complex64) -> (Complex64, Complex64) {
    let zero = Complex64::ZERO;
    polynomial
        .iter()
        .rev()
        .fold((zero, zero), |(value, slope), &coefficient| (value * w + coefficient, slope * w + value))
}

impl SampledCharacteristic {
    /// The characteristic function of a sampled axis at a stiffness (N/m) over a network.
    pub fn new(axis: &DyadAxis, stiffness: f64, network: &Network) -> Self {
        let [q, n]: [Vec<Vec<f64>>; 2] = {
            let sides = axis
                .sides
                .map(|side| SampledPlant::new(&side, network.sample_period(), network.computing_time()));
            [
                sides.iter().map(SampledPlant::denominator).collect(),
                sides.iter().map(|side| side.numerator(stiffness, axis.coupling_damping)).collect(),
            ]
        };
        let mut undelayed = multiply_polynomials(&q[0], &q[1]);
        for product in [multiply_polynomials(&q[0], &n[1]), multiply_polynomials(&q[1], &n[0])] {
            for (sum, part) in undelayed.iter_mut().zip(product) {
                *sum += part;
            }
        }
        let deflated = axis.is_free();
        if deflated {
            // Exactly 0: q₁ and q₂ both carry the factor w.
            undelayed.remove(0);
        }
        let [forward, backward] = network.whole_ticks();
        Self {
            undelayed,
            delayed: multiply_polynomials(&n[0], &n[1]),
            ticks: (forward + backward) as f64,
            period: network.sample_period(),
            deflated,
        }
    }

    /// The value of the sampled characteristic function and its derivative with respect to s.
    pub fn value_and_derivative(&self, s: Complex64) -> (Complex64, Complex64) {
        let w = exp_m1(s * self.period);
        let (c, c_slope) = evaluate_polynomial(&self.undelayed, w);
        let (b, b_slope) = evaluate_polynomial(&self.delayed, w);
        let (e, e_slope) = self.delay_factor(s, w);
        let slope = c_slope + b_slope * e + b * e_slope;
        (c + b * e, slope * (w + 1.0) * self.period)
    }

    /// The sampled characteristic function's delay factor 1 − z^(−N), divided by w if deflated, and its
    /// derivative with respect to w.
    pub fn delay_factor(&self, s: Complex64, w: Complex64) -> (Complex64, Complex64) {
        let n = self.ticks;
        let lost = -exp_m1(-s * (self.period * n));
        let turned = (1.0 - lost) * n / (1.0 + w);
        if !self.deflated {
            return (lost, turned);
        }
        if w.norm() * n.max(1.0) < 1e-3 {
            let value = if w == Complex64::ZERO { Complex64::from(n) } else { lost / w };
            // Two terms of Σ_j −j z^(−j−1): they only affect the speed of Newton's method.
            return (value, -0.5 * n * (n + 1.0) + w * (n * (n + 1.0) * (n + 2.0) / 3.0));
        }
        let value = lost / w;
        (value, (turned - value) / w)
    }

    /// A typical rate (1/s) of the fastest part of the sampled loop and the round trip.
    pub fn rate_scale(&self, axis: &DyadAxis, stiffness: f64) -> f64 {
        let fastest = axis
            .sides
            .iter()
            .map(|side| {
                (side.damping + axis.coupling_damping) / side.mass
                    + ((stiffness + side.ground_stiffness) / side.mass).sqrt()
            })
            .fold(0.0, f64::max);
        1.0 / (self.ticks * self.period + 1.0 / fastest)
    }

    /// The deepest decay rate (1/s) at which powers of z stay in range.
    pub fn deepest_rate(&self) -> f64 {
        -(600.0 / (self.ticks + 8.0)).min(40.0) / self.period
    }
}
