//! The watchdog: whether the coupling may act, and how strongly.
//!
//! ```text
//! Disengaged ──all well for `recovery`──> RampingIn ──`ramp_in`──> Engaged <──well again── Holding
//!      ^                                      │ fault                 └─────────fault────────^ │ for `hold`
//!      └──────────`ramp_out`── RampingOut <───┴────────────────────────────────────────────────┘
//! ```
//!
//! The force is multiplied by a factor: 1 while engaged or holding, 0 while disengaged, and along the ramps in between.
//! A session begins disengaged. Once the force ramps out it goes to zero, and re-engages from zero only. The states
//! depend on the time alone, not on how often the watchdog is asked.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::time::{LocalTime, Span};
use crate::error::{InvalidInput, Result};

/// Why the coupling may not act.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Cause {
    /// The session has just begun.
    Starting,
    /// The own device reports an impossible value.
    OwnMeasurement,
    /// The own device has not reported for two sample periods.
    OwnSilence,
    /// The partner has restarted.
    PartnerRestarted,
    /// A clock was set: the stamps contradict what was known of the partner's clock.
    ClockStepped,
    /// No packet of the partner comes.
    Silence,
    /// Packets come, but none has a later stamp than the newest before.
    FrozenStamps,
    /// Stamps advance and the velocity says that the partner moves, but its position does not change by a bit.
    FrozenMotion,
}

impl Cause {
    /// The cause in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Starting => "starting",
            Self::OwnMeasurement => "own-measurement",
            Self::OwnSilence => "own-silence",
            Self::PartnerRestarted => "partner-restarted",
            Self::ClockStepped => "clock-stepped",
            Self::Silence => "silence",
            Self::FrozenStamps => "frozen-stamps",
            Self::FrozenMotion => "frozen-motion",
        }
    }
}

/// What the watchdog makes of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WatchdogState {
    /// No force acts.
    Disengaged {
        /// Why.
        cause: Cause,
    },
    /// The force grows from zero.
    RampingIn,
    /// The force acts fully.
    Engaged,
    /// The force acts fully although something is wrong, in the hope that it passes.
    Holding {
        /// What is wrong.
        cause: Cause,
    },
    /// The force falls to zero.
    RampingOut {
        /// Why.
        cause: Cause,
    },
}

/// The times of the watchdog.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WatchdogSettings {
    /// Without a packet for this time the partner counts as silent.
    pub silence: Span,
    /// Without a later stamp for this time, or with a frozen motion for this time, the partner counts as frozen.
    pub frozen: Span,
    /// A position that stays the same is frozen once the velocities sent with it add up to this distance, m; above the
    /// step of the partner's encoder.
    pub frozen_distance: f64,
    /// How long the coupling goes on while the partner is silent or frozen.
    pub hold: Span,
    /// Without an own measurement for this time the own device counts as silent; two sample periods at the least, and by
    /// default.
    pub own_silence: Span,
    /// How long the own force is held while the own device does not report.
    pub own_hold: Span,
    /// From full to zero force.
    pub ramp_out: Span,
    /// From zero to full force.
    pub ramp_in: Span,
    /// How long all must be well before the force ramps in.
    pub recovery: Span,
}

impl Default for WatchdogSettings {
    /// Silent after 20 ms, frozen after 100 ms (1 cm), held for 100 ms (an own fault: 5 ms), out in 200 ms, in within
    /// 500 ms after 200 ms without fault.
    fn default() -> Self {
        let milliseconds = |number: i64| Span(number * 1_000_000);
        Self {
            silence: milliseconds(20),
            frozen: milliseconds(100),
            frozen_distance: 0.01,
            hold: milliseconds(100),
            own_silence: Span(0),
            own_hold: milliseconds(5),
            ramp_out: milliseconds(200),
            ramp_in: milliseconds(500),
            recovery: milliseconds(200),
        }
    }
}

