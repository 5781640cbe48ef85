//! One trial: two controllers, two agents, two plants and a network in virtual time.
//!
//! Time is counted in ticks of the controllers, tick n being at n·period. At every tick both sides
//! measure and send; then what has arrived is delivered; then both compute their forces, which are held
//! until the next tick. With a computing tick the forces of the tick before act instead. Both sides thus
//! use what was measured at the same instant, whichever is computed first.

use super::agent::{Mover, Observation};
use super::channel::Channel;
use super::plant::{Halt, Plant, RelaxingForce};
use super::random::{Stream, generator};
use super::record::{Record, Recording, Row, Status, TrialOutcome};
use super::schedule::Schedule;
use super::{Agent, Controller, Laboratory};
use crate::error::{InvalidInput, Result};
use crate::model::Delay;
use crate::quantity;
use crate::session::{Endpoint, Law, Motion, Nanoseconds, PacketError, wire};

/// A trial ends as diverged where a handle is further from the origin than this along an axis, m: no
/// robot reaches that far.
pub const POSITION_LIMIT: f64 = 10.0;

/// How the two sides are coupled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConnectedMode {
    /// Of the virtual spring, N/m.
    pub stiffness: f64,
    /// Of the damper beside it, N·s/m.
    pub damping: f64,
    /// From the measurement of a position to its use by the partner, one way.
    pub delay: Delay,
}

impl ConnectedMode {
    /// Refuses what is out of range.
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

/// A program of the caller's that moves an arm: the force (N per axis) from what it sees at a tick.
pub type Callback<'a, E> = &'a mut dyn FnMut(&Observation) -> std::result::Result<[f64; 2], E>;

/// Called in the course of a trial; an error ends it, such as that somebody pressed Ctrl-C.
pub type InterruptCheck<'a, E> = &'a mut dyn FnMut() -> std::result::Result<(), E>;

/// Ticks between two calls of a check_interrupt: some milliseconds, and some tenths of a second in a plant that is
/// about to be too stiff.
const TICKS_BETWEEN_CHECKS: usize = 256;

/// One trial.
#[derive(Debug, Clone, Copy)]
pub struct Trial<'a> {
    /// Where.
    pub laboratory: &'a Laboratory,
    /// How both sides are coupled; `None` in the unconnected mode.
    pub coupling: Option<ConnectedMode>,
    /// From which everything random is drawn.
    pub seed: u64,
    /// Which ticks are run and kept.
    pub schedule: Schedule,
}

/// What acts on one side from a tick on, N.
#[derive(Debug, Clone, Copy, Default)]
struct Acting {
    /// What the robot's controller asks for.
    command: [f64; 2],
    /// What the robot gives at the tick; behind a lag not yet what is asked for.
    robot: [f64; 2],
    /// What the agent asks of its arm.
    hand: [f64; 2],
}

/// One side in the course of a trial.
struct RunningStation {
    plant: Plant,
    mover: Mover,
    endpoint: Option<Endpoint>,
    /// Towards this side.
    link: Option<Channel>,
    /// Computed at the tick before: of the spring and of the agent, N.
    computed: [[f64; 2]; 2],
    /// What the actuator gives, N.
    actuator: [f64; 2],
}

impl RunningStation {
    fn diverged(&self) -> bool {
        let beyond = |values: [f64; 2], limit: f64| values.iter().any(|value| !(value.abs() <= limit));
        beyond(self.plant.position(), POSITION_LIMIT) || beyond(self.plant.velocity(), wire::MAX_VALUE)
    }

    fn measure(&self, resolution: f64) -> Motion {
        let position = self.plant.position();
        let position = if resolution > 0.0 {
            position.map(|value| (value / resolution).round() * resolution)
        } else {
            position
        };
        Motion { position, velocity: self.plant.velocity() }
    }

    /// Takes in what has arrived and gives the force of the spring, N.
    fn spring(&mut self, now: Nanoseconds) -> std::result::Result<[f64; 2], PacketError> {
        let (Some(link), Some(endpoint)) = (&mut self.link, &mut self.endpoint) else { return Ok([0.0; 2]) };
        while let Some(packet) = link.deliver(now) {
            endpoint.receive(now, &packet)?;
        }
        Ok(endpoint.force(now))
    }

    /// What acts until the next tick where these forces have been computed now, N.
    fn act(&mut self, spring: [f64; 2], hand: [f64; 2], controller: &Controller) -> Acting {
        let computed = [spring, hand];
        let before = std::mem::replace(&mut self.computed, computed);
        let [command, hand] = if controller.computing_tick { before } else { computed };
        let robot = if controller.actuator_lag > 0.0 { self.actuator } else { command };
        Acting { command, robot, hand }
    }

    /// Moves on by one period.
    fn advance(&mut self, acting: &Acting, controller: &Controller) -> std::result::Result<(), Halt> {
        let (period, time_constant) = (controller.sample_period, controller.actuator_lag);
        if time_constant > 0.0 {
            let force = RelaxingForce { from: self.actuator, to: acting.command, time_constant };
            self.actuator = force.after(period);
            return self.plant.advance_relaxing(&force, acting.hand, period);
        }
        self.plant.advance(acting.command, acting.hand, period)
    }
}

