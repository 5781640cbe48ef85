//! What an endpoint has done so far.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::Endpoint;
use crate::session::clock::ClockReport;
use crate::session::playout::{PlayoutCounts, PlayoutReport};
use crate::session::strategy::{Outgoing, PartnerView, Strategy, StrategyReport};
use crate::session::wire::Flags;
use crate::session::{Span, WatchdogState};

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

/// What a session is at one tick: what of its report costs little, and what the latest force was made of.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SessionSnapshot {
    /// The partner as the latest force used it; `None` if it used none.
    pub partner: Option<PartnerView>,
    /// The force that, for the account, acted until the newest measurement, N.
    pub acted: [f64; 2],
    /// The watchdog's factor on the latest force, 0 to 1.
    pub enabled: f64,
    /// What the next packet tells the partner.
    pub outgoing: Outgoing,
    /// The strategy's account.
    pub strategy: StrategyReport,
    /// The partner's clock.
    pub clock: ClockReport,
    /// The delay that the play-out strives for.
    pub playout_delay: Span,
    /// The counts of the play-out.
    pub playout: PlayoutCounts,
    /// Packets sent.
    pub sent: u64,
    /// Packets taken.
    pub received: u64,
    /// Datagrams refused.
    pub refused: u64,
}

impl Endpoint {
    /// What the session is at this tick. Unlike [`Endpoint::report`] it computes no quantiles, so it may be asked at every
    /// tick.
    pub fn snapshot(&self) -> SessionSnapshot {
        SessionSnapshot {
            partner: self.view,
            acted: self.acted,
            enabled: self.enabled,
            outgoing: self.strategy.outgoing(),
            strategy: self.strategy.report(),
            clock: self.clock.report(self.now),
            playout_delay: self.playout.delay(),
            playout: self.playout.counts(),
            sent: self.sent,
            received: self.received,
            refused: self.refused,
        }
    }

    /// The age of the oldest sample in the partner's motion that the latest force used, s, before any prediction; `None` if
    /// it used none. Where samples are missing between the two that are interpolated, it is older than the played instant.
    pub fn partner_age(&self) -> Option<f64> {
        self.view.and(self.playout.oldest_played()).map(Span::seconds)
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
