//! The coupling law: the force from both motions.

use super::motion::Motion;

/// The coupling law: a virtual spring between both handles and a damper in parallel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// N/m.
    pub stiffness: f64,
    /// N·s/m; 0 for none.
    pub damping: f64,
}

impl Law {
    /// The force of the coupling law on the own handle per axis, N.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::session::{Law, Motion};
    ///
    /// let own = Motion { position: [0.0, 0.1], velocity: [0.0; 2] };
    /// let partner = Motion { position: [0.1, 0.1], velocity: [0.0; 2] };
    /// assert_eq!(Law { stiffness: 20.0, damping: 0.0 }.force(&own, &partner), [2.0, 0.0]);
    /// ```
    pub fn force(&self, own: &Motion, partner: &Motion) -> [f64; 2] {
        [0, 1].map(|axis| {
            self.stiffness * (partner.position[axis] - own.position[axis])
                + self.damping * (partner.velocity[axis] - own.velocity[axis])
        })
    }
}
