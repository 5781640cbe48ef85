//! One direction of the emulated network: what a model does to packets, with seeded random numbers.
//!
//! The one-way haptic delay δ of a condition is the time from the measurement of a position to its use as
//! the partner's. The endpoint implements it: it plays every sample exactly δ after its measurement and
//! interpolates between samples. The sample after the played one must therefore have arrived. The network
//! delays packets by δ minus one sample period, or not at all if δ is shorter, so the sample measured one
//! period after the played instant has just arrived. Without jitter and loss the haptic delay is thus
//! exactly δ, whether or not it is a multiple of the period.
//!
//! Jitter delays each packet by an additional random time between 0 and its bound. The endpoint does not wait
//! for it: it interpolates between the samples it has, across lost and late ones, and holds
//! the newest if there is no newer one. A late sample is used if it is still needed. If the delay is a
//! multiple of the period, a single lost sample is never noticed as a hold, because its successor has just
//! arrived. Otherwise the previous sample is held for part of a period. Packets overtake each other if the
//! jitter exceeds the period.
//!
//! A packet meets the impairments in this order: blackout, recorded, bursty or independent loss; the queue and the
//! link of limited rate; the constant delay (or the recorded one) with the jitter; a copy of its own; the order.
//! A recorded trace is played in a circle, from a place that the seed draws, so that several trials meet all of it: a packet
//! has the delay and the fate of the recorded packet that was sent last before it. Both ways begin at the same share
//! of their traces, as they were recorded. With a trace the delay of a condition is only the time at which the endpoint
//! plays a sample.

use std::collections::VecDeque;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::adversary::AdversaryChannel;
use super::burst::BurstState;
use super::jitter::JitterSource;
use super::{Channel, Datagram, JitterDistribution, NetworkModel, PacketOrder};
use crate::rig::random::{Impairment, RandomStream, random_generator};
use crate::session::{LocalTime, Span};

impl NetworkModel {
    /// The channel of this network model towards a side, counted from 0, whose packets take at least `travel`.
    ///
    /// The model must have passed [`NetworkModel::check`]. The same seed gives the same packets.
    pub fn channel(&self, travel: Span, seed: u64, side: usize) -> Box<dyn Channel> {
        let emulated = Box::new(EmulatedChannel::new(self, travel, seed, side));
        match self.adversary {
            None => emulated,
            Some(adversary) => Box::new(AdversaryChannel::new(adversary, emulated)),
        }
    }
}

/// One direction of the emulated network.
#[derive(Debug, Clone)]
pub struct EmulatedChannel {
    model: NetworkModel,
    travel: Span,
    /// Of uniform jitter and of independent loss.
    random: ChaCha8Rng,
    jitter: JitterSource,
    jitter_random: ChaCha8Rng,
    burst: Option<BurstState>,
    copies: ChaCha8Rng,
    /// Where the recorded trace begins.
    trace_start: Span,
    /// When the link of limited rate has sent all packets.
    link_free: LocalTime,
    /// When the last packet arrives, in the order of sending.
    last_arrival: LocalTime,
    /// Packets in order of arrival.
    travelling: VecDeque<(LocalTime, Datagram)>,
}

impl EmulatedChannel {
    /// Creates a network channel towards a side whose packets take at least `travel`.
    fn new(model: &NetworkModel, travel: Span, seed: u64, side: usize) -> Self {
        let stream = |impairment| random_generator(seed, RandomStream::Impairment(impairment, side));
        Self {
            travel,
            random: random_generator(seed, RandomStream::Network(side)),
            jitter: JitterSource::new(model.distribution),
            jitter_random: stream(Impairment::Jitter),
            burst: model.burst.map(|burst| BurstState::new(burst, stream(Impairment::Burst))),
            copies: stream(Impairment::Duplicate),
            trace_start: model.trace.as_ref().map_or(Span(0), |trace| {
                let share = random_generator(seed, RandomStream::TraceStart).random::<f64>();
                Span::from_seconds(share * trace.duration())
            }),
            link_free: LocalTime(0),
            last_arrival: LocalTime(0),
            travelling: VecDeque::new(),
            model: model.clone(),
        }
    }

