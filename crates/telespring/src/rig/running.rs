//! A trial that is under way: both sides, moved tick by tick.
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
use super::record::{Record, Row, Status, TrialOutcome};
use super::station::RunningStation;
use super::target::TargetPoint;
use super::trial::Callback;
use super::{Controller, Laboratory, Target};
use crate::error::{InvalidInput, Result};
use crate::quantity;
use crate::session::{Endpoint, LocalTime, Motion};

/// Two sides of a laboratory under way, moved tick by tick by the caller: what [`Trial`](super::Trial) runs to its end.
///
/// # Examples
///
/// ```
/// use telespring::rig::{ConnectedMode, Laboratory, RunningTrial};
/// use telespring::{Delay, InvalidInput};
///
/// let coupling = ConnectedMode { stiffness: 71.2, damping: 0.0, delay: Delay::each_way(0.084)? };
/// let mut running = RunningTrial::start(&Laboratory::paper(), Some(coupling), 1)?;
/// for _ in 0..1000 {
///     running.tick::<InvalidInput>(&mut [None, None])?;
/// }
/// assert!((running.time() - 1.0).abs() < 1e-12);
/// # Ok::<(), InvalidInput>(())
/// ```
pub struct RunningTrial {
    stations: [RunningStation; 2],
    target: Target,
    controller: Controller,
    tick: usize,
    energies: Energies,
}

/// What acts from a tick on until the next.
pub(super) struct Held {
    /// The target at the tick.
    target: TargetPoint,
    /// The point that each agent aims at, m.
    aim: Row,
    /// The forces on each side.
    acting: [ActingForces; 2],
}

impl RunningTrial {
    /// Both sides at the start of a trial in this condition, `None` in the unconnected mode; `seed` is that of all random
    /// numbers. The laboratory must have passed [`Laboratory::check`].
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a value is out of range, or an arm cannot reach the first target.
    pub fn start(laboratory: &Laboratory, coupling: Option<ConnectedMode>, seed: u64) -> Result<Self> {
        Ok(Self {
            stations: RunningStation::pair(laboratory, coupling, seed)?,
            target: laboratory.target.clone(),
            controller: laboratory.controller,
            tick: 0,
            energies: Energies::default(),
        })
    }

    /// The time since the start of the running trial, s.
    pub fn time(&self) -> f64 {
        self.tick as f64 * self.controller.sample_period
    }

    /// Positions of both handles of the running trial, m.
    pub fn position(&self) -> Row {
        self.stations.each_ref().map(|station| station.robot.plant.position())
    }

    /// The energy in the account of each side's strategy in the running trial, J; NaN if it keeps none.
    pub fn account(&self) -> [f64; 2] {
        self.stations.each_ref().map(RunningStation::balance)
    }

    /// Moves both sides of the running trial over one sample period; returns the force of each robot on its handle, N, or
    /// how the trial ended. `external` moves the sides with an [`Agent::External`](super::Agent).
    ///
    /// # Errors
    ///
    /// Every error of an external agent, and [`InvalidInput`] if its force is not finite.
    pub fn tick<E: From<InvalidInput>>(
        &mut self,
        external: &mut [Option<Callback<'_, E>>; 2],
    ) -> std::result::Result<std::result::Result<Row, Status>, E> {
        let held = match self.forces(external)? {
            Ok(held) => held,
            Err(status) => return Ok(Err(status)),
        };
        let at = self.time() + self.controller.sample_period;
        Ok(match self.advance(&held) {
            Ok(()) => Ok(held.acting.map(|acting| acting.robot)),
            Err(Halt::OutOfReach(_)) => Err(Status::OutOfReach { at }),
            Err(Halt::TooStiff { .. }) => Err(Status::TooStiff { at }),
        })
    }

    /// Whether a handle of the running trial is beyond the position limit or too fast for a packet.
    pub(super) fn has_diverged(&self) -> bool {
        self.stations.iter().any(RunningStation::has_diverged)
    }

    /// Measures, sends and receives on both sides; the forces that then act until the next tick, or how the trial ended.
    pub(super) fn forces<E: From<InvalidInput>>(
        &mut self,
        external: &mut [Option<Callback<'_, E>>; 2],
    ) -> std::result::Result<std::result::Result<Held, Status>, E> {
        let time = self.time();
        // Also if the motion cannot be sent in a packet.
        let diverged = Status::Diverged { at: time };
        if self.has_diverged() {
            return Ok(Err(diverged));
        }
        let Self { stations, controller, .. } = self;
        let now = LocalTime::from_seconds(time);
        let aim_here = self.target.at_tick(self.tick, controller.sample_period);
        let shown = Motion { position: aim_here.position, velocity: aim_here.velocity };
        let measured = stations.each_ref().map(|station| station.robot.measure(controller));
        for side in 0..2 {
            if let Some(endpoint) = &mut stations[side].endpoint {
                if endpoint.handle_measurement(now, measured[side]).is_err() {
                    return Ok(Err(diverged));
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
        Ok(Ok(Held { target: aim_here, aim, acting }))
    }

    /// Writes what acts from this tick of the running trial on into a row of a record.
    pub(super) fn write(&self, held: &Held, record: &mut Record<'_>, row: usize) {
        record.target[row] = held.target.position;
        record.aim[row] = held.aim;
        for (side, station) in self.stations.iter().enumerate() {
            let ActingForces { robot, hand, .. } = held.acting[side];
            record.coupling_force[row][side] = robot;
            record.agent_force[row][side] = hand;
            record.position[row][side] = station.robot.plant.position();
            record.velocity[row][side] = station.robot.plant.velocity();
            record.handle_force[row][side] = station.robot.plant.handle_force(robot, hand);
            record.account[row][side] = station.balance();
            record.age[row][side] = station.partner_age();
        }
    }

    /// Moves both sides of the running trial to the next tick.
    pub(super) fn advance(&mut self, held: &Held) -> std::result::Result<(), Halt> {
        let mut given = [[0.0; 2]; 2];
        for ((station, acting), given) in self.stations.iter_mut().zip(&held.acting).zip(&mut given) {
            *given = station.advance(acting, &self.controller)?;
        }
        self.energies.add(given);
        self.tick += 1;
        Ok(())
    }

    /// The outcome of a running trial that ends here.
    pub(super) fn outcome(&self, status: Status, rows: usize) -> TrialOutcome {
        let [first, second] =
            self.stations.each_ref().map(|station| station.endpoint.as_ref().map(Endpoint::report));
        TrialOutcome {
            status,
            rows,
            coupling_energy: self.energies.coupling,
            hand_energy: self.energies.hands,
            sessions: first.zip(second).map(|(first, second)| [first, second]),
        }
    }
}

/// Checks the force of an external agent in a running trial.
fn check_force(side: usize, time: f64, force: [f64; 2]) -> Result<[f64; 2]> {
    for (axis, value) in force.into_iter().enumerate() {
        quantity::FORCE.check("", value).map_err(|refusal| InvalidInput {
            field: format!("agents[{side}] at {time} s, force[{axis}]"),
            ..refusal
        })?;
    }
    Ok(force)
}
