//! Losses in bursts: a network that is good or bad (Gilbert 1960, Elliott 1963).

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Losses in bursts: before each packet the network changes between a good and a bad state, and loses the packet with
/// the probability of its state.
///
/// E. N. Gilbert, "Capacity of a burst-noise channel", Bell System Technical Journal 39, 1960; E. O. Elliott,
/// "Estimates of error rates for codes on burst-noise channels", ibid. 42, 1963.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GilbertElliott {
    /// The probability to change from good to bad, per packet (p).
    pub to_bad: f64,
    /// The probability to change from bad to good, per packet (r).
    pub to_good: f64,
    /// The probability that a packet is lost in the good state (1 − k).
    pub loss_good: f64,
    /// The probability that a packet is lost in the bad state (1 − h).
    pub loss_bad: f64,
}

impl GilbertElliott {
    /// The share of packets that find the network in the bad state, p/(p + r); 0 if it never changes.
    pub fn bad_share(&self) -> f64 {
        let changes = self.to_bad + self.to_good;
        if changes > 0.0 { self.to_bad / changes } else { 0.0 }
    }

    /// The share of packets that the network loses in the long run.
    pub fn loss(&self) -> f64 {
        let bad = self.bad_share();
        (1.0 - bad) * self.loss_good + bad * self.loss_bad
    }

    /// The mean number of consecutive packets that the network loses; 0 if it loses none, infinite if all.
    ///
    /// With L the share lost and J the probability that a packet and its successor are lost, a burst begins with
    /// the probability L − J per packet, so that the mean length is L/(L − J). It is 1/r if all packets are lost
    /// in the bad state and none in the good one.
    pub fn mean_burst_length(&self) -> f64 {
        let (bad, lost) = (self.bad_share(), self.loss());
        let after_good = (1.0 - self.to_bad) * self.loss_good + self.to_bad * self.loss_bad;
        let after_bad = self.to_good * self.loss_good + (1.0 - self.to_good) * self.loss_bad;
        let both = (1.0 - bad) * self.loss_good * after_good + bad * self.loss_bad * after_bad;
        if lost == 0.0 { 0.0 } else { lost / (lost - both).max(0.0) }
    }
}

/// The state of a network that loses in bursts.
#[derive(Debug, Clone)]
pub(super) struct BurstState {
    model: GilbertElliott,
    /// Unknown before the first packet.
    is_bad: Option<bool>,
    random: ChaCha8Rng,
}

impl BurstState {
    /// The state before the first packet, which finds the network as it is in the long run.
    pub fn new(model: GilbertElliott, random: ChaCha8Rng) -> Self {
        Self { model, is_bad: None, random }
    }

    /// Whether the network loses its next packet.
    pub fn loses(&mut self) -> bool {
        let (change, fate) = (self.random.random::<f64>(), self.random.random::<f64>());
        let is_bad = match self.is_bad {
            None => change < self.model.bad_share(),
            Some(false) => change < self.model.to_bad,
            Some(true) => change >= self.model.to_good,
        };
        self.is_bad = Some(is_bad);
        fate < if is_bad { self.model.loss_bad } else { self.model.loss_good }
    }
}
