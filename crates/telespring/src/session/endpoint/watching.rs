//! The time in an endpoint, and what its watchdog sees.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::Endpoint;
use crate::session::event::{Event, EventKind};
use crate::session::watchdog::{Cause, Fault, Faults, Watchdog, WatchdogState};
use crate::session::{LocalTime, Span};

impl Endpoint {
    /// Begins a call at `now`: time does not go back, and the watchdog judges what was before.
    pub(super) fn begin(&mut self, now: LocalTime) -> LocalTime {
        if now > self.now {
            self.now = now;
            self.clock.advance(now);
            self.watch(now);
        }
        self.now
    }

    /// What is wrong at `now`.
    fn faults(&self, now: LocalTime) -> Faults {
        let impossible = self.impossible_since.map(|since| Fault { cause: Cause::OwnMeasurement, since });
        let silent = self.own_silence().filter(|silent| now > *silent);
        let silent = silent.map(|since| Fault { cause: Cause::OwnSilence, since });
        [impossible.or(silent), self.partner.fault(now)]
    }

    /// After this time the own device is silent.
    fn own_silence(&self) -> Option<LocalTime> {
        let least = self.sample_period + self.sample_period;
        self.own.map(|own| own.at + self.own_silence.max(least))
    }

    /// Lets the watchdog judge at `now`.
    pub(super) fn watch(&mut self, now: LocalTime) {
        // at most every state once
        for _ in 0..5 {
            let (faults, ready) = (self.faults(now), self.ready);
            let Some(state) = self.watchdog.as_mut().and_then(|watchdog| watchdog.step(now, faults, ready))
            else {
                return;
            };
            self.enter(now, state);
        }
    }

    /// Notes a new state of the watchdog.
    pub(super) fn enter(&mut self, now: LocalTime, state: WatchdogState) {
        let kind = match state {
            WatchdogState::Holding { cause } => EventKind::Holding(cause),
            WatchdogState::RampingOut { cause } => EventKind::RampingOut(cause),
            WatchdogState::Disengaged { cause } => EventKind::Disengaged(cause),
            WatchdogState::RampingIn => {
                self.clock.settle(now);
                if let Some(peer) = self.clock.to_peer(now) {
                    self.playout.settle(peer);
                }
                EventKind::RampingIn
            }
            WatchdogState::Engaged => {
                self.restarted = false;
                EventKind::Engaged
            }
        };
        self.events.push(now, kind);
    }

    pub(super) fn note_impossible(&mut self, now: LocalTime, value: f64) {
        self.impossible_values = self.impossible_values.saturating_add(1);
        self.events.push(now, EventKind::ImpossibleValue { value });
    }

    /// The watchdog's factor on the force.
    pub(super) fn factor(&self, now: LocalTime) -> f64 {
        self.watchdog.as_ref().map_or(1.0, |watchdog| watchdog.factor(now))
    }

    /// The state of the watchdog; engaged without one.
    pub fn state(&self) -> WatchdogState {
        self.watchdog.as_ref().map_or(WatchdogState::Engaged, Watchdog::state)
    }

    /// The oldest event not fetched yet.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.poll()
    }

    /// The next time at which the state changes if nothing else comes; `None` without a watchdog or partner.
    pub fn next_timeout(&self) -> Option<LocalTime> {
        let watchdog = self.watchdog.as_ref()?;
        let state = watchdog.state();
        let acting = !matches!(state, WatchdogState::Disengaged { .. } | WatchdogState::RampingOut { .. });
        let own = [self.own_silence().map(|silence| silence + Span(1))];
        let faults = own.into_iter().chain(self.partner.timeouts()).flatten();
        let coming = faults.filter(|time| acting && *time > self.now);
        coming.chain(watchdog.next_timeout(self.faults(self.now))).min()
    }

    /// Does what is due at `now`.
    pub fn handle_timeout(&mut self, now: LocalTime) {
        self.begin(now);
    }
}
