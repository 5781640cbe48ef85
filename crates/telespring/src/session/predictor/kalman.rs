//! Prediction by a Kalman filter.

use super::{Played, Predictor, SharedTargetView, possible};
use crate::error::{InvalidInput, Result};
use crate::session::{Motion, PeerTime};

/// After a gap longer than this the filter starts anew, s: what a hand did before says nothing any more.
const LONGEST_GAP: f64 = 1.0;
/// The standard deviation of the velocity at the start, m/s: that of a fast hand.
const FIRST_VELOCITY: f64 = 1.0;
/// The standard deviation of the acceleration at the start, m/s²: that of a fast hand.
const FIRST_ACCELERATION: f64 = 10.0;

/// What a Kalman filter takes for constant except for white noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionModel {
    /// The velocity: the acceleration is white noise.
    ConstantVelocity,
    /// The acceleration: the jerk is white noise.
    ConstantAcceleration,
}

impl MotionModel {
    /// The words for the models.
    pub const WORDS: [&'static str; 2] = ["constant-velocity", "constant-acceleration"];

    /// The model with this word; `None` for another one.
    pub fn of_word(word: &str) -> Option<Self> {
        [Self::ConstantVelocity, Self::ConstantAcceleration].into_iter().find(|model| model.word() == word)
    }

    /// The word for this model.
    pub fn word(self) -> &'static str {
        let [velocity, acceleration] = Self::WORDS;
        match self {
            Self::ConstantVelocity => velocity,
            Self::ConstantAcceleration => acceleration,
        }
    }
}

/// The noise of a Kalman filter, the same on both axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// The spectral density of the white acceleration, m²/s³, or of the white jerk, m²/s⁵.
    pub process: f64,
    /// The standard deviation of a measured position, m.
    pub position: f64,
}

/// Prediction by a Kalman filter over the played positions (Bar-Shalom, Li and Kirubarajan, *Estimation with Applications
/// to Tracking and Navigation*, 2001, 6.2: white noise in continuous time, whatever the time between the samples).
///
/// [`fit_noise`](super::fit_noise) fits the noise to recorded motion. A motion that is held leaves the filter alone: the
/// last estimate is carried on to now.
#[derive(Debug, Clone)]
pub struct Kalman {
    model: MotionModel,
    noise: Noise,
    /// The filter and the time of its last sample.
    running: Option<(Filter, PeerTime)>,
}

impl Kalman {
    /// A filter with this model and noise.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a noise is not positive and finite.
    pub fn new(model: MotionModel, noise: Noise) -> Result<Self> {
        for (field, value) in [("process", noise.process), ("position", noise.position)] {
            if !(value > 0.0 && value.is_finite() && (value * value) > 0.0) {
                return Err(InvalidInput::new(
                    field,
                    value,
                    "the noise of a Kalman filter must be a positive number",
                    "Fit it to recorded motion; for a sensor without noise give a thousandth of its step.",
                ));
            }
        }
        Ok(Self { model, noise, running: None })
    }

    /// The filter after the played motion, and the time of its last sample.
    fn take(&mut self, played: &Played) -> (Filter, PeerTime) {
        if let Some((mut filter, last)) = self.running {
            let step = (played.time - last).seconds();
            if step.abs() <= LONGEST_GAP {
                if step <= 0.0 {
                    return (filter, last);
                }
                filter.advance(step, self.model, self.noise.process);
                filter.update(played.motion.position, self.noise.position * self.noise.position);
                return (filter, played.time);
            }
        }
        let variance = self.noise.position * self.noise.position;
        let acceleration = match self.model {
            MotionModel::ConstantVelocity => 0.0,
            MotionModel::ConstantAcceleration => FIRST_ACCELERATION * FIRST_ACCELERATION,
        };
        let spread = [variance, FIRST_VELOCITY * FIRST_VELOCITY, acceleration];
        (Filter::start(&played.motion, spread), played.time)
    }
}

