//! The ages of a recorded trace that is played, wherever the ticks fall between the recorded packets.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use super::Trace;
use super::playing::{Ticks, too_close};
use crate::error::Result;
use crate::session::{LocalTime, Span};

/// Packets that come: those on their way, by the tick at which they arrive, and those that have come and are not due.
#[derive(Debug, Default)]
struct Arrivals {
    coming: BinaryHeap<Reverse<(u64, u64)>>,
    waiting: BTreeSet<u64>,
    /// The newest packet that is due and has come.
    newest_due: Option<u64>,
}

impl Arrivals {
    /// Goes to a tick at which the packets up to `due` are due.
    fn advance(&mut self, tick: u64, due: Option<u64>) {
        while let Some(Reverse((arrival, sent))) = self.coming.peek().copied()
            && arrival <= tick
        {
            self.coming.pop();
            self.waiting.insert(sent);
        }
        while let Some(first) = self.waiting.first().copied().filter(|first| Some(*first) <= due) {
            self.waiting.pop_first();
            self.newest_due = self.newest_due.max(Some(first));
        }
    }
}

impl Trace {
    /// The smallest and the largest age of any sample in use over the network's trace, s: bounds for sessions whose ticks
    /// fall anywhere between the recorded packets.
    ///
    /// Time is cut into cells of one period. Whatever the place of the ticks, each cell has one, and a packet that is sent in
    /// a cell meets one of the rows that begin in it or before. It surely comes once the slowest of these would, and may
    /// come as soon as the fastest would. The age of the oldest sample is at most that of the newest due one that has surely
    /// come; the newest sample is at the latest the first one after the gap that has surely come, and among those up to it
    /// the last that may have come.
    pub(super) fn ages_anywhere(&self, ticks: Ticks, delay: f64) -> Result<[f64; 2]> {
        let Ticks { before, round, period } = ticks;
        let step = period.0.cast_unsigned();
        let wait = Span::from_seconds(delay).0.cast_unsigned();
        let (whole, is_whole) = (wait.div_ceil(step), wait.is_multiple_of(step));
        let start = self.start(ticks);
        let (mut surely, mut maybe) = (Arrivals::default(), Arrivals::default());
        let [mut low, mut high] = [f64::INFINITY, 0.0_f64];
        for tick in 0..before + round {
            let (fastest, slowest) = self.delays_in_cell(LocalTime(tick * step) + start, period);
            let arrival = |taken: Span| tick + taken.0.max(0).cast_unsigned().div_ceil(step);
            maybe.coming.extend(fastest.map(|taken| Reverse((arrival(taken), tick))));
            surely.coming.extend(slowest.map(|taken| Reverse((arrival(taken), tick))));
            let due = tick.checked_sub(whole);
            surely.advance(tick, due);
            maybe.advance(tick, due);
            if tick < before {
                continue;
            }
            let earlier = surely.newest_due.ok_or_else(|| too_close(period))?;
            if maybe.newest_due == due {
                (low, high) = (low.min(delay), high.max(delay));
            }
            let is_due = Some(earlier) == due;
            if is_due && (is_whole || surely.waiting.contains(&(earlier + 1))) {
                continue;
            }
            let age = |sent: u64| ((tick - sent) * step) as f64 / 1e9;
            high = high.max(age(earlier));
            let end = surely.waiting.first().copied().unwrap_or(tick);
            let later = maybe.waiting.range(..=end).next_back().copied();
            low = low.min(age(later.or(maybe.newest_due).unwrap_or(earlier)));
        }
        Ok([low, high])
    }

    /// The shortest and the longest time that a packet takes which is sent over the network in the period from `from` on;
    /// `None` if all packets of the trace there are lost, and if one is.
    fn delays_in_cell(&self, from: LocalTime, period: Span) -> (Option<Span>, Option<Span>) {
        let circle = LocalTime::from_seconds(self.duration).0.max(1);
        let begin = from.0 % circle;
        let after = self.rows.partition_point(|row| LocalTime::from_seconds(row.time).0 <= begin);
        let mut rows = vec![self.rows[after.saturating_sub(1)]];
        let (mut index, mut round) = (after, 0);
        loop {
            if index == self.rows.len() {
                (index, round) = (0, round + circle);
            }
            let row = self.rows[index];
            if LocalTime::from_seconds(row.time).0 + round >= begin + period.0.cast_unsigned() {
                break;
            }
            rows.push(row);
            index += 1;
        }
        let taken = rows.iter().filter(|row| !row.lost).map(|row| Span::from_seconds(row.delay));
        let slowest = if rows.iter().any(|row| row.lost) { None } else { taken.clone().max() };
        (taken.min(), slowest)
    }
}
