//! What a tick notes beside its force: with it a recording holds all that the endpoint was told, in its order.

use telespring::session::wire::{LENGTH, Packet};
use telespring::session::{LocalTime, Span};

use super::arrivals::MOST_DATAGRAMS;
use crate::device::{Reading, Stamp};

/// Arrivals that may be noted in a row, and how many more with every tick: a flood is counted, not noted.
const MOST_NOTED: u32 = 1024;
const NOTED_PER_TICK: u32 = 4;

/// A datagram that the endpoint was given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// The tick at which it was taken up, after the measurement of that tick and before its force.
    pub tick: u64,
    /// When it was taken up.
    pub time: LocalTime,
    /// Whether the endpoint took it; it refused it otherwise.
    pub is_taken: bool,
    /// Its length, bytes.
    pub length: usize,
    /// Its first bytes: all of one that was taken.
    pub datagram: [u8; LENGTH],
}

impl Arrival {
    /// The bytes that are known.
    pub fn bytes(&self) -> &[u8] {
        self.datagram.get(..self.length).unwrap_or(&self.datagram)
    }
}

/// The partner's packet with the highest sequence number so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Newest {
    /// When it came.
    pub arrival: LocalTime,
    /// The packet.
    pub packet: Packet,
}

/// The forces of a tick, N.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Forces {
    /// The mean force on the handle since the measurement before, if the device knows it.
    pub measured: Option<[f64; 2]>,
    /// What the endpoint was told to have acted, if it did not know it.
    pub told: Option<[f64; 2]>,
    /// What the endpoint wants; `None` while it is not asked.
    pub wanted: Option<[f64; 2]>,
}

/// What the ticks note.
#[derive(Debug)]
pub(super) struct Notes {
    /// The number of this tick, from 0.
    pub(super) tick: u64,
    /// Whether the endpoint was given the motion of this tick.
    pub(super) is_measured: bool,
    /// Whether it was told the time alone.
    pub(super) is_timed: bool,
    pub(super) forces: Forces,
    /// The share of the endpoint's force that was let through.
    pub(super) share: f64,
    /// When the endpoint was asked for the force of this tick.
    pub(super) asked: Option<LocalTime>,
    pub(super) newest: Option<Newest>,
    /// The arrivals of this tick.
    arrivals: Vec<Arrival>,
    /// How many arrivals may still be noted, and how many were not.
    allowance: u32,
    pub(super) unnoted: u64,
    delays: Delays,
}

/// Over so long the shortest way from the device counts, once and a half on average: the two clocks drift apart.
const WINDOW: Span = Span(5_000_000_000);

/// The times from a measurement, by the device's clock, to its tick, s: the clocks' difference included.
#[derive(Debug, Default)]
struct Delays {
    newest: Option<Stamp>,
    /// When this window began, its least, and that of the window before.
    began: LocalTime,
    least: [Option<f64>; 2],
}

impl Delays {
    /// Takes a stamp, and returns how much longer than the shortest lately its way was, s.
    fn take(&mut self, now: LocalTime, stamp: Stamp) -> f64 {
        if self.newest.is_some_and(|newest| stamp.sequence < newest.sequence || stamp.time < newest.time) {
            // a device program that was started anew has another clock
            *self = Self::default();
        }
        self.newest = Some(stamp);
        let delay = now.seconds() - stamp.time;
        let [least, before] = self.least;
        if least.is_none() || now - self.began >= WINDOW {
            (self.began, self.least) = (now, [Some(delay), least]);
        } else {
            self.least = [least.map(|least| least.min(delay)), before];
        }
        delay - self.least.into_iter().flatten().fold(delay, f64::min)
    }
}

impl Notes {
    pub(super) fn new() -> Self {
        Self {
            tick: 0,
            is_measured: false,
            is_timed: false,
            forces: Forces::default(),
            share: 0.0,
            asked: None,
            newest: None,
            arrivals: Vec::with_capacity(MOST_DATAGRAMS),
            allowance: MOST_NOTED,
            unnoted: 0,
            delays: Delays::default(),
        }
    }

    /// The next tick begins.
    pub(super) fn begin(&mut self) {
        (self.is_measured, self.is_timed) = (false, false);
        (self.forces, self.share, self.asked) = (Forces::default(), 0.0, None);
        self.arrivals.clear();
        self.allowance = self.allowance.saturating_add(NOTED_PER_TICK).min(MOST_NOTED);
    }

    /// The arrivals of this tick, in their order.
    pub(super) fn arrivals(&self) -> &[Arrival] {
        &self.arrivals
    }

    /// Notes a datagram that the endpoint was given.
    pub(super) fn arrive(&mut self, time: LocalTime, datagram: &[u8], packet: Option<Packet>) {
        if let Some(packet) = packet {
            let anew = |newest: &Newest| {
                newest.packet.session != packet.session || newest.packet.sequence < packet.sequence
            };
            if self.newest.as_ref().is_none_or(anew) {
                self.newest = Some(Newest { arrival: time, packet });
            }
        }
        if self.allowance == 0 || self.arrivals.len() == self.arrivals.capacity() {
            self.unnoted = self.unnoted.saturating_add(1);
            return;
        }
        self.allowance -= 1;
        let mut bytes = [0; LENGTH];
        bytes.iter_mut().zip(datagram).for_each(|(place, byte)| *place = *byte);
        self.arrivals.push(Arrival {
            tick: self.tick,
            time,
            is_taken: packet.is_some(),
            length: datagram.len(),
            datagram: bytes,
        });
    }

