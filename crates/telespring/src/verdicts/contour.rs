//! Counts the multipliers of a sampled axis outside a circle by the argument principle.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::sampled_characteristic::SampledCharacteristic;
use crate::characteristic::exp_m1;

/// The maximum number of steps; a delay of 100 s at 1 kHz needs about 1e4.
const MAX_STEPS: usize = 1_000_000;
/// The maximum number of starting points for Newton's method.
const MAX_PLACES: usize = 24;

/// Why the multipliers could not be counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CountFailure {
    /// A root lies on the circle or too close to it.
    RootOnCircle,
    /// The delay turns the function too often.
    TooLong,
}

/// The Taylor coefficients of a polynomial at a point `w` of the contour, by repeated synthetic division.
fn taylor_coefficients(polynomial: &[f64], w: Complex64) -> [Complex64; 8] {
    let mut shifted = [Complex64::ZERO; 8];
    for (slot, &coefficient) in shifted.iter_mut().zip(polynomial) {
        *slot = coefficient.into();
    }
    let length = polynomial.len();
    for start in 0..length {
        for i in (start..length - 1).rev() {
            let carried = shifted[i + 1] * w;
            shifted[i] += carried;
        }
    }
    shifted
}

/// An upper bound on the change of a polynomial within `distance` along the contour.
fn change_bound(taylor: &[f64; 8], distance: f64) -> f64 {
    distance * taylor[1..].iter().rev().fold(0.0, |sum, coefficient| sum * distance + coefficient)
}

/// The number of multipliers with |z| > e^(rate·h), and the points s on the circle where the function comes
/// closest to 0.
///
/// The circle is followed from z = r to z = −r. Bounds on the parts of the function keep it, over each
/// step, within a disc around its value that excludes 0, so its argument is followed exactly.
pub(super) fn count_outside_circle(
    function: &SampledCharacteristic,
    rate: f64,
) -> Result<(usize, Vec<Complex64>), CountFailure> {
    let h = function.period;
    let n = function.ticks;
    let radius = (rate * h).exp();
    let echo_size = (-rate * h * n).exp();
    if !echo_size.is_finite() {
        return Err(CountFailure::TooLong);
    }
    let mut places: Vec<(f64, Complex64)> = Vec::new();
    let mut closeness = [f64::INFINITY; 2];
    let mut previous_place = Complex64::ZERO;
    let mut angle = 0.0_f64;
    let mut turned = 0.0;
    let mut step = PI / 8.0;
    let mut current: Option<Complex64> = None;
    for _ in 0..MAX_STEPS {
        let s = Complex64::new(rate, angle / h);
        let w = exp_m1(Complex64::new(rate * h, angle));
        let (echo, _) = function.delay_factor(s, w);
        let c = taylor_coefficients(&function.undelayed, w);
        let b = taylor_coefficients(&function.delayed, w);
        let value = c[0] + b[0] * echo;
        if let Some(before) = current {
            turned += (value / before).arg();
        }
        current = Some(value);

        let size = value.norm();
        let terms = |polynomial: &[f64]| {
            polynomial.iter().rev().fold(0.0, |sum, coefficient| sum * w.norm() + coefficient.abs())
        };
        let relative = size / (terms(&function.undelayed) + terms(&function.delayed) * echo.norm());
        if closeness[1] < closeness[0] && closeness[1] <= relative {
            places.push((closeness[1], previous_place));
        }
        closeness = [closeness[1], relative];
        previous_place = s;
        if angle >= PI {
            break;
        }

        let c = c.map(|coefficient| coefficient.norm());
        let b = b.map(|coefficient| coefficient.norm());
        let echo_norm = echo.norm();
        let w_norm = w.norm();
        step = (2.0 * step).min(PI - angle);
        loop {
            let distance = radius * step;
            let turn = echo_size * (n * step).min(2.0);
            let echo_change = if function.deflated {
                let near = n * n * echo_size.max(1.0) * step;
                let left = w_norm - distance;
                if left > 0.0 { near.min((turn + echo_norm * distance) / left) } else { near }
            } else {
                turn
            };
            let b_change = change_bound(&b, distance);
            let moved = change_bound(&c, distance) + b_change * echo_norm + (b[0] + b_change) * echo_change;
            if moved <= 0.9 * size {
                break;
            }
            step *= 0.5;
            if angle + step == angle || step.is_nan() {
                return Err(CountFailure::RootOnCircle);
            }
        }
        angle = if step >= PI - angle { PI } else { angle + step };
    }
    if angle < PI {
        return Err(CountFailure::TooLong);
    }
    // A minimum at the last point has no successor to reveal it.
    if closeness[1] < closeness[0] {
        places.push((closeness[1], previous_place));
    }
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    places.truncate(MAX_PLACES);
    // The function is real at both ends; half of the circle turns by π per turn of the whole.
    let turns = turned / PI;
    let degree = (function.undelayed.len() - 1) as f64;
    let outside = degree - turns;
    let count = outside.round();
    if (outside - count).abs() > 1e-3 || count < 0.0 {
        return Err(CountFailure::RootOnCircle);
    }
    // A slow real multiplier close to z = 1 shows no minimum there, where all terms vanish together.
    let places = places.into_iter().map(|(_, place)| place).chain([Complex64::from(rate)]);
    Ok((count as usize, places.collect()))
}
