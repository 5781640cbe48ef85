//! Stable intervals of the constant delay.

use super::crossings::{Crossing, all_crossings};
use crate::error::{InvalidInput, Result};
use crate::model::DyadAxis;
use crate::quantity;

/// The maximum delay δ_m, s: every shorter one-way delay above 0 is stable. Infinite if no constant delay
/// destabilises, 0 if every short delay is unstable.
///
/// Without delay, a dyad that lacks damping may only be at the limit of stability: two undamped robots with a
/// coupling damper drift together at a constant speed, which any delay stops. If the delays of both directions
/// differ, the maximum bounds their mean. It replaces the paper's Eq. 6.
///
/// # Errors
///
/// [`InvalidInput`] if the stiffness (N/m) is out of range.
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
    let crossings = all_crossings(axis, stiffness);
    let ends = crossings.iter().map(|crossing| {
        // A pair that leaves the axis to the left as the delay starts was not unstable; it comes back later.
        let starts_stable = crossing.delay == 0.0 && crossing.direction < 0;
        if starts_stable { crossing.period() } else { crossing.delay }
    });
    Ok(ends.fold(f64::INFINITY, f64::min))
}

/// All intervals of stable one-way delays from 0 to `horizon`, s, as `(start, end)`.
///
/// Intervals are open, except for a start at 0. A dyad that is stable at every short delay but not without
/// delay, for lack of damping, starts at the smallest positive number. A delay at which a root only touches
/// the imaginary axis ends one interval and starts the next. The `horizon` may be infinite: beyond some delay a dyad
/// is always or never stable. A crossing is followed through a million periods; the list ends there, and no longer
/// delay counts as stable.
///
/// # Errors
///
/// [`InvalidInput`] if the stiffness (N/m) is out of range or the horizon (s) is not positive.
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
pub(super) fn stable_delays_within(axis: &DyadAxis, crossings: &[Crossing], horizon: f64) -> Vec<(f64, f64)> {
    let mut stable = Vec::new();
    let mut start = if is_stable_without_delay(axis) { 0.0 } else { f64::MIN_POSITIVE };
    let last = horizon.min(permanent_instability_delay(crossings));
    let mut unstable = 0;
    let mut turns = [0u32; 4];
    loop {
        let next = crossings
            .iter()
            .zip(&mut turns)
            .map(|(crossing, turn)| (crossing.delay + f64::from(*turn) * crossing.period(), crossing, turn))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let (delay, crossing, turn) = match next {
            Some(event) if event.0 < last && *event.2 < MAX_TURNS => event,
            next => {
                // What follows a crossing that is not followed does not count as stable.
                let end = next.map_or(last, |event| event.0.min(last));
                if unstable == 0 && start < end {
                    stable.push((start, end));
                }
                return stable;
            }
        };
        *turn += 1;
        if unstable == 0 && delay > start {
            stable.push((start, delay));
        }
        unstable += unstable_pair_change(crossing, delay);
        start = start.max(delay);
    }
}

/// The change in the number of unstable pairs at a crossing. A pair on the axis without delay was not
/// unstable before, so its return changes nothing.
fn unstable_pair_change(crossing: &Crossing, delay: f64) -> i32 {
    i32::from(crossing.direction).max(if delay == 0.0 { 0 } else { -1 })
}

/// The maximum number of recurrences followed if no delay ends the search.
const MAX_TURNS: u32 = 1_000_000;

/// A delay beyond which some root is always unstable, s; infinite if there is none.
///
/// Pairs leave once per period of a leaving crossing and return once per period of a returning one. The
/// highest frequency leaves and the directions alternate, so that leaving prevails.
fn permanent_instability_delay(crossings: &[Crossing]) -> f64 {
    let net: f64 = crossings.iter().map(|c| f64::from(c.direction) * c.frequency).sum();
    if net <= 0.0 {
        return f64::INFINITY;
    }
    // A series has crossed ω(δ − δ₀)/π times, or once more.
    let offset: f64 = crossings
        .iter()
        .map(|c| {
            let lag = f64::from(c.direction) * c.frequency * c.delay;
            lag + if c.direction < 0 { std::f64::consts::PI } else { 0.0 }
        })
        .sum();
    (offset + std::f64::consts::PI) / net
}

/// Counts, from the stable intervals, the roots with positive real part at a one-way delay (s), without the
/// rigid-body root.
///
/// # Errors
///
/// [`InvalidInput`] if the stiffness (N/m) or the delay (s) is out of range.
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

/// The number of unstable roots of an axis whose stiffness and delay have been checked.
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

/// Whether the undelayed dyad is stable. Its coupling is passive, so no root lies in the open right
/// half-plane. A root on the imaginary axis needs an undamped motion: one damped side excludes it, since
/// the spring carries every motion there; with two undamped sides and a coupling damper, both must move
/// together.
pub(super) fn is_stable_without_delay(axis: &DyadAxis) -> bool {
    let [first, second] = &axis.sides;
    let damped = first.damping > 0.0 || second.damping > 0.0;
    let moves_as_one = first.ground_stiffness * second.mass == second.ground_stiffness * first.mass;
    damped || axis.coupling_damping > 0.0 && !moves_as_one
}

/// The stability of every pair of stiffness and one-way delay, row by row, one row per stiffness.
///
/// # Errors
///
/// [`InvalidInput`] if a stiffness (N/m) or a delay (s) is out of range.
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
        let crossings = all_crossings(axis, k);
        let intervals = stable_delays_within(axis, &crossings, longest + 1.0);
        stable.extend(delay.iter().map(|&delay| is_in_any(&intervals, delay)));
    }
    Ok(stable)
}

/// Whether a delay lies in one of the intervals of stable delays.
pub(crate) fn is_in_any(intervals: &[(f64, f64)], delay: f64) -> bool {
    intervals.iter().any(|&(start, end)| delay < end && (delay > start || delay == 0.0 && start == 0.0))
}

/// The intervals that two lists of stable intervals have in common; both ascend, and so does the result.
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
