//! A robot in its arm behind what its controller puts before the handle: position sensor, computing tick and actuator lag.

use super::Controller;
use super::plant::{Halt, Plant, RelaxingForce};
use crate::session::Motion;

/// The forces that act on one side from a tick on, N.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ActingForces {
    /// The force commanded by the robot's controller.
    pub(super) command: [f64; 2],
    /// The force of the robot at the tick, behind the actuator lag.
    pub(super) robot: [f64; 2],
    /// The force commanded by the agent.
    pub(super) hand: [f64; 2],
}

/// A plant as its controller sees and moves it.
#[derive(Debug, Clone)]
pub(super) struct ActuatedPlant {
    pub(super) plant: Plant,
    /// The forces computed at the previous tick: of the robot's controller and of the agent, N.
    computed: [[f64; 2]; 2],
    /// The force of the actuator, N.
    actuator: [f64; 2],
}

impl ActuatedPlant {
    /// The plant with an actuator at rest.
    pub(super) fn new(plant: Plant) -> Self {
        Self { plant, computed: [[0.0; 2]; 2], actuator: [0.0; 2] }
    }

    /// Measures position and velocity of the plant with the resolution of the controller's sensor.
    pub(super) fn measure(&self, controller: &Controller) -> Motion {
        let (position, step) = (self.plant.position(), controller.encoder_resolution);
        let position =
            if step > 0.0 { position.map(|value| (value / step).round() * step) } else { position };
        Motion { position, velocity: self.plant.velocity() }
    }

    /// The forces that act on the plant until the next tick, given the newly computed ones, N.
    pub(super) fn acting_forces(
        &mut self,
        commanded: [f64; 2],
        hand: [f64; 2],
        controller: &Controller,
    ) -> ActingForces {
        let computed = [commanded, hand];
        let before = std::mem::replace(&mut self.computed, computed);
        let [command, hand] = if controller.computing_tick { before } else { computed };
        let robot = if controller.actuator_lag > 0.0 { self.actuator } else { command };
        ActingForces { command, robot, hand }
    }

    /// The mean force of the robot over the `span` s to come, N: the command, unless the actuator lags.
    pub(super) fn mean_force(&self, acting: &ActingForces, controller: &Controller, span: f64) -> [f64; 2] {
        self.lagging(acting, controller).map_or(acting.command, |force| force.mean(span))
    }

    /// Moves the plant over `span` s under the acting forces.
    pub(super) fn advance(
        &mut self,
        acting: &ActingForces,
        controller: &Controller,
        span: f64,
    ) -> std::result::Result<(), Halt> {
        let Some(force) = self.lagging(acting, controller) else {
            return self.plant.advance(acting.command, acting.hand, span);
        };
        self.actuator = force.after(span);
        self.plant.advance_relaxing(&force, acting.hand, span)
    }

    /// The force of the robot where its actuator lags.
    fn lagging(&self, acting: &ActingForces, controller: &Controller) -> Option<RelaxingForce> {
        let time_constant = controller.actuator_lag;
        let force = RelaxingForce { from: self.actuator, to: acting.command, time_constant };
        (time_constant > 0.0).then_some(force)
    }
}
