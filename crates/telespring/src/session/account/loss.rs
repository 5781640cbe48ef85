//! What a robot's damping certainly took of the energy of one axis.

/// With an encoder, a window closes once the displacement is this many steps: then the step takes at most an eighth of
/// the loss.
const STEPS: f64 = 16.0;

/// With an encoder, the longest window, s: human motion hardly changes its velocity in it.
const LONGEST: f64 = 0.05;

/// A stretch of time on one axis whose loss is not yet credited.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LossWindow {
    elapsed: f64,
    displacement: f64,
}

impl LossWindow {
    /// Extends the window; when it closes, a lower bound of the loss ∫ b v² over it, J, and 0 before.
    ///
    /// b (∫v)²/t ≤ ∫ b v² (Cauchy–Schwarz), and an encoder step hides at most one step of the displacement. A time that
    /// is not positive cannot be judged: the window starts anew without credit.
    pub(super) fn add(&mut self, elapsed: f64, displacement: f64, damping: f64, step: f64) -> f64 {
        if !(elapsed > 0.0) {
            *self = Self::default();
            return 0.0;
        }
        self.elapsed += elapsed;
        self.displacement += displacement;
        let distance = self.displacement.abs();
        if step > 0.0 && distance < STEPS * step && self.elapsed < LONGEST {
            return 0.0;
        }
        let certain = (distance - step).max(0.0);
        let loss = damping * certain * certain / self.elapsed;
        *self = Self::default();
        if loss.is_finite() { loss } else { 0.0 }
    }
}
