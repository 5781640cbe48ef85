//! A trial: two controllers, two agents, two plants and a network in virtual time.

use super::agent::Observation;
use super::connected::ConnectedMode;
use super::plant::Halt;
use super::record::{Record, Recording, Status, TrialOutcome};
use super::running::RunningTrial;
use super::schedule::Schedule;
use super::{Agent, Laboratory};
use crate::error::InvalidInput;

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
        let Laboratory { stations: sides, controller, .. } = self.laboratory;
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
        let mut running = RunningTrial::start(self.laboratory, self.coupling, self.seed)?;
        let mut rows = 0;
        for tick in 0..=ticks {
            if tick % TICKS_BETWEEN_CHECKS == 0 && !running.has_diverged() {
                check_interrupt()?;
            }
            let held = match running.forces(&mut external)? {
                Ok(held) => held,
                Err(status) => return Ok(running.outcome(status, rows)),
            };
            if tick % stride == 0 {
                running.write(&held, record, rows);
                rows += 1;
            }
            if tick == ticks {
                break;
            }
            if let Err(halt) = running.advance(&held) {
                let at = (tick + 1) as f64 * period;
                let status = match halt {
                    Halt::OutOfReach(_) => Status::OutOfReach { at },
                    Halt::TooStiff { .. } => Status::TooStiff { at },
                };
                return Ok(running.outcome(status, rows));
            }
        }
        Ok(running.outcome(Status::Completed, rows))
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
