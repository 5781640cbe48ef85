//! Counts of spans of time in bins that grow with the span.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use crate::session::Span;

/// The resolution of short spans, ns.
const UNIT: u64 = 1 << 10;
/// Up to twice this many units every unit has a bin; above, every doubling has this many: a bin is at most a 32nd of
/// its spans wide.
const PER_DOUBLING: u64 = 32;
/// The doublings, up to ten hours; the last bin holds everything above, too.
const DOUBLINGS: u64 = 30;
const BINS: usize = (PER_DOUBLING * (DOUBLINGS + 2)) as usize;

/// Counts of spans; negative ones count as 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    counts: Box<[u64]>,
    total: u64,
}

/// The bin of a span.
fn bin(span: Span) -> usize {
    let units = span.0.max(0).cast_unsigned() / UNIT;
    let doubling = u64::from(units.max(1).ilog2().saturating_sub(PER_DOUBLING.ilog2()));
    let bin = doubling * PER_DOUBLING + (units >> doubling);
    usize::try_from(bin).unwrap_or(BINS).min(BINS - 1)
}

/// The shortest span that is longer than every span of the bin.
fn end(bin: usize) -> Span {
    let bin = bin as u64;
    let doubling = (bin / PER_DOUBLING).saturating_sub(1);
    let units = (bin + 1 - doubling * PER_DOUBLING) << doubling;
    Span((units * UNIT).cast_signed())
}

impl Histogram {
    /// An empty histogram.
    pub fn new() -> Self {
        Self { counts: vec![0; BINS].into_boxed_slice(), total: 0 }
    }

    /// The largest quantile that spans up to this one can have: the end of its bin.
    pub fn largest_quantile(longest: Span) -> Span {
        end(bin(longest))
    }

    /// Counts a span.
    pub fn add(&mut self, span: Span) {
        if let Some(count) = self.counts.get_mut(bin(span)) {
            *count = count.saturating_add(1);
            self.total = self.total.saturating_add(1);
        }
    }

    /// Takes a counted span back.
    pub fn remove(&mut self, span: Span) {
        if let Some(count) = self.counts.get_mut(bin(span)).filter(|count| **count > 0) {
            *count = count.saturating_sub(1);
            self.total = self.total.saturating_sub(1);
        }
    }

    /// The number of spans.
    pub fn len(&self) -> u64 {
        self.total
    }

    /// True without any span.
    pub fn is_empty(&self) -> bool {
        self.total == 0
    }

    /// Forgets all spans.
    pub fn clear(&mut self) {
        self.counts.fill(0);
        self.total = 0;
    }

    /// A span that at least the share `quantile` of all spans does not exceed, at most a 32nd (and 1 µs) above the
    /// smallest such span; `None` without any span.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::session::{Span, playout::Histogram};
    ///
    /// let mut ages = Histogram::new();
    /// for milliseconds in 1..=100 {
    ///     ages.add(Span(milliseconds * 1_000_000));
    /// }
    /// let median = ages.quantile(0.5).unwrap();
    /// assert!(Span(50_000_000) <= median && median <= Span(51_600_000), "{median:?}");
    /// ```
    pub fn quantile(&self, quantile: f64) -> Option<Span> {
        let wanted = (quantile.clamp(0.0, 1.0) * self.total as f64).ceil().max(1.0) as u64;
        let mut below = 0_u64;
        let found = self.counts.iter().position(|count| {
            below = below.saturating_add(*count);
            below >= wanted
        });
        if self.total == 0 { None } else { found.map(end) }
    }
}

impl Default for Histogram {
    fn default() -> Self {
        Self::new()
    }
}