impl Predictor for Kalman {
    fn predict(&mut self, played: &Played, _: Option<&SharedTargetView>) -> Motion {
        if played.motion.impossible_value().is_some() {
            return played.motion;
        }
        let (filter, last) = self.take(played);
        self.running = Some((filter, last));
        let ahead = (played.age + (played.time - last)).seconds();
        possible(filter.after(ahead), played)
    }

    fn reset(&mut self) {
        self.running = None;
    }
}

/// The estimate of both axes, and its covariance, which is the same for both.
#[derive(Debug, Clone, Copy)]
pub(super) struct Filter {
    /// Position, velocity and acceleration per axis.
    state: [[f64; 3]; 2],
    /// The upper triangle of the covariance by rows.
    covariance: [f64; 6],
}

impl Filter {
    /// A filter that has seen one motion; `spread` is the variance of position, velocity and acceleration.
    pub(super) fn start(motion: &Motion, [position, velocity, acceleration]: [f64; 3]) -> Self {
        let Motion { position: [x, y], velocity: [u, v] } = *motion;
        Self {
            state: [[x, u, 0.0], [y, v, 0.0]],
            covariance: [position, 0.0, 0.0, velocity, 0.0, acceleration],
        }
    }

    /// Carries the estimate `step` s on.
    pub(super) fn advance(&mut self, step: f64, model: MotionModel, process: f64) {
        let half = 0.5 * step * step;
        self.state = self.state.map(|[x, v, a]| [x + step * v + half * a, v + step * a, a]);
        let [xx, xv, xa, vv, va, aa] = self.covariance;
        // Φ P Φᵀ, first Φ P without the last row, which stays
        let (row_xx, row_xv, row_xa) =
            (xx + step * xv + half * xa, xv + step * vv + half * va, xa + step * va + half * aa);
        let (row_vv, row_va) = (vv + step * va, va + step * aa);
        let moved = [
            row_xx + step * row_xv + half * row_xa,
            row_xv + step * row_xa,
            row_xa,
            row_vv + step * row_va,
            row_va,
            aa,
        ];
        let square = step * step;
        let added = match model {
            MotionModel::ConstantVelocity => [square * step / 3.0, square / 2.0, 0.0, step, 0.0, 0.0],
            MotionModel::ConstantAcceleration => {
                let cube = square * step;
                [cube * square / 20.0, square * square / 8.0, cube / 6.0, cube / 3.0, square / 2.0, step]
            }
        };
        let mut sum = moved;
        for (sum, added) in sum.iter_mut().zip(added) {
            *sum += process * added;
        }
        self.covariance = sum;
    }

    /// Takes in a measured position with this variance; returns what was not expected of it per axis, and the variance of
    /// that.
    pub(super) fn update(&mut self, [x, y]: [f64; 2], variance: f64) -> ([f64; 2], f64) {
        let [xx, xv, xa, vv, va, aa] = self.covariance;
        let total = xx + variance;
        let gain = [xx / total, xv / total, xa / total];
        let [first, second] = self.state;
        let innovation = |[estimate, _, _]: [f64; 3], measured: f64| measured - estimate;
        let innovations = [innovation(first, x), innovation(second, y)];
        let correct = |[p, v, a]: [f64; 3], innovation: f64| {
            let [on_p, on_v, on_a] = gain;
            [p + on_p * innovation, v + on_v * innovation, a + on_a * innovation]
        };
        let [along_x, along_y] = innovations;
        self.state = [correct(first, along_x), correct(second, along_y)];
        let rest = variance / total;
        self.covariance = [
            xx * rest,
            xv * rest,
            xa * rest,
            (vv - xv * xv / total).max(0.0),
            va - xv * xa / total,
            (aa - xa * xa / total).max(0.0),
        ];
        (innovations, total)
    }

    /// The motion `ahead` s after the last sample.
    fn after(&self, ahead: f64) -> Motion {
        let [[x, u, a], [y, v, b]] = self.state;
        let half = 0.5 * ahead * ahead;
        Motion {
            position: [x + ahead * u + half * a, y + ahead * v + half * b],
            velocity: [u + ahead * a, v + ahead * b],
        }
    }
}
