//! The status of a site: where the session is, and what happened in the last second.

use std::collections::VecDeque;

use serde::Serialize;
use telespring::session::{LocalTime, Span};

use crate::site::{Moment, Phase};
use crate::summary::watchdog_words;

/// From one status to the next.
pub const INTERVAL: Span = Span(100_000_000);
/// The time that shares and lateness are over.
const WINDOW: Span = Span(1_000_000_000);
/// The most ticks in the window: a loop with a shorter period than 50 µs has a shorter window.
const MOST_TICKS: usize = 20_000;

/// The status of a site. Times in s, forces in N, energies in J, distances in m; `null` is not known.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Status {
    /// The robot of the study, 1 or 2.
    pub side: u8,
    /// Since the first tick.
    pub time: f64,
    /// The state of the session.
    pub phase: &'static str,
    /// The state of the watchdog, and why.
    pub watchdog: &'static str,
    /// See `watchdog`.
    pub watchdog_cause: Option<&'static str>,
    /// The latest round trip.
    pub round_trip: Option<f64>,
    /// The age of the partner's motion in use.
    pub age: Option<f64>,
    /// The share of the partner's packets that were lost.
    pub loss: Option<f64>,
    /// How late ticks began.
    pub lateness: LatenessNow,
    /// Ticks left out.
    pub overruns: u64,
    /// Where the time goes.
    pub latency: LatencyNow,
    /// The size of the force now.
    pub force: f64,
    /// The stiffness of the study's spring, N/m.
    pub stiffness: f64,
    /// The stiffness that acts now, N/m: 0 without a force, less than the study's while the force ramps.
    pub stiffness_in_use: f64,
    /// The share of the ticks at which the strategy changed the force of the spring.
    pub limited_share: Option<f64>,
    /// What changed the force since the status before.
    pub limits: Vec<&'static str>,
    /// The energy in the account.
    pub balance: Option<f64>,
    /// The mean distance to the target so far.
    pub te: Option<f64>,
    /// How far the handles are apart while they are aligned.
    pub offset: Option<f64>,
    /// Whether the person here consents, and the one there.
    pub consents: [bool; 2],
    /// Whether this site wants a pause, and the partner.
    pub pauses: [bool; 2],
}

/// See [`Status::lateness`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LatenessNow {
    /// Half of the ticks began no later.
    pub median: f64,
    /// 99 of 100.
    pub quantile_99: f64,
    /// The latest.
    pub largest: f64,
}

/// See [`Status::latency`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LatencyNow {
    /// From the measurement by the device to the tick, beyond the shortest of the session.
    pub device: Option<f64>,
    /// From the time at which the tick was due to its command.
    #[serde(rename = "loop")]
    pub control: f64,
    /// From the partner's measurement to the arrival of its packet.
    pub network: Option<f64>,
    /// What the age of the motion in use has beyond that.
    pub playout: Option<f64>,
}

/// A tick of the window.
#[derive(Debug, Clone, Copy)]
struct Tick {
    time: LocalTime,
    lateness: Span,
    /// Counts so far.
    overruns: u64,
    received: u64,
    lost: u64,
    strategy_ticks: u64,
    limited_ticks: u64,
    held_ticks: u64,
}

/// Makes the status of a site from its ticks.
#[derive(Debug)]
pub struct Gauge {
    side: u8,
    first: Option<LocalTime>,
    /// When the next status is due.
    due: LocalTime,
    window: VecDeque<Tick>,
    /// The latest tick of the status before.
    told: Option<Tick>,
    /// Whether the force was cut since the status before.
    is_cut: bool,
    /// Whether it was softened.
    is_softened: bool,
    /// Sum of the distances to the target, m, and their number.
    distance: (f64, u64),
}

impl Gauge {
    /// A gauge for side 1 or 2.
    pub fn new(side: u8) -> Self {
        Self {
            side,
            first: None,
            due: LocalTime(0),
            window: VecDeque::new(),
            told: None,
            is_cut: false,
            is_softened: false,
            distance: (0.0, 0),
        }
    }

    /// The first tick.
    pub fn first(&self) -> Option<LocalTime> {
        self.first
    }

