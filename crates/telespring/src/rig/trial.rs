//! A trial: two controllers, two agents, two plants and a network in virtual time.
//!
//! Time is counted in ticks of the controllers; tick n is at n·period. At every tick both sides measure and
//! send; then packets that have arrived are delivered; then both compute their forces, which are held until
//! the next tick. With a computing tick the forces of the previous tick act instead. Both sides thus use
//! samples of the same instant, in either order of computation.

use super::agent::{AgentState, Observation};
use super::network::Channel;
use super::passivity::{PassivityReport, held_force_energy};
use super::plant::{Halt, Plant, RelaxingForce};
use super::record::{Record, Recording, Row, Status, TrialOutcome};
use super::schedule::Schedule;
use super::{Agent, Controller, Laboratory};
use crate::error::{InvalidInput, Result};
use crate::model::Delay;
use crate::quantity;
use crate::session::{Endpoint, EndpointSettings, Law, LocalTime, Motion, SideFacts, Span, motion};

/// A trial diverges if a handle is farther than this from the origin along an axis, m: no robot reaches
/// that far.
pub const POSITION_LIMIT: f64 = 10.0;

/// The connected mode: stiffness, damping and delay of the coupling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConnectedMode {
    /// The stiffness of the virtual spring, N/m.
    pub stiffness: f64,
    /// The damping in parallel with it, N·s/m.
    pub damping: f64,
    /// The one-way delays from the measurement of a position to its use by the partner.
    pub delay: Delay,
}

impl ConnectedMode {
    /// Checks that stiffness and damping of a trial's connected mode are in range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field.
    pub fn check(&self) -> Result<()> {
        quantity::STIFFNESS.check("stiffness", self.stiffness)?;
        quantity::DAMPING.check("coupling_damping", self.damping)?;
        Ok(())
    }
}

/// An external agent: returns the force (N per axis) for its observation at a tick.
pub type Callback<'a, E> = &'a mut dyn FnMut(&Observation) -> std::result::Result<[f64; 2], E>;

/// Called during a trial; an error ends the trial, for instance after Ctrl-C.
pub type InterruptCheck<'a, E> = &'a mut dyn FnMut() -> std::result::Result<(), E>;

/// Ticks between two calls of the interrupt check: a few milliseconds, or some tenths of a second if a
/// plant is about to be too stiff.
const TICKS_BETWEEN_CHECKS: usize = 256;

/// One trial of a laboratory in one condition.
#[derive(Debug, Clone, Copy)]
pub struct Trial<'a> {
    /// The laboratory.
    pub laboratory: &'a Laboratory,
    /// The coupling of both sides; `None` in the unconnected mode.
    pub coupling: Option<ConnectedMode>,
    /// The seed of all random numbers.
    pub seed: u64,
    /// The ticks to run and to record.
    pub schedule: Schedule,
}

/// The forces that act on one side from a tick on, N.
#[derive(Debug, Clone, Copy, Default)]
struct ActingForces {
    /// The force commanded by the robot's controller.
    command: [f64; 2],
    /// The force of the robot at the tick, behind the actuator lag.
    robot: [f64; 2],
    /// The force commanded by the agent.
    hand: [f64; 2],
}

/// The state of one side during a trial.
struct RunningStation {
    plant: Plant,
    mover: AgentState,
    endpoint: Option<Endpoint>,
    /// The channel towards this side.
    link: Option<Box<dyn Channel>>,
    /// The forces computed at the previous tick: of the spring and of the agent, N.
    computed: [[f64; 2]; 2],
    /// The force of the actuator, N.
    actuator: [f64; 2],
}

impl RunningStation {
    /// Whether, in the running trial, a handle is beyond the position limit or too fast for a packet.
    fn has_diverged(&self) -> bool {
        let beyond = |values: [f64; 2], limit: f64| values.iter().any(|value| !(value.abs() <= limit));
        beyond(self.plant.position(), POSITION_LIMIT) || beyond(self.plant.velocity(), motion::MAX_VALUE)
    }

