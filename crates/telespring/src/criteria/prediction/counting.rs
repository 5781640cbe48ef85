//! The count of unstable roots of a loop with a predictor, by the argument principle.

use num_complex::Complex64;

use super::loop_polynomials::{PredictedLoop, Quintic, SidePolynomials};
use crate::characteristic::DelayExponential;
use crate::error::{InvalidInput, Result};
use crate::spectrum::contour::{Probe, Winding, taylor_step, zeros_right_of};

/// The largest number of steps along the contour.
const STEPS: usize = 400_000;

/// The characteristic function R(s) + D₁ D₂ (1 − e^(−T s)) with R = N₁ N₂ − D₁ D₂, divided by s if both handles are free.
struct PredictedCharacteristic {
    /// R, or R/s.
    remainder: Vec<f64>,
    /// D₁ D₂.
    delayed: Vec<f64>,
    round_trip: f64,
    rigid_body: bool,
}

/// The product of two polynomials, added to another one.
fn add_product(sum: &mut [f64], one: &Quintic, other: &Quintic) {
    for (i, a) in one.iter().enumerate() {
        for (j, b) in other.iter().enumerate() {
            sum[i + j] += a * b;
        }
    }
}

/// A polynomial and its first derivative at a point.
fn jet(coefficients: &[f64], s: Complex64) -> [Complex64; 2] {
    coefficients
        .iter()
        .rev()
        .fold([Complex64::ZERO; 2], |[value, slope], &c| [value * s + c, slope * s + value])
}

/// Bounds on a polynomial and its first two derivatives at this |s|.
fn bounds(coefficients: &[f64], size: f64) -> [f64; 3] {
    coefficients.iter().rev().fold([0.0; 3], |[value, slope, bend], c| {
        [value * size + c.abs(), slope * size + value, bend * size + 2.0 * slope]
    })
}

impl PredictedCharacteristic {
    /// The characteristic function of a loop at a stiffness (N/m) and an age each way (s).
    fn new(predicted: &PredictedLoop<'_>, stiffness: f64, age: f64) -> Self {
        let [first, second] =
            predicted.axis.sides.each_ref().map(|side| predicted.side(side, stiffness, age));
        let SidePolynomials { alone: a1, coupling: d1, .. } = first;
        let SidePolynomials { alone: a2, coupling: d2, .. } = second;
        let (mut remainder, mut delayed) = (vec![0.0; 11], vec![0.0; 11]);
        add_product(&mut remainder, &a1, &a2);
        add_product(&mut remainder, &a1, &d2);
        add_product(&mut remainder, &d1, &a2);
        add_product(&mut delayed, &d1, &d2);
        let rigid_body = predicted.axis.is_free();
        if rigid_body {
            // its constant is 0 exactly
            remainder.remove(0);
        }
        Self { remainder, delayed, round_trip: 2.0 * age, rigid_body }
    }
}

impl Winding for PredictedCharacteristic {
    /// A safe step to the right of the imaginary axis, where |e^(−T s)| ≤ 1.
    fn probe(&self, s: Complex64, _: Complex64, longest: f64) -> Probe {
        let t = self.round_trip;
        let exponential = DelayExponential::at(s, t);
        let lag = if self.rigid_body {
            exponential.integral(s, t)
        } else {
            crate::characteristic::Jet { value: exponential.complement, slope: exponential.decay * t }
        };
        let [remainder, remainder_slope] = jet(&self.remainder, s);
        let [delayed, delayed_slope] = jet(&self.delayed, s);
        let value = remainder + delayed * lag.value;
        let slope = remainder_slope + delayed_slope * lag.value + delayed * lag.slope;
        let curvature = |radius: f64| {
            let [least, most] = [(s.norm() - radius).max(0.0), s.norm() + radius];
            let lag = if self.rigid_body {
                DelayExponential::integral_bounds(least, t, 1.0)
            } else {
                [2.0, t, t * t]
            };
            let [value, slope, bend] = bounds(&self.delayed, most);
            bounds(&self.remainder, most)[2] + bend * lag[0] + 2.0 * slope * lag[1] + value * lag[2]
        };
        Probe { value, step: taylor_step(value.norm(), slope.norm(), curvature, longest) }
    }
}

/// The number of roots with positive real part, without the rigid-body root, at a stiffness (N/m) and an age (s).
pub(super) fn unstable_roots(predicted: &PredictedLoop<'_>, stiffness: f64, age: f64) -> Result<u32> {
    let function = PredictedCharacteristic::new(predicted, stiffness, age);
    let radius = predicted.root_bound(stiffness, age);
    // a root on the axis itself is not unstable: then a line just right of it is counted
    let mut stop = None;
    for share in [0.0, 1e-12, 1e-10, 1e-8] {
        match zeros_right_of(&function, share * radius, radius, STEPS) {
            Ok(count) => return Ok(u32::try_from(count).unwrap_or(u32::MAX)),
            Err(error) => stop = Some(error),
        }
    }
    let reason = stop.map_or_else(String::new, |error| error.to_string());
    Err(InvalidInput::new(
        "stiffness",
        stiffness,
        format!("the unstable roots of this loop cannot be counted: {reason}"),
        "Change the stiffness or the delay a little, or look at the roots of its delay system.",
    ))
}
