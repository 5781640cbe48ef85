//! The messages of a recording. Points of time are whole nanoseconds of this side's monotonic clock unless they say
//! otherwise; all else is in SI units. `docs/recording.md` has every field.

use foxglove::Encode;
use foxglove::bytes::Bytes;
use telespring::session::{Motion, Span};

use crate::feed::Item;
use crate::site::{self, Happened, Moment};
use crate::summary;

/// A quantity per axis.
#[derive(Debug, Clone, Copy, PartialEq, Encode)]
pub struct Pair {
    /// Of axis x.
    pub x: f64,
    /// Of axis y.
    pub y: f64,
}

impl From<[f64; 2]> for Pair {
    fn from([x, y]: [f64; 2]) -> Self {
        Self { x, y }
    }
}

/// The motion of a handle or of a target.
#[derive(Debug, Clone, Copy, PartialEq, Encode)]
pub struct HandleMotion {
    /// Position, m.
    pub position: Pair,
    /// Velocity, m/s.
    pub velocity: Pair,
}

impl From<Motion> for HandleMotion {
    fn from(motion: Motion) -> Self {
        Self { position: motion.position.into(), velocity: motion.velocity.into() }
    }
}

/// A tick of the loop.
#[derive(Debug, Clone, PartialEq, Encode)]
#[allow(missing_docs, reason = "docs/recording.md describes every field")]
pub struct Tick {
    pub tick: u64,
    pub time: u64,
    pub asked_time: Option<u64>,
    pub commanded_time: u64,
    pub lateness: f64,
    pub duration: f64,
    pub phase: &'static str,
    pub watchdog: &'static str,
    pub watchdog_cause: Option<&'static str>,
    pub watchdog_factor: f64,
    pub is_measured: bool,
    pub is_limited: bool,
    pub own: Option<HandleMotion>,
    pub device_sequence: Option<f64>,
    pub device_time: Option<f64>,
    pub target: Option<HandleMotion>,
    pub partner_played: Option<HandleMotion>,
    pub partner_predicted: Option<HandleMotion>,
    pub partner_newest: Option<HandleMotion>,
    pub partner_sequence: Option<u64>,
    pub partner_sent_time: Option<u64>,
    pub partner_arrival_time: Option<u64>,
    pub commanded_force: Pair,
    pub wanted_force: Option<Pair>,
    pub acted_force: Option<Pair>,
    pub told_force: Option<Pair>,
    pub measured_force: Option<Pair>,
    pub age: Option<f64>,
    pub played_age: Option<f64>,
    pub playout_delay: f64,
    pub round_trip: Option<f64>,
    pub smallest_round_trip: Option<f64>,
    pub clock_offset: Option<i64>,
    pub clock_offset_error: Option<i64>,
    pub energy_balance: Option<f64>,
    pub energy_given_out: f64,
    pub energy_sent: f64,
    pub energy_received: f64,
    pub partner_energy_sent: Option<f64>,
    pub stiffness_wanted: f64,
    pub stiffness: f64,
    pub partner_stiffness: Option<f64>,
    pub latency_device: Option<f64>,
    pub latency_loop: f64,
    pub latency_network: Option<f64>,
    pub latency_playout: Option<f64>,
    pub packets_sent: u64,
    pub packets_received: u64,
    pub packets_refused: u64,
    pub packets_lost: u64,
    pub packets_late: u64,
    pub held_ticks: u64,
    pub unrecorded_arrivals: u64,
    pub is_timed: bool,
    pub share: f64,
    pub handle_offset: Option<Pair>,
    pub overruns: u64,
}

