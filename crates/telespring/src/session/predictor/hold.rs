//! No prediction.

use super::{Played, Predictor, SharedTargetView};
use crate::session::Motion;

/// No prediction: the partner's motion as played.
#[derive(Debug, Clone, Copy, Default)]
pub struct Hold;

impl Predictor for Hold {
    fn predict(&mut self, played: &Played, _: Option<&SharedTargetView>) -> Motion {
        played.motion
    }

    fn reset(&mut self) {}
}
