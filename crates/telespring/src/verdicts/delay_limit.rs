//! The first delay at which a dyad becomes unstable, with the controllers that it has.

use super::operators::{OperatorBox, OperatorPair, OperatorRange};
use super::ranges::Crossing;
use super::sampled_delays::DelayPath;
use super::tightness::is_tight;
use super::{Network, check_ranges, sampled_maximum_delay, sampled_spectral_radius};
use crate::criteria::maximum_delay;
use crate::error::Result;
use crate::model::{Delay, Dyad};
use crate::quantity;

/// The first delay at which a dyad becomes unstable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DelayLimit {
    /// Every shorter mean one-way delay (s) is stable on every axis for every operator; sampled controllers included.
    /// Infinite if no delay destabilises, 0 if none is known to be stable.
    pub delay: f64,
    /// True if this delay itself is stable: a sampled controller sees nothing of a delay but whole periods.
    pub attained: bool,
    /// False if the search over a range of operators was cut off, or may be more than 5 % and a period low.
    pub proven: bool,
    /// The smallest limit found for a single pair of operators, s: no limit over the range is larger.
    pub least_found: f64,
    /// The axis with the limit.
    pub worst_axis: usize,
}

/// The limit of one axis: a delay that holds for all its operators, the least found for one pair, and whether the
/// search ended.
struct AxisLimit {
    delay: f64,
    least_found: f64,
    is_finished: bool,
}

impl AxisLimit {
    /// The limit for one pair of operators.
    fn exact(delay: f64) -> Self {
        Self { delay, least_found: delay, is_finished: true }
    }

    /// The smaller of two limits.
    fn min(self, other: Self) -> Self {
        Self {
            delay: self.delay.min(other.delay),
            least_found: self.least_found.min(other.least_found),
            is_finished: self.is_finished && other.is_finished,
        }
    }
}

/// The operators of a box that are tried one by one: where a search ended, the weakest, the middle, the corners.
fn examples(region: &OperatorBox, found: Option<&[[f64; 3]; 2]>) -> Vec<OperatorPair> {
    let mut examples: Vec<OperatorPair> = found.map(|sides| region.operators_of(sides)).into_iter().collect();
    examples.extend([region.weakest_corner(), region.middle()]);
    examples.extend(region.corners());
    examples
}

/// The limit of one axis under continuous controllers.
fn continuous_limit(region: &OperatorBox, k: f64) -> Result<AxisLimit> {
    if region.is_point() {
        return Ok(AxisLimit::exact(maximum_delay(&region.axis(&region.middle()), k)?));
    }
    let family = region.family();
    if !family.is_stable_without_delay() {
        return Ok(AxisLimit::exact(0.0));
    }
    if family.crossing(k, None) == Crossing::Excluded {
        return Ok(AxisLimit::exact(f64::INFINITY));
    }
    let first = family.first_round_trip(k, f64::INFINITY);
    let mut least_found = f64::INFINITY;
    for at in examples(region, first.sides.as_ref()) {
        least_found = least_found.min(maximum_delay(&region.axis(&at), k)?);
    }
    let delay = (0.5 * first.value).min(least_found);
    Ok(AxisLimit { delay, least_found, is_finished: first.is_finished && is_tight(delay, least_found) })
}

/// Whether the middle of a region is stable under sampled controllers without any delay.
fn is_stable_at_once(region: &OperatorBox, network: &Network, k: f64) -> Result<bool> {
    let immediate = network.with_delay(Delay::each_way(0.0)?);
    Ok(sampled_spectral_radius(&region.axis(&region.middle()), k, &immediate)?.is_stable())
}

/// Whether all of a region is stable under sampled controllers without any delay: its middle is, and no operator in it has a
/// root on the stability boundary.
fn is_all_stable_at_once(region: &OperatorBox, network: &Network, k: f64) -> Result<bool> {
    if !is_stable_at_once(region, network, k)? {
        return Ok(false);
    }
    let immediate = network.with_delay(Delay::each_way(0.0)?);
    Ok(region.is_point()
        || region.sampled_family(network).crossing(k, Some(immediate.held_round_trip()))
            == Crossing::Excluded)
}

