//! How many packets in a row a network does not deliver, with a probability that still counts.

use super::{Blackout, GilbertElliott, NetworkModel};

/// A longer run of lost packets than the one that counts occurs in an hour with a smaller probability.
pub const COUNTED_PROBABILITY: f64 = 1e-6;
/// The time in which a run is looked for, s: an hour.
pub const COUNTED_TIME: f64 = 3600.0;
/// A row of losses that may last longer than this has no bound, s.
pub const LONGEST_GAP: f64 = 100.0;

/// Two states, good and bad, as a row or column.
type Pair = [f64; 2];
/// A matrix on them.
type Square = [Pair; 2];

fn times(a: &Square, b: &Square) -> Square {
    [0, 1].map(|i| [0, 1].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

/// A row times a power of a matrix, summed up.
fn sum_after(row: Pair, matrix: &Square, power: u64) -> f64 {
    let (mut left, mut squared, mut result) = (power, *matrix, [[1.0, 0.0], [0.0, 1.0]]);
    while left > 0 {
        if left % 2 == 1 {
            result = times(&result, &squared);
        }
        squared = times(&squared, &squared);
        left /= 2;
    }
    let [first, second] = result;
    row[0] * (first[0] + first[1]) + row[1] * (second[0] + second[1])
}

/// Independent losses and bursts of a network together, as a chain of two states.
struct LossChain {
    /// The share of time in each state.
    share: Pair,
    /// From one packet to the next.
    steps: Square,
    /// The probability that a packet is lost in each state.
    loss: Pair,
}

impl LossChain {
    fn new(loss: f64, burst: Option<GilbertElliott>) -> Self {
        let Some(burst) = burst else {
            return Self { share: [1.0, 0.0], steps: [[1.0, 0.0], [0.0, 1.0]], loss: [loss, 0.0] };
        };
        let bad = burst.bad_share();
        let also = |own: f64| 1.0 - (1.0 - loss) * (1.0 - own);
        Self {
            share: [1.0 - bad, bad],
            steps: [[1.0 - burst.to_bad, burst.to_bad], [burst.to_good, 1.0 - burst.to_good]],
            loss: [also(burst.loss_good), also(burst.loss_bad)],
        }
    }

    /// How many rows of at least `length` (1 or more) lost packets `packets` packets hold on the average: each begins at
    /// the first packet or after one that came.
    fn expected_runs(&self, length: u64, packets: f64) -> f64 {
        // one packet on, and lost: the transfer matrix of "lost"
        let lost = self.steps.map(|row| [row[0] * self.loss[0], row[1] * self.loss[1]]);
        let first = [self.share[0] * self.loss[0], self.share[1] * self.loss[1]];
        let came = [self.share[0] - first[0], self.share[1] - first[1]];
        let later = (packets - length as f64).max(0.0);
        sum_after(first, &lost, length - 1) + later * sum_after(came, &lost, length)
    }

    /// The longest row of lost packets that counts among `packets`, up to `most`; `None` if it is longer.
    fn longest_run(&self, packets: f64, most: u64) -> Option<u64> {
        let counts = |length: u64| self.expected_runs(length, packets) >= COUNTED_PROBABILITY;
        if counts(most.saturating_add(1)) {
            return None;
        }
        // longer rows are rarer
        let (mut counted, mut rare) = (0, most.saturating_add(1));
        while rare - counted > 1 {
            let middle = counted + (rare - counted) / 2;
            if counts(middle) { counted = middle } else { rare = middle }
        }
        Some(counted)
    }
}

impl NetworkModel {
    /// The longest time without a packet that comes because packets are lost, as a number of packets in a row, one sent
    /// every `period` (s): by chance (independent losses and bursts), in a blackout, and at a full queue.
    ///
    /// Chance has no longest row. The one that counts is the longest of which an hour ([`COUNTED_TIME`]) holds
    /// [`COUNTED_PROBABILITY`] or more on the average, which bounds the probability of a longer one. `None` if that lasts
    /// longer than [`LONGEST_GAP`]. A recorded trace and an adversary are not part of it.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::rig::NetworkModel;
    ///
    /// let lossy = NetworkModel { loss: 0.01, ..NetworkModel::ideal() };
    /// assert_eq!(lossy.longest_loss(0.001), Some(6)); // 3.6·10⁶ · 0.01⁶ is above 10⁻⁶, with 0.01⁷ below
    /// assert_eq!(NetworkModel { loss: 1.0, ..NetworkModel::ideal() }.longest_loss(0.001), None);
    /// ```
    pub fn longest_loss(&self, period: f64) -> Option<u64> {
        let chance = self.longest_chance_loss(period)?;
        let queue = self.longest_queue_loss(period);
        let missing = match self.blackout {
            None => chance,
            Some(blackout) => blackout.longest_loss(period, chance)?,
        };
        let total = missing.saturating_add(queue);
        (total as f64 * period <= LONGEST_GAP).then_some(total)
    }

    /// The longest row of packets lost by chance.
    fn longest_chance_loss(&self, period: f64) -> Option<u64> {
        if self.loss == 0.0 && self.burst.is_none() {
            return Some(0);
        }
        let most = (LONGEST_GAP / period).floor() as u64;
        LossChain::new(self.loss, self.burst).longest_run(COUNTED_TIME / period, most)
    }

    /// The longest row of packets that find the queue of the link full: after one that was taken, the next has room when
    /// the link has sent another.
    fn longest_queue_loss(&self, period: f64) -> u64 {
        let Some(rate) = self.rate else { return 0 };
        let service = rate.service_time();
        if service <= period * (1.0 + 1e-9) { 0 } else { (service / period * (1.0 - 1e-9)).ceil() as u64 - 1 }
    }
}

impl Blackout {
    /// The longest row of lost packets around a blackout of the network, if chance loses at most `chance` in a row before
    /// and after it; `None` if blackouts may follow each other without a packet between them.
    fn longest_loss(&self, period: f64, chance: u64) -> Option<u64> {
        let within = |time: f64| time / period;
        if self.duration == 0.0 {
            return Some(chance);
        }
        // as many times of sending as fit into an interval without its end
        let inside = within(self.duration).mul_add(1.0 - 1e-12, 0.0).ceil() as u64;
        let between = self.period.map_or(f64::INFINITY, |step| within(step - self.duration));
        if (between * (1.0 + 1e-12)).floor() <= chance as f64 {
            return None;
        }
        Some(inside + 2 * chance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// The probability that `packets` hold a row of at least `length` lost ones: forward, packet by packet, over the state
    /// and the length of the row so far.
    fn probability(chain: &LossChain, length: usize, packets: usize) -> f64 {
        let mut row: Vec<Pair> = vec![[0.0; 2]; length];
        let mut seen = 0.0;
        for packet in 0..packets {
            let mut next = vec![[0.0; 2]; length];
            for (lost, states) in row.iter().enumerate() {
                for to in 0..2 {
                    let arrive = if packet == 0 {
                        if lost == 0 { chain.share[to] } else { 0.0 }
                    } else {
                        states[0] * chain.steps[0][to] + states[1] * chain.steps[1][to]
                    };
                    next[0][to] += arrive * (1.0 - chain.loss[to]);
                    let more = arrive * chain.loss[to];
                    if lost + 1 == length { seen += more } else { next[lost + 1][to] += more }
                }
            }
            row = next;
        }
        seen
    }

    #[test]
    fn cross_the_longest_row_is_that_of_a_forward_computation() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut share = || random.random_range(0.05..0.95);
        for _ in 0..40 {
            let burst = GilbertElliott {
                to_bad: share(),
                to_good: share(),
                loss_good: 0.4 * share(),
                loss_bad: share(),
            };
            let chain = LossChain::new(0.3 * share(), Some(burst));
            for length in 2..14 {
                let (expected, exact) =
                    (chain.expected_runs(length as u64, 300.0), probability(&chain, length, 300));
                // Markov; and rare rows come alone
                assert!(exact <= expected * (1.0 + 1e-12), "{length} {exact} {expected}");
                if expected < 1e-3 {
                    assert!(exact > expected * (1.0 - 5e-3), "{length} {exact} {expected}");
                }
            }
            let longest = usize::try_from(chain.longest_run(300.0, 1 << 20).unwrap()).unwrap();
            assert!(probability(&chain, longest + 1, 300) < COUNTED_PROBABILITY);
            assert!(probability(&chain, longest.max(1), 300) > 0.99 * COUNTED_PROBABILITY);
        }
    }

    #[test]
    fn ref_rows_without_end_have_no_bound() {
        let stuck = GilbertElliott { to_bad: 0.1, to_good: 0.0, loss_good: 0.0, loss_bad: 1.0 };
        let never = GilbertElliott { to_bad: 0.0, ..stuck };
        let model = |burst| NetworkModel { burst: Some(burst), ..NetworkModel::ideal() };
        assert_eq!(model(stuck).longest_loss(1e-3), None);
        assert_eq!(model(never).longest_loss(1e-3), Some(0));
        // slow to recover: 100 s are not enough
        assert_eq!(model(GilbertElliott { to_good: 1e-5, ..stuck }).longest_loss(1e-3), None);
        let always = Blackout { start: 0.0, duration: 2.0, period: Some(2.0) };
        assert_eq!(NetworkModel { blackout: Some(always), ..NetworkModel::ideal() }.longest_loss(1e-3), None);
    }
}
