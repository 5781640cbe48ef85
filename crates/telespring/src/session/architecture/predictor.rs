//! The predictors that an architecture may have.

use crate::session::predictor::{MotionModel, Noise};

/// What a Kalman filter assumes of the partner's motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KalmanDesign {
    /// What it takes for constant.
    pub model: MotionModel,
    /// Its noise.
    pub noise: Noise,
}

impl Default for KalmanDesign {
    /// A constant acceleration with the noise of smooth hands that follow the paper's figure (`docs/guard.md`):
    /// 100 m²/s⁵, and 10 µm.
    fn default() -> Self {
        Self { model: MotionModel::ConstantAcceleration, noise: Noise { process: 100.0, position: 1e-5 } }
    }
}

/// From the partner's motion as played to now.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum PredictorDesign {
    /// The motion as played.
    #[default]
    Hold,
    /// The partner goes on at its velocity.
    Linear,
    /// A Kalman filter of the partner's motion.
    Kalman(KalmanDesign),
    /// The partner keeps its distance from the target that both sides show.
    SharedTarget,
}

impl PredictorDesign {
    /// The words for the kinds of predictor.
    pub const KINDS: [&'static str; 4] = ["hold", "linear", "kalman", "shared-target"];

    /// The predictor of this kind with its usual settings; `None` for another word.
    pub fn of_kind(kind: &str) -> Option<Self> {
        Some(match kind {
            "hold" => Self::Hold,
            "linear" => Self::Linear,
            "kalman" => Self::Kalman(KalmanDesign::default()),
            "shared-target" => Self::SharedTarget,
            _ => return None,
        })
    }

    /// The word for the kind of this predictor.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Hold => "hold",
            Self::Linear => "linear",
            Self::Kalman(_) => "kalman",
            Self::SharedTarget => "shared-target",
        }
    }
}
