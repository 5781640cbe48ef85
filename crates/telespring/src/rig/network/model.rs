//! What one direction of a network does to packets, as plain values in SI units.

use std::sync::Arc;

use super::{Adversary, GilbertElliott, JitterDistribution, Trace};
use crate::session::{LocalTime, Span};

/// Both directions of a network; each has its own model and its own random numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    /// The way from robot 1 to robot 2.
    pub forward: NetworkModel,
    /// The way from robot 2 to robot 1.
    pub backward: NetworkModel,
}

impl Network {
    /// A network that does the same in both directions.
    pub fn each_way(model: NetworkModel) -> Self {
        Self { forward: model.clone(), backward: model }
    }

    /// The largest additional delays of the network, forward and backward, s.
    pub fn jitters(&self) -> [f64; 2] {
        [self.forward.jitter, self.backward.jitter]
    }

    /// The network's model of the way towards a side, counted from 0.
    pub fn towards(&self, side: usize) -> &NetworkModel {
        if side == 1 { &self.forward } else { &self.backward }
    }
}

/// What one direction of the emulated network does to packets besides the constant delay of a condition.
///
/// Each impairment draws from its own stream of random numbers, once or more for every packet sent, also for one
/// that is lost: changing one impairment leaves the numbers of all others unchanged. Only the default jitter and
/// the independent loss share a stream; they draw in pairs.
#[derive(Debug, Clone, PartialEq)]
pub struct NetworkModel {
    /// The largest delay of a packet beyond the constant one, s.
    pub jitter: f64,
    /// How the additional delay is distributed between 0 and `jitter`.
    pub distribution: JitterDistribution,
    /// The probability that a packet is lost, independent of all others. A lost sample is interpolated across if its
    /// successor has arrived in time; otherwise the newest sample is held.
    pub loss: f64,
    /// Losses in bursts, in addition.
    pub burst: Option<GilbertElliott>,
    /// The probability that a packet comes twice; the copy has its own additional delay.
    pub duplicate: f64,
    /// Whether packets may overtake each other.
    pub order: PacketOrder,
    /// A link of limited rate that all packets pass before the constant delay.
    pub rate: Option<RateLimit>,
    /// Times at which every packet sent is lost.
    pub blackout: Option<Blackout>,
    /// Recorded delays and losses, played again in place of the constant delay.
    pub trace: Option<Arc<Trace>>,
    /// An adversary behind this network that decides what the receiver gets.
    pub adversary: Option<Adversary>,
}

impl NetworkModel {
    /// A network with a constant delay only.
    pub const fn ideal() -> Self {
        Self {
            jitter: 0.0,
            distribution: JitterDistribution::Uniform,
            loss: 0.0,
            burst: None,
            duplicate: 0.0,
            order: PacketOrder::Any,
            rate: None,
            blackout: None,
            trace: None,
            adversary: None,
        }
    }
}

/// Whether packets of a network may overtake each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PacketOrder {
    /// A packet with a shorter delay overtakes an earlier one.
    Any,
    /// First in, first out: a packet waits for all that were sent before it.
    Fifo,
}

/// A link of limited rate in a network: it sends one packet after the other, and the rest wait.
///
/// A packet takes `s = 8·`[`PACKET_BYTES`](Self::PACKET_BYTES)`/rate` on the link. If one comes every h ≥ s, each is
/// delayed by s; if h < s, packet n (from 0) is delayed by s + n (s − h), until the queue is full.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateLimit {
    /// Bits per second.
    pub bits_per_second: f64,
    /// How many packets wait at most, besides the one on the link; a packet that finds the queue full is lost.
    pub queue: usize,
}

impl RateLimit {
    /// The bytes of a packet on the link: its own and the headers of IPv4 (20) and UDP (8).
    pub const PACKET_BYTES: usize = crate::session::wire::LENGTH + 28;
    /// The queue if none is given, packets: a second at 1 kHz.
    pub const QUEUE: usize = 1000;

    /// The time of a packet on the link, s.
    pub fn service_time(&self) -> f64 {
        8.0 * Self::PACKET_BYTES as f64 / self.bits_per_second
    }
}

/// Times at which a network loses every packet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blackout {
    /// The beginning of the first, s after the start of the trial.
    pub start: f64,
    /// How long each lasts, s.
    pub duration: f64,
    /// The time from one beginning to the next, s; `None` for a single blackout.
    pub period: Option<f64>,
}

impl Blackout {
    /// Whether the network's blackout covers a packet sent at this time, where the trial starts at 0; the end is not
    /// covered.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::rig::Blackout;
    /// use telespring::session::LocalTime;
    ///
    /// let blackout = Blackout { start: 2.0, duration: 0.5, period: Some(10.0) };
    /// let covered = [1.9, 2.0, 2.4, 2.5, 12.2].map(|time| blackout.covers(LocalTime::from_seconds(time)));
    /// assert_eq!(covered, [false, true, true, false, true]);
    /// ```
    pub fn covers(&self, time: LocalTime) -> bool {
        // in whole ns, so that a beginning counts whichever period it is of
        let Some(since) = time.checked_sub(Span::from_seconds(self.start)) else { return false };
        let duration = Span::from_seconds(self.duration).0.cast_unsigned();
        match self.period {
            None => since.0 < duration,
            Some(period) => since.0 % Span::from_seconds(period).0.max(1).cast_unsigned() < duration,
        }
    }
}