    /// How much longer than the shortest lately the way of this tick's motion took from its measurement to the tick, s.
    pub(super) fn device_delay(&mut self, now: LocalTime, reading: &Reading) -> Option<f64> {
        let stamp = reading.stamp.filter(|stamp| stamp.time.is_finite())?;
        reading.motion?;
        Some(self.delays.take(now, stamp))
    }
}

/// Where the time goes between the partner's measurement and the own force, s; `None` is not known.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Latency {
    /// From the measurement by the own device to the tick, beyond the shortest of the last seconds.
    pub device: Option<f64>,
    /// From the time at which the tick was due to its command.
    pub control: f64,
    /// From the partner's measurement to the arrival of its newest packet; as exact as the partner's clock is known.
    pub network: Option<f64>,
    /// What the age of the motion in use has beyond that: it waits for its time, or is held because none has come.
    pub playout: Option<f64>,
}

/// From the partner's stamp to the arrival, by the offset of the clocks, s.
pub(super) fn transit(newest: &Newest, offset: Option<Span>) -> Option<f64> {
    let sent = LocalTime(newest.packet.sent.0) - offset?;
    Some((newest.arrival - sent).seconds())
}

#[cfg(test)]
mod tests {
    use telespring::session::{Motion, PeerTime};

    use super::*;

    fn packet(sequence: u64) -> Packet {
        let motion = Motion { position: [sequence as f64, 0.0], velocity: [0.0; 2] };
        Packet { session: 5, ..Packet::of(sequence, PeerTime(1000 + sequence), motion) }
    }

    #[test]
    fn law_a_flood_is_counted_and_what_comes_at_the_usual_rate_is_noted() {
        let mut notes = Notes::new();
        let (mut given, mut noted) = (0_u64, 0);
        for tick in 0..1000 {
            notes.begin();
            // a flood for a while, then one packet per tick
            for _ in 0..if tick < 500 { MOST_DATAGRAMS } else { 1 } {
                notes.arrive(LocalTime(tick), b"no packet", None);
                given += 1;
            }
            noted += notes.arrivals().len() as u64;
            assert!(tick < 500 || notes.arrivals().len() == 1, "{tick}");
            assert!(notes.arrivals().iter().all(|arrival| arrival.bytes() == b"no packet"));
        }
        assert_eq!(noted + notes.unnoted, given);
        assert!(noted <= u64::from(MOST_NOTED) + 501 * u64::from(NOTED_PER_TICK) + 500, "{noted}");
    }

    #[test]
    fn law_the_newest_packet_is_the_one_with_the_highest_number_of_its_session() {
        let mut notes = Notes::new();
        let mut come = |time, packet: Packet| {
            notes.arrive(LocalTime(time), &packet.encode(), Some(packet));
            let newest = notes.newest.unwrap();
            (newest.arrival.0, newest.packet.sequence)
        };
        assert_eq!(come(10, packet(3)), (10, 3));
        assert_eq!(come(11, packet(2)), (10, 3));
        assert_eq!(come(12, packet(4)), (12, 4));
        assert_eq!(come(13, Packet { session: 6, ..packet(0) }), (13, 0));
    }

    #[test]
    fn law_a_transit_is_counted_on_one_clock() {
        let newest = Newest { arrival: LocalTime(9_000), packet: packet(1) };
        assert_eq!(transit(&newest, None), None);
        // the partner's clock is 500 ns ahead
        let seconds = transit(&newest, Some(Span(500))).unwrap();
        assert!((seconds - (9_000.0 - (1_001.0 - 500.0)) * 1e-9).abs() < 1e-18);
    }

    #[test]
    fn law_a_longer_way_from_the_device_is_seen_whatever_its_clock_reads() {
        let mut notes = Notes::new();
        let motion = Some(Motion { position: [0.0; 2], velocity: [0.0; 2] });
        let mut sequence = 0.0;
        let mut after = |now: f64, time, is_new| {
            sequence = if is_new { 1.0 } else { sequence + 1.0 };
            let reading = Reading {
                motion,
                stamp: Some(Stamp { sequence, time }),
                acted: None,
                target: None,
                is_ready: true,
                is_stopped: false,
            };
            notes.device_delay(LocalTime::from_seconds(now), &reading)
        };
        assert_eq!(after(5.0, 1005.0, true), Some(0.0));
        assert!((after(5.003, 1005.001, false).unwrap() - 0.002).abs() < 1e-9);
        assert_eq!(after(5.003, f64::NAN, false), None);
        // a device whose clock is slow by 100 ppm, for an hour, with a late row now and then
        for tick in 1..36_000_u32 {
            let seconds = f64::from(tick) * 0.1;
            let late = if tick % 7 == 0 { 0.004 } else { 0.0 };
            let shown = after(5.0 + seconds + late, 1005.0 + seconds * (1.0 - 1e-4), false).unwrap();
            assert!(tick < 200 || (shown - late).abs() <= 1.1e-3, "{tick}: {shown}");
        }
        // its program is started anew, with another clock
        assert_eq!(after(3610.0, 17.0, true), Some(0.0));
        assert!((after(3610.004, 17.001, false).unwrap() - 0.003).abs() < 1e-9);
    }
}
