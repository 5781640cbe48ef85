//! Inverse criteria: the maximum stiffness or minimum damping for a delay.

use super::branch_and_bound::{Region, Wanted, crossing_parameters};
use super::critical::critical_stiffness;
use super::crossing_search::{finished, stiffness_crossings, unsearchable};
use super::crossings::all_crossings;
use super::intervals::{is_in_any, is_stable_without_delay, stable_delays, unstable_roots};
use super::lines::DampingLine;
use super::undamped_resonance::{crossing_free_stiffness, undamped_resonances};
use crate::error::Result;
use crate::model::DyadAxis;
use crate::quantity;

/// The maximum stiffness K at a one-way delay (s): every k with 0 < k < K is stable, N/m.
///
/// Infinite without delay, 0 if even a soft spring is unstable. Some dyads become stable again at a larger
/// stiffness, which does not count. K is the smallest stiffness on the curve of crossings, all of which are
/// enclosed; it does not come from a bisection on stability.
///
/// # Errors
///
/// [`InvalidInput`](crate::InvalidInput) if the delay (s) is out of range, or if masses, dampings and stiffnesses differ by so many
/// decades that the search does not end or finds nothing.
///
/// # Examples
///
/// ```
/// use telespring::{criteria::{maximum_delay, maximum_stiffness}, hman};
/// let x = hman().axis(0)?;
/// let stiffness = maximum_stiffness(&x, 0.1)?;
/// assert!((maximum_delay(&x, stiffness)? - 0.1).abs() < 1e-12);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn maximum_stiffness(axis: &DyadAxis, delay: f64) -> Result<f64> {
    quantity::DELAY.check("delay", delay)?;
    if delay == 0.0 {
        return Ok(if is_stable_without_delay(axis) { f64::INFINITY } else { 0.0 });
    }
    let round_trip = 2.0 * delay;
    let critical = critical_stiffness(axis);
    if critical > 0.0 {
        let low = critical * (1.0 - 1e-9);
        return first_crossing_stiffness(axis, low, delay);
    }
    let (resonances, coincident) = undamped_resonances(axis, round_trip);
    if resonances.is_empty() {
        let mut low = soft_stiffness(axis, round_trip);
        if coincident {
            // Both roots move in proportion to k here, so a count of roots still separates them.
            low = axis.sides.iter().fold(f64::INFINITY, |low, side| {
                let frequency = (side.ground_stiffness / side.mass).sqrt();
                low.min(1e-4 * side.ground_stiffness).min(0.1 * side.mass * frequency / round_trip)
            });
        } else if !axis.is_free() && axis.coupling_damping == 0.0 {
            low = low.max(crossing_free_stiffness(axis, round_trip));
        }
        if axis.is_free() && unstable_roots(axis, low, delay) > 0 {
            return Ok(0.0);
        }
        let stiffness = first_crossing_stiffness(axis, low, delay)?;
        // No root crosses in between, so one stiffness represents all.
        return Ok(if unstable_roots(axis, 0.5 * stiffness, delay) > 0 { 0.0 } else { stiffness });
    }

    let soft = resonances.iter().map(|resonance| resonance.valid).fold(f64::INFINITY, f64::min);
    let mut first = resonances
        .iter()
        .filter_map(|resonance| resonance.first_unstable_stiffness(soft))
        .fold(f64::INFINITY, f64::min);
    // All other roots are stable with a soft spring; the search covers the frequencies beside the resonances.
    let bands: Vec<(f64, f64)> = resonances.iter().map(|resonance| resonance.frequency_band(soft)).collect();
    let low = crossing_free_stiffness(axis, round_trip).min(soft);
    let high = soft.min(first);
    if low < high {
        let beside = stiffness_crossings(axis, round_trip, 0.0, (low, high), Wanted::Least, &bands)?;
        first = beside.first().copied().unwrap_or(first).min(first);
    }
    if first.is_finite() { Ok(first) } else { first_crossing_stiffness(axis, soft, delay) }
}

