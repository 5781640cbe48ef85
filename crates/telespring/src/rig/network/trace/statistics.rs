//! What a recorded trace of a network shows.

use super::{Trace, TraceRow};

/// What a recorded trace of a network shows; delays are those of the packets that came.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TraceStatistics {
    /// Packets sent.
    pub sent: usize,
    /// The median time between two packets sent, s.
    pub interval: f64,
    /// The longest time between two packets sent, s: a pause of the sender, or lost packets that left no row.
    pub longest_interval: f64,
    /// The share of packets lost.
    pub loss: f64,
    /// The mean number of packets lost in a row; 0 without losses.
    pub burst_length: f64,
    /// The share of packets that came after one sent later (reordered in the sense of RFC 4737).
    pub reordered: f64,
    /// The smallest delay, s.
    pub minimum: f64,
    /// The mean delay, s.
    pub mean: f64,
    /// The standard deviation of the delays, s.
    pub sd: f64,
    /// The median delay, s.
    pub median: f64,
    /// The delay that 99 % of the packets do not exceed, s.
    pub quantile_99: f64,
    /// The largest delay, s.
    pub maximum: f64,
    /// The correlation of the delays of successive packets; the emulator's jitter has 0. NaN if all are equal.
    pub autocorrelation: f64,
}

/// The median time between two packets of a trace, s.
pub(super) fn median_interval(rows: &[TraceRow]) -> f64 {
    median(rows.windows(2).map(|pair| pair[1].time - pair[0].time).collect())
}

/// The median of values of a trace; NaN without values.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    quantile_of(&values, 0.5)
}

/// A quantile of a trace's sorted values, between neighbours in proportion; NaN without values.
fn quantile_of(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = share.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let (low, high) = (sorted[below], sorted[(below + 1).min(last)]);
    low + (place - below as f64) * (high - low)
}

/// The lengths of all runs of lost packets, and of packets that came, in a trace.
pub(super) fn run_lengths(rows: &[TraceRow]) -> [Vec<usize>; 2] {
    let mut runs = [Vec::new(), Vec::new()];
    for run in rows.chunk_by(|a, b| a.lost == b.lost) {
        runs[usize::from(!run[0].lost)].push(run.len());
    }
    runs
}

impl Trace {
    /// The delays of the packets that came over the network, sorted, s.
    pub(super) fn sorted_delays(&self) -> Vec<f64> {
        let mut delays: Vec<f64> = self.rows.iter().filter(|row| !row.lost).map(|row| row.delay).collect();
        delays.sort_by(f64::total_cmp);
        delays
    }

    /// The delay that this share of the packets that came over the network does not exceed, s; between two recorded
    /// delays in proportion.
    pub fn quantile(&self, share: f64) -> f64 {
        quantile_of(&self.sorted_delays(), share)
    }

    /// What the network's trace shows.
    pub fn statistics(&self) -> TraceStatistics {
        let rows = &self.rows;
        let sorted = self.sorted_delays();
        let count = sorted.len() as f64;
        let mean = sorted.iter().sum::<f64>() / count;
        let variance = sorted.iter().map(|delay| (delay - mean).powi(2)).sum::<f64>() / count;
        let came: Vec<&TraceRow> = rows.iter().filter(|row| !row.lost).collect();
        let mut arrivals: Vec<(f64, usize)> =
            came.iter().enumerate().map(|(index, row)| (row.time + row.delay, index)).collect();
        arrivals.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut newest = 0;
        let mut reordered = 0;
        for (_, index) in arrivals {
            reordered += usize::from(index < newest);
            newest = newest.max(index);
        }
        // only of packets whose successor came too
        let (mut pairs, mut products) = (0.0, 0.0);
        for pair in rows.windows(2).filter(|pair| !pair[0].lost && !pair[1].lost) {
            pairs += 1.0;
            products += (pair[0].delay - mean) * (pair[1].delay - mean);
        }
        let [lost, _] = run_lengths(rows);
        let losses = lost.iter().sum::<usize>() as f64;
        TraceStatistics {
            sent: rows.len(),
            interval: median_interval(rows),
            longest_interval: rows.windows(2).map(|pair| pair[1].time - pair[0].time).fold(0.0, f64::max),
            loss: losses / rows.len() as f64,
            burst_length: if lost.is_empty() { 0.0 } else { losses / lost.len() as f64 },
            reordered: reordered as f64 / count,
            minimum: quantile_of(&sorted, 0.0),
            mean,
            sd: variance.sqrt(),
            median: quantile_of(&sorted, 0.5),
            quantile_99: quantile_of(&sorted, 0.99),
            maximum: quantile_of(&sorted, 1.0),
            // equal delays vary by rounding only
            autocorrelation: if sorted.first() < sorted.last() {
                products / pairs / variance
            } else {
                f64::NAN
            },
        }
    }
}
