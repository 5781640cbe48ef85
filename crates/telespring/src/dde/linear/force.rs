//! Forces on a robot as functions of its local time.

use super::MAGNITUDE_LIMIT;
use super::piecewise::PiecewisePolynomial;
use super::series::{Coefficients, Instant};
use crate::error::{InvalidInput, Result};
use crate::quantity;

/// A sine: amplitude · sin(angular_frequency · t + phase).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sine {
    /// Amplitude, N.
    pub amplitude: f64,
    /// Angular frequency, rad/s.
    pub angular_frequency: f64,
    /// Phase at t = 0, rad.
    pub phase: f64,
}

/// The value of a sampled signal between its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hold {
    /// Zero-order hold: each value is held until the next sample, as a digital controller does.
    Zero,
    /// Linear interpolation between samples.
    Linear,
}

/// A force sampled at t = i/rate, i = 0, 1, …; after the last sample its value is held.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledForce {
    values: Vec<f64>,
    rate: f64,
    hold: Hold,
}

impl SampledForce {
    /// Creates a force from its samples (N), rate (Hz) and interpolation.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if there is no value, a value is not finite or beyond 1e12 N, or the rate is out of
    /// range.
    pub fn new(values: Vec<f64>, rate: f64, hold: Hold) -> Result<Self> {
        quantity::RATE.check("rate", rate)?;
        if values.is_empty() {
            return Err(InvalidInput::new(
                "values",
                "[]",
                "a sampled force needs at least one value",
                "Give the samples, or a constant force of 0.",
            ));
        }
        for (i, &value) in values.iter().enumerate() {
            check_magnitude(&format!("values[{i}]"), value, "N")?;
        }
        Ok(Self { values, rate, hold })
    }

    /// The sample of the force at an index, held after the last.
    fn value(&self, index: usize) -> f64 {
        self.values[index.min(self.values.len() - 1)]
    }

    /// True if the sampled force changes at sample `index` (from 1 on).
    fn changes_at_sample(&self, index: usize) -> bool {
        let (before, here) = (self.value(index - 1), self.value(index));
        match self.hold {
            Hold::Zero => here != before,
            Hold::Linear => here != before || self.value(index + 1) != here,
        }
    }
}

/// The force of a person or motor on one robot, from t = 0 of that robot's clock.
///
/// # Examples
///
/// ```
/// use telespring::dde::linear::Force;
/// let push = Force::Step(1.0);
/// let swing = Force::from_function(&mut |t| (3.0 * t).sin() * (-t).exp(), &[], 10.0)?;
/// assert!(swing.error() < 1e-13);
/// # assert_eq!(push.error(), 0.0);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Force {
    /// A constant force, N.
    Step(f64),
    /// A constant (N) and a sum of sines.
    Sines {
        /// The constant part, N.
        constant: f64,
        /// The sines.
        sines: Vec<Sine>,
    },
    /// A sampled signal.
    Sampled(SampledForce),
    /// Polynomials of time, N.
    Polynomial(PiecewisePolynomial),
}

/// A break point: a time at which a force or a history is not smooth.
#[derive(Debug, Clone, Copy)]
pub(super) struct Break {
    /// The time on the robot's own clock, s.
    pub time: f64,
    /// The lowest derivative of the position that may jump there.
    pub order: usize,
    /// The effect of the jump, relative to the signal.
    pub effect: f64,
}

/// The effect of an edge between pieces of a smooth approximation.
pub(super) const SMOOTH_EDGE: f64 = 1e-13;

impl Force {
    /// Approximates a function of time (s) over `duration` (s) that may jump or have kinks at
    /// `breakpoints`.
    ///
    /// [`Force::error`] gives the approximation error; see [`PiecewisePolynomial::from_function`]. After
    /// `duration` the last value is held.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the duration is out of range, or the function returns a value that is not finite
    /// or is beyond 1e12 N.
    pub fn from_function(
        function: &mut dyn FnMut(f64) -> f64,
        breakpoints: &[f64],
        duration: f64,
    ) -> Result<Self> {
        quantity::DURATION.check("duration", duration)?;
        PiecewisePolynomial::from_function(function, breakpoints, 0.0, duration).map(Self::Polynomial)
    }

    /// The estimated approximation error, N; 0 unless the force came from a function.
    pub fn error(&self) -> f64 {
        match self {
            Self::Polynomial(pieces) => pieces.error(),
            _ => 0.0,
        }
    }

    /// Whether that error is small; see [`PiecewisePolynomial::is_resolved`].
    pub fn is_resolved(&self) -> bool {
        match self {
            Self::Polynomial(pieces) => pieces.is_resolved(),
            _ => true,
        }
    }

