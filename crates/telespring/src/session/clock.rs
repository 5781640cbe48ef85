//! The partner's clock, seen from this side: round trip, offset with bounds, drift.
//!
//! No packet tells the offset of two clocks exactly, but each bounds it, because no packet arrives before it was sent.
//! A packet that arrives at local time t₄ with the partner's stamp t₃ says that the partner's clock reads at least t₃
//! now: offset ≥ t₃ − t₄. A stamp t₁ of our own that the partner received at its time t₂ says: offset ≤ t₂ − t₁ at t₁.
//! The interval between the best of both is at most as long as the smallest round trip: the middle is off by no more
//! than half of it, however unequal the two ways are (as in the Network Time Protocol, RFC 5905). As clocks drift, both
//! bounds loosen with time by the largest drift that is allowed for.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::time::{LocalTime, PeerTime, Span};
use super::wire::Packet;
use crate::error::{InvalidInput, Result};

/// The share of the time by which the offset in use may change: it follows a better estimate without a jump.
const SLEW: f64 = 0.01;
/// The largest drift within one round trip of clocks that are kept together by other means.
const SHARED_DRIFT: f64 = 1e-3;
/// The number of earlier estimates from which the drift is computed.
const SNAPSHOTS: usize = 8;

/// How the clocks of the two sides compare.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClockSettings {
    /// Both sides read one clock, or clocks kept together by other means, as in the virtual laboratory.
    Shared {
        /// The largest difference of the two clocks.
        error: Span,
    },
    /// The offset is estimated from the packets.
    Estimated {
        /// The largest drift between the clocks, s/s; ordinary quartz clocks stay below 2·10⁻⁴.
        max_drift: f64,
        /// The time over which the drift is measured.
        window: Span,
    },
}

impl Default for ClockSettings {
    /// One clock, as in the virtual laboratory.
    fn default() -> Self {
        Self::Shared { error: Span(0) }
    }
}

impl ClockSettings {
    /// Estimated clocks with the drift of ordinary quartz clocks, measured over 80 s.
    pub fn estimated() -> Self {
        Self::Estimated { max_drift: 2e-4, window: Span(80_000_000_000) }
    }

    /// Checks the values.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field.
    pub fn check(&self) -> Result<()> {
        match *self {
            Self::Shared { error } if error < Span(0) => Err(InvalidInput::new(
                "clock.error",
                format!("{} s", error.seconds()),
                "the largest difference of the clocks is 0 or more",
                "Give its magnitude.",
            )),
            Self::Estimated { max_drift, .. } if !(0.0..=0.1).contains(&max_drift) => Err(InvalidInput::new(
                "clock.max_drift",
                max_drift,
                "the drift is a share from 0 to 0.1",
                "Give 2e-4 for ordinary quartz clocks.",
            )),
            Self::Estimated { window, .. } if window < Span(1_000_000) => Err(InvalidInput::new(
                "clock.window",
                format!("{} s", window.seconds()),
                "the drift is measured over at least 0.001 s",
                "Give 80 s.",
            )),
            _ => Ok(()),
        }
    }
}

/// The drift of the partner's clock against this one over the last window, s/s; positive if it runs faster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// The best guess, if the two ways did not change.
    pub estimate: f64,
    /// The mean drift over the window is at least this …
    pub lower: f64,
    /// … and at most this.
    pub upper: f64,
}

/// What is known of the partner's clock.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ClockReport {
    /// The latest round trip, without the time that the partner held the stamp.
    pub round_trip: Option<Span>,
    /// The smallest one since the partner started.
    pub minimum_round_trip: Option<Span>,
    /// The partner's clock minus this one, as in use.
    pub offset: Option<Span>,
    /// The true offset differs by no more than this.
    pub offset_error: Option<Span>,
    /// The drift, from the second estimate on.
    pub drift: Option<Drift>,
    /// How often the packets contradicted each other, for instance because a clock was set: the estimate began anew.
    pub steps: u64,
    /// Echoes that cannot be: of a stamp not sent yet, or held longer than it was away.
    pub impossible_echoes: u64,
}

/// The interval in which the offset (ns, partner minus local) lies at a point of time.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    at: LocalTime,
    lower: i64,
    upper: Option<i64>,
}

