//! The replay of one site.

use super::recorded::{RecordedSite, RecordedTick};
use crate::error::{InvalidInput, Result};
use crate::rig::network::Datagram;
use crate::session::gate::{ForceGate, ForceLimits, Passed};
use crate::session::{Endpoint, EndpointSettings, Event, LocalTime, SessionReport, WatchdogState};

/// The most events that a replay keeps; the rest is counted.
const MOST_EVENTS: usize = 65_536;

/// Which force an endpoint is told to have acted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Acted {
    /// The recorded one: for the session's own settings.
    Recorded,
    /// The replayed one, as the site would have let it through: for other settings. What a device made of it beyond that, such
    /// as a lag, is not known.
    Replayed,
}

/// What the replay of a site is made of.
#[derive(Debug, Clone)]
pub struct ReplaySettings {
    /// The endpoint, with the session id that it had.
    pub endpoint: EndpointSettings,
    /// Which force it is told to have acted.
    pub acted: Acted,
    /// The largest force that the site lets through, and its steepest growth.
    pub limits: ForceLimits,
}

/// One tick of a replayed site. It has no force, age or limit where the endpoint was not asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplayedTick {
    /// The force of the endpoint, N; zero where it was not asked.
    pub wanted: [f64; 2],
    /// The force that the site lets through, N.
    pub force: [f64; 2],
    /// The age of the oldest sample of the partner in use, s.
    pub age: Option<f64>,
    /// The energy in the account, J; `None` if the strategy keeps none.
    pub balance: Option<f64>,
    /// The energy given out to the own handle since the start, J.
    pub given_out: f64,
    /// Whether the strategy changed the force of the spring.
    pub is_limited: bool,
    /// The state of the watchdog.
    pub state: WatchdogState,
}

/// A replayed site.
#[derive(Debug, Clone)]
pub struct ReplayedSite {
    /// Every tick of the recording.
    pub ticks: Vec<ReplayedTick>,
    /// What the endpoint did in all.
    pub report: SessionReport,
    /// What happened, oldest first.
    pub events: Vec<Event>,
    /// Events for which there was no room.
    pub missed_events: u64,
    /// Arrivals whose content comes from the replayed partner; the others are as recorded.
    pub renewed: usize,
}

/// Replays one site; its partner's packets have the content that they had.
///
/// # Errors
///
/// [`InvalidInput`] for a setting out of range.
pub fn replay_site(settings: ReplaySettings, recording: &RecordedSite) -> Result<ReplayedSite> {
    let mut site = RunningReplay::new(settings, recording)?;
    while let Some(arrival) = site.next_arrival() {
        site.take(&arrival);
    }
    Ok(site.finish())
}

/// A site in the course of its replay.
pub(super) struct RunningReplay<'a> {
    recording: &'a RecordedSite,
    endpoint: Endpoint,
    is_watched: bool,
    acted: Acted,
    gate: ForceGate,
    /// The tick that is under way, whether it has been measured, and the next arrival.
    tick: usize,
    is_measured: bool,
    arrival: usize,
    limited_ticks: u64,
    outcome: Vec<ReplayedTick>,
    events: Vec<Event>,
    missed_events: u64,
    pub(super) renewed: usize,
    /// The packets that the endpoint has sent, oldest first, with their stamps, where somebody wants them.
    pub(super) sent: Option<Vec<(LocalTime, Datagram)>>,
}

impl<'a> RunningReplay<'a> {
    pub(super) fn new(settings: ReplaySettings, recording: &'a RecordedSite) -> Result<Self> {
        let ReplaySettings { endpoint, acted, limits } = settings;
        let remedy = "Give the limit of the site, or infinity for none.";
        if !(limits.largest > 0.0) {
            return Err(InvalidInput::new("largest_force", limits.largest, "a force above 0 N", remedy));
        }
        if !(limits.rise > 0.0) {
            return Err(InvalidInput::new("steepest_rise", limits.rise, "a growth above 0 N/s", remedy));
        }
        Ok(Self {
            recording,
            gate: ForceGate::new(limits, endpoint.sample_period, endpoint.computing_tick),
            is_watched: endpoint.watchdog.is_some(),
            endpoint: Endpoint::new(endpoint)?,
            acted,
            tick: 0,
            is_measured: false,
            arrival: 0,
            limited_ticks: 0,
            outcome: Vec::with_capacity(recording.ticks().len()),
            events: Vec::new(),
            missed_events: 0,
            renewed: 0,
            sent: None,
        })
    }

