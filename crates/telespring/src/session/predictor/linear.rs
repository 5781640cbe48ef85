//! Prediction along a straight line.

use super::{Played, Predictor, SharedTargetView, possible};
use crate::session::Motion;

/// Prediction along a straight line: the played position plus its age times the velocity, which is kept.
///
/// With the bare spring and ages that do not change this is a linear delay system: see `docs/guard.md` for where the
/// prediction itself destabilises. Only a motion that no handle can have is refused; then the played one is used.
#[derive(Debug, Clone, Copy, Default)]
pub struct Linear;

impl Predictor for Linear {
    fn predict(&mut self, played: &Played, _: Option<&SharedTargetView>) -> Motion {
        let Motion { position: [x, y], velocity: [u, v] } = played.motion;
        let age = played.age.seconds();
        possible(Motion { position: [x + age * u, y + age * v], velocity: [u, v] }, played)
    }

    fn reset(&mut self) {}
}
