//! The control architecture: what both sides do with the partner's motion, as plain data without a state.
//!
//! An [`Architecture`] is what a study names and what two programs agree on. [`Architecture::endpoint_settings`] makes
//! the settings of a live side from it, for the laboratory and for a live program alike.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

mod predictor;
mod settings;
mod strategy;

pub use predictor::{KalmanDesign, PredictorDesign};
pub use settings::SideFacts;
pub use strategy::{
    GuardDesign, SetPositionDesign, StrategyDesign, TimeDomainPassivityDesign, TwoLayerDesign, WaveDesign,
};

use super::playout::AdaptiveDelay;

/// When both sides play the partner's motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlayoutDesign {
    /// A fixed time after its measurement, s; `None` for the delay that the network has.
    Fixed {
        /// This time, s.
        delay: Option<f64>,
    },
    /// As soon as the network allows.
    Adaptive(AdaptiveDelay),
}

impl Default for PlayoutDesign {
    /// Fixed, at the delay of the network.
    fn default() -> Self {
        Self::Fixed { delay: None }
    }
}

impl PlayoutDesign {
    /// The words for the kinds of play-out.
    pub const KINDS: [&'static str; 2] = ["fixed", "adaptive"];

    /// The play-out of this kind with its usual settings; `None` for another word.
    pub fn of_kind(kind: &str) -> Option<Self> {
        match kind {
            "fixed" => Some(Self::default()),
            "adaptive" => Some(Self::Adaptive(AdaptiveDelay::default())),
            _ => None,
        }
    }

    /// The word for the kind of this play-out.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Fixed { .. } => "fixed",
            Self::Adaptive(_) => "adaptive",
        }
    }
}

/// A control architecture: strategy, predictor and play-out, the same on both sides.
///
/// The default is the paper's bare spring.
///
/// # Examples
///
/// ```
/// use telespring::session::architecture::{Architecture, PredictorDesign, StrategyDesign};
///
/// let spring = Architecture::default();
/// assert_eq!(spring.label(), "spring");
/// let guarded = Architecture {
///     strategy: StrategyDesign::of_kind("guard").unwrap(),
///     predictor: PredictorDesign::SharedTarget,
///     ..spring
/// };
/// assert_eq!(guarded.label(), "guard + shared-target");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Architecture {
    /// How the partner's motion becomes a force.
    pub strategy: StrategyDesign,
    /// From the partner's motion as played to now.
    pub predictor: PredictorDesign,
    /// When the partner's motion is played.
    pub playout: PlayoutDesign,
}

impl Architecture {
    /// The architecture in a few words: the strategy, the predictor unless it holds, the play-out unless it is fixed.
    /// Other settings do not show.
    pub fn label(&self) -> String {
        let mut label = self.strategy.kind().to_owned();
        if self.predictor != PredictorDesign::Hold {
            label += " + ";
            label += self.predictor.kind();
        }
        if let PlayoutDesign::Adaptive(_) = self.playout {
            label += ", adaptive";
        }
        label
    }

    /// What a comparison runs if nobody chooses: the bare spring, the guard with every predictor, and the strategies of the
    /// literature, all with their usual settings.
    pub fn usual() -> Vec<Self> {
        let guard = StrategyDesign::Guard(GuardDesign::default());
        let adaptive = PlayoutDesign::Adaptive(AdaptiveDelay::default());
        let mut usual = vec![Self::default(), Self { playout: adaptive, ..Self::default() }];
        usual.extend(
            [
                PredictorDesign::Hold,
                PredictorDesign::Linear,
                PredictorDesign::Kalman(KalmanDesign::default()),
                PredictorDesign::SharedTarget,
            ]
            .map(|predictor| Self { strategy: guard, predictor, ..Self::default() }),
        );
        let others = StrategyDesign::KINDS.into_iter().filter_map(StrategyDesign::of_kind);
        let others =
            others.filter(|strategy| !matches!(strategy, StrategyDesign::Spring | StrategyDesign::Guard(_)));
        usual.extend(others.map(|strategy| Self { strategy, ..Self::default() }));
        usual
    }
}
