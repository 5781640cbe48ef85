//! Plants: a robot with the arm that holds its handle.

mod lumped;
mod two_link;

pub use lumped::LumpedPlant;
pub use two_link::{SMALLEST_ELBOW_SINE, TwoLinkPlant};

use std::f64::consts::{PI, TAU};

use super::energy::held_force_energy;
use super::{Arm, Handle};
use crate::error::{InvalidInput, Result};

/// The arm cannot reach the position of the handle.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the arm cannot reach x = {} m, y = {} m", .position[0], .position[1])]
pub struct OutOfReach {
    /// The requested position, or the last one within reach, m.
    pub position: [f64; 2],
}

/// Why a plant cannot move on.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Halt {
    /// The arm would have to stretch beyond its reach.
    #[error(transparent)]
    OutOfReach(#[from] OutOfReach),
    /// The time constants are so short that the span would need too many steps.
    #[error("the motion is too stiff to follow at x = {} m, y = {} m", .position[0], .position[1])]
    TooStiff {
        /// The last position, m.
        position: [f64; 2],
    },
}

/// A force that relaxes from one value to another as e^(−t/τ), as behind a first-order actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelaxingForce {
    /// The initial force, N per axis.
    pub from: [f64; 2],
    /// The final force, N per axis.
    pub to: [f64; 2],
    /// The time constant τ, s, above 0.
    pub time_constant: f64,
}

impl RelaxingForce {
    /// The relaxing force on a plant after `span` s, N per axis.
    pub fn after(&self, span: f64) -> [f64; 2] {
        let rest = (-span / self.time_constant).exp();
        [0, 1].map(|axis| self.to[axis] + rest * (self.from[axis] - self.to[axis]))
    }

    /// The mean of a plant's relaxing force over `span` s, N per axis, with the same impulse.
    pub fn mean(&self, span: f64) -> [f64; 2] {
        let (rest, _) = lumped::exponential_averages(span / self.time_constant);
        [0, 1].map(|axis| self.to[axis] + rest * (self.from[axis] - self.to[axis]))
    }
}

/// What an agent holds while a plant advances: forces (N) at the position of the handle (m), or torques (N·m) at the angles
/// of the joints (rad).
#[derive(Debug, Clone, Copy)]
pub(super) struct Held {
    effort: [f64; 2],
    place: [f64; 2],
}

/// A robot with the arm that holds its handle.
#[derive(Debug, Clone)]
pub enum Plant {
    /// An arm with constant mass and damping.
    Lumped(LumpedPlant),
    /// A two-link arm, whose apparent mass and damping change with the pose.
    TwoLink(TwoLinkPlant),
}

impl Plant {
    /// Creates a plant of either kind at rest at `position`, m.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the arm cannot reach it.
    pub fn new(handle: Handle, arm: &Arm, position: [f64; 2]) -> Result<Self> {
        match *arm {
            Arm::Lumped { mass, damping } => {
                Ok(Self::Lumped(LumpedPlant::new(handle, mass, damping, position)))
            }
            Arm::TwoLink(arm) => {
                let plant = TwoLinkPlant::new(handle, arm, position).map_err(|outside| {
                    InvalidInput::new(
                        "base",
                        format!("{:?}", arm.base),
                        format!("{outside}, where the handle starts"),
                        "Move the base so that its distance from there is between the difference and the sum of \
                         the links' lengths, with a margin to both.",
                    )
                })?;
                Ok(Self::TwoLink(plant))
            }
        }
    }

    /// The position of the plant's handle, m.
    pub fn position(&self) -> [f64; 2] {
        match self {
            Self::Lumped(plant) => plant.position(),
            Self::TwoLink(plant) => plant.position(),
        }
    }

    /// The velocity of the plant's handle, m/s.
    pub fn velocity(&self) -> [f64; 2] {
        match self {
            Self::Lumped(plant) => plant.velocity(),
            Self::TwoLink(plant) => plant.velocity(),
        }
    }

    /// The same plant, of either kind, with this velocity, m/s.
    #[must_use]
    pub fn with_velocity(self, velocity: [f64; 2]) -> Self {
        match self {
            Self::Lumped(plant) => Self::Lumped(plant.with_velocity(velocity)),
            Self::TwoLink(plant) => Self::TwoLink(plant.with_velocity(velocity)),
        }
    }

    /// Moves the plant over `span` s while the robot's force on the handle and the agent's force at the
    /// hand (N per axis) are held.
    ///
    /// # Errors
    ///
    /// [`Halt`] if the arm would have to stretch beyond its reach, or the motion is too stiff.
    pub fn advance(
        &mut self,
        robot_force: [f64; 2],
        hand_force: [f64; 2],
        span: f64,
    ) -> std::result::Result<(), Halt> {
        match self {
            Self::Lumped(plant) => {
                plant.advance(robot_force, hand_force, span);
                Ok(())
            }
            Self::TwoLink(plant) => plant.advance(robot_force, hand_force, span),
        }
    }

    /// As [`Plant::advance`] under a relaxing robot force: exact for a linear plant; otherwise the mean
    /// force is held.
    ///
    /// # Errors
    ///
    /// As [`Plant::advance`].
    pub fn advance_relaxing(
        &mut self,
        robot_force: &RelaxingForce,
        hand_force: [f64; 2],
        span: f64,
    ) -> std::result::Result<(), Halt> {
        match self {
            Self::Lumped(plant) => {
                plant.advance_relaxing(robot_force, hand_force, span);
                Ok(())
            }
            Self::TwoLink(plant) => plant.advance(robot_force.mean(span), hand_force, span),
        }
    }

    /// What the agent holds if it commands this force now (N).
    pub(super) fn hold(&self, hand_force: [f64; 2]) -> Held {
        match self {
            Self::Lumped(plant) => Held { effort: hand_force, place: plant.position() },
            Self::TwoLink(plant) => {
                Held { effort: plant.torque_for(hand_force), place: plant.joint_angles() }
            }
        }
    }

    /// The energy that the agent has given to the plant with what it held since, J.
    pub(super) fn held_energy(&self, held: &Held) -> f64 {
        let Held { effort, place } = *held;
        match self {
            Self::Lumped(plant) => held_force_energy(effort, place, plant.position()),
            Self::TwoLink(plant) => {
                // no joint turns by half a turn in a period
                let [first, second] = plant.joint_angles();
                let turn = |to: f64, from: f64| (to - from + PI).rem_euclid(TAU) - PI;
                effort[0] * turn(first, place[0]) + effort[1] * turn(second, place[1])
            }
        }
    }

    /// The force of the plant's arm on the handle under these forces, N per axis.
    pub fn handle_force(&self, robot_force: [f64; 2], hand_force: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Lumped(plant) => plant.handle_force(robot_force, hand_force),
            Self::TwoLink(plant) => plant.handle_force(robot_force, hand_force),
        }
    }
}
