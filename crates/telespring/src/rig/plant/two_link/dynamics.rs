//! Dynamics of robot and two-link arm at one instant.

use super::OutOfReach;
use super::kinematics::{Pose, Symmetric};
use crate::rig::{Handle, TwoLinkArm};

/// The robot and the arm, with pose-independent values computed once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ArmDynamics {
    pub handle: Handle,
    pub arm: TwoLinkArm,
    /// Inertia about the shoulder of everything that turns with the upper link, its actuator included,
    /// kg·m².
    first: f64,
    /// Inertia of the lower link about the elbow, kg·m².
    second: f64,
    /// Mass of the lower link times its lever times the length of the upper link, kg·m².
    coupling: f64,
}

/// The force balance at the handle: mass · acceleration = push + Coulomb friction.
#[derive(Debug, Clone, Copy)]
pub(super) struct ForceBalance {
    /// Robot and arm, kg.
    pub mass: Symmetric,
    /// All forces but friction, including those from the rotation of the links, N.
    pub push: [f64; 2],
    arm_mass: Symmetric,
    arm_push: [f64; 2],
}

impl ForceBalance {
    /// The force of the two-link arm on the robot at an acceleration of the handle, N.
    pub fn arm_force(&self, acceleration: [f64; 2]) -> [f64; 2] {
        let inertial = self.arm_mass.times(acceleration);
        [self.arm_push[0] - inertial[0], self.arm_push[1] - inertial[1]]
    }
}

impl ArmDynamics {
    /// The inertias in the dynamics of robot and two-link arm that no pose changes.
    pub fn new(handle: Handle, arm: TwoLinkArm) -> Self {
        let TwoLinkArm { link_length, link_mass, link_centre, link_inertia, rotor_inertia, .. } = arm;
        Self {
            handle,
            arm,
            first: link_inertia[0]
                + link_mass[0] * link_centre[0].powi(2)
                + link_mass[1] * link_length[0].powi(2)
                + rotor_inertia[0],
            second: link_inertia[1] + link_mass[1] * link_centre[1].powi(2),
            coupling: link_mass[1] * link_length[0] * link_centre[1],
        }
    }

    /// The inertia of the arm with respect to the angular velocities of the links: first, mixed, second.
    #[inline]
    fn inertia(&self, pose: &Pose) -> [f64; 3] {
        // The elbow actuator turns with the difference of both angular velocities.
        let rotor = self.arm.rotor_inertia[1];
        [self.first + rotor, self.coupling * pose.cosine - rotor, self.second + rotor]
    }

    /// The dynamics' apparent mass and damping of the arm at the handle in a pose, kg and N·s/m.
    pub fn operator(&self, pose: &Pose) -> (Symmetric, Symmetric) {
        let [shoulder, elbow] = self.arm.joint_damping;
        (pose.at_handle(self.inertia(pose)), pose.at_handle([shoulder + elbow, -elbow, elbow]))
    }

    /// The force balance of the dynamics at a position and velocity, under joint torques and a robot force.
    #[inline]
    pub fn force_balance(
        &self,
        position: [f64; 2],
        velocity: [f64; 2],
        torque: [f64; 2],
        robot_force: [f64; 2],
    ) -> Result<ForceBalance, OutOfReach> {
        let pose = Pose::at(&self.arm, position)?;
        let [w1, w2] = pose.rates(velocity);
        let [l1, l2] = self.arm.link_length;
        let [shoulder, elbow] = self.arm.joint_damping;
        let centrifugal = self.coupling * pose.sine;
        // Moments on the links: the elbow actuator pushes one against the other.
        let hinge = torque[1] - elbow * (w2 - w1);
        let moment =
            [torque[0] - shoulder * w1 - hinge + centrifugal * w2 * w2, hinge - centrifugal * w1 * w1];
        // At constant velocity of the handle the angular velocities of the links change by this.
        let (inward1, inward2) = (l1 * w1 * w1, l2 * w2 * w2);
        let turning = [
            (inward1 * pose.cosine + inward2) / (l1 * pose.sine),
            -(inward1 + inward2 * pose.cosine) / (l2 * pose.sine),
        ];
        let inertia @ [first, cross, second] = self.inertia(&pose);
        let arm_push = pose.force([
            moment[0] - first * turning[0] - cross * turning[1],
            moment[1] - cross * turning[0] - second * turning[1],
        ]);
        let arm_mass = pose.at_handle(inertia);
        let damping = self.handle.damping;
        Ok(ForceBalance {
            mass: arm_mass.plus_diagonal(self.handle.mass),
            push: [
                robot_force[0] - damping[0] * velocity[0] + arm_push[0],
                robot_force[1] - damping[1] * velocity[1] + arm_push[1],
            ],
            arm_mass,
            arm_push,
        })
    }
}
