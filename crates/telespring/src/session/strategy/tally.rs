//! What every strategy reports of its own port: energy given out, and how often it changed the force.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::{Outgoing, StrategyReport, Tick};
use crate::session::pair::{dot, finite_or, size};

/// The longest time between two measurements that a strategy integrates over, s: a clock that jumps moves no more.
const LONGEST_STEP: f64 = 0.1;

/// The time since the previous measurement as a strategy uses it, s: from 0 to [`LONGEST_STEP`].
pub(super) fn step(tick: &Tick) -> f64 {
    if tick.elapsed > 0.0 { tick.elapsed.min(LONGEST_STEP) } else { 0.0 }
}

/// The running account of one side's port.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tally {
    report: StrategyReport,
    /// The sum over the limited ticks of the share of the force that was withheld.
    withheld: f64,
    limited: bool,
}

impl Tally {
    /// Takes account of the time since the previous measurement; the energy given out to the own handle in it, J, or
    /// `None` if nobody knows it.
    pub(super) fn settle(&mut self, tick: &Tick) -> Option<f64> {
        let given_out = dot(tick.acted, tick.displacement());
        self.report.given_out = finite_or(self.report.given_out + given_out, self.report.given_out);
        given_out.is_finite().then_some(given_out)
    }

    /// Counts one tick with a partner.
    pub(super) fn count(&mut self, wanted: [f64; 2], force: [f64; 2]) {
        self.report.ticks = self.report.ticks.saturating_add(1);
        self.limited = force != wanted;
        if self.limited {
            self.report.limited_ticks = self.report.limited_ticks.saturating_add(1);
            let kept = size(force) / size(wanted);
            self.withheld += if kept.is_finite() { 1.0 - kept } else { 1.0 };
        }
    }

    /// There is no partner at this tick.
    pub(super) fn pause(&mut self) {
        self.limited = false;
    }

    /// Whether the force was changed at the last tick.
    pub(super) fn is_limited(&self) -> bool {
        self.limited
    }

    /// What the partner must know of a strategy without a signal of its own.
    pub(super) fn outgoing(&self, stiffness: f64, energy_sent: f64) -> Outgoing {
        Outgoing { energy_sent, signal: [0.0; 2], stiffness, limited: self.limited }
    }

    /// The report, without balance and exchanged energy.
    pub(super) fn report(&self) -> StrategyReport {
        let limited = self.report.limited_ticks;
        StrategyReport {
            withheld: if limited == 0 { 0.0 } else { self.withheld / limited as f64 },
            ..self.report
        }
    }
}
