//! One way of an impaired path in any clock: packets in, packets out.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What one way does to packets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Way {
    /// How long a packet takes, s.
    pub delay: f64,
    /// How much longer or shorter it may take, s, equally likely anywhere in between.
    pub jitter: f64,
    /// The probability that a packet is lost.
    pub loss: f64,
    /// The probability that a packet comes twice; the copy has its own jitter.
    pub copies: f64,
    /// Whether a packet waits for those that were sent before it; else it overtakes them where its jitter lets it.
    pub keeps_order: bool,
    /// Bytes per second of a link that all packets pass first; `None` for no limit.
    pub rate: Option<f64>,
    /// How long a packet waits at most for that link, s; one that would have to wait longer is lost.
    pub longest_wait: f64,
    /// Nothing gets through.
    pub is_dark: bool,
}

impl Way {
    /// A way that takes no time and loses nothing.
    pub const IDEAL: Self = Self {
        delay: 0.0,
        jitter: 0.0,
        loss: 0.0,
        copies: 0.0,
        keeps_order: false,
        rate: None,
        longest_wait: 0.1,
        is_dark: false,
    };
}

/// What became of the packets of one way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Came in.
    pub taken: u64,
    /// Of those, lost by chance.
    pub lost: u64,
    /// Of those, lost in the dark.
    pub dark: u64,
    /// Of those, lost because the link of limited rate was busy for too long.
    pub crowded: u64,
    /// Copies made.
    pub copied: u64,
    /// Went out, copies included.
    pub given: u64,
    /// Of those, after one that had come in later.
    pub overtaken: u64,
}

impl Counts {
    /// Packets on their way.
    pub fn travelling(&self) -> u64 {
        self.taken + self.copied - self.lost - self.dark - self.crowded - self.given
    }
}

/// One way, with the packets on it. Times are in s, of any clock that does not go back.
#[derive(Debug)]
pub struct Line {
    /// What the way does from now on; packets under way go on as they are.
    pub way: Way,
    random: ChaCha8Rng,
    counts: Counts,
    /// When the link of limited rate is free.
    free: f64,
    /// The latest arrival so far.
    latest: f64,
    /// Arrival in ns, place among the arrivals, number of the packet.
    due: BinaryHeap<Reverse<(u64, u64, u64)>>,
    packets: BTreeMap<u64, Vec<u8>>,
    places: u64,
    /// The highest number of a packet that went out.
    newest: Option<u64>,
}

impl Line {
    /// A way whose chances a seed draws.
    pub fn new(way: Way, seed: u64) -> Self {
        Self {
            way,
            random: ChaCha8Rng::seed_from_u64(seed),
            counts: Counts::default(),
            free: 0.0,
            latest: 0.0,
            due: BinaryHeap::new(),
            packets: BTreeMap::new(),
            places: 0,
            newest: None,
        }
    }

    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Takes a packet. Every packet draws the same number of times, so that one setting does not change another's chances.
    pub fn take(&mut self, now: f64, packet: &[u8]) {
        let [fate, again, spread, copy_spread] = [(); 4].map(|()| self.random.random::<f64>());
        let Way { delay, jitter, loss, copies, is_dark, .. } = self.way;
        self.counts.taken += 1;
        if is_dark {
            self.counts.dark += 1;
            return;
        }
        if fate < loss {
            self.counts.lost += 1;
            return;
        }
        let Some(departure) = self.departure(now, packet.len()) else {
            self.counts.crowded += 1;
            return;
        };
        let number = self.counts.taken;
        let takes = |spread: f64| (delay + jitter * (2.0 * spread - 1.0)).max(0.0);
        self.put(departure + takes(spread), 2 * number, packet);
        if again < copies {
            self.counts.copied += 1;
            self.put(departure + takes(copy_spread), 2 * number + 1, packet);
        }
    }

    /// When the link of limited rate has sent a packet that comes now.
    fn departure(&mut self, now: f64, bytes: usize) -> Option<f64> {
        let Some(rate) = self.way.rate else { return Some(now) };
        let start = self.free.max(now);
        if start - now > self.way.longest_wait {
            return None;
        }
        self.free = start + bytes as f64 / rate;
        Some(self.free)
    }

    fn put(&mut self, arrival: f64, number: u64, packet: &[u8]) {
        let arrival = if self.way.keeps_order { arrival.max(self.latest) } else { arrival };
        self.latest = self.latest.max(arrival);
        self.places += 1;
        self.due.push(Reverse(((arrival * 1e9) as u64, self.places, number)));
        self.packets.insert(number, packet.to_vec());
    }

    /// When the next packet is due, s.
    pub fn next_due(&self) -> Option<f64> {
        self.due.peek().map(|Reverse((arrival, ..))| *arrival as f64 * 1e-9)
    }

    /// The next packet that has arrived by now.
    pub fn give(&mut self, now: f64) -> Option<Vec<u8>> {
        if self.next_due().is_none_or(|due| due > now) {
            return None;
        }
        let Reverse((_, _, number)) = self.due.pop()?;
        self.counts.given += 1;
        self.counts.overtaken += u64::from(self.newest.is_some_and(|newest| newest > number));
        self.newest = self.newest.max(Some(number));
        self.packets.remove(&number)
    }
}
