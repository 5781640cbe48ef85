//! The delays at which the sampled dyad is stable.
//!
//! A controller uses a partner's sample from the first tick after it has arrived: the loop sees whole periods, N_f and N_b, and
//! nothing else of the delays. Every delay of a range between two ticks is therefore the same dyad, and all round trips
//! N = N_f + N_b follow from one count and the crossings of the unit circle.

use super::Network;
use super::contour;
use super::network::ticks_of;
use super::sampled_characteristic::SampledCharacteristic;
use super::sampled_crossings::{CrossingSeries, crossing_series};
use crate::error::{InvalidInput, Result};
use crate::model::{Delay, DyadAxis};
use crate::quantity;

/// A crossing this close to a whole number of periods, relative to it, counts as on it: rounding decides there.
const ROUNDING: f64 = 1e-9;
/// The most crossings followed: beyond the last one nothing is known, and nothing counts as stable.
const MAX_CROSSINGS: usize = 4_000_000;

/// The round trips (whole periods) at which a sampled axis is stable, as windows with both ends included.
#[derive(Debug, Clone)]
struct StableRoundTrips {
    windows: Vec<(u64, u64)>,
    /// True if the dyad is at its limit without delay, as two robots that may drift together, and decided by one period.
    drifts_at_once: bool,
}

impl StableRoundTrips {
    /// The stable round trips of an axis at a stiffness (N/m), up to a longest one (periods).
    pub fn new(axis: &DyadAxis, stiffness: f64, network: &Network, longest: u64) -> Result<Self> {
        // Without delay two undamped robots may only drift together: one period decides then.
        for start in 0..2 {
            let ticks = start as f64 * network.sample_period();
            let at_start = network.with_delay(Delay::new(ticks, 0.0)?);
            let function = SampledCharacteristic::new(axis, stiffness, &at_start);
            if let Ok((outside, _)) = contour::count_outside_circle(&function, 0.0) {
                let series = crossing_series(axis, stiffness, network);
                let windows = stable_windows(&series, start, outside, longest);
                return Ok(Self { windows, drifts_at_once: start > 0 });
            }
        }
        Ok(Self { windows: Vec::new(), drifts_at_once: false })
    }

    /// The stable mean delays (s) in ascending order, each interval open at its start and closed at its end, where
    /// both delays grow in the proportion of the network's.
    pub fn delays(&self, network: &Network) -> Vec<(f64, f64)> {
        let way = DelayPath::new(network);
        let mut found: Vec<(f64, f64)> = Vec::new();
        for &(from, to) in &self.windows {
            // Equal delays both ways may skip a round trip: then every delay above 0 lies in the window.
            let start = if from == 0 { 0.0 } else { way.longest_within(from - 1).max(f64::MIN_POSITIVE) };
            let end = way.longest_within(to);
            if end <= start && !(from == 0 && found.is_empty()) {
                continue;
            }
            match found.last_mut() {
                Some(last) if last.1 == start => last.1 = end,
                _ => found.push((start, end)),
            }
        }
        found
    }
}

/// The windows of round trips without a multiplier outside the circle, from a count of those at a `start`.
fn stable_windows(series: &[CrossingSeries], start: u64, outside: usize, longest: u64) -> Vec<(u64, u64)> {
    let mut windows = Vec::new();
    let mut outside = outside as i64;
    let mut from = start;
    // The next occurrence of every series after the start.
    let mut turns: Vec<f64> =
        series.iter().map(|each| ((start as f64 - each.first) / each.step).floor().max(-1.0) + 1.0).collect();
    let last = (longest as f64).min(permanent_instability(series, start, outside));
    for _ in 0..MAX_CROSSINGS {
        let next = series
            .iter()
            .zip(&mut turns)
            .map(|(each, turn)| (each.first + *turn * each.step, each.leaving, turn))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let (at, leaving) = match next {
            Some((at, leaving, turn)) if at <= last => {
                *turn += 1.0;
                (at, leaving)
            }
            _ => {
                if outside == 0 && series.iter().all(|each| each.leaving <= 0) {
                    windows.push((from, u64::MAX));
                } else if outside == 0 && from <= longest {
                    windows.push((from, longest));
                }
                return windows;
            }
        };
        let slack = ROUNDING * at.max(1.0);
        if outside == 0 && leaving >= 0 {
            let before = (at - slack).ceil() - 1.0;
            if before >= from as f64 {
                windows.push((from, before as u64));
            }
        }
        outside += i64::from(leaving);
        if leaving <= 0 {
            from = from.max((at + slack).floor() as u64 + 1);
        }
    }
    windows
}

/// A round trip (periods) beyond which some multiplier lies outside the circle; infinite if there is none.
fn permanent_instability(series: &[CrossingSeries], start: u64, outside: i64) -> f64 {
    let start = start as f64;
    let (mut net, mut offset) = (0.0, -(outside as f64));
    for each in series {
        let rate = f64::from(each.leaving) / each.step;
        net += rate;
        // A series has occurred (N − first)/step times since, or once more.
        offset += rate * each.first.max(start) + f64::from(each.leaving.abs());
    }
    if net > 0.0 { offset / net } else { f64::INFINITY }
}

/// Delays that grow together, in the proportion of a network's (equal ones if it has none).
pub(super) struct DelayPath {
    /// Forward and backward delay of a mean delay of 1.
    shares: [f64; 2],
    period: f64,
}

impl DelayPath {
    /// The path of the delays behind the playout buffer.
    pub fn new(network: &Network) -> Self {
        let delays = network.buffered();
        let mean = 0.5 * (delays[0] + delays[1]);
        let shares = if mean > 0.0 { delays.map(|delay| delay / mean) } else { [1.0; 2] };
        Self { shares, period: network.sample_period() }
    }