impl WatchdogSettings {
    /// The usual times for controllers of this sample period: the default, but the partner counts as silent or frozen after
    /// three periods at the earliest, so that a lost packet and a late one after it are no fault.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::session::{Span, WatchdogSettings};
    /// assert_eq!(WatchdogSettings::for_period(Span(1_000_000)), WatchdogSettings::default());
    /// let slow = WatchdogSettings::for_period(Span::from_seconds(1.0 / 30.0));
    /// assert_eq!(slow.silence, Span(3 * 33_333_333));
    /// ```
    pub fn for_period(sample_period: Span) -> Self {
        let (usual, least) = (Self::default(), sample_period + sample_period + sample_period);
        Self { silence: usual.silence.max(least), frozen: usual.frozen.max(least), ..usual }
    }

    /// The watchdog that lets the force be zero `silence` after the partner's last packet, counted to the tick that is due by
    /// then: 2 parts without a reaction, 5 of holding on, 8 of ramp. While the own device or the loop stands still, the force
    /// stays for `stall`, then it ramps out.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the silence is too short for this sample period.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::session::{Span, WatchdogSettings};
    /// let [silence, stall, period] = [0.152, 0.02, 0.001].map(Span::from_seconds);
    /// let watchdog = WatchdogSettings::within(silence, stall, period)?;
    /// let parts = [watchdog.silence, watchdog.hold, watchdog.ramp_out];
    /// assert_eq!(parts, [0.02, 0.05, 0.08].map(Span::from_seconds));
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn within(silence: Span, stall: Span, sample_period: Span) -> Result<Self> {
        let whole = silence - sample_period - sample_period;
        let unheeded = whole.scaled(2.0 / 15.0);
        if unheeded < sample_period + sample_period {
            return Err(InvalidInput::new(
                "silence",
                format!("{} s", silence.seconds()),
                format!("at least 17 sample periods of {} s", sample_period.seconds()),
                "Lengthen it, or shorten the sample period.",
            ));
        }
        let (hold, usual) = (whole.scaled(5.0 / 15.0), Self::for_period(sample_period));
        Ok(Self {
            silence: unheeded,
            hold,
            ramp_out: whole - unheeded - hold,
            own_silence: stall - usual.own_hold,
            ..usual
        })
    }

    /// Checks the values.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field.
    pub fn check(&self) -> Result<()> {
        let Self {
            silence,
            frozen,
            frozen_distance,
            hold,
            own_silence,
            own_hold,
            ramp_out,
            ramp_in,
            recovery,
        } = *self;
        for (field, span) in [
            ("silence", silence),
            ("frozen", frozen),
            ("hold", hold),
            ("own_hold", own_hold),
            ("ramp_out", ramp_out),
            ("ramp_in", ramp_in),
            ("recovery", recovery),
        ] {
            if span < Span(1) {
                return Err(InvalidInput::new(
                    format!("watchdog.{field}"),
                    format!("{} s", span.seconds()),
                    "the times of the watchdog are above 0",
                    "Shorten it, but do not leave it out.",
                ));
            }
        }
        if own_silence < Span(0) {
            return Err(InvalidInput::new(
                "watchdog.own_silence",
                format!("{} s", own_silence.seconds()),
                "a time that is not negative",
                "Give 0 for two sample periods.",
            ));
        }
        if !(frozen_distance > 0.0 && frozen_distance.is_finite()) {
            return Err(InvalidInput::new(
                "watchdog.frozen_distance",
                format!("{frozen_distance} m"),
                "a distance above 0",
                "Give a few steps of the partner's encoder.",
            ));
        }
        Ok(())
    }
}

/// Something that is wrong, and since when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fault {
    pub(super) cause: Cause,
    pub(super) since: LocalTime,
}

/// What is wrong with this side and with the partner.
pub(super) type Faults = [Option<Fault>; 2];

/// The state of the coupling.
#[derive(Debug, Clone)]
pub(super) struct Watchdog {
    settings: WatchdogSettings,
    state: WatchdogState,
    since: LocalTime,
    /// The factor at which the ramp began.
    from: f64,
    well_since: Option<LocalTime>,
}

impl Watchdog {
    pub(super) fn new(settings: WatchdogSettings) -> Self {
        let state = WatchdogState::Disengaged { cause: Cause::Starting };
        Self { settings, state, since: LocalTime(0), from: 0.0, well_since: None }
    }

    pub(super) fn state(&self) -> WatchdogState {
        self.state
    }