impl Bounds {
    /// The same interval later, loosened by the drift.
    fn loosened(self, now: LocalTime, max_drift: f64) -> Self {
        let allowance = drift_allowance(now - self.at, max_drift);
        Self {
            at: now,
            lower: self.lower.saturating_sub(allowance),
            upper: self.upper.map(|upper| upper.saturating_add(allowance)),
        }
    }
}

/// A closed interval at a point of time.
#[derive(Debug, Clone, Copy, Default)]
struct Snapshot {
    at: LocalTime,
    lower: i64,
    upper: i64,
}

/// The clock of the partner.
#[derive(Debug, Clone)]
pub struct Clock {
    settings: ClockSettings,
    bounds: Option<Bounds>,
    /// The offset in use and since when, ns.
    in_use: Option<(LocalTime, i64)>,
    snapshots: [Option<Snapshot>; SNAPSHOTS],
    report: ClockReport,
}

/// By how much clocks with this drift can part within `elapsed`, ns, rounded up.
fn drift_allowance(elapsed: Span, max_drift: f64) -> i64 {
    (elapsed.0.max(0) as f64 * max_drift).ceil() as i64
}

/// A reading of the partner's clock minus one of this clock, ns.
fn difference(peer: PeerTime, local: LocalTime) -> i64 {
    if peer.0 >= local.0 {
        i64::try_from(peer.0.saturating_sub(local.0)).unwrap_or(i64::MAX)
    } else {
        i64::try_from(local.0.saturating_sub(peer.0)).map_or(i64::MIN, i64::wrapping_neg)
    }
}

/// The middle of two numbers, without overflow.
fn middle(lower: i64, upper: i64) -> i64 {
    lower.midpoint(upper)
}

impl Clock {
    /// A clock of which nothing is known yet, unless it is shared.
    ///
    /// # Errors
    ///
    /// As [`ClockSettings::check`].
    pub fn new(settings: ClockSettings) -> Result<Self> {
        settings.check()?;
        let mut clock = Self {
            settings,
            bounds: None,
            in_use: None,
            snapshots: [None; SNAPSHOTS],
            report: ClockReport::default(),
        };
        clock.forget();
        Ok(clock)
    }

    /// Forgets all estimates, after the partner has restarted; the counts stay.
    pub fn forget(&mut self) {
        let ClockReport { steps, impossible_echoes, .. } = self.report;
        self.report = ClockReport { steps, impossible_echoes, ..ClockReport::default() };
        (self.bounds, self.in_use, self.snapshots) = (None, None, [None; SNAPSHOTS]);
        if let ClockSettings::Shared { .. } = self.settings {
            self.in_use = Some((LocalTime(0), 0));
        }
    }

    /// The largest drift that is allowed for, s/s.
    fn max_drift(&self) -> f64 {
        match self.settings {
            ClockSettings::Shared { .. } => SHARED_DRIFT,
            ClockSettings::Estimated { max_drift, .. } => max_drift,
        }
    }

    /// Takes the stamps of a packet that arrived at `now`; `now` must not decrease from call to call.
    pub fn handle_packet(&mut self, now: LocalTime, packet: &Packet) {
        let received = packet.echo.and_then(|echo| {
            let away = (now >= echo.stamp).then(|| now - echo.stamp);
            let received = packet.sent.checked_sub(echo.held);
            // the partner's clock may have measured the held time a little long
            let slack = Span(drift_allowance(echo.held, self.max_drift()).saturating_add(1));
            match (away, received) {
                (Some(away), Some(received)) if away + slack >= echo.held => {
                    let round_trip = (away - echo.held).max(Span(0));
                    let smallest = self.report.minimum_round_trip.unwrap_or(round_trip);
                    self.report.round_trip = Some(round_trip);
                    self.report.minimum_round_trip = Some(smallest.min(round_trip));
                    Some((echo.stamp, received))
                }
                _ => {
                    self.report.impossible_echoes = self.report.impossible_echoes.saturating_add(1);
                    None
                }
            }
        });
        let ClockSettings::Estimated { max_drift, window } = self.settings else { return };
        let lower = difference(packet.sent, now);
        let upper = received.map(|(stamp, received)| {
            difference(received, stamp).saturating_add(drift_allowance(now - stamp, max_drift))
        });
        let fresh = Bounds { at: now, lower, upper };
        let tightened = self.bounds.map_or(fresh, |before| {
            let before = before.loosened(now, max_drift);
            let upper = match (before.upper, upper) {
                (Some(one), Some(other)) => Some(one.min(other)),
                (one, other) => one.or(other),
            };
            Bounds { at: now, lower: before.lower.max(lower), upper }
        });
        let contradictory = tightened.upper.is_some_and(|upper| upper < tightened.lower);
        if contradictory {
            self.forget();
            self.report.steps = self.report.steps.saturating_add(1);
        }
        let bounds = if contradictory { fresh } else { tightened };
        self.bounds = Some(bounds);
        if let Some(upper) = bounds.upper.filter(|upper| *upper >= bounds.lower) {
            self.measure_drift(Snapshot { at: now, lower: bounds.lower, upper }, window, max_drift);
        }
        self.advance(now);
    }

