//! Whether a whole range of delays or of stiffnesses is stable, also beyond the first limit.
//!
//! A dyad may become stable again at a larger delay or stiffness: an island of stability. A reserve there counts only
//! if nothing between its ends is unstable, which single verdicts cannot tell.

use super::operators::{OperatorBox, OperatorRange};
use super::sampled_delays::DelayPath;
use super::sampled_line::first_crossing_stiffness;
use super::{Network, check_ranges, sampled_spectral_radius, sampled_stable_delays};
use crate::criteria::{is_in_any, stable_delays};
use crate::error::{InvalidInput, Result};
use crate::model::Dyad;
use crate::quantity;

/// True if a dyad is proven to be stable at a stiffness (N/m) for every operator and at every delay between two
/// multiples of the network's, under its controllers.
///
/// # Errors
///
/// As [`verdicts`](super::verdicts()).
pub fn is_stable_over_delays(
    dyad: &Dyad,
    operators: Option<&[OperatorRange; 2]>,
    stiffness: f64,
    network: &Network,
    factors: (f64, f64),
) -> Result<bool> {
    let k = quantity::STIFFNESS.check("stiffness", stiffness)?;
    check_ends("factors", factors)?;
    check_ranges(dyad, operators)?;
    let mean = network.buffered_mean();
    let ends = (factors.0 * mean, factors.1 * mean);
    for index in 0..dyad.axis_names().len() {
        if !is_axis_stable_over_delays(&OperatorBox::new(dyad, operators, index), k, network, ends)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Refuses ends of a range that do not ascend.
fn check_ends(field: &str, (from, to): (f64, f64)) -> Result<()> {
    if 0.0 <= from && from <= to && to.is_finite() {
        return Ok(());
    }
    Err(InvalidInput::new(
        field,
        format!("({from}, {to})"),
        "two finite numbers that are not negative and ascend are required",
        "Write the smaller one first.",
    ))
}

/// The same for one axis and mean delays (s).
fn is_axis_stable_over_delays(
    region: &OperatorBox,
    k: f64,
    network: &Network,
    (from, to): (f64, f64),
) -> Result<bool> {
    let member = region.axis(&region.middle());
    let is_sampled = network.sample_period() > 0.0;
    let holds_both = |intervals: &[(f64, f64)]| {
        intervals.iter().any(|&(start, end)| (start < from || start == 0.0) && to < end)
    };
    if region.is_point() {
        let continuous = holds_both(&stable_delays(&member, k, 2.0 * to + 1.0)?);
        let sampled = || -> Result<bool> {
            let intervals = sampled_stable_delays(&member, k, network, 2.0 * to + 1.0)?;
            // In whole periods, as the controllers count: an end is stable itself, and a start is not.
            let path = DelayPath::new(network);
            Ok(intervals.iter().any(|&(start, end)| {
                (start == 0.0 || path.ticks(start) < path.ticks(from))
                    && (to <= end || path.ticks(to) <= path.ticks(end))
            }))
        };
        return Ok(continuous && (!is_sampled || sampled()?));
    }
    let is_member_stable = is_in_any(&stable_delays(&member, k, 2.0 * from + 1.0)?, from);
    if !is_member_stable || !region.family().excludes_round_trips(k, (2.0 * from, 2.0 * to)) {
        return Ok(false);
    }
    if !is_sampled {
        return Ok(true);
    }
    let path = DelayPath::new(network);
    let h = network.sample_period();
    let ticks = (path.ticks(from), path.ticks(to));
    let trip = (ticks.0 as f64 * h, ticks.1 as f64 * h);
    let at_start = network.with_delay(path.delays(from)?);
    Ok(sampled_spectral_radius(&member, k, &at_start)?.is_stable()
        && region.sampled_family(network).excludes_round_trips(k, trip))
}

/// True if a dyad is proven to be stable over a network for every operator and at every stiffness of a range (N/m),
/// under its controllers.
///
/// # Errors
///
/// As [`verdicts`](super::verdicts()).
pub fn is_stable_over_stiffnesses(
    dyad: &Dyad,
    operators: Option<&[OperatorRange; 2]>,
    stiffnesses: (f64, f64),
    network: &Network,
) -> Result<bool> {
    let from = quantity::STIFFNESS.check("stiffnesses[0]", stiffnesses.0)?;
    let to = quantity::STIFFNESS.check("stiffnesses[1]", stiffnesses.1)?;
    check_ends("stiffnesses", stiffnesses)?;
    check_ranges(dyad, operators)?;
    let delay = network.buffered_mean();
    for index in 0..dyad.axis_names().len() {
        let region = OperatorBox::new(dyad, operators, index);
        let member = region.axis(&region.middle());
        let is_member_stable =
            delay == 0.0 || is_in_any(&stable_delays(&member, from, 2.0 * delay + 1.0)?, delay);
        let is_continuous_stable = is_member_stable
            && if delay == 0.0 {
                region.family().is_stable_without_delay()
            } else {
                region.family().excludes_stiffnesses((from, to), 2.0 * delay)
            };
        if !is_continuous_stable {
            return Ok(false);
        }
        if network.sample_period() > 0.0 {
            let is_free_of_crossings = if region.is_point() {
                first_crossing_stiffness(&member, network, (from, to)) >= to
            } else {
                region.sampled_family(network).excludes_stiffnesses((from, to), network.held_round_trip())
            };
            if !is_free_of_crossings || !sampled_spectral_radius(&member, from, network)?.is_stable() {
                return Ok(false);
            }
        }
    }
    Ok(true)
}
