//! The target that the agents follow, as a function of time.

use super::{Schedule, Target};

/// Position and velocity of the target at one tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TargetPoint {
    /// m.
    pub position: [f64; 2],
    /// m/s.
    pub velocity: [f64; 2],
}

/// Eq. 12, the only place where it is written out: p*(t) = (A sin 2ωt, B sin ωt) and its derivative, with A
/// and B in m, ω in rad/s and t in s.
fn figure_eight([a, b]: [f64; 2], w: f64, time: f64) -> TargetPoint {
    let (sin, cos) = (w * time).sin_cos();
    TargetPoint {
        // sin 2ωt and cos 2ωt by the double angle
        position: [2.0 * a * sin * cos, b * sin],
        velocity: [2.0 * a * w * (cos - sin) * (cos + sin), b * w * cos],
    }
}

/// Positions of the target of Eq. 12 at the given times (s), m, for amplitudes A and B (m) and ω (rad/s).
///
/// # Examples
///
/// ```
/// let half = std::f64::consts::FRAC_PI_4;
/// let [[x, y]] = telespring::rig::figure_eight_positions([0.05, 0.1], 1.0, &[half])[..] else { panic!() };
/// assert!((x - 0.05).abs() < 1e-15 && (y - 0.1 * half.sin()).abs() < 1e-15);
/// ```
pub fn figure_eight_positions(amplitude: [f64; 2], angular_frequency: f64, times: &[f64]) -> Vec<[f64; 2]> {
    times.iter().map(|&time| figure_eight(amplitude, angular_frequency, time).position).collect()
}

impl Target {
    /// The target positions in every recorded row of a schedule at this sample period (s), m; empty for a
    /// sampled target without samples.
    pub fn positions(&self, schedule: &Schedule, sample_period: f64) -> Vec<[f64; 2]> {
        if matches!(self, Self::Sampled(samples) if samples.is_empty()) {
            return Vec::new();
        }
        (0..schedule.rows())
            .map(|row| self.at_tick(row * schedule.stride(), sample_period).position)
            .collect()
    }

    /// The target at any time (s), for controllers with this period (s). A sampled target is that of the nearest tick.
    pub(crate) fn at_time(&self, time: f64, period: f64) -> TargetPoint {
        match self {
            Self::FigureEight { amplitude, angular_frequency } => {
                figure_eight(*amplitude, *angular_frequency, time)
            }
            Self::Sampled(_) => self.at_tick((time / period).round() as usize, period),
        }
    }

    /// The target at a tick of controllers with this period (s). A sampled target stays at its last sample.
    pub(crate) fn at_tick(&self, tick: usize, period: f64) -> TargetPoint {
        match self {
            Self::FigureEight { amplitude, angular_frequency } => {
                figure_eight(*amplitude, *angular_frequency, tick as f64 * period)
            }
            Self::Sampled(samples) => {
                let last = samples.len() - 1;
                let position = samples[tick.min(last)];
                let next = samples[(tick + 1).min(last)];
                TargetPoint { position, velocity: [0, 1].map(|axis| (next[axis] - position[axis]) / period) }
            }
        }
    }
}
