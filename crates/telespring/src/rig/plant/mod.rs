//! What moves: a robot's handle with the arm that holds it.

mod lumped;
pub mod two_link;

pub use lumped::LumpedPlant;
pub use two_link::{OutOfReach, TwoLinkPlant};

use super::{Arm, Handle};
use crate::error::{InvalidInput, Result};

/// A force that goes from one value to another as e^(−t/τ), as behind an actuator of first order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelaxingForce {
    /// Where it starts, N per axis.
    pub from: [f64; 2],
    /// Where it goes, N per axis.
    pub to: [f64; 2],
    /// τ, s, above 0.
    pub time_constant: f64,
}

impl RelaxingForce {
    /// Where it is after `span` s, N per axis.
    pub fn after(&self, span: f64) -> [f64; 2] {
        let rest = (-span / self.time_constant).exp();
        [0, 1].map(|axis| self.to[axis] + rest * (self.from[axis] - self.to[axis]))
    }

    /// Its mean over `span` s, N per axis: held that long, it has the same impulse.
    pub fn mean(&self, span: f64) -> [f64; 2] {
        let (rest, _) = lumped::averages(span / self.time_constant);
        [0, 1].map(|axis| self.to[axis] + rest * (self.from[axis] - self.to[axis]))
    }
}

/// A handle in the hands of an arm.
#[derive(Debug, Clone)]
pub enum Plant {
    /// An arm that is the same in every pose.
    Lumped(LumpedPlant),
    /// Two links.
    TwoLink(TwoLinkPlant),
}

impl Plant {
    /// At rest at `position`, m.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where the arm cannot reach it.
    pub fn new(handle: Handle, arm: &Arm, position: [f64; 2]) -> Result<Self> {
        match *arm {
            Arm::Lumped { mass, damping } => {
                Ok(Self::Lumped(LumpedPlant::new(handle, mass, damping, position)))
            }
            Arm::TwoLink(arm) => {
                TwoLinkPlant::new(handle, arm, position).map(Self::TwoLink).map_err(|unreached| {
                    InvalidInput::new(
                        "base",
                        format!("{:?}", arm.base),
                        format!("the arm has to reach the start of the task: {unreached}"),
                        "Move the base, or give the links other lengths.",
                    )
                })
            }
        }
    }

    /// Where the handle is, m.
    pub fn position(&self) -> [f64; 2] {
        match self {
            Self::Lumped(plant) => plant.position(),
            Self::TwoLink(plant) => plant.position(),
        }
    }

    /// How fast the handle moves, m/s.
    pub fn velocity(&self) -> [f64; 2] {
        match self {
            Self::Lumped(plant) => plant.velocity(),
            Self::TwoLink(plant) => plant.velocity(),
        }
    }

    /// Moves on by `span` s while the robot's force on the handle and what the agent commands (N per axis)
    /// are held: of a lumped arm the force on the hand, of two links the torques that this force asks for
    /// in the pose at the start.
    ///
    /// # Errors
    ///
    /// [`OutOfReach`] where the arm would have to stretch further than it can.
    pub fn advance(
        &mut self,
        robot_force: [f64; 2],
        hand_force: [f64; 2],
        span: f64,
    ) -> std::result::Result<(), OutOfReach> {
        match self {
            Self::Lumped(plant) => plant.advance(robot_force, hand_force, span),
            Self::TwoLink(plant) => plant.advance(robot_force, hand_force, span)?,
        }
        Ok(())
    }

    /// As [`Plant::advance`] while the robot's force relaxes: exact where the plant is linear, elsewhere
    /// the mean of the force over the span is held.
    ///
    /// # Errors
    ///
    /// As [`Plant::advance`].
    pub fn advance_relaxing(
        &mut self,
        robot_force: &RelaxingForce,
        hand_force: [f64; 2],
        span: f64,
    ) -> std::result::Result<(), OutOfReach> {
        match self {
            Self::Lumped(plant) => plant.advance_relaxing(robot_force, hand_force, span),
            Self::TwoLink(plant) => plant.advance(robot_force.mean(span), hand_force, span)?,
        }
        Ok(())
    }

    /// The force of the arm on the handle under these forces, N per axis.
    pub fn handle_force(&self, robot_force: [f64; 2], hand_force: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Lumped(plant) => plant.handle_force(robot_force, hand_force),
            Self::TwoLink(plant) => plant.handle_force(robot_force, hand_force),
        }
    }
}
