//! One robot of a laboratory, moved step by step: what a live program moves where no real robot is.

use super::actuated::ActuatedPlant;
use super::agent::{AgentState, Observation};
use super::plant::{Halt, Plant};
use super::{Agent, Controller, Laboratory, Target};
use crate::error::{InvalidInput, Result};
use crate::session::Motion;

/// One robot of a laboratory with its arm and its agent, without a coupling.
///
/// It moves as in a [`Trial`](super::Trial): at every step the agent sees the measured motion and the target, the robot is
/// told a force, and both are held for the step. After its construction it allocates nothing.
///
/// # Examples
///
/// ```
/// use telespring::rig::{Laboratory, SimulatedRobot};
///
/// let mut robot = SimulatedRobot::new(&Laboratory::paper(), 0, 1)?;
/// for tick in 0..1000 {
///     robot.advance(tick as f64 * 1e-3, [0.0; 2], 1e-3).unwrap();
/// }
/// let (here, there) = (robot.measure().position, robot.target(1.0).position);
/// assert!((here[0] - there[0]).hypot(here[1] - there[1]) < 0.05);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone)]
pub struct SimulatedRobot {
    robot: ActuatedPlant,
    agent: AgentState,
    target: Target,
    controller: Controller,
}

impl SimulatedRobot {
    /// The robot of a side, 0 or 1, at rest on the first target; `seed` is that of a trial. The laboratory must have
    /// passed [`Laboratory::check`].
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the agent or the target is a program of the caller's, or the arm cannot reach the first target.
    pub fn new(laboratory: &Laboratory, side: usize, seed: u64) -> Result<Self> {
        let Laboratory { stations, target, controller, .. } = laboratory;
        let station = &stations[side];
        let number = side + 1;
        if matches!(station.agent, Agent::External) {
            return Err(InvalidInput::new(
                format!("agent{number}"),
                "external",
                "a simulated robot has an agent of the study: skilled or less skilled",
                format!("Write agent{number} = {{kind = \"skilled\"}}."),
            ));
        }
        if matches!(target, Target::Sampled(samples) if samples.is_empty()) {
            return Err(InvalidInput::new(
                "task",
                "external",
                "a simulated robot needs a target of the study",
                "Write task = {kind = \"figure-eight\"}.",
            ));
        }
        let start = target.at_tick(0, controller.sample_period).position;
        let plant = Plant::new(station.handle, &station.arm, start)
            .map_err(|refusal| refusal.within(&format!("arm{number}")))?;
        Ok(Self {
            robot: ActuatedPlant::new(plant),
            agent: AgentState::new(&station.agent, seed, side),
            target: target.clone(),
            controller: *controller,
        })
    }

    /// The motion of the simulated robot's handle as its sensor reports it.
    pub fn measure(&self) -> Motion {
        self.robot.measure(&self.controller)
    }

    /// The target that the simulated robot's agent follows, `time` s after the start.
    pub fn target(&self, time: f64) -> Motion {
        let point = self.target.at_time(time, self.controller.sample_period);
        Motion { position: point.position, velocity: point.velocity }
    }

    /// Moves the robot over `span` s from `time`, s after the start, during which both forces are held: `command`, N, and
    /// what the agent does about what it sees at `time`. With a computing tick those of the step before act instead.
    /// Returns the mean force of the robot on the handle, N.
    ///
    /// # Errors
    ///
    /// [`Halt`] if the arm would have to stretch beyond its reach, or the motion is too stiff.
    pub fn advance(
        &mut self,
        time: f64,
        command: [f64; 2],
        span: f64,
    ) -> std::result::Result<[f64; 2], Halt> {
        let aim = self.target.at_time(time, self.controller.sample_period);
        let Motion { position, velocity } = self.measure();
        let seen = Observation { time, position, velocity, target: aim.position };
        let (_, hand) = self.agent.aim_and_force(&seen, &aim);
        let acting = self.robot.acting_forces(command, hand, &self.controller);
        let mean = self.robot.mean_force(&acting, &self.controller, span);
        self.robot.advance(&acting, &self.controller, span)?;
        Ok(mean)
    }
}
