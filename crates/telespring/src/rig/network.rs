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
//! not wait longer for it: it holds the newest sample it has, as it does for a lost one, and takes up the
//! late one if its turn is not over. Packets overtake each other where the jitter exceeds the period.

use std::collections::VecDeque;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Network;
use crate::session::Nanoseconds;
use crate::session::wire::LENGTH;

/// One direction of the network.
#[derive(Debug, Clone)]
pub(crate) struct Link {
    delay: Nanoseconds,
    jitter: f64,
    loss: f64,
    random: ChaCha8Rng,
    /// In order of arrival.
    travelling: VecDeque<(Nanoseconds, [u8; LENGTH])>,
}

impl Link {
    /// A network whose packets take `delay` at least.
    pub(crate) fn new(network: &Network, delay: Nanoseconds, random: ChaCha8Rng) -> Self {
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
