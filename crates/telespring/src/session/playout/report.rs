//! What a play-out has done.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::histogram::Histogram;
use super::sequences::Sequences;
use crate::session::Span;

/// The ages of the motion in use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ages {
    /// The smallest age of any sample in use. Between two samples the age is that of the played instant; where samples
    /// between them are missing, those of both count.
    pub smallest: Span,
    /// The mean age of the played instants.
    pub mean: Span,
    /// The largest age of any sample in use.
    pub largest: Span,
    /// Half of the played instants are no older, at most a 32nd more than exact.
    pub median: Span,
    /// 9 of 10 are no older.
    pub quantile_90: Span,
    /// 99 of 100 are no older.
    pub quantile_99: Span,
}

impl Ages {
    /// The middle d and half the width J of the range [d − J, d + J] in which all ages lie: what the verdict on an age in
    /// a range needs. The range is exact or up to 1 ns wider.
    pub fn range(&self) -> (Span, Span) {
        let width = self.largest - self.smallest;
        let half = Span(width.0 / 2 + width.0 % 2);
        (self.largest - half, half)
    }
}

/// What a play-out has done since it was made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlayoutReport {
    /// The delay that it strives for now.
    pub delay: Span,
    /// Ages of the motion in use; `None` before the first.
    pub ages: Option<Ages>,
    /// Samples that came, repetitions left out.
    pub received: u64,
    /// Samples that have not come, although later ones have.
    pub lost: u64,
    /// Repetitions.
    pub repeated: u64,
    /// Samples that came after their time.
    pub late: u64,
    /// Of these, the ones dropped because a later sample was in use already.
    pub overtaken: u64,
    /// Samples dropped because too many were waiting.
    pub crowded_out: u64,
    /// Ticks at which a motion was used.
    pub ticks: u64,
    /// Of these, ticks at which an old motion was held because no later sample had come.
    pub held_ticks: u64,
}

/// The counts of a [`PlayoutReport`] that change from tick to tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PlayoutCounts {
    /// Samples that have not come, although later ones have.
    pub lost: u64,
    /// Samples that came after their time.
    pub late: u64,
    /// Ticks at which an old motion was held because no later sample had come.
    pub held_ticks: u64,
}

impl PlayoutReport {
    /// The share of the ticks at which an old motion was held; 0 without ticks.
    pub fn held_share(&self) -> f64 {
        if self.ticks == 0 { 0.0 } else { self.held_ticks as f64 / self.ticks as f64 }
    }
}

/// The running counts behind a [`PlayoutReport`].
#[derive(Debug, Clone)]
pub(super) struct Counts {
    pub(super) sequences: Sequences,
    /// Losses before the partner restarted.
    pub(super) lost_before: u64,
    pub(super) received: u64,
    pub(super) repeated: u64,
    pub(super) late: u64,
    pub(super) overtaken: u64,
    pub(super) crowded_out: u64,
    ticks: u64,
    held_ticks: u64,
    ages: Histogram,
    /// Sum of all ages, ns.
    sum: f64,
    range: Option<(Span, Span)>,
}

impl Counts {
    pub(super) fn new() -> Self {
        Self {
            sequences: Sequences::new(),
            lost_before: 0,
            received: 0,
            repeated: 0,
            late: 0,
            overtaken: 0,
            crowded_out: 0,
            ticks: 0,
            held_ticks: 0,
            ages: Histogram::new(),
            sum: 0.0,
            range: None,
        }
    }

    /// Counts a tick with a motion of this age, from samples of ages in this range.
    pub(super) fn tick(&mut self, age: Span, (newest, oldest): (Span, Span), held: bool) {
        self.ticks = self.ticks.saturating_add(1);
        self.held_ticks = self.held_ticks.saturating_add(u64::from(held));
        self.ages.add(age);
        self.sum += age.0 as f64;
        let (smallest, largest) = self.range.unwrap_or((newest, oldest));
        self.range = Some((smallest.min(newest), largest.max(oldest)));
    }

    /// Begins with a new series of sequence numbers.
    pub(super) fn restart(&mut self) {
        self.lost_before = self.lost_before.saturating_add(self.sequences.missing());
        self.sequences = Sequences::new();
    }

    /// Samples that have not come, although later ones have.
    fn lost(&self) -> u64 {
        self.lost_before.saturating_add(self.sequences.missing())
    }

    pub(super) fn so_far(&self) -> PlayoutCounts {
        PlayoutCounts { lost: self.lost(), late: self.late, held_ticks: self.held_ticks }
    }

    pub(super) fn report(&self, delay: Span) -> PlayoutReport {
        let quantile = |share, largest: Span| self.ages.quantile(share).unwrap_or(largest).min(largest);
        let ages = self.range.map(|(smallest, largest)| Ages {
            smallest,
            mean: Span((self.sum / self.ticks.max(1) as f64).round() as i64),
            largest,
            median: quantile(0.5, largest),
            quantile_90: quantile(0.9, largest),
            quantile_99: quantile(0.99, largest),
        });
        PlayoutReport {
            delay,
            ages,
            received: self.received,
            lost: self.lost(),
            repeated: self.repeated,
            late: self.late,
            overtaken: self.overtaken,
            crowded_out: self.crowded_out,
            ticks: self.ticks,
            held_ticks: self.held_ticks,
        }
    }
}
