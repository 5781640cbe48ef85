//! The network emulator: one direction.
//!
//! A condition's one-way haptic delay δ is what passes from the measurement of a position to its use as
//! the partner's. The endpoint makes it: it plays every sample exactly δ after it was measured,
//! interpolating between samples. For that the sample after the played one must be there in time. The
//! network therefore takes δ less one sample period, or nothing where δ is shorter: the sample measured one
//! period after the played instant, or earlier, has then just arrived. Without jitter and loss the haptic
//! delay is thus exactly δ, whether or not it is a whole number of periods.
//!
//! Jitter makes each packet later by a time of its own, uniform between 0 and its bound. The endpoint does
//! not wait longer for it: between the samples it has it interpolates, over those that are lost or late as
//! well, and where none newer has come it holds the newest. A late one is taken up if its turn is not over. A
//! single lost sample is thus never noticed as a hold where the delay is a whole number of periods: when it
//! would be played its successor has just come. Elsewhere the sample before it is held for a part of a
//! period. Packets overtake each other where the jitter exceeds the period.

use std::collections::VecDeque;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::NetworkImpairments;
use crate::session::Nanoseconds;
use crate::session::wire::LENGTH;

/// One direction of the network.
#[derive(Debug, Clone)]
pub(crate) struct Channel {
    delay: Nanoseconds,
    jitter: f64,
    loss: f64,
    random: ChaCha8Rng,
    /// In order of arrival.
    travelling: VecDeque<(Nanoseconds, [u8; LENGTH])>,
}

impl Channel {
    /// A network whose packets take `delay` at least.
    pub(crate) fn new(network: &NetworkImpairments, delay: Nanoseconds, random: ChaCha8Rng) -> Self {
        Self { delay, jitter: network.jitter, loss: network.loss, random, travelling: VecDeque::new() }
    }

    /// Takes the packet that is sent `now`.
    pub(crate) fn send(&mut self, now: Nanoseconds, packet: [u8; LENGTH]) {
        // drawn in pairs, so that a change of one leaves the other's numbers
        let (mut lateness, mut fate) = (0.0, 1.0);
        if self.jitter > 0.0 || self.loss > 0.0 {
            (lateness, fate) = (self.random.random::<f64>(), self.random.random::<f64>());
        }
        if fate < self.loss {
            return;
        }
        let arrival = now.plus(self.delay).plus(Nanoseconds::from_seconds(lateness * self.jitter));
        let place = match self.travelling.back() {
            Some((latest, _)) if *latest > arrival => {
                self.travelling.partition_point(|(time, _)| *time <= arrival)
            }
            _ => self.travelling.len(),
        };
        self.travelling.insert(place, (arrival, packet));
    }

    /// The next packet that has arrived by `now`.
    pub(crate) fn deliver(&mut self, now: Nanoseconds) -> Option<[u8; LENGTH]> {
        if self.travelling.front()?.0 > now {
            return None;
        }
        self.travelling.pop_front().map(|(_, packet)| packet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::random::{Stream, generator};
    use crate::session::{Endpoint, Law, Motion};

    const PERIOD: Nanoseconds = Nanoseconds(1_000_000);

    fn link(jitter: f64, loss: f64, delay: f64) -> Channel {
        let delay = Nanoseconds::from_seconds(delay).before(PERIOD).unwrap_or_default();
        Channel::new(&NetworkImpairments { jitter, loss }, delay, generator(3, Stream::Network(0)))
    }

    /// The packet sent at tick `n` carries n in its first bytes.
    fn numbered(n: u64) -> [u8; LENGTH] {
        let mut packet = [0; LENGTH];
        packet[..8].copy_from_slice(&n.to_le_bytes());
        packet
    }

    /// For every packet that came, its number and how long it took (s), looked for every 10 µs.
    fn passage(link: &mut Channel, packets: u64) -> Vec<(u64, f64)> {
        let mut came = Vec::new();
        for step in 0..(packets + 500) * 100 {
            let now = Nanoseconds(step * 10_000);
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
        // a straight movement is interpolated without error, so that the force tells the delay
        let (speed, stiffness) = (0.25, 80.0);
        for delay in [0.0, 0.0004, 0.001, 0.00173, 0.0835955, 0.334] {
            let mut side = Endpoint::new(Law { stiffness, damping: 0.0 }, Nanoseconds::from_seconds(delay));
            let mut partner = side.clone();
            let mut link = link(0.0, 0.0, delay);
            for tick in 0..1000 {
                let now = Nanoseconds(tick * PERIOD.0);
                side.send(now, Motion::default()).unwrap();
                let position = [speed * now.seconds(), 0.0];
                link.send(now, partner.send(now, Motion { position, velocity: [0.0; 2] }).unwrap());
                while let Some(packet) = link.deliver(now) {
                    side.receive(now, &packet).unwrap();
                }
                let expected = stiffness * speed * (now.seconds() - delay).max(0.0);
                // rounding of the force only
                assert!((side.force(now)[0] - expected).abs() < 1e-12, "delay {delay}, tick {tick}");
            }
        }
    }

    #[test]
    fn law_packets_keep_their_order_and_take_the_delay_less_one_period() {
        let came = passage(&mut link(0.0, 0.0, 0.05), 200);
        assert_eq!(came.len(), 200);
        for (n, (number, taken)) in came.iter().enumerate() {
            assert_eq!(*number, n as u64);
            assert!((taken - 0.049).abs() < 1e-9);
        }
    }

    #[test]
    fn law_jitter_is_uniform_inside_its_bounds_and_reorders() {
        let came = passage(&mut link(0.02, 0.0, 0.05), 4000);
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
        let came = passage(&mut link(0.0, 0.1, 0.0), 10_000);
        let lost = 1.0 - came.len() as f64 / 10_000.0;
        // 4 standard errors of a share
        assert!((lost - 0.1).abs() < 4.0 * (0.09_f64 / 10_000.0).sqrt(), "{lost}");
        assert!(passage(&mut link(0.0, 1.0, 0.0), 100).is_empty());
    }
}
