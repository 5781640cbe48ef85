//! The emulator's models that fit a recorded trace best.

use super::statistics::run_lengths;
use super::{Trace, special};
use crate::rig::network::{GilbertElliott, JitterDistribution, NetworkModel};

/// A distribution of jitter fitted to the delays of a network's trace by maximum likelihood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JitterFit {
    /// The constant delay, s, to which the jitter is added.
    pub delay: f64,
    /// The bound of the jitter, s: delay and bound together are the largest delay of the trace.
    pub jitter: f64,
    /// How the jitter is distributed.
    pub distribution: JitterDistribution,
    /// The logarithm of the likelihood of what the emulator plays; the larger of two fits is the better one.
    pub log_likelihood: f64,
    /// How well it fits: the largest difference between the shares of packets up to a delay, recorded and fitted
    /// (Kolmogorov's distance). 0 is perfect; below 1.36/√n no difference shows in n independent delays.
    pub distance: f64,
}

/// Losses in bursts, fitted to the runs of a network's trace by maximum likelihood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BurstFit {
    /// All packets are lost in the bad state and none in the good one: then the states can be seen.
    pub model: GilbertElliott,
    /// The number of bursts.
    pub bursts: usize,
    /// How well it fits: the largest difference between the shares of bursts up to a length, recorded and fitted.
    pub distance: f64,
}

/// The emulator's models that fit a network's trace.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceFit {
    /// The distributions of the jitter, the most likely first; empty if all delays are equal.
    pub jitter: Vec<JitterFit>,
    /// The losses; `None` if there are none.
    pub burst: Option<BurstFit>,
    /// The smallest delay of the trace, s.
    pub minimum: f64,
}

impl TraceFit {
    /// The emulator's network model that fits the trace best, and the constant delay, s, that it is added to.
    pub fn model(&self) -> (f64, NetworkModel) {
        let burst = self.burst.map(|fit| fit.model);
        let constant = NetworkModel { burst, ..NetworkModel::ideal() };
        match self.jitter.first() {
            None => (self.minimum, constant),
            Some(best) => {
                let JitterFit { delay, jitter, distribution, .. } = *best;
                (delay, NetworkModel { jitter, distribution, ..constant })
            }
        }
    }
}

impl Trace {
    /// Fits the emulator's models to the network's trace.
    ///
    /// The constant delay is chosen with the distribution; times recorded in whole steps are taken as anywhere
    /// within half a step. A distribution that the emulator would refuse is left out. The emulator draws
    /// every delay by itself: where [`autocorrelation`](super::TraceStatistics::autocorrelation) is far from 0, only the
    /// trace itself shows how long delays last.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::rig::{Trace, TraceRow};
    ///
    /// let rows = (0..100).map(|n| TraceRow { time: f64::from(n), delay: 0.02, lost: n % 10 == 0 });
    /// let fit = Trace::new(rows.collect())?.fit();
    /// assert!(fit.jitter.is_empty());
    /// assert_eq!(fit.burst.unwrap().model.mean_burst_length(), 1.0);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn fit(&self) -> TraceFit {
        let sorted = self.sorted_delays();
        TraceFit { jitter: fit_jitter(&sorted), burst: self.fit_burst(), minimum: sorted[0] }
    }

    /// Fits losses in bursts to the runs of the network's trace.
    fn fit_burst(&self) -> Option<BurstFit> {
        let rows = self.rows();
        let [mut lost, _] = run_lengths(rows);
        if lost.is_empty() {
            return None;
        }
        // transitions from a packet to the next one: [came, lost] → [came, lost]
        let mut transitions = [[0.0_f64; 2]; 2];
        for pair in rows.windows(2) {
            transitions[usize::from(pair[0].lost)][usize::from(pair[1].lost)] += 1.0;
        }
        let share = |from: usize, to: usize| {
            let all = transitions[from][0] + transitions[from][1];
            if all > 0.0 { transitions[from][to] / all } else { 1.0 }
        };
        let (to_bad, to_good) = (share(0, 1), share(1, 0));
        lost.sort_unstable();
        let count = lost.len() as f64;
        let difference = |length: usize| {
            let recorded = lost.partition_point(|&other| other <= length) as f64 / count;
            (1.0 - (1.0 - to_good).powf(length as f64) - recorded).abs()
        };
        let distance =
            lost.iter().map(|&length| difference(length - 1).max(difference(length))).fold(0.0, f64::max);
        let model = GilbertElliott { to_bad, to_good, loss_good: 0.0, loss_bad: 1.0 };
        Some(BurstFit { model, bursts: lost.len(), distance })
    }
}

/// The additional delays of a trace above a constant delay, in the form in which the fits need them.
struct Excess<'a> {
    sorted: &'a [f64],
    /// The step to which the delays were rounded, s; tiny if they were not.
    step: f64,
}

/// A family of distributions of a trace's jitter: from delay to fit.
type Family = fn(&[f64], f64) -> JitterDistribution;