    /// When the network's link of limited rate has sent a packet that comes now; `None` if its queue is full.
    fn departure(&mut self, now: LocalTime) -> Option<LocalTime> {
        let Some(rate) = self.model.rate else { return Some(now) };
        let service = Span::from_seconds(rate.service_time());
        let before = (self.link_free - now).0.max(0).cast_unsigned();
        // The packet on the link is not in the queue.
        let waiting = before.div_ceil(service.0.max(1).cast_unsigned()).saturating_sub(1);
        if before > 0 && waiting >= rate.queue as u64 {
            return None;
        }
        self.link_free = self.link_free.max(now) + service;
        Some(self.link_free)
    }

    /// Puts a packet of the network among those that travel.
    fn insert(&mut self, arrival: LocalTime, packet: Datagram) {
        let arrival = match self.model.order {
            PacketOrder::Any => arrival,
            PacketOrder::Fifo => arrival.max(self.last_arrival),
        };
        self.last_arrival = arrival;
        let place = match self.travelling.back() {
            Some((latest, _)) if *latest > arrival => {
                self.travelling.partition_point(|(time, _)| *time <= arrival)
            }
            _ => self.travelling.len(),
        };
        self.travelling.insert(place, (arrival, packet));
    }
}

impl Channel for EmulatedChannel {
    fn send(&mut self, now: LocalTime, packet: Datagram) {
        let NetworkModel { jitter, loss, duplicate, .. } = self.model;
        // Drawn in pairs, so that changing one impairment leaves the other's numbers unchanged.
        let (mut lateness, mut fate) = (0.0, 1.0);
        if jitter > 0.0 || loss > 0.0 {
            (lateness, fate) = (self.random.random::<f64>(), self.random.random::<f64>());
        }
        lateness *= jitter;
        if jitter > 0.0 && self.model.distribution != JitterDistribution::Uniform {
            lateness = self.jitter.draw(jitter, &mut self.jitter_random);
        }
        let copy = (duplicate > 0.0).then(|| {
            let comes_twice = self.copies.random::<f64>() < duplicate;
            (comes_twice, self.jitter.draw(jitter, &mut self.copies))
        });
        let lost_in_burst = self.burst.as_mut().is_some_and(BurstState::loses);
        let recorded = self.model.trace.as_ref().map(|trace| trace.at(now + self.trace_start));
        let blacked_out = self.model.blackout.is_some_and(|blackout| blackout.covers(now));
        if fate < loss || lost_in_burst || blacked_out || recorded.is_some_and(|row| row.lost) {
            return;
        }
        let Some(departure) = self.departure(now) else { return };
        let travel = recorded.map_or(self.travel, |row| Span::from_seconds(row.delay));
        self.insert(departure + travel + Span::from_seconds(lateness), packet);
        if let Some((true, lateness)) = copy {
            self.insert(departure + travel + Span::from_seconds(lateness), packet);
        }
    }

