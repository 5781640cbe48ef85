//! The count of multipliers outside a circle, by a walk that cannot skip a turn.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::sampled_characteristic::SampledCharacteristic;
use crate::characteristic::exp_m1;

/// Steps after which a walk is given up; a delay of 100 s at 1 kHz needs some 1e4.
const MAX_STEPS: usize = 1_000_000;
/// The most places that are handed to Newton's method.
const MAX_PLACES: usize = 24;

/// Why a walk gave no count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CountFailure {
    /// A root lies on the circle, or too near to tell.
    RootOnCircle,
    /// The delay turns the function too often.
    TooLong,
}

/// All Taylor coefficients of a polynomial at `w`, by repeated synthetic division.
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

/// The most that a polynomial can change within `distance`.
fn change_bound(taylor: &[f64; 8], distance: f64) -> f64 {
    distance * taylor[1..].iter().rev().fold(0.0, |sum, coefficient| sum * distance + coefficient)
}

/// The number of multipliers with |z| > e^(rate·h), and the places s on the circle where the function
/// comes closest to 0.
///
/// From z = r to z = −r: each step is short enough that the function stays within a disc around its
/// value that does not hold 0, by bounds on its parts, so its argument is followed exactly.
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
    // A minimum at the last point has no successor to show it.
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
    Ok((count as usize, places.into_iter().map(|(_, place)| place).collect()))
}
