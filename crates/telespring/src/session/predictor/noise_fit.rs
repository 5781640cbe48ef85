//! The noise of a Kalman filter, fitted to recorded motion.

use super::kalman::{Filter, MotionModel, Noise};
use crate::error::{InvalidInput, Result};
use crate::session::Motion;

/// The fewest samples that a fit needs.
const FEWEST: usize = 20;
/// The ratios of process to measurement noise that are tried, as powers of ten, without a unit.
const RATIOS: (i32, i32) = (-16, 6);
/// The difference of logarithmic likelihoods that tells a noise from none: half the 95 % point of χ² with one degree of
/// freedom.
const CONFIDENT: f64 = 1.92;
/// The variances of velocity and acceleration at the start, over those that two or three samples give: far above what the
/// largest ratio adds.
const UNKNOWN: f64 = 1e12;

/// How the fit of a noise ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FitEnd {
    /// The likelihood has a maximum, and both noises are surely there.
    Maximum,
    /// The record does not tell the measurement noise from none (likelihood ratio at 95 %): the positions are exact, or too
    /// far apart to show their noise.
    NoMeasurementNoise,
    /// The record does not tell the process noise from none: the motion follows the model.
    NoProcessNoise,
}

/// A fitted noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseFit {
    /// The noise of the largest likelihood.
    pub noise: Noise,
    /// Its logarithmic likelihood; larger by some units means a better model of the same record.
    pub log_likelihood: f64,
    /// How the fit ended.
    pub end: FitEnd,
}

/// Fits the noise of a Kalman filter to recorded positions (m, per axis) at their times (s) by maximum likelihood.
///
/// The likelihood is that of the innovations of both axes, with the first two or three samples for the start. The
/// measurement noise is profiled out, so that one number is searched: the ratio of process to measurement noise.
///
/// # Errors
///
/// [`InvalidInput`] if there are fewer than 20 samples, as many times as positions are not given, a value is not finite,
/// the times do not rise, or nothing moves.
///
/// # Examples
///
/// ```
/// use telespring::session::predictor::{FitEnd, MotionModel, fit_noise};
///
/// // a hand on a circle of 5 cm, measured in steps of 0.1 mm
/// let times: Vec<f64> = (0..4000).map(|n| n as f64 * 0.005).collect();
/// let step = |x: f64| (x / 1e-4).round() * 1e-4;
/// let positions: Vec<[f64; 2]> =
///     times.iter().map(|t| [step(0.05 * (3.0 * t).cos()), step(0.05 * (3.0 * t).sin())]).collect();
/// let fit = fit_noise(MotionModel::ConstantAcceleration, &times, &positions)?;
/// assert_eq!(fit.end, FitEnd::Maximum);
/// assert!((fit.noise.position / (1e-4 / 12.0_f64.sqrt()) - 1.0).abs() < 0.1); // a uniform error
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn fit_noise(model: MotionModel, times: &[f64], positions: &[[f64; 2]]) -> Result<NoiseFit> {
    let mean_step = check_record(times, positions)?;
    let unit = match model {
        MotionModel::ConstantVelocity => mean_step.powi(-3),
        MotionModel::ConstantAcceleration => mean_step.powi(-5),
    };
    let record = Record { model, times, positions, mean_step };
    // over half the logarithm to base 10, so that whole numbers are half decades
    let at = |half_decades: f64| record.profile(unit * 10.0_f64.powf(0.5 * half_decades));
    let (first, last) = (2 * RATIOS.0, 2 * RATIOS.1);
    let mut best = (first, f64::NEG_INFINITY);
    for half_decades in first..=last {
        let likelihood = at(f64::from(half_decades)).0;
        if likelihood > best.1 {
            best = (half_decades, likelihood);
        }
    }
    let at_edge = |edge: i32| at(f64::from(edge)).0 > best.1 - CONFIDENT;
    let end = match () {
        () if at_edge(last) => FitEnd::NoMeasurementNoise,
        () if at_edge(first) => FitEnd::NoProcessNoise,
        () => FitEnd::Maximum,
    };
    let exponent = match best.0 {
        edge if edge == first || edge == last => f64::from(edge),
        inside => largest(|x| at(x).0, f64::from(inside) - 1.0, f64::from(inside) + 1.0),
    };
    let (log_likelihood, variance) = at(exponent);
    if !(variance > 0.0) {
        return Err(InvalidInput::new(
            "positions",
            "the same everywhere",
            "the recorded handle must move",
            "Record a hand that follows its target.",
        ));
    }
    let noise = Noise { process: variance * unit * 10.0_f64.powf(0.5 * exponent), position: variance.sqrt() };
    Ok(NoiseFit { noise, log_likelihood, end })
}