    /// Measures position and velocity with the sensor's resolution at a tick of the trial.
    fn measure_motion(&self, resolution: f64) -> Motion {
        let position = self.plant.position();
        let position = if resolution > 0.0 {
            position.map(|value| (value / resolution).round() * resolution)
        } else {
            position
        };
        Motion { position, velocity: self.plant.velocity() }
    }

    /// The energy in the account of the strategy, J; NaN if there is none.
    fn balance(&self) -> f64 {
        let report = self.endpoint.as_ref().map(Endpoint::strategy_report);
        report.and_then(|report| report.balance).unwrap_or(f64::NAN)
    }

    /// The age of the partner's motion in use, s; NaN if there is none.
    fn partner_age(&self) -> f64 {
        self.endpoint.as_ref().and_then(Endpoint::partner_age).unwrap_or(f64::NAN)
    }

    /// Receives all packets that have arrived and returns the force of the spring, N.
    fn spring_force(&mut self, now: LocalTime, measured: Motion) -> [f64; 2] {
        let (Some(link), Some(endpoint)) = (&mut self.link, &mut self.endpoint) else { return [0.0; 2] };
        link.observe(measured);
        while let Some(packet) = link.deliver(now) {
            // What is refused is dropped, as by a live program; only an adversary alters packets so that they are.
            let _ = endpoint.handle_datagram(now, &packet);
        }
        endpoint.force(now)
    }

    /// The forces that act in the trial until the next tick, given the newly computed ones, N.
    fn acting_forces(&mut self, spring: [f64; 2], hand: [f64; 2], controller: &Controller) -> ActingForces {
        let computed = [spring, hand];
        let before = std::mem::replace(&mut self.computed, computed);
        let [command, hand] = if controller.computing_tick { before } else { computed };
        let robot = if controller.actuator_lag > 0.0 { self.actuator } else { command };
        ActingForces { command, robot, hand }
    }

    /// The mean force of the trial's robot over the next sample period, N; it is held but for the actuator lag.
    fn mean_robot_force(&self, acting: &ActingForces, controller: &Controller) -> [f64; 2] {
        if controller.actuator_lag > 0.0 {
            let (from, to, time_constant) = (self.actuator, acting.command, controller.actuator_lag);
            return RelaxingForce { from, to, time_constant }.mean(controller.sample_period);
        }
        acting.command
    }

    /// Moves the plant of one side of the trial over one sample period.
    fn advance_plant(
        &mut self,
        acting: &ActingForces,
        controller: &Controller,
    ) -> std::result::Result<(), Halt> {
        let (period, time_constant) = (controller.sample_period, controller.actuator_lag);
        if time_constant > 0.0 {
            let force = RelaxingForce { from: self.actuator, to: acting.command, time_constant };
            self.actuator = force.after(period);
            if let Some(endpoint) = &mut self.endpoint {
                endpoint.handle_acted(force.mean(period));
            }
            return self.plant.advance_relaxing(&force, acting.hand, period);
        }
        self.plant.advance(acting.command, acting.hand, period)
    }
}

impl Laboratory {
    /// What one side of the coupling, 0 or 1, knows in a trial of the laboratory; live, the session id is another.
    pub fn side_facts(&self, side: usize, coupling: &ConnectedMode) -> SideFacts {
        let Self { controller, session, .. } = self;
        let ConnectedMode { stiffness, damping, delay } = *coupling;
        // Robot 2 receives in the forward direction.
        let seen = |[forward, backward]: [f64; 2]| {
            if side == 0 { [backward, forward] } else { [forward, backward] }
        };
        SideFacts {
            session: side as u64 + 1,
            law: Law { stiffness, damping },
            delays: seen([delay.forward(), delay.backward()]),
            lateness: seen(session.lateness),
            has_playout_buffer: session.has_playout_buffer,
            sample_period: controller.sample_period,
            computing_tick: controller.computing_tick,
            encoder_step: controller.encoder_resolution,
            least_damping: [session.least_damping[side], session.least_damping[1 - side]],
        }
    }

    /// Checks that both sides can run the laboratory's architecture in a condition.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the setting that is refused.
    pub fn check_session(&self, coupling: &ConnectedMode) -> Result<()> {
        for side in 0..2 {
            let facts = self.side_facts(side, coupling);
            Endpoint::new(self.session.architecture.endpoint_settings(&facts)?)?;
        }
        Ok(())
    }
}