    /// Compares the interval with the one of a window ago.
    fn measure_drift(&mut self, now: Snapshot, window: Span, max_drift: f64) {
        let [newest, ..] = &self.snapshots;
        let interval = Span(window.0 / SNAPSHOTS as i64);
        if newest.is_some_and(|newest| now.at - newest.at < interval) {
            return;
        }
        if let Some(oldest) = self.snapshots.iter().rev().flatten().next() {
            let elapsed = (now.at - oldest.at).0.max(1) as f64;
            let per_time = |later: i64, earlier: i64| {
                ((later as f64 - earlier as f64) / elapsed).clamp(-max_drift, max_drift)
            };
            let (lower, upper) = (per_time(now.lower, oldest.upper), per_time(now.upper, oldest.lower));
            let estimate = per_time(middle(now.lower, now.upper), middle(oldest.lower, oldest.upper));
            self.report.drift = Some(Drift { estimate, lower, upper });
        }
        self.snapshots.rotate_right(1);
        if let Some(place) = self.snapshots.first_mut() {
            *place = Some(now);
        }
    }

    /// Lets the offset in use follow the middle of its interval.
    pub fn advance(&mut self, now: LocalTime) {
        let Some(Bounds { lower, upper: Some(upper), .. }) = self.bounds else { return };
        let wanted = middle(lower, upper);
        let offset = match self.in_use {
            None => wanted,
            Some((since, offset)) => {
                let step = (now - since).scaled(SLEW).0.max(0);
                wanted.clamp(offset.saturating_sub(step), offset.saturating_add(step))
            }
        };
        self.in_use = Some((now, offset));
    }

    /// Uses the middle of the interval at once: while no force acts, a jump does no harm.
    pub fn settle(&mut self, now: LocalTime) {
        if let ClockSettings::Estimated { .. } = self.settings {
            self.in_use = None;
            self.advance(now);
        }
    }

    /// The partner's clock minus this one, as in use; `None` before an echo has come.
    pub fn offset(&self) -> Option<Span> {
        self.in_use.map(|(_, offset)| Span(offset))
    }

    /// The true offset at `now` differs from [`Clock::offset`] by no more than this.
    pub fn offset_error(&self, now: LocalTime) -> Option<Span> {
        let (_, offset) = self.in_use?;
        match self.settings {
            ClockSettings::Shared { error } => Some(error),
            ClockSettings::Estimated { max_drift, .. } => {
                let Bounds { lower, upper, .. } = self.bounds?.loosened(now, max_drift);
                let (below, above) = (Span(offset) - Span(lower), Span(upper?) - Span(offset));
                Some(below.max(above))
            }
        }
    }

    /// What the partner's clock reads when this one reads `time`.
    pub fn to_peer(&self, time: LocalTime) -> Option<PeerTime> {
        self.offset().map(|offset| PeerTime(time.0) + offset)
    }

    /// What this clock reads when the partner's reads `time`.
    pub fn to_local(&self, time: PeerTime) -> Option<LocalTime> {
        self.offset().map(|offset| LocalTime(time.0) - offset)
    }

    /// By how much a stamp that arrives at `now` lies in the future of a shared clock, if it does.
    pub fn ahead(&self, now: LocalTime, sent: PeerTime) -> Option<Span> {
        let ClockSettings::Shared { error } = self.settings else { return None };
        Some(sent - (PeerTime(now.0) + error)).filter(|ahead| *ahead > Span(0))
    }

    /// How often the estimate began anew because the stamps contradicted it.
    pub fn steps(&self) -> u64 {
        self.report.steps
    }

    /// What is known at `now`.
    pub fn report(&self, now: LocalTime) -> ClockReport {
        ClockReport { offset: self.offset(), offset_error: self.offset_error(now), ..self.report }
    }
}