/// The smallest stiffness above `low` at which a root crosses, N/m; a refusal of the axis if none is found.
///
/// With a positive delay every large stiffness is unstable, so that a crossing lies below the first unstable
/// stiffness of a doubling sequence.
fn first_crossing_stiffness(axis: &DyadAxis, low: f64, delay: f64) -> Result<f64> {
    let mut high = 2.0 * low;
    while high > 0.0 && high.is_finite() && unstable_roots(axis, high, delay) == 0 {
        high *= 2.0;
    }
    if high == 0.0 || !high.is_finite() {
        return Err(unsearchable(axis, "found no unstable stiffness"));
    }
    let first = stiffness_crossings(axis, 2.0 * delay, 0.0, (low, high), Wanted::Least, &[])?;
    first.first().copied().ok_or_else(|| unsearchable(axis, "found none below an unstable stiffness"))
}

/// The smallest damping d, N·s/m, added to both robots, such that every larger addition is stable at this
/// stiffness (N/m) and one-way delay (s); 0 if every addition is stable.
///
/// # Errors
///
/// [`InvalidInput`](crate::InvalidInput) if the stiffness or the delay is out of range, or if the search does not end, as for
/// [`maximum_stiffness`].
///
/// # Examples
///
/// ```
/// use telespring::{DyadAxis, criteria::{critical_stiffness, minimum_damping}};
/// // At a very long delay the smallest damping is that of the delay-independent dyad.
/// let axis = DyadAxis::new(1.0, 2.0, 1.0, 2.0)?;
/// let added = minimum_damping(&axis, 50.0, 100.0)?;
/// let damped = DyadAxis::new(1.0, 2.0 + added, 1.0, 2.0 + added)?;
/// assert!((critical_stiffness(&damped) - 50.0).abs() < 0.1);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn minimum_damping(axis: &DyadAxis, stiffness: f64, delay: f64) -> Result<f64> {
    quantity::STIFFNESS.check("stiffness", stiffness)?;
    quantity::DELAY.check("delay", delay)?;
    if delay == 0.0 {
        return Ok(0.0);
    }
    // With bᵢ² + 2 bᵢ c ≥ 2 mᵢ (k + k_h,i) on both sides no delay destabilises.
    let c = axis.coupling_damping;
    let enough = axis.sides.iter().fold(0.0f64, |enough, side| {
        let elastic = stiffness + side.ground_stiffness;
        enough.max((2.0 * side.mass * elastic + c * c).sqrt() - c - side.damping)
    });
    if enough == 0.0 {
        return Ok(0.0);
    }
    let line = DampingLine::new(axis, 2.0 * delay, stiffness);
    // At its limit a dyad has a crossing at no added damping, which rounding would move to either side of 0.
    let least = 1e-9 * enough;
    let region = Region {
        frequency: (0.0, crossing_frequency_bound(axis, stiffness)),
        parameter: (least, enough * (1.0 + 1e-9)),
    };
    if let Some(&last) = finished(axis, crossing_parameters(&line, region, Wanted::Greatest))?.first() {
        return Ok(last);
    }
    Ok(if is_in_any(&stable_delays(axis, stiffness, 2.0 * delay)?, delay) { 0.0 } else { least })
}

/// A stiffness (N/m) far below every change of stability of a dyad whose critical stiffness is 0.
fn soft_stiffness(axis: &DyadAxis, round_trip: f64) -> f64 {
    let [first, second] = &axis.sides;
    let damping = first.damping + second.damping + 2.0 * axis.coupling_damping;
    let by_delay = first.mass.min(second.mass) / (round_trip * round_trip);
    let by_damping = damping * damping / first.mass.max(second.mass);
    1e-9 * if damping > 0.0 { by_delay.min(by_damping) } else { by_delay }
}

/// A frequency above every crossing for all stiffnesses up to `stiffness`, rad/s.
fn crossing_frequency_bound(axis: &DyadAxis, stiffness: f64) -> f64 {
    let squared = if axis.is_free() {
        // Free handles: ω²/k of the highest crossing grows with k, and so does ω.
        all_crossings(axis, stiffness).last().map_or(0.0, |last| last.frequency.powi(2))
    } else {
        0.0
    };
    if squared > 0.0 {
        return squared.sqrt() * (1.0 + 1e-6);
    }
    // From mω² ≥ 2k + k_h on, |P| exceeds |k + cjω|.
    axis.sides
        .iter()
        .map(|side| (2.0 * stiffness + side.ground_stiffness) / side.mass)
        .fold(0.0, f64::max)
        .sqrt()
}
