//! The bare spring of the paper: its force whatever happens.

use super::{Outgoing, Strategy, StrategyReport, Tick};
use crate::session::Law;

/// The bare spring (Ivanova et al. 2021): the force of the coupling law from the partner's motion in use.
#[derive(Debug, Clone, Copy)]
pub struct Spring {
    law: Law,
    report: StrategyReport,
}

impl Spring {
    /// A spring with this law.
    pub fn new(law: Law) -> Self {
        Self { law, report: StrategyReport::default() }
    }
}

impl Strategy for Spring {
    fn settle(&mut self, tick: &Tick) {
        let [x, y] = tick.displacement();
        self.report.given_out += tick.acted[0] * x + tick.acted[1] * y;
    }

    fn force(&mut self, tick: &Tick) -> [f64; 2] {
        let Some(partner) = &tick.partner else { return [0.0; 2] };
        self.report.ticks = self.report.ticks.saturating_add(1);
        self.law.force(&tick.own, &partner.wanted).map(|force| force * tick.enabled)
    }

    fn outgoing(&self) -> Outgoing {
        Outgoing { stiffness: self.law.stiffness, ..Outgoing::default() }
    }

    fn report(&self) -> StrategyReport {
        self.report
    }
}