/// Fits all distributions of the jitter to a trace's sorted delays.
fn fit_jitter(sorted: &[f64]) -> Vec<JitterFit> {
    let (least, most) = (sorted[0], sorted[sorted.len() - 1]);
    if least == most {
        return Vec::new();
    }
    let mut step = most - least;
    for pair in sorted.windows(2) {
        let apart = pair[1] - pair[0];
        // delays that differ by rounding only are the same
        if apart > 1e-9 * most {
            step = step.min(apart);
        }
    }
    let excess = Excess { sorted, step };
    let mut fits = vec![excess.fit(excess.smallest_offset(), |_, _| JitterDistribution::Uniform)];
    fits.push(excess.fit(excess.smallest_offset(), fit_normal));
    for family in [fit_gamma as Family, fit_log_normal as Family] {
        fits.push(excess.fit(excess.best_offset(family), family));
    }
    fits.retain(|fit| {
        let model =
            NetworkModel { jitter: fit.jitter, distribution: fit.distribution, ..NetworkModel::ideal() };
        fit.log_likelihood.is_finite() && model.check().is_ok()
    });
    fits.sort_by(|a, b| b.log_likelihood.total_cmp(&a.log_likelihood));
    fits
}

impl Excess<'_> {
    /// The trace's smallest additional delay if the constant delay is as large as it can be, s: half a step, or what
    /// an exponential distribution would have.
    fn smallest_offset(&self) -> f64 {
        let count = self.sorted.len() as f64;
        let mean = self.sorted.iter().sum::<f64>() / count;
        (0.5 * self.step).max((mean - self.sorted[0]) / count).min(self.largest_offset())
    }

    /// The trace's smallest additional delay if the constant delay is 0, s.
    fn largest_offset(&self) -> f64 {
        // a recorded delay of 0 is one of up to half a step
        self.sorted[0].max(0.5 * self.step)
    }

    /// The additional delays of the trace if the smallest is `offset`, s.
    fn above(&self, offset: f64) -> Vec<f64> {
        self.sorted.iter().map(|delay| delay - self.sorted[0] + offset).collect()
    }

    /// The trace's smallest additional delay that makes a family of distributions most likely, s.
    fn best_offset(&self, family: Family) -> f64 {
        const POINTS: usize = 17;
        let (mut low, mut high) = (self.smallest_offset().ln(), self.largest_offset().ln());
        let mut best = low;
        // a grid, and twice a finer one around its best point
        for _ in 0..3 {
            let grid = |point: usize| low + (high - low) * point as f64 / (POINTS - 1) as f64;
            let likelihood = |offset: &f64| self.fit(offset.exp(), family).log_likelihood;
            let points: Vec<(f64, f64)> =
                (0..POINTS).map(grid).map(|offset| (likelihood(&offset), offset)).collect();
            let at = (0..POINTS).max_by(|&a, &b| points[a].0.total_cmp(&points[b].0)).unwrap_or(0);
            best = points[at].1;
            (low, high) = (points[at.saturating_sub(1)].1, points[(at + 1).min(POINTS - 1)].1);
        }
        best.exp()
    }

    /// Fits one family of distributions to the trace if the smallest additional delay is `offset`, s.
    fn fit(&self, offset: f64, family: Family) -> JitterFit {
        let excess = self.above(offset);
        let bound = excess[excess.len() - 1] + 0.5 * self.step.min(offset);
        let distribution = family(&excess, bound);
        let inside = distribution.mass(bound);
        let density = |x: &f64| distribution.ln_density(*x, bound);
        let log_likelihood = excess.iter().map(density).sum::<f64>() - excess.len() as f64 * inside.ln();
        let count = excess.len() as f64;
        let mut distance = 0.0_f64;
        for (index, &x) in excess.iter().enumerate() {
            let is_last = excess.get(index + 1).is_none_or(|next| *next > x);
            if is_last {
                // in the middle between this recorded delay and the next one
                let fitted = distribution.cumulative(x + 0.5 * self.step, bound);
                distance = distance.max((fitted - (index + 1) as f64 / count).abs());
            }
        }
        let delay = (self.sorted[0] - offset).max(0.0);
        JitterFit { delay, jitter: bound, distribution, log_likelihood, distance }
    }
}

/// Mean and standard deviation of a trace's additional delays.
fn moments(excess: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = excess.clone().count() as f64;
    let mean = excess.clone().sum::<f64>() / count;
    (mean, (excess.map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt())
}

/// The normal distribution that makes a trace's additional delays most likely.
fn fit_normal(excess: &[f64], _: f64) -> JitterDistribution {
    let (mean, sd) = moments(excess.iter().copied());
    JitterDistribution::Normal { mean, sd }
}

/// The log-normal distribution that makes a trace's additional delays most likely.
fn fit_log_normal(excess: &[f64], _: f64) -> JitterDistribution {
    let (mean, sd) = moments(excess.iter().map(|x| x.ln()));
    let of_delay = (mean + 0.5 * sd * sd).exp();
    JitterDistribution::LogNormal { mean: of_delay, sd: of_delay * (sd * sd).exp_m1().sqrt() }
}

/// The gamma distribution that makes a trace's additional delays most likely: ln k − ψ(k) = ln x̄ − mean of ln x for its
/// shape k, whose left side decreases.
fn fit_gamma(excess: &[f64], _: f64) -> JitterDistribution {
    let (mean, _) = moments(excess.iter().copied());
    let (of_logarithms, _) = moments(excess.iter().map(|x| x.ln()));
    let wanted = mean.ln() - of_logarithms;
    let (mut low, mut high) = (1e-6_f64.ln(), 1e9_f64.ln());
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        let shape = middle.exp();
        if shape.ln() - special::digamma(shape) > wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    JitterDistribution::Gamma { mean, sd: mean / (0.5 * low).exp() }
}
