//! Prediction with a target that both sides show.

use super::{Played, Predictor, SharedTargetView, possible};
use crate::session::Motion;

/// Prediction with a target that both sides show: the partner keeps the distance to the target that it had when it
/// measured the played motion, p*(now) + x₂(then) − p*(then).
///
/// An error ε of the clock offset moves "then" along the target: the predicted position is wrong by at most ε times the
/// largest speed of the target. Without a target the played motion is used.
#[derive(Debug, Clone, Copy, Default)]
pub struct SharedTarget;

impl Predictor for SharedTarget {
    fn predict(&mut self, played: &Played, target: Option<&SharedTargetView>) -> Motion {
        let Some(SharedTargetView { now, then }) = target else { return played.motion };
        let carry = |[now_x, now_y]: [f64; 2], [x, y]: [f64; 2], [then_x, then_y]: [f64; 2]| {
            [now_x + (x - then_x), now_y + (y - then_y)]
        };
        let motion = Motion {
            position: carry(now.position, played.motion.position, then.position),
            velocity: carry(now.velocity, played.motion.velocity, then.velocity),
        };
        possible(motion, played)
    }

    fn reset(&mut self) {}
}