impl Trial<'_> {
    /// Both stations at the start of the trial.
    fn start_stations(&self) -> Result<[RunningStation; 2]> {
        let Laboratory { stations: sides, target, controller, network, .. } = self.laboratory;
        let period = Span::from_seconds(controller.sample_period);
        let start = target.at_tick(0, controller.sample_period).position;
        let station = |side: usize| -> Result<RunningStation> {
            let linked = self.coupling.map(|coupling| -> Result<_> {
                let facts = self.laboratory.side_facts(side, &coupling);
                let settings = EndpointSettings {
                    // the laboratory asks what the coupling does, on however old a motion
                    watchdog: None,
                    ..self.laboratory.session.architecture.endpoint_settings(&facts)?
                };
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

    /// Runs the trial and records it in its own memory.
    ///
    /// # Errors
    ///
    /// As [`Trial::run`].
    pub fn record<E: From<InvalidInput>>(
        &self,
        external: [Option<Callback<'_, E>>; 2],
    ) -> std::result::Result<Recording, E> {
        self.record_interruptible(external, &mut || Ok(()))
    }

    /// As [`Trial::record`], with the interrupt check of [`Trial::run_interruptible`].
    ///
    /// # Errors
    ///
    /// As [`Trial::run_interruptible`].
    pub fn record_interruptible<E: From<InvalidInput>>(
        &self,
        external: [Option<Callback<'_, E>>; 2],
        check_interrupt: InterruptCheck<'_, E>,
    ) -> std::result::Result<Recording, E> {
        let mut recording = Recording::new(self.schedule.rows());
        let outcome = self.run_interruptible(external, &mut recording.slots(), check_interrupt)?;
        recording.truncate(outcome);
        Ok(recording)
    }

    /// Runs the trial into the caller's arrays; `external` moves the sides with an [`Agent::External`]. The
    /// laboratory must have passed [`Laboratory::check`].
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a value is out of range, an arm cannot reach the first target, an external agent
    /// is missing or returns a force that is not finite, or `record` is too short; and every error of an
    /// external agent.
    pub fn run<E: From<InvalidInput>>(
        &self,
        external: [Option<Callback<'_, E>>; 2],
        record: &mut Record<'_>,
    ) -> std::result::Result<TrialOutcome, E> {
        self.run_interruptible(external, record, &mut || Ok(()))
    }

    /// As [`Trial::run`]; `check_interrupt` is called regularly, and its error ends the trial.
    ///
    /// # Errors
    ///
    /// As [`Trial::run`], and every error of `check_interrupt`.
    pub fn run_interruptible<E: From<InvalidInput>>(
        &self,
        mut external: [Option<Callback<'_, E>>; 2],
        record: &mut Record<'_>,
        check_interrupt: InterruptCheck<'_, E>,
    ) -> std::result::Result<TrialOutcome, E> {
        let Laboratory { stations: sides, target, controller, .. } = self.laboratory;
        let (ticks, stride) = (self.schedule.ticks(), self.schedule.stride());
        if let Some(coupling) = &self.coupling {
            coupling.check()?;
        }
        for side in 0..2 {
            if matches!(sides[side].agent, Agent::External) && external[side].is_none() {
                return Err(missing_agent(side).into());
            }
        }
        if record.len() < self.schedule.rows() {
            let rows = self.schedule.rows();
            let refusal = InvalidInput::new(
                "record",
                format!("{} row(s)", record.len()),
                format!("every array needs {rows} rows"),
                "Schedule::rows gives the length.",
            );
            return Err(refusal.into());
        }
        let period = controller.sample_period;
        let mut stations = self.start_stations()?;
        let mut rows = 0;
        let mut passivity = PassivityReport::default();
        for tick in 0..=ticks {
            let time = tick as f64 * period;
            let now = LocalTime::from_seconds(time);
            let aim_here = target.at_tick(tick, period);
            let shown = Motion { position: aim_here.position, velocity: aim_here.velocity };
            // Also if the motion cannot be sent in a packet.
            let diverged = Status::Diverged { at: time };
            if stations.iter().any(RunningStation::has_diverged) {
                return Ok(outcome(diverged, rows, passivity, &stations));
            }
            if tick % TICKS_BETWEEN_CHECKS == 0 {
                check_interrupt()?;
            }
            let measured =
                stations.each_ref().map(|station| station.measure_motion(controller.encoder_resolution));
            for side in 0..2 {
                if let Some(endpoint) = &mut stations[side].endpoint {
                    if endpoint.handle_measurement(now, measured[side]).is_err() {
                        return Ok(outcome(diverged, rows, passivity, &stations));
                    }
                    endpoint.handle_target(now, shown);
                    if let (Some(packet), Some(link)) =
                        (endpoint.poll_transmit(now), &mut stations[1 - side].link)
                    {
                        link.send(now, packet);
                    }
                }
            }
            let (mut aim, mut acting) = (Row::default(), [ActingForces::default(); 2]);
            for (side, station) in stations.iter_mut().enumerate() {
                let seen = Observation {
                    time,
                    position: measured[side].position,
                    velocity: measured[side].velocity,
                    target: aim_here.position,
                };
                let hand;
                (aim[side], hand) = match (&station.mover, &mut external[side]) {
                    (AgentState::External, Some(program)) => {
                        (aim_here.position, check_force(side, time, program(&seen)?)?)
                    }
                    _ => station.mover.aim_and_force(&seen, &aim_here),
                };
                let spring = station.spring_force(now, measured[side]);
                acting[side] = station.acting_forces(spring, hand, controller);
            }
            if tick % stride == 0 {
                record.target[rows] = aim_here.position;
                record.aim[rows] = aim;
                for (side, station) in stations.iter().enumerate() {
                    let ActingForces { robot, hand, .. } = acting[side];
                    record.coupling_force[rows][side] = robot;
                    record.agent_force[rows][side] = hand;
                    record.position[rows][side] = station.plant.position();
                    record.velocity[rows][side] = station.plant.velocity();
                    record.handle_force[rows][side] = station.plant.handle_force(robot, hand);
                    record.account[rows][side] = station.balance();
                    record.age[rows][side] = station.partner_age();
                }
                rows += 1;
            }
            if tick == ticks {
                break;
            }
            let mut given = 0.0;
            for (station, acting) in stations.iter_mut().zip(&acting) {
                let (from, force) = (station.plant.position(), station.mean_robot_force(acting, controller));
                if let Err(halt) = station.advance_plant(acting, controller) {
                    let at = (tick + 1) as f64 * period;
                    let status = match halt {
                        Halt::OutOfReach(_) => Status::OutOfReach { at },
                        Halt::TooStiff { .. } => Status::TooStiff { at },
                    };
                    return Ok(outcome(status, rows, passivity, &stations));
                }
                given += held_force_energy(force, from, station.plant.position());
            }
            passivity = passivity.after(given);
        }
        Ok(outcome(Status::Completed, rows, passivity, &stations))
    }
}

/// The outcome of a trial whose stations are at its end.
fn outcome(
    status: Status,
    rows: usize,
    passivity: PassivityReport,
    stations: &[RunningStation; 2],
) -> TrialOutcome {
    let [first, second] = stations.each_ref().map(|station| station.endpoint.as_ref().map(Endpoint::report));
    TrialOutcome {
        status,
        rows,
        passivity,
        sessions: first.zip(second).map(|(first, second)| [first, second]),
    }
}

/// The error for an external agent that a trial lacks.
fn missing_agent(side: usize) -> InvalidInput {
    InvalidInput::new(
        format!("agents[{side}]"),
        "none",
        format!("agent {} is external and must be given", side + 1),
        "Give a function of time, position, velocity and target that returns the force.",
    )
}

/// Checks the force of an external agent in a trial.
fn check_force(side: usize, time: f64, force: [f64; 2]) -> Result<[f64; 2]> {
    for (axis, value) in force.into_iter().enumerate() {
        quantity::FORCE.check("", value).map_err(|refusal| InvalidInput {
            field: format!("agents[{side}] at {time} s, force[{axis}]"),
            ..refusal
        })?;
    }
    Ok(force)
}