impl Tick {
    /// The message of a tick.
    pub fn new(moment: &Moment, lateness: Span, duration: Span, overruns: u64) -> Self {
        let site::Latency { device, control, network, playout } = moment.latency(lateness);
        let session = &moment.session;
        let used = moment.used_partner();
        let newest = moment.newest.map(|newest| newest.packet);
        let clock = session.clock;
        let (watchdog, watchdog_cause) = summary::watchdog_words(moment.state);
        Self {
            tick: moment.tick,
            time: moment.time.0,
            asked_time: moment.asked.map(|time| time.0),
            commanded_time: moment.commanded.0,
            lateness: lateness.seconds(),
            duration: duration.seconds(),
            phase: moment.phase.word(),
            watchdog,
            watchdog_cause,
            watchdog_factor: session.enabled,
            is_measured: moment.is_measured,
            is_limited: moment.is_limited(),
            own: moment.motion.map(Into::into),
            device_sequence: moment.stamp.map(|stamp| stamp.sequence),
            device_time: moment.stamp.map(|stamp| stamp.time),
            target: moment.target.map(Into::into),
            partner_played: used.map(|used| used.played.into()),
            partner_predicted: used.map(|used| used.wanted.into()),
            partner_newest: newest.map(|packet| packet.motion.into()),
            partner_sequence: newest.map(|packet| packet.sequence),
            partner_sent_time: newest.map(|packet| packet.sent.0),
            partner_arrival_time: moment.newest.map(|newest| newest.arrival.0),
            commanded_force: moment.force.into(),
            wanted_force: moment.forces.wanted.map(Into::into),
            acted_force: moment.is_measured.then(|| session.acted.into()),
            told_force: moment.forces.told.map(Into::into),
            measured_force: moment.forces.measured.map(Into::into),
            age: moment.asked.and(moment.age),
            played_age: used.map(|used| used.age),
            playout_delay: session.playout_delay.seconds(),
            round_trip: clock.round_trip.map(Span::seconds),
            smallest_round_trip: clock.minimum_round_trip.map(Span::seconds),
            clock_offset: clock.offset.map(|span| span.0),
            clock_offset_error: clock.offset_error.map(|span| span.0),
            energy_balance: moment.balance,
            energy_given_out: session.strategy.given_out,
            energy_sent: session.strategy.energy_sent,
            energy_received: session.strategy.energy_received,
            partner_energy_sent: used.map(|used| used.energy_sent),
            stiffness_wanted: moment.wanted_stiffness,
            stiffness: moment.stiffness_in_use(),
            partner_stiffness: used.map(|used| used.stiffness),
            latency_device: device,
            latency_loop: control,
            latency_network: network,
            latency_playout: playout,
            packets_sent: session.sent,
            packets_received: session.received,
            packets_refused: session.refused,
            packets_lost: session.playout.lost,
            packets_late: session.playout.late,
            held_ticks: session.playout.held_ticks,
            unrecorded_arrivals: moment.unnoted_arrivals,
            is_timed: moment.is_timed,
            share: moment.share,
            handle_offset: moment.offset.map(Into::into),
            overruns,
        }
    }
}

/// A datagram that the endpoint was given.
#[derive(Debug, Clone, PartialEq, Encode)]
#[allow(missing_docs, reason = "docs/recording.md describes every field")]
pub struct Arrival {
    pub tick: u64,
    pub time: u64,
    pub is_taken: bool,
    pub length: u64,
    pub datagram: Bytes,
}

impl From<&site::Arrival> for Arrival {
    fn from(arrival: &site::Arrival) -> Self {
        Self {
            tick: arrival.tick,
            time: arrival.time.0,
            is_taken: arrival.is_taken,
            length: arrival.length as u64,
            datagram: Bytes::copy_from_slice(arrival.bytes()),
        }
    }
}

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Encode)]
#[allow(missing_docs, reason = "docs/recording.md describes every field")]
pub struct Event {
    pub time: u64,
    pub event: String,
    pub cause: Option<String>,
}

impl Event {
    /// The message of an event.
    pub fn new(time: u64, happened: &Happened) -> Self {
        let (event, cause) = summary::event_words(happened);
        Self { time, event: event.to_owned(), cause }
    }

    /// Items for which there was no room in the queue.
    pub fn missed(time: u64, count: u64) -> Self {
        Self { time, event: "recording-missed".to_owned(), cause: Some(count.to_string()) }
    }
}

/// The time of an item on this side's clock, ns.
pub fn time_of(item: &Item) -> u64 {
    match item {
        Item::Tick { moment, .. } => moment.time.0,
        Item::Arrival(arrival) => arrival.time.0,
        Item::Event { time, .. } => time.0,
    }
}
