//! Predictors: from the partner's motion of some time ago to its motion now.
//!
//! The play-out gives a motion of a known age. A predictor says where the partner is now. It may be wrong: the guard
//! makes any answer safe. The bare spring with a predictor is a delay system of its own.

mod hold;
mod kalman;
mod linear;
mod noise_fit;
mod shared_target;

pub use hold::Hold;
pub use kalman::{Kalman, MotionModel, Noise};
pub use linear::Linear;
pub use noise_fit::{FitEnd, NoiseFit, fit_noise};
pub use shared_target::SharedTarget;

use super::motion::Motion;
use super::time::{PeerTime, Span};

/// The partner's motion as it left the play-out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Played {
    /// The motion.
    pub motion: Motion,
    /// When the partner measured it, on the partner's clock.
    pub time: PeerTime,
    /// How long ago that is.
    pub age: Span,
    /// Whether an older motion is held because no newer one has come.
    pub held: bool,
}

/// The target that both sides show, on the shared clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SharedTargetView {
    /// The target now.
    pub now: Motion,
    /// The target when the partner measured the played motion.
    pub then: Motion,
}

/// From the partner's motion of some time ago to its motion now.
pub trait Predictor {
    /// The partner's motion now. Called once per tick with the motion in use; `target` is the shared target, if there
    /// is one.
    fn predict(&mut self, played: &Played, target: Option<&SharedTargetView>) -> Motion;

    /// Forgets everything, for instance after the partner has restarted.
    fn reset(&mut self);
}

/// The predictor of a session.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum PredictorChoice {
    /// The motion as played.
    Hold(Hold),
    /// The partner goes on at its velocity.
    Linear(Linear),
    /// A Kalman filter of the partner's motion.
    Kalman(Kalman),
    /// The partner keeps its distance from the target that both sides show.
    SharedTarget(SharedTarget),
}

impl Default for PredictorChoice {
    fn default() -> Self {
        Self::Hold(Hold)
    }
}

impl PredictorChoice {
    /// Whether the predictor uses the target that both sides show.
    pub fn uses_target(&self) -> bool {
        matches!(self, Self::SharedTarget(_))
    }

    fn chosen_mut(&mut self) -> &mut dyn Predictor {
        match self {
            Self::Hold(predictor) => predictor,
            Self::Linear(predictor) => predictor,
            Self::Kalman(predictor) => predictor,
            Self::SharedTarget(predictor) => predictor,
        }
    }
}

impl Predictor for PredictorChoice {
    fn predict(&mut self, played: &Played, target: Option<&SharedTargetView>) -> Motion {
        self.chosen_mut().predict(played, target)
    }

    fn reset(&mut self) {
        self.chosen_mut().reset();
    }
}

/// The predicted motion if a handle can have it, otherwise the played one.
fn possible(predicted: Motion, played: &Played) -> Motion {
    if predicted.impossible_value().is_none() { predicted } else { played.motion }
}
