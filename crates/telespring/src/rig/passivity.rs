//! An observer of the energy that passes between the coupling and the two people.

/// The energy that a trial's coupling took from the two people, less what it gave them.
///
/// Counted at both handles together from the force of each robot and the motion of its handle: a held force F over a
/// displacement Δx gives F·Δx exactly, whatever the motion in between. A coupling is passive if it never gives out
/// more than it took: then `minimum` is not below 0, but for the little that a sampled spring generates. Behind an
/// actuator lag the mean force of each period is counted.
///
/// B. Hannaford and J.-H. Ryu, "Time-domain passivity control of haptic interfaces", IEEE Transactions on Robotics
/// and Automation 18 (1), 2002.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PassivityReport {
    /// Over the whole trial, J; negative if the coupling gave more than it took.
    pub total: f64,
    /// The smallest value at any tick, J; at most 0, its value at the start.
    pub minimum: f64,
}

impl PassivityReport {
    /// The report after a tick of the trial at whose end the robots had given out this energy, J.
    #[must_use]
    pub(super) fn after(self, given: f64) -> Self {
        let total = self.total - given;
        Self { total, minimum: self.minimum.min(total) }
    }
}

/// The energy of a force held over a displacement in a trial, J.
pub(super) fn held_force_energy(force: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    force[0] * (to[0] - from[0]) + force[1] * (to[1] - from[1])
}
