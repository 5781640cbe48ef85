//! The energy that passes through the coupling, and through the two hands.

/// The energy that a trial's coupling took at both handles, less what it gave out there.
///
/// A passivity observer at the port of the coupling: between the robots' forces and the motion of their handles. Robots and
/// arms stand between it and the people, whose energy is [`TrialOutcome::hand_energy`](super::TrialOutcome). A held force
/// F over a displacement Δx gives F·Δx exactly, whatever the motion in between. A coupling is passive if it never gives out
/// more than it took: then `minimum` is not below 0, but for the little that a sampled spring generates. Behind an
/// actuator lag the mean force of each period is counted.
///
/// B. Hannaford and J.-H. Ryu, "Time-domain passivity control of haptic interfaces", IEEE Transactions on Robotics
/// and Automation 18 (1), 2002.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CouplingEnergy {
    /// Over the whole trial, J; negative if the coupling gave more than it took.
    pub total: f64,
    /// The smallest value at any tick, J; at most 0, its value at the start.
    pub minimum: f64,
}

impl CouplingEnergy {
    /// The energy after a tick of the trial in which the robots gave this energy to their handles, J.
    #[must_use]
    fn after(self, given: f64) -> Self {
        let total = self.total - given;
        Self { total, minimum: self.minimum.min(total) }
    }
}

/// All energy that a trial counts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Energies {
    pub(super) coupling: CouplingEnergy,
    /// What each hand got, J.
    pub(super) hands: [f64; 2],
}

impl Energies {
    /// Counts a tick of the trial: what each robot, and what each hand, gave, J.
    pub(super) fn add(&mut self, given: [[f64; 2]; 2]) {
        let [[first, first_hand], [second, second_hand]] = given;
        self.coupling = self.coupling.after(first + second);
        let [one, two] = self.hands;
        self.hands = [one - first_hand, two - second_hand];
    }
}

/// The energy of a force held over a displacement in a trial, J; or of torques held over turns.
pub(super) fn held_force_energy(force: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    force[0] * (to[0] - from[0]) + force[1] * (to[1] - from[1])
}