    /// The next change of state at `now`, or before it, because of these faults; `ready`: there is a motion to follow.
    pub(super) fn step(&mut self, now: LocalTime, faults: Faults, ready: bool) -> Option<WatchdogState> {
        use WatchdogState::{Disengaged, Engaged, Holding, RampingIn, RampingOut};
        let first = faults.into_iter().flatten().min_by_key(|fault| fault.since);
        let (state, since) = match (self.state, first) {
            (RampingIn, Some(Fault { cause, since })) => (RampingOut { cause }, since.max(self.since)),
            (Engaged, Some(Fault { cause, since })) => (Holding { cause }, since.max(self.since)),
            (Holding { .. }, None) => (Engaged, now),
            (Holding { .. }, Some(_)) => {
                let (cause, end) = self.end_of_hold(faults)?;
                if now < end {
                    return None;
                }
                (RampingOut { cause }, end.max(self.since))
            }
            (RampingOut { cause }, _) => {
                let end = self.since + self.settings.ramp_out.scaled(self.from);
                if now < end {
                    return None;
                }
                (Disengaged { cause }, end)
            }
            (RampingIn, None) => {
                let end = self.since + self.settings.ramp_in;
                if now < end {
                    return None;
                }
                (Engaged, end)
            }
            (Disengaged { .. }, None) if ready => {
                let well_since = *self.well_since.get_or_insert(now);
                if now - well_since < self.settings.recovery {
                    return None;
                }
                (RampingIn, now)
            }
            (Disengaged { .. }, _) => {
                self.well_since = None;
                return None;
            }
            (Engaged, None) => return None,
        };
        self.enter(state, since);
        Some(state)
    }

    /// The partner begins anew: the force ramps out at once. Returns the state if it changes.
    pub(super) fn let_go(&mut self, now: LocalTime, cause: Cause) -> Option<WatchdogState> {
        self.well_since = None;
        if matches!(self.state, WatchdogState::Disengaged { .. } | WatchdogState::RampingOut { .. }) {
            return None;
        }
        let state = WatchdogState::RampingOut { cause };
        self.enter(state, now);
        Some(state)
    }

    fn enter(&mut self, state: WatchdogState, since: LocalTime) {
        self.from = self.factor(since);
        (self.state, self.since, self.well_since) = (state, since, None);
    }

    /// The first fault that has lasted, or will have lasted, for as long as the force is held, and when.
    fn end_of_hold(&self, faults: Faults) -> Option<(Cause, LocalTime)> {
        let ends =
            faults.into_iter().flatten().map(|fault| (fault.cause, fault.since + self.hold(fault.cause)));
        ends.min_by_key(|(_, end)| *end)
    }

    fn hold(&self, cause: Cause) -> Span {
        match cause {
            Cause::OwnMeasurement | Cause::OwnSilence => self.settings.own_hold,
            _ => self.settings.hold,
        }
    }

    /// The factor on the force, 0 to 1.
    pub(super) fn factor(&self, now: LocalTime) -> f64 {
        let share = |whole: Span| ((now - self.since).0.max(0) as f64 / whole.0.max(1) as f64).min(1.0);
        match self.state {
            WatchdogState::Disengaged { .. } => 0.0,
            WatchdogState::Engaged | WatchdogState::Holding { .. } => 1.0,
            WatchdogState::RampingIn => share(self.settings.ramp_in),
            WatchdogState::RampingOut { .. } => (self.from - share(self.settings.ramp_out)).max(0.0),
        }
    }

    /// The next time at which the state changes if these faults last and no other comes.
    pub(super) fn next_timeout(&self, faults: Faults) -> Option<LocalTime> {
        match self.state {
            WatchdogState::Disengaged { .. } => self.well_since.map(|since| since + self.settings.recovery),
            WatchdogState::RampingIn => Some(self.since + self.settings.ramp_in),
            WatchdogState::Engaged => None,
            WatchdogState::Holding { .. } => self.end_of_hold(faults).map(|(_, end)| end),
            WatchdogState::RampingOut { .. } => Some(self.since + self.settings.ramp_out.scaled(self.from)),
        }
    }
}
