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

    /// The target at a tick of controllers with this period (s). A sampled target stays at its last sample.
    pub(crate) fn at_tick(&self, tick: usize, period: f64) -> TargetPoint {
        match self {
            Self::FigureEight { amplitude: [a, b], angular_frequency: w } => {
                let (sin, cos) = (w * (tick as f64 * period)).sin_cos();
                TargetPoint {
                    // sin 2ωt and cos 2ωt by the double-angle formulas.
                    position: [2.0 * a * sin * cos, b * sin],
                    velocity: [2.0 * a * w * (cos - sin) * (cos + sin), b * w * cos],
                }
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
