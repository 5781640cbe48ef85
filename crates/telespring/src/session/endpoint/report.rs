//! What an endpoint has done so far.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::Endpoint;
use crate::session::WatchdogState;
use crate::session::clock::ClockReport;
use crate::session::playout::PlayoutReport;
use crate::session::strategy::{Strategy, StrategyReport};
use crate::session::wire::Flags;

/// What a session has done so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SessionReport {
    /// The state of the watchdog; engaged without one.
    pub state: WatchdogState,
    /// The partner's session id; `None` before its first packet.
    pub partner: Option<u64>,
    /// The partner's state as of its newest packet.
    pub partner_flags: Flags,
    /// How often the partner has restarted.
    pub restarts: u64,
    /// Packets sent.
    pub sent: u64,
    /// Packets taken.
    pub received: u64,
    /// Datagrams refused.
    pub refused: u64,
    /// Values of the own device, the target or the measured force that were impossible.
    pub impossible_values: u64,
    /// Events given up because nobody fetched them.
    pub missed_events: u64,
    /// The partner's clock.
    pub clock: ClockReport,
    /// The play-out.
    pub playout: PlayoutReport,
    /// The strategy's account.
    pub strategy: StrategyReport,
}

impl Endpoint {
    /// The age of the partner's motion that the latest force used, s, as played and before any prediction; `None` if it
    /// used none.
    pub fn partner_age(&self) -> Option<f64> {
        self.view.map(|view| view.age)
    }

    /// All energy that the partner says it has sent to this side, J: the largest total of each of its sessions.
    pub fn partner_energy(&self) -> f64 {
        self.partner.energy_sent()
    }

    /// The strategy's account so far: a part of the report that costs little.
    pub fn strategy_report(&self) -> StrategyReport {
        self.strategy.report()
    }

    /// What the session has done so far.
    pub fn report(&self) -> SessionReport {
        SessionReport {
            state: self.state(),
            partner: self.partner.session(),
            partner_flags: self.partner.flags(),
            restarts: self.partner.restarts,
            sent: self.sent,
            received: self.received,
            refused: self.refused,
            impossible_values: self.impossible_values,
            missed_events: self.events.missed(),
            clock: self.clock.report(self.now),
            playout: self.playout.report(),
            strategy: self.strategy.report(),
        }
    }
}
