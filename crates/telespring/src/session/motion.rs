//! The motion of a handle at one instant.

/// The largest position (m) or velocity (m/s): no handle exceeds it, and every force computed from it is finite.
pub const MAX_VALUE: f64 = 1e6;

/// The motion of a handle at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Position per axis, m.
    pub position: [f64; 2],
    /// Velocity per axis, m/s.
    pub velocity: [f64; 2],
}

impl Motion {
    /// The first value that is not finite or exceeds [`MAX_VALUE`], if there is one.
    pub fn impossible_value(&self) -> Option<f64> {
        [self.position, self.velocity].into_iter().flatten().find(|value| !(value.abs() <= MAX_VALUE))
    }

    /// The motion on the straight line from this one (share 0) to a later one (share 1).
    #[must_use]
    pub fn towards(&self, later: &Self, share: f64) -> Self {
        Self {
            position: between(self.position, later.position, share),
            velocity: between(self.velocity, later.velocity, share),
        }
    }
}

/// The pair on the straight line between two pairs.
pub(super) fn between(from: [f64; 2], to: [f64; 2], share: f64) -> [f64; 2] {
    let ([x, y], [u, v]) = (from, to);
    [x + share * (u - x), y + share * (v - y)]
}
