//! Where multipliers of the sampled dyad meet the unit circle as the delay grows.
//!
//! A multiplier z = e^(jθ) satisfies A(z) = B(z) z^(−N), with A = (q₁ + n₁)(q₂ + n₂), B = n₁ n₂ and N the round trip in
//! periods. Its modulus does not depend on N: |A|² − |B|² = 0 is a polynomial in v = 1 − cos θ, of degree 4, or 6 with
//! a computing time. Each of its roots in 0 < v < 2 meets the circle at N = N₀ + 2πl/θ, so that all crossings are known, as
//! those of the continuous dyad are from the paper's Eq. 8.

use std::f64::consts::TAU;

use num_complex::Complex64;
use twofloat::TwoFloat;

use super::Network;
use super::sampled_line::{CircleFactor, CircleSide, versine};
use super::zero_order_hold::SampledPlant;
use crate::characteristic::ln_1p;
use crate::model::DyadAxis;
use crate::poly::{Polynomial, Real, positive_roots};

/// The number of coefficients of |A|² − |B|² in v, at most.
const LENGTH: usize = 7;

/// A series of round trips at which the number of multipliers outside the circle changes.
#[derive(Debug, Clone, Copy)]
pub(super) struct CrossingSeries {
    /// The first round trip, in periods.
    pub first: f64,
    /// The distance of the next one, in periods.
    pub step: f64,
    /// How many multipliers leave the circle there; negative if they return, 0 if they only touch it.
    pub leaving: i32,
}

/// A polynomial in v with 1 coefficient or more, constant term first.
fn polynomial<R: Real>(coefficients: &[f64]) -> Polynomial<R, LENGTH> {
    let mut found = Polynomial { coefficient: [R::from(0.0); LENGTH], magnitude: [0.0; LENGTH] };
    for (i, &value) in coefficients.iter().enumerate() {
        found.coefficient[i] = R::from(value);
        found.magnitude[i] = value.abs();
    }
    found
}

/// The sum of polynomials in v.
fn sum<R: Real>(a: &Polynomial<R, LENGTH>, b: &Polynomial<R, LENGTH>) -> Polynomial<R, LENGTH> {
    let mut found = *a;
    for i in 0..LENGTH {
        found.coefficient[i] = found.coefficient[i] + b.coefficient[i];
        found.magnitude[i] += b.magnitude[i];
    }
    found
}

/// The product of polynomials in v.
fn product<R: Real>(a: &Polynomial<R, LENGTH>, b: &Polynomial<R, LENGTH>) -> Polynomial<R, LENGTH> {
    let mut found = polynomial(&[]);
    for i in 0..LENGTH {
        for j in 0..LENGTH - i {
            found.coefficient[i + j] = found.coefficient[i + j] + a.coefficient[i] * b.coefficient[j];
            found.magnitude[i + j] += a.magnitude[i] * b.magnitude[j];
        }
    }
    found
}

/// |q + n|² − |n|² and |n|² of one side on the unit circle.
struct SquaredSide<R> {
    excess: Polynomial<R, LENGTH>,
    coupling: Polynomial<R, LENGTH>,
}