/// The limit of one axis under sampled controllers.
///
/// Over a range no root crosses while the round trip grows as a real number, so that all whole numbers of periods have the
/// same count of unstable roots as none at all: at the highest frequency the loop turns, but its gain is below 1.
fn sampled_limit(region: &OperatorBox, network: &Network, k: f64) -> Result<AxisLimit> {
    if region.is_point() {
        return Ok(AxisLimit::exact(sampled_maximum_delay(&region.axis(&region.middle()), k, network)?));
    }
    let h = network.sample_period();
    let family = region.sampled_family(network);
    let is_stable_at_once = is_stable_at_once(region, network, k)?;
    if is_stable_at_once && family.crossing(k, None) == Crossing::Excluded {
        return Ok(AxisLimit::exact(f64::INFINITY));
    }
    let first = family.first_round_trip(k, f64::INFINITY);
    let mut least_found = f64::INFINITY;
    for at in examples(region, first.sides.as_ref()) {
        least_found = least_found.min(sampled_maximum_delay(&region.axis(&at), k, network)?);
    }
    let periods = (first.value / h).ceil() - 1.0;
    let delay = if is_stable_at_once && periods >= 0.0 {
        DelayPath::new(network).longest_within(periods as u64).min(least_found)
    } else {
        0.0
    };
    let is_tight = is_tight(delay, least_found - h);
    Ok(AxisLimit { delay, least_found, is_finished: first.is_finished && is_tight })
}

/// The first delay at which a dyad becomes unstable at a stiffness (N/m), for one pair of operators or over ranges.
///
/// Both delays of the network grow in the proportion that they have behind its playout buffer (equal ones if it has none);
/// the limit is the mean of both. Under sampled controllers it comes from the one-period map: each direction counts
/// in whole periods, rounded up, and all multipliers that leave the unit circle are followed. The continuous dyad must be
/// stable, too. Beyond the limit a dyad may be stable again:
/// [`stable_delays`](crate::criteria::stable_delays), [`sampled_stable_delays`](super::sampled_stable_delays).
///
/// # Errors
///
/// As [`verdicts`](super::verdicts()).
///
/// # Examples
///
/// ```
/// use telespring::{Delay, hman};
/// use telespring::verdicts::{Network, delay_limit};
/// let network = Network::new(Delay::each_way(0.1)?, 0.0, 0.0, 0.001, 0.0)?;
/// let limit = delay_limit(&hman(), None, 71.2, &network)?;
/// assert!(limit.proven && limit.attained && (limit.delay - 0.165).abs() < 1e-12);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn delay_limit(
    dyad: &Dyad,
    operators: Option<&[OperatorRange; 2]>,
    stiffness: f64,
    network: &Network,
) -> Result<DelayLimit> {
    let k = quantity::STIFFNESS.check("stiffness", stiffness)?;
    check_ranges(dyad, operators)?;
    let is_sampled = network.sample_period() > 0.0;
    let mut worst = DelayLimit {
        delay: f64::INFINITY,
        attained: is_sampled,
        proven: true,
        least_found: f64::INFINITY,
        worst_axis: 0,
    };
    for index in 0..dyad.axis_names().len() {
        let region = OperatorBox::new(dyad, operators, index);
        let continuous = continuous_limit(&region, k)?;
        let continuous_end = continuous.delay;
        let axis = if is_sampled { continuous.min(sampled_limit(&region, network, k)?) } else { continuous };
        worst.proven &= axis.is_finished;
        worst.least_found = worst.least_found.min(axis.least_found);
        if axis.delay == f64::INFINITY || axis.delay > worst.delay {
            continue;
        }
        let is_attained = is_sampled
            && axis.delay < continuous_end
            // no delay at all may be too long, too
            && (axis.delay > 0.0 || is_all_stable_at_once(&region, network, k)?);
        if axis.delay == worst.delay {
            worst.attained &= is_attained;
            continue;
        }
        (worst.delay, worst.attained, worst.worst_axis) = (axis.delay, is_attained, index);
    }
    Ok(worst)
}