    /// Takes a tick that began `lateness` after it was due, after `overruns` ticks that were left out; a status if one is
    /// due.
    pub fn take(&mut self, moment: &Moment, lateness: Span, overruns: u64) -> Option<Status> {
        let now = moment.time;
        self.first.get_or_insert(now);
        let tick = Tick::new(moment, lateness, overruns);
        while self.window.front().is_some_and(|oldest| now - oldest.time > WINDOW)
            || self.window.len() >= MOST_TICKS
        {
            self.window.pop_front();
        }
        self.window.push_back(tick);
        self.is_cut |= moment.is_cut;
        self.is_softened |= moment.phase == Phase::Running && moment.share < 1.0;
        if let Some(distance) = moment.distance() {
            self.distance = (self.distance.0 + distance, self.distance.1 + 1);
        }
        if now < self.due {
            return None;
        }
        self.due = now + INTERVAL;
        let status = self.status(moment, lateness);
        (self.told, self.is_cut, self.is_softened) = (Some(tick), false, false);
        Some(status)
    }

    fn status(&self, moment: &Moment, lateness: Span) -> Status {
        let (watchdog, watchdog_cause) = watchdog_words(moment.state);
        let [x, y] = moment.force;
        let (sum, count) = self.distance;
        let latency = moment.latency(lateness);
        let newest = self.window.back().copied();
        let over = |count: fn(&Tick) -> u64| grown(self.window.front(), newest.as_ref(), count);
        let (received, lost) = (over(|tick| tick.received), over(|tick| tick.lost));
        let (ticks, limited) = (over(|tick| tick.strategy_ticks), over(|tick| tick.limited_ticks));
        let share = |part: u64, whole: u64| (whole > 0).then(|| part as f64 / whole as f64);
        Status {
            side: self.side,
            time: self.first.map_or(0.0, |first| (moment.time - first).seconds()),
            phase: moment.phase.word(),
            watchdog,
            // while nothing is coupled the watchdog judges nothing: its cause is of an earlier time
            watchdog_cause: watchdog_cause.filter(|_| moment.phase.is_coupled()),
            round_trip: moment.round_trip.map(Span::seconds),
            age: moment.age,
            loss: share(lost, received + lost),
            lateness: self.lateness(),
            overruns: over(|tick| tick.overruns),
            latency: LatencyNow {
                device: latency.device,
                control: latency.control,
                network: latency.network,
                playout: latency.playout,
            },
            force: x.hypot(y),
            stiffness: moment.wanted_stiffness,
            stiffness_in_use: moment.stiffness_in_use(),
            limited_share: share(limited, ticks),
            limits: self.limits(newest.as_ref()),
            balance: moment.balance,
            te: (count > 0).then(|| sum / count as f64),
            offset: moment.offset.filter(|_| moment.phase == Phase::Aligning).map(|[x, y]| x.hypot(y)),
            consents: moment.consents,
            pauses: moment.pauses,
        }
    }

    /// What changed the force since the status before.
    fn limits(&self, newest: Option<&Tick>) -> Vec<&'static str> {
        let since = |count: fn(&Tick) -> u64| grown(self.told.as_ref(), newest, count) > 0;
        [
            ("strategy", since(|tick| tick.limited_ticks)),
            ("force", self.is_cut),
            ("softened", self.is_softened),
            ("held", since(|tick| tick.held_ticks)),
        ]
        .into_iter()
        .filter_map(|(word, is_so)| is_so.then_some(word))
        .collect()
    }

    fn lateness(&self) -> LatenessNow {
        let mut sorted: Vec<Span> = self.window.iter().map(|tick| tick.lateness).collect();
        sorted.sort_unstable();
        let quantile = |hundredths: usize| {
            let place = (sorted.len() * hundredths).div_ceil(100).max(1) - 1;
            sorted.get(place).map_or(0.0, |span| span.seconds())
        };
        LatenessNow { median: quantile(50), quantile_99: quantile(99), largest: quantile(100) }
    }
}

impl Tick {
    fn new(moment: &Moment, lateness: Span, overruns: u64) -> Self {
        let session = &moment.session;
        Self {
            time: moment.time,
            lateness,
            overruns,
            received: session.received,
            lost: session.playout.lost,
            strategy_ticks: session.strategy.ticks,
            limited_ticks: session.strategy.limited_ticks,
            held_ticks: session.playout.held_ticks,
        }
    }
}

/// By how much a count has grown; a loss that came after all makes it smaller.
fn grown(before: Option<&Tick>, after: Option<&Tick>, count: impl Fn(&Tick) -> u64) -> u64 {
    match (before, after) {
        (Some(before), Some(after)) => count(after).saturating_sub(count(before)),
        _ => 0,
    }
}
