//! The recorded signals of a trial and how it ended.

use super::CouplingEnergy;
use crate::session::SessionReport;

/// One value per robot and axis.
pub type Row = [[f64; 2]; 2];

/// The caller's arrays for the recorded signals: one row per recorded tick, per robot and axis.
#[derive(Debug)]
pub struct Record<'a> {
    /// The position of the target, m.
    pub target: &'a mut [[f64; 2]],
    /// Positions of the handles, m.
    pub position: &'a mut [Row],
    /// Velocities of the handles, m/s.
    pub velocity: &'a mut [Row],
    /// Force of each robot on its handle, from this tick on, N.
    pub coupling_force: &'a mut [Row],
    /// Force of each agent on its arm, from this tick on, N.
    pub agent_force: &'a mut [Row],
    /// Force of each arm on its handle, from this tick on, N.
    pub handle_force: &'a mut [Row],
    /// The point each agent aims at, m: the mean of its spots, or the target itself.
    pub aim: &'a mut [Row],
    /// The energy in the account of each side's strategy, J; NaN if it keeps none, or unconnected.
    pub account: &'a mut [[f64; 2]],
    /// The age of the partner's motion that each side uses, s; NaN while there is none.
    pub age: &'a mut [[f64; 2]],
}

impl Record<'_> {
    /// The number of rows that fit into all arrays of the record of a trial.
    pub(super) fn len(&self) -> usize {
        [
            self.target.len(),
            self.position.len(),
            self.velocity.len(),
            self.coupling_force.len(),
            self.agent_force.len(),
            self.handle_force.len(),
            self.aim.len(),
            self.account.len(),
            self.age.len(),
        ]
        .into_iter()
        .min()
        .unwrap_or(0)
    }
}

/// How a trial ended.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Status {
    /// The last tick was reached.
    Completed,
    /// A handle exceeded [`POSITION_LIMIT`](super::POSITION_LIMIT).
    Diverged {
        /// The first such tick, s.
        at: f64,
    },
    /// An arm would have had to stretch beyond its reach.
    OutOfReach {
        /// The first tick not reached, s.
        at: f64,
    },
    /// The motion of a two-link plant is too stiff: one period would need too many steps.
    TooStiff {
        /// The first tick not reached, s.
        at: f64,
    },
}

/// How a trial ended, and the number of recorded rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialOutcome {
    /// How it ended.
    pub status: Status,
    /// The number of rows written, from the first.
    pub rows: usize,
    /// The energy that the coupling took at both handles, less what it gave out there.
    pub coupling_energy: CouplingEnergy,
    /// The energy that each hand got, J; negative if it gave more than it got.
    ///
    /// The force that an agent holds over a period, times the displacement of its handle in it; for a two-link arm its
    /// torques times the turns of the joints. That is exact whatever the motion in the period, because plants are integrated
    /// under just these held forces or torques.
    pub hand_energy: [f64; 2],
    /// What both sides of the coupling did; `None` in the unconnected mode.
    pub sessions: Option<[SessionReport; 2]>,
}

/// A recorded trial in its own memory. Two are equal if they hold the same numbers, NaN where the other has NaN.
#[derive(Debug, Clone)]
pub struct Recording {
    /// How the trial ended; all lists end there.
    pub outcome: TrialOutcome,
    /// As in [`Record`].
    pub target: Vec<[f64; 2]>,
    /// As in [`Record`].
    pub position: Vec<Row>,
    /// As in [`Record`].
    pub velocity: Vec<Row>,
    /// As in [`Record`].
    pub coupling_force: Vec<Row>,
    /// As in [`Record`].
    pub agent_force: Vec<Row>,
    /// As in [`Record`].
    pub handle_force: Vec<Row>,
    /// As in [`Record`].
    pub aim: Vec<Row>,
    /// As in [`Record`]; empty if the strategy keeps no account, or unconnected.
    pub account: Vec<[f64; 2]>,
    /// As in [`Record`].
    pub age: Vec<[f64; 2]>,
}

impl PartialEq for Recording {
    fn eq(&self, other: &Self) -> bool {
        let pairs = |recording: &Self| {
            let Self { target, account, age, .. } = recording;
            target.iter().chain(account).chain(age).flatten().map(|value| bits(*value)).collect::<Vec<_>>()
        };
        let rows = |recording: &Self| {
            let Self { position, velocity, coupling_force, agent_force, handle_force, aim, .. } = recording;
            let all = [position, velocity, coupling_force, agent_force, handle_force, aim];
            all.into_iter().flatten().flatten().flatten().map(|value| bits(*value)).collect::<Vec<_>>()
        };
        self.outcome == other.outcome && pairs(self) == pairs(other) && rows(self) == rows(other)
    }
}

/// The bits of a number, the same for every NaN and for both zeros.
fn bits(value: f64) -> u64 {
    if value.is_nan() { f64::NAN.to_bits() } else { (value + 0.0).to_bits() }
}

impl Recording {
    /// A recording with this number of empty rows.
    pub(super) fn new(rows: usize) -> Self {
        let empty = || vec![Row::default(); rows];
        Self {
            outcome: TrialOutcome {
                status: Status::Completed,
                rows,
                coupling_energy: CouplingEnergy::default(),
                hand_energy: [0.0; 2],
                sessions: None,
            },
            target: vec![[0.0; 2]; rows],
            position: empty(),
            velocity: empty(),
            coupling_force: empty(),
            agent_force: empty(),
            handle_force: empty(),
            aim: empty(),
            account: vec![[f64::NAN; 2]; rows],
            age: vec![[f64::NAN; 2]; rows],
        }
    }

    /// The arrays of the recording as a record to write to.
    pub(super) fn slots(&mut self) -> Record<'_> {
        Record {
            target: &mut self.target,
            position: &mut self.position,
            velocity: &mut self.velocity,
            coupling_force: &mut self.coupling_force,
            agent_force: &mut self.agent_force,
            handle_force: &mut self.handle_force,
            aim: &mut self.aim,
            account: &mut self.account,
            age: &mut self.age,
        }
    }

    /// Cuts the recording to the rows of the outcome.
    pub(super) fn truncate(&mut self, outcome: TrialOutcome) {
        self.outcome = outcome;
        self.target.truncate(outcome.rows);
        self.age.truncate(outcome.rows);
        let has_account = outcome.sessions.is_some_and(|[first, _]| first.strategy.balance.is_some());
        self.account.truncate(if has_account { outcome.rows } else { 0 });
        for rows in [
            &mut self.position,
            &mut self.velocity,
            &mut self.coupling_force,
            &mut self.agent_force,
            &mut self.handle_force,
            &mut self.aim,
        ] {
            rows.truncate(outcome.rows);
        }
    }
}