    /// Checks the amplitudes, frequencies and phases of a force.
    pub(super) fn check(&self, field: &str) -> Result<()> {
        match self {
            Self::Step(value) => check_magnitude(field, *value, "N"),
            Self::Sines { constant, sines } => {
                check_magnitude(&format!("{field}.constant"), *constant, "N")?;
                for (i, sine) in sines.iter().enumerate() {
                    check_magnitude(&format!("{field}.sines[{i}].amplitude"), sine.amplitude, "N")?;
                    check_magnitude(
                        &format!("{field}.sines[{i}].angular_frequency"),
                        sine.angular_frequency,
                        "rad/s",
                    )?;
                    check_magnitude(&format!("{field}.sines[{i}].phase"), sine.phase, "rad")?;
                }
                Ok(())
            }
            Self::Sampled(_) | Self::Polynomial(_) => Ok(()),
        }
    }

    /// The fastest rate of the force signal itself, 1/s.
    pub(super) fn fastest_rate(&self) -> f64 {
        match self {
            Self::Sines { sines, .. } => sines.iter().map(|s| s.angular_frequency.abs()).fold(0.0, f64::max),
            _ => 0.0,
        }
    }

    /// The maximum number of breaks of the force before `end` (s).
    pub(super) fn breaks_before(&self, end: f64) -> f64 {
        match self {
            Self::Sampled(sampled) => (sampled.values.len() as f64).min(end * sampled.rate),
            Self::Polynomial(pieces) => pieces.edges().partition_point(|&edge| edge < end) as f64,
            _ => 0.0,
        }
    }

    /// The first break of the force at or after index `cursor`; moves `cursor` to it.
    pub(super) fn next_break(&self, cursor: &mut usize) -> Option<Break> {
        match self {
            Self::Step(_) | Self::Sines { .. } => None,
            Self::Sampled(sampled) => {
                *cursor = (*cursor).max(1);
                while *cursor < sampled.values.len() && !sampled.changes_at_sample(*cursor) {
                    *cursor += 1;
                }
                let order = if sampled.hold == Hold::Zero { 2 } else { 3 };
                (*cursor < sampled.values.len()).then(|| Break {
                    time: *cursor as f64 / sampled.rate,
                    order,
                    effect: 1.0,
                })
            }
            Self::Polynomial(pieces) => {
                while pieces.edges().get(*cursor).is_some_and(|&edge| edge <= 0.0) {
                    *cursor += 1;
                }
                pieces.edges().get(*cursor).map(|&time| Break {
                    time,
                    order: 2,
                    effect: if pieces.is_break(*cursor) { 1.0 } else { SMOOTH_EDGE },
                })
            }
        }
    }

    /// Writes the Taylor series of the force over [start, start + length]; returns the number of
    /// coefficients.
    pub(super) fn series(
        &self,
        start: Instant,
        length: f64,
        degree: usize,
        into: &mut Coefficients,
    ) -> usize {
        match self {
            Self::Step(value) => {
                into[0] = *value;
                1
            }
            Self::Sines { constant, sines } => {
                into[..=degree].fill(0.0);
                into[0] = *constant;
                for sine in sines {
                    add_sine_series(sine, start, length, &mut into[..=degree]);
                }
                degree + 1
            }
            Self::Sampled(sampled) => {
                let middle = start.high + 0.5 * length;
                let index = (middle * sampled.rate).max(0.0) as usize;
                let value = sampled.value(index);
                if sampled.hold == Hold::Zero {
                    into[0] = value;
                    return 1;
                }
                let rise = sampled.value(index + 1) - value;
                let fraction = start.high.mul_add(sampled.rate, -(index as f64)) + start.low * sampled.rate;
                into[0] = value + rise * fraction;
                into[1] = rise * sampled.rate * length;
                2
            }
            Self::Polynomial(pieces) => pieces.series(start.high, length, start.high + 0.5 * length, into),
        }
    }
}

/// Adds the Taylor series of a sinusoidal force over one step.
fn add_sine_series(sine: &Sine, start: Instant, length: f64, into: &mut [f64]) {
    let omega = sine.angular_frequency;
    // The angle to twice the working precision: rounding it at 1e5 rad would cost 1e-11.
    let angle = omega * start.high;
    let rest = omega.mul_add(start.high, -angle) + omega * start.low + sine.phase;
    let ((s, c), (rest_s, rest_c)) = (angle.sin_cos(), rest.sin_cos());
    let step = omega * length;
    let mut even = sine.amplitude * (s * rest_c + c * rest_s);
    let mut odd = sine.amplitude * (c * rest_c - s * rest_s) * step;
    for (pair, values) in into.chunks_mut(2).enumerate() {
        let n = 2.0 * pair as f64;
        values[0] += even;
        even *= -step * step / ((n + 1.0) * (n + 2.0));
        if let Some(value) = values.get_mut(1) {
            *value += odd;
            odd *= -step * step / ((n + 2.0) * (n + 3.0));
        }
    }
}

/// Checks that a value of a force is finite and within [`MAGNITUDE_LIMIT`].
pub(super) fn check_magnitude(field: &str, value: f64, unit: &str) -> Result<()> {
    if value.abs() <= MAGNITUDE_LIMIT {
        return Ok(());
    }
    Err(InvalidInput::new(
        field,
        value,
        format!("a finite number of at most {MAGNITUDE_LIMIT:e} {unit} in magnitude is required"),
        "Replace missing or infinite values by numbers.",
    ))
}
