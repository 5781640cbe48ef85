//! A trial: two controllers, two agents, two plants and a network in virtual time.
//!
//! Time is counted in ticks of the controllers; tick n is at n·period. At every tick both sides measure and
//! send; then packets that have arrived are delivered; then both compute their forces, which are held until
//! the next tick. With a computing tick the forces of the previous tick act instead. Both sides thus use
//! samples of the same instant, in either order of computation.

use super::actuated::ActingForces;
use super::agent::{AgentState, Observation};
use super::connected::ConnectedMode;
use super::energy::Energies;
use super::plant::Halt;
use super::record::{Record, Recording, Row, Status, TrialOutcome};
use super::schedule::Schedule;
use super::station::RunningStation;
use super::{Agent, Laboratory};
use crate::error::{InvalidInput, Result};
use crate::quantity;
use crate::session::{Endpoint, LocalTime, Motion};

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

impl Trial<'_> {
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
        let mut energies = Energies::default();
        for tick in 0..=ticks {
            let time = tick as f64 * period;
            let now = LocalTime::from_seconds(time);
            let aim_here = target.at_tick(tick, period);
            let shown = Motion { position: aim_here.position, velocity: aim_here.velocity };
            // Also if the motion cannot be sent in a packet.
            let diverged = Status::Diverged { at: time };
            if stations.iter().any(RunningStation::has_diverged) {
                return Ok(outcome(diverged, rows, energies, &stations));
            }
            if tick % TICKS_BETWEEN_CHECKS == 0 {
                check_interrupt()?;
            }
            let measured = stations.each_ref().map(|station| station.robot.measure(controller));
            for side in 0..2 {
                if let Some(endpoint) = &mut stations[side].endpoint {
                    if endpoint.handle_measurement(now, measured[side]).is_err() {
                        return Ok(outcome(diverged, rows, energies, &stations));
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
                acting[side] = station.robot.acting_forces(spring, hand, controller);
            }
            if tick % stride == 0 {
                record.target[rows] = aim_here.position;
                record.aim[rows] = aim;
                for (side, station) in stations.iter().enumerate() {
                    let ActingForces { robot, hand, .. } = acting[side];
                    record.coupling_force[rows][side] = robot;
                    record.agent_force[rows][side] = hand;
                    record.position[rows][side] = station.robot.plant.position();
                    record.velocity[rows][side] = station.robot.plant.velocity();
                    record.handle_force[rows][side] = station.robot.plant.handle_force(robot, hand);
                    record.account[rows][side] = station.balance();
                    record.age[rows][side] = station.partner_age();
                }
                rows += 1;
            }
            if tick == ticks {
                break;
            }
            let mut given = [[0.0; 2]; 2];
            for ((station, acting), given) in stations.iter_mut().zip(&acting).zip(&mut given) {
                match station.advance(acting, controller) {
                    Ok(energy) => *given = energy,
                    Err(halt) => {
                        let at = (tick + 1) as f64 * period;
                        let status = match halt {
                            Halt::OutOfReach(_) => Status::OutOfReach { at },
                            Halt::TooStiff { .. } => Status::TooStiff { at },
                        };
                        return Ok(outcome(status, rows, energies, &stations));
                    }
                }
            }
            energies.add(given);
        }
        Ok(outcome(Status::Completed, rows, energies, &stations))
    }
}

/// The outcome of a trial whose stations are at its end.
fn outcome(status: Status, rows: usize, energies: Energies, stations: &[RunningStation; 2]) -> TrialOutcome {
    let [first, second] = stations.each_ref().map(|station| station.endpoint.as_ref().map(Endpoint::report));
    TrialOutcome {
        status,
        rows,
        coupling_energy: energies.coupling,
        hand_energy: energies.hands,
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