/// The mean time between the samples of a record that can be fitted, s.
fn check_record(times: &[f64], positions: &[[f64; 2]]) -> Result<f64> {
    if times.len() < FEWEST || times.len() != positions.len() {
        return Err(InvalidInput::new(
            "positions",
            format!("{} positions at {} times", positions.len(), times.len()),
            format!("a fit needs at least {FEWEST} positions and as many times"),
            "Give a longer record, and one time for every position.",
        ));
    }
    for (index, pair) in times.windows(2).enumerate() {
        if let &[earlier, later] = pair
            && !(later > earlier && later.is_finite() && earlier.is_finite())
        {
            return Err(InvalidInput::new(
                format!("times[{}]", index + 1),
                later,
                "times must be numbers that rise",
                "Sort the record, and leave out what is there twice.",
            ));
        }
    }
    for (index, position) in positions.iter().enumerate() {
        for value in position {
            if !(value.abs() <= crate::session::motion::MAX_VALUE) {
                return Err(InvalidInput::new(
                    format!("positions[{index}]"),
                    value,
                    "positions must be numbers in metres",
                    "Leave out samples without a position: the times need not be regular.",
                ));
            }
        }
    }
    let (first, last) = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(1.0));
    Ok((last - first) / (times.len() - 1) as f64)
}

/// A record to be fitted.
struct Record<'a> {
    model: MotionModel,
    times: &'a [f64],
    positions: &'a [[f64; 2]],
    mean_step: f64,
}

impl Record<'_> {
    /// The logarithmic likelihood at a ratio of process noise to measurement variance, and the variance that maximises it.
    fn profile(&self, ratio: f64) -> (f64, f64) {
        let square = self.mean_step * self.mean_step;
        let (acceleration, start) = match self.model {
            MotionModel::ConstantVelocity => (0.0, 2),
            MotionModel::ConstantAcceleration => (UNKNOWN / (square * square), 3),
        };
        let mut samples = self.times.iter().zip(self.positions);
        let Some((&first, &position)) = samples.next() else { return (f64::NEG_INFINITY, 0.0) };
        let mut filter =
            Filter::start(&Motion { position, velocity: [0.0; 2] }, [1.0, UNKNOWN / square, acceleration]);
        let (mut last, mut sum, mut logarithms, mut count) = (first, 0.0, 0.0, 0.0);
        for (index, (&time, &position)) in samples.enumerate() {
            filter.advance(time - last, self.model, ratio);
            last = time;
            let ([x, y], variance) = filter.update(position, 1.0);
            if index + 1 >= start {
                sum += (x * x + y * y) / variance;
                logarithms += 2.0 * variance.ln();
                count += 2.0;
            }
        }
        let variance = sum / count;
        let likelihood = -0.5 * (logarithms + count * (variance * std::f64::consts::TAU).ln() + count);
        (if likelihood.is_nan() { f64::NEG_INFINITY } else { likelihood }, variance)
    }
}

/// Where a function with one maximum between two points has it, by golden sections.
fn largest(function: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let section = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut left, mut right) = (high - section * (high - low), low + section * (high - low));
    let (mut at_left, mut at_right) = (function(left), function(right));
    for _ in 0..30 {
        if at_left > at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - section * (high - low);
            at_left = function(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + section * (high - low);
            at_right = function(right);
        }
    }
    0.5 * (low + high)
}
