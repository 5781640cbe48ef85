//! One side of a running trial: its plant, its agent and its endpoint.

use super::actuated::{ActingForces, ActuatedPlant};
use super::agent::AgentState;
use super::connected::ConnectedMode;
use super::energy::held_force_energy;
use super::network::Channel;
use super::plant::{Halt, Plant};
use super::{Controller, Laboratory};
use crate::error::Result;
use crate::session::{Endpoint, LocalTime, Motion, Span, motion};

/// A trial diverges if a handle is farther than this from the origin along an axis, m: no robot reaches
/// that far.
pub const POSITION_LIMIT: f64 = 10.0;

/// The state of one side during a trial.
pub(super) struct RunningStation {
    pub(super) robot: ActuatedPlant,
    pub(super) mover: AgentState,
    pub(super) endpoint: Option<Endpoint>,
    /// The channel towards this side.
    pub(super) link: Option<Box<dyn Channel>>,
}

impl RunningStation {
    /// Whether, in the running trial, a handle is beyond the position limit or too fast for a packet.
    pub(super) fn has_diverged(&self) -> bool {
        let beyond = |values: [f64; 2], limit: f64| values.iter().any(|value| !(value.abs() <= limit));
        let plant = &self.robot.plant;
        beyond(plant.position(), POSITION_LIMIT) || beyond(plant.velocity(), motion::MAX_VALUE)
    }

    /// The energy in the account of the strategy, J; NaN if there is none.
    pub(super) fn balance(&self) -> f64 {
        let report = self.endpoint.as_ref().map(Endpoint::strategy_report);
        report.and_then(|report| report.balance).unwrap_or(f64::NAN)
    }

    /// The age of the oldest sample of the partner in use, s; NaN if there is none.
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

    /// Moves the robot of one side of the trial over one sample period; the energy that the robot, and that the agent, gave
    /// in it, J.
    pub(super) fn advance(
        &mut self,
        acting: &ActingForces,
        controller: &Controller,
    ) -> std::result::Result<[f64; 2], Halt> {
        let (period, plant) = (controller.sample_period, &self.robot.plant);
        let (from, held) = (plant.position(), plant.hold(acting.hand));
        let mean = self.robot.mean_force(acting, controller, period);
        if controller.actuator_lag > 0.0
            && let Some(endpoint) = &mut self.endpoint
        {
            endpoint.handle_acted(mean);
        }
        self.robot.advance(acting, controller, period)?;
        let plant = &self.robot.plant;
        Ok([held_force_energy(mean, from, plant.position()), plant.held_energy(&held)])
    }
}

impl RunningStation {
    /// Both stations at the start of a trial in this condition.
    pub(super) fn pair(
        laboratory: &Laboratory,
        coupling: Option<ConnectedMode>,
        seed: u64,
    ) -> Result<[Self; 2]> {
        let Laboratory { stations: sides, target, controller, network, .. } = laboratory;
        let period = Span::from_seconds(controller.sample_period);
        let start = target.at_tick(0, controller.sample_period).position;
        let station = |side: usize| -> Result<Self> {
            let linked = coupling.map(|coupling| -> Result<_> {
                let facts = laboratory.side_facts(side, &coupling);
                let settings = laboratory.session.architecture.rehearsal_settings(&facts)?;
                let travel = (Span::from_seconds(facts.delays[0]) - period).max(Span(0));
                Ok((Endpoint::new(settings)?, network.towards(side).channel(travel, seed, side)))
            });
            let (endpoint, link) = linked.transpose()?.unzip();
            let plant = Plant::new(sides[side].handle, &sides[side].arm, start)
                .map_err(|refusal| refusal.within(&format!("arm{}", side + 1)))?;
            Ok(Self {
                robot: ActuatedPlant::new(plant),
                mover: AgentState::new(&sides[side].agent, seed, side),
                endpoint,
                link,
            })
        };
        Ok([station(0)?, station(1)?])
    }
}
