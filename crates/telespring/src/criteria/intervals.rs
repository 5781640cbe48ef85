//! Which constant delays are stable.

use super::crossings::{Crossing, all_crossings};
use crate::error::{InvalidInput, Result};
use crate::model::DyadAxis;
use crate::quantity;

/// The maximum delay δ_m, s: every shorter one-way delay is stable; infinite where no constant delay
/// destabilises, and 0 where the undelayed dyad is not stable.
///
/// Where the delays of both ways differ it bounds their mean. Replaces the paper's Eq. 6.
///
/// # Errors
///
/// [`InvalidInput`] where the stiffness (N/m) is not in range.
///
/// # Examples
///
/// ```
/// use telespring::{criteria::maximum_delay, hman};
/// let x = hman().axis(0)?;
/// let delay = maximum_delay(&x, 2.0 * 35.615988)?;
/// assert!((delay - 0.16718632).abs() < 1e-7);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn maximum_delay(axis: &DyadAxis, stiffness: f64) -> Result<f64> {
    quantity::STIFFNESS.check("stiffness", stiffness)?;
    if !is_stable_without_delay(axis) {
        return Ok(0.0);
    }
    let found = all_crossings(axis, stiffness);
    Ok(found.iter().fold(f64::INFINITY, |first, crossing| first.min(crossing.delay)))
}

/// All intervals of stable one-way delays from 0 to `horizon`, s, as `(start, end)`.
///
/// An interval holds neither its end nor its start, except a start at 0 (a dyad that is stable at
/// every short delay but not without delay, for lack of damping, starts at the smallest positive
/// number). A delay at which a root only touches the imaginary axis ends one interval and starts the
/// next; of such touches, which never end, the first million are listed. The `horizon` may be
/// infinite: above some delay a dyad is always or never stable.
///
/// # Errors
///
/// [`InvalidInput`] where the stiffness (N/m) is not in range or the horizon (s) is not positive.
///
/// # Examples
///
/// ```
/// use telespring::{DyadAxis, criteria::stable_delays};
/// let axis = DyadAxis::new(0.97670822, 2.15372614, 0.30379312, 4.59594729)?;
/// let stable = stable_delays(&axis, 9.174736188, 10.0)?;
/// assert_eq!(stable.len(), 2);
/// assert!((stable[1].0 - 1.7738).abs() < 1e-4 && (stable[1].1 - 2.1128).abs() < 1e-4);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn stable_delays(axis: &DyadAxis, stiffness: f64, horizon: f64) -> Result<Vec<(f64, f64)>> {
    quantity::STIFFNESS.check("stiffness", stiffness)?;
    if horizon.is_nan() || horizon <= 0.0 {
        return Err(InvalidInput::new(
            "horizon",
            horizon,
            "the horizon must be a positive number of seconds, or infinite",
            "Give the longest one-way delay of interest in s.",
        ));
    }
    Ok(stable_delays_within(axis, &all_crossings(axis, stiffness), horizon))
}

/// The stable intervals up to the horizon, from the crossings.
pub(super) fn stable_delays_within(axis: &DyadAxis, found: &[Crossing], horizon: f64) -> Vec<(f64, f64)> {
    let mut stable = Vec::new();
    let mut start = if is_stable_without_delay(axis) { 0.0 } else { f64::MIN_POSITIVE };
    let last = horizon.min(never_stable_after(found));
    let mut unstable = 0;
    let mut turns = [0u32; 4];
    loop {
        let next = found
            .iter()
            .zip(&mut turns)
            .map(|(crossing, turn)| (crossing.delay + f64::from(*turn) * crossing.period(), crossing, turn))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let (delay, crossing, turn) = match next {
            Some(event) if event.0 < last && *event.2 < MAX_TURNS => event,
            _ => {
                if unstable == 0 && start < last {
                    stable.push((start, last));
                }
                return stable;
            }
        };
        *turn += 1;
        if unstable == 0 && delay > start {
            stable.push((start, delay));
        }
        unstable += pairs_moved(crossing, delay);
        start = start.max(delay);
    }
}

/// How many pairs enter the unstable half-plane: one that is on the axis without delay was not
/// unstable before, and its return frees nothing.
fn pairs_moved(crossing: &Crossing, delay: f64) -> i32 {
    i32::from(crossing.direction).max(if delay == 0.0 { 0 } else { -1 })
}

/// How many recurrences of one crossing are followed where no delay ends the search.
const MAX_TURNS: u32 = 1_000_000;