    /// Goes on to the next datagram that arrives, and returns it; `None` at the end of the recording.
    pub(super) fn next_arrival(&mut self) -> Option<super::RecordedArrival> {
        while let Some(tick) = self.recording.ticks().get(self.tick) {
            if !self.is_measured {
                self.measure(tick);
                self.is_measured = true;
            }
            let arrival = self.recording.arrivals().get(self.arrival);
            if let Some(arrival) = arrival.filter(|arrival| arrival.tick == self.tick) {
                return Some(*arrival);
            }
            self.answer(tick);
            self.tick += 1;
            self.is_measured = false;
        }
        None
    }

    /// When the tick under way began; `None` at the end.
    pub(super) fn now(&self) -> Option<LocalTime> {
        self.recording.ticks().get(self.tick).map(|tick| tick.time)
    }

    /// How far the replay has come: the tick, whether it has been measured, the arrival.
    pub(super) fn place(&self) -> (usize, bool, usize) {
        (self.tick, self.is_measured, self.arrival)
    }

    /// Whether all that is sent at this stamp has been sent.
    pub(super) fn is_past(&self, stamp: LocalTime) -> bool {
        self.now().is_none_or(|now| now > stamp || (now == stamp && self.is_measured))
    }

    /// Takes the datagram that [`RunningReplay::next_arrival`] returned, or what replaces it.
    pub(super) fn take(&mut self, arrival: &super::RecordedArrival) {
        // What is refused is an event, as it was then.
        let _ = self.endpoint.handle_datagram(arrival.time, &arrival.datagram);
        self.arrival += 1;
    }

    /// What the site does at the beginning of a tick.
    fn measure(&mut self, tick: &RecordedTick) {
        let Some(motion) = tick.motion else {
            let is_resting = matches!(self.endpoint.state(), WatchdogState::Disengaged { .. });
            if tick.answered.is_none() && self.is_watched && !is_resting {
                // a site that is not coupled lets the watchdog of its endpoint go on until it rests
                self.endpoint.handle_timeout(tick.time);
            }
            return;
        };
        if motion.impossible_value().is_none() {
            self.gate.release(tick.time);
        }
        let acted = match self.acted {
            Acted::Recorded => tick.acted,
            Acted::Replayed => {
                let Passed { force, is_wanted } = self.gate.commanded();
                (!is_wanted).then_some(force)
            }
        };
        if let Some(acted) = acted {
            self.endpoint.handle_acted(acted);
        }
        // An impossible motion is an event, as it was then.
        let _ = self.endpoint.handle_measurement(tick.time, motion);
        if let Some(target) = tick.target {
            self.endpoint.handle_target(tick.time, target);
        }
        if let (Some(packet), Some(sent)) = (self.endpoint.poll_transmit(tick.time), &mut self.sent) {
            sent.push((tick.time, packet));
        }
    }

    /// What the site does at the end of a tick.
    fn answer(&mut self, tick: &RecordedTick) {
        let wanted = tick.answered.map(|time| (time, self.endpoint.force(time)));
        let force = match wanted {
            Some((time, wanted)) => self.gate.pass(time, wanted, tick.share),
            None => {
                self.gate.close(tick.time);
                [0.0; 2]
            }
        };
        let wanted = wanted.map(|(_, wanted)| wanted);
        let report = self.endpoint.strategy_report();
        self.outcome.push(ReplayedTick {
            wanted: wanted.unwrap_or_default(),
            force,
            age: wanted.and_then(|_| self.endpoint.partner_age()),
            balance: report.balance,
            given_out: report.given_out,
            is_limited: report.limited_ticks > self.limited_ticks,
            state: self.endpoint.state(),
        });
        self.limited_ticks = report.limited_ticks;
        while let Some(event) = self.endpoint.poll_event() {
            if self.events.len() < MOST_EVENTS {
                self.events.push(event);
            } else {
                self.missed_events += 1;
            }
        }
    }

    /// The outcome, at the end of the recording.
    pub(super) fn finish(self) -> ReplayedSite {
        ReplayedSite {
            ticks: self.outcome,
            report: self.endpoint.report(),
            events: self.events,
            missed_events: self.missed_events,
            renewed: self.renewed,
        }
    }
}
