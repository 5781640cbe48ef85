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
}