/// A delay after which some root is always unstable, s; infinite where there is none.
///
/// Pairs leave once per period of a leaving crossing and return once per period of a returning one;
/// the highest frequency leaves, and the directions alternate, so that leaving wins in the long run.
fn never_stable_after(found: &[Crossing]) -> f64 {
    let net: f64 = found.iter().map(|c| f64::from(c.direction) * c.frequency).sum();
    if net <= 0.0 {
        return f64::INFINITY;
    }
    // A series has crossed between ω(δ − δ₀)/π and one time more.
    let offset: f64 = found
        .iter()
        .map(|c| {
            let lag = f64::from(c.direction) * c.frequency * c.delay;
            lag + if c.direction < 0 { std::f64::consts::PI } else { 0.0 }
        })
        .sum();
    (offset + std::f64::consts::PI) / net
}

/// The number of characteristic roots with positive real part at a one-way delay, s (the rigid-body
/// root not counted).
///
/// # Errors
///
/// [`InvalidInput`] where the stiffness (N/m) or the delay (s) is not in range.
///
/// # Examples
///
/// ```
/// use telespring::{criteria::unstable_root_count, hman};
/// let x = hman().axis(0)?;
/// assert_eq!(unstable_root_count(&x, 71.2, 0.167)?, 0);
/// assert_eq!(unstable_root_count(&x, 71.2, 0.334)?, 2);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn unstable_root_count(axis: &DyadAxis, stiffness: f64, delay: f64) -> Result<u32> {
    quantity::STIFFNESS.check("stiffness", stiffness)?;
    quantity::DELAY.check("delay", delay)?;
    Ok(unstable_roots(axis, stiffness, delay))
}

pub(super) fn unstable_roots(axis: &DyadAxis, stiffness: f64, delay: f64) -> u32 {
    let pairs: f64 = all_crossings(axis, stiffness)
        .iter()
        .map(|crossing| {
            let times = ((delay - crossing.delay) / crossing.period()).ceil().max(0.0);
            let uncounted = if crossing.delay == 0.0 && crossing.direction < 0 { 1.0 } else { 0.0 };
            f64::from(crossing.direction) * (times - uncounted).max(0.0)
        })
        .sum();
    2 * pairs.max(0.0) as u32
}

/// Whether the undelayed dyad is stable. Its coupling is passive, so that no root lies in the open
/// right half-plane, and one on the imaginary axis needs a motion that meets no damping: with one
/// damped side there is none, because the spring carries every motion to it; with undamped sides and a
/// damper, both must move as one.
pub(super) fn is_stable_without_delay(axis: &DyadAxis) -> bool {
    let [first, second] = &axis.sides;
    let damped = first.damping > 0.0 || second.damping > 0.0;
    let moves_as_one = first.ground_stiffness * second.mass == second.ground_stiffness * first.mass;
    damped || axis.coupling_damping > 0.0 && !moves_as_one
}

/// For every stiffness and every one-way delay: is it stable? Row by row, one row per stiffness.
///
/// # Errors
///
/// [`InvalidInput`] where a stiffness (N/m) or a delay (s) is not in range.
///
/// # Examples
///
/// ```
/// use telespring::{criteria::stability_map, hman};
/// let x = hman().axis(0)?;
/// assert_eq!(stability_map(&x, &[30.0, 71.2], &[0.1, 0.2])?, [true, true, true, false]);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn stability_map(axis: &DyadAxis, stiffness: &[f64], delay: &[f64]) -> Result<Vec<bool>> {
    for (i, &value) in stiffness.iter().enumerate() {
        quantity::STIFFNESS.check(&format!("stiffness[{i}]"), value)?;
    }
    for (i, &value) in delay.iter().enumerate() {
        quantity::DELAY.check(&format!("delay[{i}]"), value)?;
    }
    let longest = delay.iter().fold(0.0f64, |longest, &value| longest.max(value));
    let mut stable = Vec::with_capacity(stiffness.len() * delay.len());
    for &k in stiffness {
        let found = all_crossings(axis, k);
        let intervals = stable_delays_within(axis, &found, longest + 1.0);
        stable.extend(delay.iter().map(|&delay| is_in_any(&intervals, delay)));
    }
    Ok(stable)
}

/// Whether a delay lies inside one of the stable intervals.
pub(crate) fn is_in_any(intervals: &[(f64, f64)], delay: f64) -> bool {
    intervals.iter().any(|&(start, end)| delay < end && (delay > start || delay == 0.0 && start == 0.0))
}

/// The intervals that two lists of intervals have in common; both ascend, and so does the result.
///
/// # Examples
///
/// ```
/// use telespring::criteria::intersection;
/// assert_eq!(intersection(&[(0.0, 2.0), (3.0, 5.0)], &[(1.0, 4.0)]), [(1.0, 2.0), (3.0, 4.0)]);
/// ```
pub fn intersection(first: &[(f64, f64)], second: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let (mut i, mut j) = (0, 0);
    let mut common = Vec::new();
    while let (Some(a), Some(b)) = (first.get(i), second.get(j)) {
        let (start, end) = (a.0.max(b.0), a.1.min(b.1));
        if start < end {
            common.push((start, end));
        }
        if a.1 < b.1 { i += 1 } else { j += 1 }
    }
    common
}