    /// Both delays of a mean delay (s).
    pub fn delays(&self, mean: f64) -> Result<Delay> {
        Delay::new(self.shares[0] * mean, self.shares[1] * mean)
    }

    /// The round trip (periods) of a mean delay (s).
    pub fn ticks(&self, mean: f64) -> u64 {
        self.shares.iter().map(|share| ticks_of(share * mean, self.period)).sum()
    }

    /// The longest mean delay (s) with at most this round trip (periods): a whole number of periods one way.
    pub fn longest_within(&self, ticks: u64) -> f64 {
        if ticks == u64::MAX {
            return f64::INFINITY;
        }
        let upper = 0.5 * ticks as f64 * self.period;
        let mut longest = 0.0_f64;
        for share in self.shares.into_iter().filter(|&share| share > 0.0) {
            // Rounding up adds less than two periods to the round trip.
            let count = (share * upper / self.period * (1.0 + ROUNDING)).floor();
            for less in 0..3 {
                let mean = (count - f64::from(less)).max(0.0) * self.period / share;
                if self.ticks(mean) <= ticks {
                    longest = longest.max(mean);
                }
            }
        }
        longest
    }
}

/// All intervals of stable one-way delays of one axis under sampled controllers up to `horizon`, s, as `(start, end)`.
///
/// A delay is the mean of both directions, which keep the proportion that they have in `network` behind its playout
/// buffer (equal without any delay). A controller uses a sample from its next tick on, so that each direction counts in whole
/// periods. An interval excludes its start and includes its end; the first also includes a start at 0, and starts at the smallest
/// positive number if every short delay is stable but not none. The `horizon` ends the last one; an interval that goes on
/// for ever has an infinite end.
///
/// # Errors
///
/// [`InvalidInput`] if the stiffness (N/m) is out of range, the network has no sample period or the horizon (s) is not
/// positive.
///
/// # Examples
///
/// ```
/// use telespring::{Delay, DyadAxis};
/// use telespring::verdicts::{Network, sampled_stable_delays};
/// let axis = DyadAxis::new(0.8334, 7.7257, 0.7776, 7.4208)?;
/// let network = Network::new(Delay::each_way(0.1)?, 0.0, 0.0, 0.001, 0.0)?;
/// let stable = sampled_stable_delays(&axis, 71.2, &network, 1.0)?;
/// assert_eq!(stable.len(), 1);
/// assert!((stable[0].1 - 0.165).abs() < 1e-12);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn sampled_stable_delays(
    axis: &DyadAxis,
    stiffness: f64,
    network: &Network,
    horizon: f64,
) -> Result<Vec<(f64, f64)>> {
    if horizon.is_nan() || horizon <= 0.0 {
        return Err(InvalidInput::new(
            "horizon",
            horizon,
            "the horizon must be a positive number of seconds, or infinite",
            "Give the longest one-way delay of interest in s.",
        ));
    }
    let within = stable_round_trips(axis, stiffness, network, horizon)?.delays(network).into_iter();
    Ok(within
        .filter(|&(start, _)| start < horizon)
        .map(|(start, end)| (start, if end.is_finite() { end.min(horizon) } else { end }))
        .collect())
}

/// The stable round trips of a checked sampled axis, for delays up to `horizon` (s).
fn stable_round_trips(
    axis: &DyadAxis,
    stiffness: f64,
    network: &Network,
    horizon: f64,
) -> Result<StableRoundTrips> {
    quantity::STIFFNESS.check("stiffness", stiffness)?;
    if network.sample_period() == 0.0 {
        return Err(InvalidInput::new(
            "network.sample_period",
            0.0,
            "stable delays of sampled controllers need a sample period above 0",
            "Give the period of the controllers, such as 0.001, or use the stable delays of continuous ones.",
        ));
    }
    // One period more: the last round trip may lie between two ticks.
    let longest = (2.0 * horizon.min(LONGEST) / network.sample_period()).ceil() as u64 + 2;
    StableRoundTrips::new(axis, stiffness, network, longest)
}

/// Delays beyond this are not followed, s: far above what a network may have.
const LONGEST: f64 = 1e3;

/// The maximum delay of one axis under sampled controllers, s: every one-way delay up to this one is stable, itself included.
/// Infinite if no constant delay destabilises, 0 if a shorter one is unstable.
///
/// Without delay, two undamped robots with a coupling damper only drift together; any delay stops them.
///
/// Delays are counted as in [`sampled_stable_delays`].
///
/// # Errors
///
/// As [`sampled_stable_delays`].
///
/// # Examples
///
/// ```
/// use telespring::{Delay, DyadAxis};
/// use telespring::verdicts::{Network, sampled_maximum_delay};
/// let axis = DyadAxis::new(0.8334, 7.7257, 0.7776, 7.4208)?;
/// let network = Network::new(Delay::new(0.05, 0.15)?, 0.0, 0.0, 0.001, 0.0)?;
/// assert!((sampled_maximum_delay(&axis, 71.2, &network)? - 0.494 / 3.0).abs() < 1e-12);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn sampled_maximum_delay(axis: &DyadAxis, stiffness: f64, network: &Network) -> Result<f64> {
    let stable = stable_round_trips(axis, stiffness, network, f64::INFINITY)?;
    let first = stable.delays(network).into_iter().next();
    Ok(first
        .filter(|&(start, _)| start == 0.0 || stable.drifts_at_once && start < f64::EPSILON)
        .map_or(0.0, |(_, end)| end))
}
