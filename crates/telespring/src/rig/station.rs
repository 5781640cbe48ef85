//! One side of a running trial: its plant, its agent and its endpoint.

use super::agent::AgentState;
use super::energy::held_force_energy;
use super::network::Channel;
use super::plant::{Halt, Plant, RelaxingForce};
use super::{Controller, Laboratory, Trial};
use crate::error::Result;
use crate::session::{Endpoint, LocalTime, Motion, Span, motion};

/// A trial diverges if a handle is farther than this from the origin along an axis, m: no robot reaches
/// that far.
pub const POSITION_LIMIT: f64 = 10.0;

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

/// The state of one side during a trial.
pub(super) struct RunningStation {
    pub(super) plant: Plant,
    pub(super) mover: AgentState,
    pub(super) endpoint: Option<Endpoint>,
    /// The channel towards this side.
    pub(super) link: Option<Box<dyn Channel>>,
    /// The forces computed at the previous tick: of the spring and of the agent, N.
    computed: [[f64; 2]; 2],
    /// The force of the actuator, N.
    actuator: [f64; 2],
}

impl RunningStation {
    /// Whether, in the running trial, a handle is beyond the position limit or too fast for a packet.
    pub(super) fn has_diverged(&self) -> bool {
        let beyond = |values: [f64; 2], limit: f64| values.iter().any(|value| !(value.abs() <= limit));
        beyond(self.plant.position(), POSITION_LIMIT) || beyond(self.plant.velocity(), motion::MAX_VALUE)
    }

    /// Measures position and velocity with the sensor's resolution at a tick of the trial.
    pub(super) fn measure_motion(&self, resolution: f64) -> Motion {
        let position = self.plant.position();
        let position = if resolution > 0.0 {
            position.map(|value| (value / resolution).round() * resolution)
        } else {
            position
        };
        Motion { position, velocity: self.plant.velocity() }
    }

    /// The energy in the account of the strategy, J; NaN if there is none.
    pub(super) fn balance(&self) -> f64 {
        let report = self.endpoint.as_ref().map(Endpoint::strategy_report);
        report.and_then(|report| report.balance).unwrap_or(f64::NAN)
    }

    /// The age of the partner's motion in use, s; NaN if there is none.
    pub(super) fn partner_age(&self) -> f64 {
        self.endpoint.as_ref().and_then(Endpoint::partner_age).unwrap_or(f64::NAN)
    }

    /// Receives all packets that have arrived and returns the force of the spring, N.
    pub(super) fn spring_force(&mut self, now: LocalTime, measured: Motion) -> [f64; 2] {
        let (Some(link), Some(endpoint)) = (&mut self.link, &mut self.endpoint) else { return [0.0; 2] };
        link.observe(measured);
        while let Some(packet) = link.deliver(now) {
            // What is refused is dropped, as by a live program; only an adversary alters packets so that they are.
            let _ = endpoint.handle_datagram(now, &packet);
        }
        endpoint.force(now)
    }

    /// The forces that act in the trial until the next tick, given the newly computed ones, N.
    pub(super) fn acting_forces(
        &mut self,
        spring: [f64; 2],
        hand: [f64; 2],
        controller: &Controller,
    ) -> ActingForces {
        let computed = [spring, hand];
        let before = std::mem::replace(&mut self.computed, computed);
        let [command, hand] = if controller.computing_tick { before } else { computed };
        let robot = if controller.actuator_lag > 0.0 { self.actuator } else { command };
        ActingForces { command, robot, hand }
    }

    /// Moves the plant of one side of the trial over one sample period; the energy that the robot, and that the agent, gave
    /// in it, J.
    pub(super) fn advance_plant(
        &mut self,
        acting: &ActingForces,
        controller: &Controller,
    ) -> std::result::Result<[f64; 2], Halt> {
        let (period, time_constant) = (controller.sample_period, controller.actuator_lag);
        let (from, held) = (self.plant.position(), self.plant.hold(acting.hand));
        let mut mean = acting.command;
        if time_constant > 0.0 {
            let force = RelaxingForce { from: self.actuator, to: acting.command, time_constant };
            mean = force.mean(period);
            self.actuator = force.after(period);
            if let Some(endpoint) = &mut self.endpoint {
                endpoint.handle_acted(mean);
            }
            self.plant.advance_relaxing(&force, acting.hand, period)?;
        } else {
            self.plant.advance(acting.command, acting.hand, period)?;
        }
        Ok([held_force_energy(mean, from, self.plant.position()), self.plant.held_energy(&held)])
    }
}

impl Trial<'_> {
    /// Both stations at the start of the trial.
    pub(super) fn start_stations(&self) -> Result<[RunningStation; 2]> {
        let Laboratory { stations: sides, target, controller, network, .. } = self.laboratory;
        let period = Span::from_seconds(controller.sample_period);
        let start = target.at_tick(0, controller.sample_period).position;
        let station = |side: usize| -> Result<RunningStation> {
            let linked = self.coupling.map(|coupling| -> Result<_> {
                let facts = self.laboratory.side_facts(side, &coupling);
                let settings = self.laboratory.session.architecture.rehearsal_settings(&facts)?;
                let travel = (Span::from_seconds(facts.delays[0]) - period).max(Span(0));
                Ok((Endpoint::new(settings)?, network.towards(side).channel(travel, self.seed, side)))
            });
            let (endpoint, link) = linked.transpose()?.unzip();
            Ok(RunningStation {
                plant: Plant::new(sides[side].handle, &sides[side].arm, start)
                    .map_err(|refusal| refusal.within(&format!("arm{}", side + 1)))?,
                mover: AgentState::new(&sides[side].agent, self.seed, side),
                endpoint,
                link,
                computed: [[0.0; 2]; 2],
                actuator: [0.0; 2],
            })
        };
        Ok([station(0)?, station(1)?])
    }
}