impl<R: Real> SquaredSide<R> {
    /// The squared moduli of one side at a stiffness with a coupling damper.
    fn new(plant: &SampledPlant, alone: &CircleFactor, stiffness: f64, damper: f64) -> Self {
        let numerator = plant.numerator(stiffness, damper);
        let [n0, n1] = [numerator[0], numerator[1]];
        let n2 = numerator.get(2).copied().unwrap_or(0.0);
        let number = R::from;
        let [m0, m1, m2] = [n0, n1, n2].map(number);
        // |n|² in v with |w|² = 2v, Re w = −v and Re w² = 2v(v − 1), free of the terms that cancel.
        let mut coupling: Polynomial<R, LENGTH> = polynomial(&[n0 * n0, 0.0, 0.0]);
        coupling.coefficient[0] = m0 * m0;
        coupling.coefficient[1] = number(2.0) * m1 * (m1 - m0) - number(4.0) * m0 * m2;
        coupling.magnitude[1] = 2.0 * n1.abs() * (n1.abs() + n0.abs()) + 4.0 * (n0 * n2).abs();
        coupling.coefficient[2] = number(4.0) * m2 * (m2 + m0 - m1);
        coupling.magnitude[2] = 4.0 * n2.abs() * (n2.abs() + n0.abs() + n1.abs());
        // |q|² + 2 Re(q n̄) with sin² θ = v (2 − v).
        let force = match numerator[..] {
            [n0, n1, n2] => CircleFactor::quadratic(n0, n1, n2),
            _ => CircleFactor::linear(n0, n1),
        };
        let twice = |p: &[f64]| polynomial::<R>(p).scaled(2.0);
        let re = product(&polynomial(&alone.re), &sum(&polynomial(&alone.re), &twice(&force.re)));
        let im = product(&polynomial(&alone.im), &sum(&polynomial(&alone.im), &twice(&force.im)));
        Self { excess: sum(&re, &product(&im, &polynomial(&[0.0, 2.0, -1.0]))), coupling }
    }
}

impl<R: Real> Polynomial<R, LENGTH> {
    /// The polynomial in v times a small whole number.
    fn scaled(mut self, factor: f64) -> Self {
        for i in 0..LENGTH {
            self.coefficient[i] = self.coefficient[i] * R::from(factor);
            self.magnitude[i] *= factor;
        }
        self
    }
}

/// |A|² − |B|² on the unit circle as a polynomial in v.
fn modulus_difference<R: Real>(
    axis: &DyadAxis,
    sides: &[(SampledPlant, CircleSide); 2],
    stiffness: f64,
) -> Polynomial<R, LENGTH> {
    let [first, second] = sides
        .each_ref()
        .map(|(plant, side)| SquaredSide::new(plant, &side.alone, stiffness, axis.coupling_damping));
    // (G₁ + |n₁|²)(G₂ + |n₂|²) − |n₁|²|n₂|².
    let mixed = sum(&product(&first.excess, &second.coupling), &product(&second.excess, &first.coupling));
    sum(&product(&first.excess, &second.excess), &mixed)
}

/// All round trips at which multipliers of the sampled axis meet the unit circle at a stiffness (N/m).
///
/// If |B| exceeds |A| at z = −1, one more multiplier leaves with every period, halfway between two whole numbers of
/// them; the function is real there, and the pairs that return make up for it.
pub(super) fn crossing_series(axis: &DyadAxis, stiffness: f64, network: &Network) -> Vec<CrossingSeries> {
    let sides = axis.sides.map(|side| {
        let plant = SampledPlant::new(&side, network.sample_period(), network.computing_time());
        (plant, CircleSide::new(&side, network, axis.coupling_damping))
    });
    let difference = modulus_difference::<f64>(axis, &sides, stiffness);
    let roots = positive_roots(&difference, || modulus_difference::<TwoFloat>(axis, &sides, stiffness));
    let mut series: Vec<CrossingSeries> = roots
        .iter()
        .filter(|root| root.at < 2.0)
        .map(|root| {
            let angle = 2.0 * (0.5 * root.at).sqrt().asin();
            let turned: f64 = sides.iter().map(|(_, side)| loop_phase(side, stiffness, angle)).sum();
            CrossingSeries {
                first: (-turned).rem_euclid(TAU) / angle,
                step: TAU / angle,
                leaving: 2 * i32::from(root.slope),
            }
        })
        .collect();
    let at_half_turn = difference.coefficient.iter().rev().fold(0.0, |sum, &value| sum * 2.0 + value);
    if at_half_turn < 0.0 {
        series.push(CrossingSeries { first: 0.5, step: 1.0, leaving: 1 });
    }
    series
}

/// arg((q + n)/n) of one side at an angle of the circle.
fn loop_phase(side: &CircleSide, stiffness: f64, angle: f64) -> f64 {
    let (v, sine) = (versine(angle), angle.sin());
    let [coupling, _] = side.at(stiffness);
    let ratio: Complex64 = side.alone.value(v, sine).0 / coupling.value(v, sine).0;
    ln_1p(ratio).im
}