impl Trial<'_> {
    fn stations(&self) -> Result<[RunningStation; 2]> {
        let Laboratory { stations: sides, target, controller, network } = self.laboratory;
        let period = Nanoseconds::from_seconds(controller.sample_period);
        let start = target.at(0, controller.sample_period).position;
        let station = |side: usize| -> Result<RunningStation> {
            let linked = self.coupling.map(|ConnectedMode { stiffness, damping, delay }| {
                // what robot 2 receives comes forward
                let delay = if side == 1 { delay.forward() } else { delay.backward() };
                let delay = Nanoseconds::from_seconds(delay);
                let travel = delay.before(period).unwrap_or_default();
                let random = generator(self.seed, Stream::Network(side));
                (Endpoint::new(Law { stiffness, damping }, delay), Channel::new(network, travel, random))
            });
            let (endpoint, link) = linked.unzip();
            Ok(RunningStation {
                plant: Plant::new(sides[side].handle, &sides[side].arm, start)
                    .map_err(|refusal| refusal.within(&format!("arm{}", side + 1)))?,
                mover: Mover::new(&sides[side].agent, self.seed, side),
                endpoint,
                link,
                computed: [[0.0; 2]; 2],
                actuator: [0.0; 2],
            })
        };
        Ok([station(0)?, station(1)?])
    }

    /// Runs it into memory of its own.
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

    /// As [`Trial::record`], with the check_interrupt of [`Trial::run_interruptible`].
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

    /// Runs it; `external` moves the sides whose agent is [`Agent::External`]. The laboratory is taken as
    /// checked ([`Laboratory::check`]).
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where a value is out of range, an arm cannot reach the first target, an external
    /// agent is missing or gives a force that is not finite, or `record` is too short; and whatever an
    /// external agent returns.
    pub fn run<E: From<InvalidInput>>(
        &self,
        external: [Option<Callback<'_, E>>; 2],
        record: &mut Record<'_>,
    ) -> std::result::Result<TrialOutcome, E> {
        self.run_interruptible(external, record, &mut || Ok(()))
    }

    /// As [`Trial::run`]; `check_interrupt` is called now and then, and what it returns as an error ends the trial.
    ///
    /// # Errors
    ///
    /// As [`Trial::run`], and whatever `check_interrupt` returns.
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
                "Ask Schedule::rows for the length.",
            );
            return Err(refusal.into());
        }
        let period = controller.sample_period;
        let mut stations = self.stations()?;
        let mut rows = 0;
        for tick in 0..=ticks {
            let time = tick as f64 * period;
            let now = Nanoseconds::from_seconds(time);
            let aim_here = target.at(tick, period);
            // also where a motion is none that a packet may carry
            let diverged = TrialOutcome { status: Status::Diverged { at: time }, rows };
            if stations.iter().any(RunningStation::diverged) {
                return Ok(diverged);
            }
            if tick % TICKS_BETWEEN_CHECKS == 0 {
                check_interrupt()?;
            }
            let measured = stations.each_ref().map(|station| station.measure(controller.encoder_resolution));
            for side in 0..2 {
                if let Some(endpoint) = &mut stations[side].endpoint {
                    let Ok(packet) = endpoint.send(now, measured[side]) else { return Ok(diverged) };
                    if let Some(link) = &mut stations[1 - side].link {
                        link.send(now, packet);
                    }
                }
            }
            let (mut aim, mut acting) = (Row::default(), [Acting::default(); 2]);
            for (side, station) in stations.iter_mut().enumerate() {
                let seen = Observation {
                    time,
                    position: measured[side].position,
                    velocity: measured[side].velocity,
                    target: aim_here.position,
                };
                let hand;
                (aim[side], hand) = match (&station.mover, &mut external[side]) {
                    (Mover::External, Some(program)) => {
                        (aim_here.position, check_force(side, time, program(&seen)?)?)
                    }
                    _ => station.mover.act(&seen, &aim_here),
                };
                let Ok(spring) = station.spring(now) else { return Ok(diverged) };
                acting[side] = station.act(spring, hand, controller);
            }
            if tick % stride == 0 {
                record.target[rows] = aim_here.position;
                record.aim[rows] = aim;
                for (side, station) in stations.iter().enumerate() {
                    let Acting { robot, hand, .. } = acting[side];
                    record.coupling_force[rows][side] = robot;
                    record.agent_force[rows][side] = hand;
                    record.position[rows][side] = station.plant.position();
                    record.velocity[rows][side] = station.plant.velocity();
                    record.handle_force[rows][side] = station.plant.handle_force(robot, hand);
                }
                rows += 1;
            }
            if tick == ticks {
                break;
            }
            for (station, acting) in stations.iter_mut().zip(&acting) {
                if let Err(halt) = station.advance(acting, controller) {
                    let at = (tick + 1) as f64 * period;
                    let status = match halt {
                        Halt::OutOfReach(_) => Status::OutOfReach { at },
                        Halt::TooStiff { .. } => Status::TooStiff { at },
                    };
                    return Ok(TrialOutcome { status, rows });
                }
            }
        }
        Ok(TrialOutcome { status: Status::Completed, rows })
    }
}

fn missing_agent(side: usize) -> InvalidInput {
    InvalidInput::new(
        format!("agents[{side}]"),
        "none",
        format!("agent {} is a program of the caller's and has to be given", side + 1),
        "Give a function of time, position, velocity and target that returns the force.",
    )
}

fn check_force(side: usize, time: f64, force: [f64; 2]) -> Result<[f64; 2]> {
    for (axis, value) in force.into_iter().enumerate() {
        quantity::FORCE.check("", value).map_err(|refusal| InvalidInput {
            field: format!("agents[{side}] at {time} s, force[{axis}]"),
            ..refusal
        })?;
    }
    Ok(force)
}