    fn deliver(&mut self, now: LocalTime) -> Option<Datagram> {
        if self.travelling.front()?.0 > now {
            return None;
        }
        self.travelling.pop_front().map(|(_, packet)| packet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::wire::LENGTH;
    use crate::session::{Endpoint, EndpointSettings, Law, Motion};

    const PERIOD: Span = Span(1_000_000);

    fn link(jitter: f64, loss: f64, delay: f64) -> Box<dyn Channel> {
        let delay = (Span::from_seconds(delay) - PERIOD).max(Span(0));
        NetworkModel { jitter, loss, ..NetworkModel::ideal() }.channel(delay, 3, 0)
    }

    /// The packet sent at tick `n` carries n in its first bytes.
    fn numbered(n: u64) -> [u8; LENGTH] {
        let mut packet = [0; LENGTH];
        packet[..8].copy_from_slice(&n.to_le_bytes());
        packet
    }

    /// For every packet that came, its number and how long it took (s), looked for every 10 µs.
    fn passage(link: &mut dyn Channel, packets: u64) -> Vec<(u64, f64)> {
        let mut came = Vec::new();
        for step in 0..(packets + 500) * 100 {
            let now = LocalTime(step * 10_000);
            if step % 100 == 0 && step / 100 < packets {
                link.send(now, numbered(step / 100));
            }
            while let Some(packet) = link.deliver(now) {
                let number = u64::from_le_bytes(packet[..8].try_into().unwrap());
                came.push((number, now.seconds() - number as f64 * 1e-3));
            }
        }
        came
    }

    #[test]
    fn law_the_haptic_delay_is_exact_for_any_fraction_of_a_period() {
        // a straight movement is interpolated without error, so the force reveals the delay
        let (speed, stiffness) = (0.25, 80.0);
        for delay in [0.0, 0.0004, 0.001, 0.00173, 0.0835955, 0.334] {
            let law = Law { stiffness, damping: 0.0 };
            let [mut side, mut partner] = [1, 2].map(|id| {
                let settings = EndpointSettings::new(id, law, Span::from_seconds(delay));
                Endpoint::new(EndpointSettings { watchdog: None, ..settings }).unwrap()
            });
            let mut link = link(0.0, 0.0, delay);
            for tick in 0..1000 {
                let now = LocalTime(0) + Span(tick * PERIOD.0);
                side.handle_measurement(now, Motion::default()).unwrap();
                let position = [speed * now.seconds(), 0.0];
                partner.handle_measurement(now, Motion { position, velocity: [0.0; 2] }).unwrap();
                link.send(now, partner.poll_transmit(now).unwrap());
                while let Some(packet) = link.deliver(now) {
                    side.handle_datagram(now, &packet).unwrap();
                }
                let expected = stiffness * speed * (now.seconds() - delay).max(0.0);
                // rounding of the force only
                assert!((side.force(now)[0] - expected).abs() < 1e-12, "delay {delay}, tick {tick}");
            }
        }
    }

    #[test]
    fn law_packets_keep_their_order_and_take_the_delay_less_one_period() {
        let came = passage(&mut *link(0.0, 0.0, 0.05), 200);
        assert_eq!(came.len(), 200);
        for (n, (number, taken)) in came.iter().enumerate() {
            assert_eq!(*number, n as u64);
            assert!((taken - 0.049).abs() < 1e-9);
        }
    }

    #[test]
    fn law_jitter_is_uniform_inside_its_bounds_and_reorders() {
        let came = passage(&mut *link(0.02, 0.0, 0.05), 4000);
        assert_eq!(came.len(), 4000);
        // a look every 10 µs finds a packet at most that much late
        assert!(came.iter().all(|(_, taken)| (0.049..0.069 + 1.1e-5).contains(taken)));
        assert!(came.windows(2).any(|pair| pair[1].0 < pair[0].0));
        let mean = came.iter().map(|(_, taken)| taken).sum::<f64>() / 4000.0;
        // 4 standard errors of a uniform mean, and the look's half step
        let error = 4.0 * 0.02 / 12.0_f64.sqrt() / 4000.0_f64.sqrt();
        assert!((mean - 0.059).abs() < error + 1e-5, "{mean}");
    }

    #[test]
    fn law_loss_is_as_frequent_as_asked() {
        let came = passage(&mut *link(0.0, 0.1, 0.0), 10_000);
        let lost = 1.0 - came.len() as f64 / 10_000.0;
        // 4 standard errors of a share
        assert!((lost - 0.1).abs() < 4.0 * (0.09_f64 / 10_000.0).sqrt(), "{lost}");
        assert!(passage(&mut *link(0.0, 1.0, 0.0), 100).is_empty());
    }
}
