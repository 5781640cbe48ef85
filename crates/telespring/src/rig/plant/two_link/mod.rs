//! A robot with a two-link arm under torque control.
//!
//! The arm of Section IV-B of the paper: two actuated joints and a free bearing at the handle, in a
//! horizontal plane. The equations of the arm in the angular velocities of its links are transformed to the
//! handle, where the robot's own mass, damping and friction act: with Λ = J⁻ᵀ M J⁻¹,
//!
//! (m + Λ) p″ = F_robot − b p′ − friction + J⁻ᵀ (τ − C θ′ − D θ′) + Λ J′ θ′.

mod arm;
mod dynamics;
mod friction;
mod kinematics;
mod stepping;
#[cfg(test)]
mod tests;

use self::dynamics::ArmDynamics;
use self::kinematics::Pose;
use self::stepping::{HeldForces, State};
use super::{Halt, OutOfReach};
use crate::rig::{Handle, TwoLinkArm};

pub use self::kinematics::SMALLEST_ELBOW_SINE;

/// The motion of a robot with a two-link arm.
///
/// # Examples
///
/// A push of 1 N away from the shoulder for 10 ms:
///
/// ```
/// use telespring::rig::{Handle, TwoLinkArm, plant::TwoLinkPlant};
/// let handle = Handle { mass: [0.8, 0.7], damping: [7.0, 6.0], coulomb: [0.0, 0.0] };
/// let mut plant = TwoLinkPlant::new(handle, TwoLinkArm::HEBI_X8, [0.0, 0.0])?;
/// for _ in 0..10 {
///     plant.advance([0.0, 0.0], [0.0, 1.0], 1e-3)?;
/// }
/// assert!(plant.velocity()[1] > 0.0);
/// # Ok::<(), telespring::rig::plant::Halt>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TwoLinkPlant {
    rig: ArmDynamics,
    state: State,
    torque: [f64; 2],
    step: f64,
}

impl TwoLinkPlant {
    /// Creates a two-link plant at rest with the handle at `position`, m.
    ///
    /// # Errors
    ///
    /// [`OutOfReach`] if the arm cannot hold it there.
    pub fn new(handle: Handle, arm: TwoLinkArm, position: [f64; 2]) -> Result<Self, OutOfReach> {
        Pose::at(&arm, position)?;
        let state = [position[0], position[1], 0.0, 0.0];
        Ok(Self { rig: ArmDynamics::new(handle, arm), state, torque: [0.0; 2], step: f64::INFINITY })
    }

    /// The same plant with this velocity of the handle, m/s.
    #[must_use]
    pub fn with_velocity(mut self, velocity: [f64; 2]) -> Self {
        self.state[2..].copy_from_slice(&velocity);
        self
    }

    /// Position of the handle, m.
    pub fn position(&self) -> [f64; 2] {
        [self.state[0], self.state[1]]
    }

    /// Velocity of the handle, m/s.
    pub fn velocity(&self) -> [f64; 2] {
        [self.state[2], self.state[3]]
    }

    /// The last torques of shoulder and elbow, N·m.
    pub fn torque(&self) -> [f64; 2] {
        self.torque
    }

    /// The present pose of the two-link arm.
    fn pose(&self) -> Pose {
        // Every stored position was within reach.
        Pose::at(&self.rig.arm, self.position()).expect("the arm holds the handle")
    }

    /// Angles of shoulder and elbow, rad.
    pub fn joint_angles(&self) -> [f64; 2] {
        self.pose().joint_angles()
    }

    /// Angular velocities of shoulder and elbow, rad/s.
    pub fn joint_velocities(&self) -> [f64; 2] {
        let [first, second] = self.pose().rates(self.velocity());
        [first, second - first]
    }

    /// The joint torques that a hand force (N) commands in this pose: J(θ)ᵀ F of Eqs. 13 and 14, each
    /// limited to its torque limit, N·m.
    pub fn torque_for(&self, hand_force: [f64; 2]) -> [f64; 2] {
        let limit = self.rig.arm.torque_limit;
        let torque = self.pose().torque(&self.rig.arm, hand_force);
        [torque[0].clamp(-limit[0], limit[0]), torque[1].clamp(-limit[1], limit[1])]
    }

    /// Moves the plant over `span` (s) under the robot's actuator force and the torques that `hand_force`
    /// commands now (N), both held.
    ///
    /// # Errors
    ///
    /// [`Halt`] if the handle leaves the reach or the motion is too stiff; the plant then stays at its last
    /// state.
    pub fn advance(&mut self, robot_force: [f64; 2], hand_force: [f64; 2], span: f64) -> Result<(), Halt> {
        self.advance_by_torque(robot_force, self.torque_for(hand_force), span)
    }

    /// Moves the plant over `span` (s) under held joint torques, N·m.
    ///
    /// # Errors
    ///
    /// [`Halt`] as in [`TwoLinkPlant::advance`].
    pub fn advance_by_torque(
        &mut self,
        robot_force: [f64; 2],
        torque: [f64; 2],
        span: f64,
    ) -> Result<(), Halt> {
        self.torque = torque;
        let held = HeldForces { torque, robot_force };
        stepping::advance_two_link(&self.rig, held, span, &mut self.state, &mut self.step)
    }

    /// The force of the arm on the handle under these forces, N, as a force sensor between them measures
    /// it.
    pub fn handle_force(&self, robot_force: [f64; 2], hand_force: [f64; 2]) -> [f64; 2] {
        let torque = self.torque_for(hand_force);
        let (position, velocity, level) = (self.position(), self.velocity(), self.rig.handle.coulomb);
        let balance = self
            .rig
            .force_balance(position, velocity, torque, robot_force)
            .expect("the arm holds the handle");
        let contact = friction::consistent_contacts(&balance, velocity, level);
        balance.arm_force(friction::motion_under(&balance, contact, level).acceleration)
    }

    /// Kinetic energy of robot and arm, J.
    pub fn kinetic_energy(&self) -> f64 {
        let velocity = self.velocity();
        let mass = self.rig.operator(&self.pose()).0.plus_diagonal(self.rig.handle.mass);
        0.5 * kinematics::dot(velocity, mass.times(velocity))
    }
}
