//! The dyad under sampled controllers over a range of operators.

use super::operators::{OperatorBox, OperatorPair};
use super::ranges::{CertifiedBound, Crossing, Family};
use super::sampled::SOFTEST;
use super::sampled_roots::SampledSpectrum;
use super::tightness::LOOSE;
use super::{Network, bounded_delay, sampled, sampled_spectral_radius};
use crate::error::Result;
use crate::model::Delay;
use crate::quantity;

/// The sampled dyad on one axis.
pub(super) struct SampledAxis {
    /// The slowest multiplier of the operators examined.
    pub spectrum: SampledSpectrum,
    /// The largest stiffness (N/m), up to the bound of tier 4, that is stable for every operator.
    pub stiffness_bound: f64,
    /// True if the given stiffness is proven to be stable for every operator.
    pub is_stable: bool,
    /// False if the search over the range was cut off, or the bound may be more than 5 % low.
    pub is_proven: bool,
}

/// A stiffness (N/m) up to which every member is stable, from the rule of tier 2 with the samples' ages at this
/// constant delay; 0 if that rule does not apply.
fn soft_stiffness(family: &Family, network: &Network) -> f64 {
    if family.coupling_damping > 0.0 {
        return 0.0;
    }
    let own = network.oldest_own_sample();
    let ages = network.whole_ticks().map(|ticks| ticks as f64 * network.sample_period() + own);
    bounded_delay::stiffness_bound(family.sides.map(|side| side.damping.0), ages, own)
}

/// Just beyond the bound of one pair of operators, where even a narrow window is unstable.
const BEYOND: f64 = 1.0001;

/// With a coupling damper the rule of tier 2 is missing: the search starts at the softest spring, or at one stiffer by
/// this factor if it cannot decide there.
const STIFFER: f64 = 100.0;
/// The largest start, N/m: robots are not coupled by softer springs.
const LARGEST_START: f64 = 0.1;

/// The first stiffness at which some member is unstable.
struct FirstUnstable {
    /// The bound; 0 if none is known.
    bound: CertifiedBound,
    /// Softer springs than this (N/m) are not examined.
    start: f64,
}

/// The first stiffness (N/m) up to `limit` at which some member is unstable under sampled controllers.
fn first_unstable_stiffness(
    region: &OperatorBox,
    family: &Family,
    network: &Network,
    limit: f64,
) -> Result<FirstUnstable> {
    if family.coupling_damping > 0.0 {
        return first_unstable_with_damper(region, family, network, limit);
    }
    let start = soft_stiffness(family, network);
    let bound = if start == 0.0 {
        CertifiedBound { value: 0.0, sides: None, is_finished: false }
    } else if start >= limit {
        CertifiedBound { value: limit, sides: None, is_finished: true }
    } else {
        family.first_stiffness(Some(network.held_round_trip()), start, limit)
    };
    Ok(FirstUnstable { bound, start: 0.0 })
}

/// The same with a coupling damper: softer springs than the start are not examined.
fn first_unstable_with_damper(
    region: &OperatorBox,
    family: &Family,
    network: &Network,
    limit: f64,
) -> Result<FirstUnstable> {
    let unknown = CertifiedBound { value: 0.0, sides: None, is_finished: false };
    let round_trip = Some(network.held_round_trip());
    let mut start = (SOFTEST * limit).clamp(quantity::STIFFNESS.minimum(), LARGEST_START);
    while start < limit {
        for at in region.corners().into_iter().chain([region.middle()]) {
            if !sampled_spectral_radius(&region.axis(&at), start, network)?.is_stable() {
                return Ok(FirstUnstable { bound: unknown, start });
            }
        }
        // Some members are stable, and no member has a root on the axis: all are stable.
        if family.crossing(start, round_trip) == Crossing::Excluded {
            let bound = family.first_stiffness(round_trip, start, limit);
            if bound.value > start {
                return Ok(FirstUnstable { bound, start });
            }
        }
        if start == LARGEST_START {
            break;
        }
        start = (STIFFER * start).min(LARGEST_START);
    }
    Ok(FirstUnstable { bound: unknown, start })
}

/// The sampled dyad on one axis at a stiffness `k` (N/m). `limit` is the bound of tier 4, with the operators
/// `worst`.
pub(super) fn sampled_axis(
    region: &OperatorBox,
    worst: &OperatorPair,
    limit: f64,
    network: &Network,
    k: f64,
) -> Result<SampledAxis> {
    let nominal = region.axis(worst);
    let spectrum = sampled_spectral_radius(&nominal, k, network)?;
    if region.is_point() {
        let stiffness_bound = sampled::stiffness_bound(&nominal, network, limit);
        // A search that does not end leaves a bound with stable springs beyond.
        let is_unstable = |k: f64| {
            quantity::STIFFNESS.check("stiffness", k).is_err()
                || sampled_spectral_radius(&nominal, k, network).is_ok_and(|found| !found.is_stable())
        };
        let is_proven = [BEYOND, LOOSE]
            .into_iter()
            .any(|factor| factor * stiffness_bound >= limit || is_unstable(factor * stiffness_bound));
        return Ok(SampledAxis { spectrum, stiffness_bound, is_stable: spectrum.is_stable(), is_proven });
    }
    let family = region.sampled_family(network);
    let FirstUnstable { bound: certified, start } =
        first_unstable_stiffness(region, &family, network, limit)?;
    let mut spectrum = spectrum;
    let found = certified.sides.as_ref().map(|sides| region.operators_of(sides));
    let above = LOOSE * certified.value;
    // The aliases of a slow hold may keep the search from seeing how far it could go.
    let mut is_tight = above >= limit;
    for at in found.into_iter().chain([*worst, region.weakest_corner(), region.middle()]) {
        let axis = region.axis(&at);
        let other = sampled_spectral_radius(&axis, k, network)?;
        if other.radius > spectrum.radius {
            spectrum = other;
        }
        is_tight = is_tight
            || quantity::STIFFNESS.check("stiffness", above).is_ok()
                && !sampled_spectral_radius(&axis, above, network)?.is_stable();
    }
    let verdict = if !spectrum.is_stable() {
        Some(false)
    } else if start <= k && k < certified.value {
        Some(true)
    } else {
        match family.crossing(k, Some(network.held_round_trip())) {
            Crossing::Excluded => Some(true),
            Crossing::Found => Some(false),
            Crossing::Unresolved => None,
        }
    };
    Ok(SampledAxis {
        spectrum,
        stiffness_bound: certified.value,
        is_stable: verdict == Some(true),
        is_proven: verdict.is_some() && certified.is_finished && is_tight,
    })
}

/// A mean one-way delay (s) below which every member is stable under sampled controllers, whatever the rounding up
/// to whole periods makes of the delays of both directions.
///
/// No root crosses while the round trip grows as a real number, so that all whole numbers of periods have the same
/// count of unstable roots as none at all: at the highest frequency the loop turns, but its gain is below 1.
pub(super) fn stable_delay(region: &OperatorBox, network: &Network, k: f64, limit: f64) -> Result<f64> {
    let h = network.sample_period();
    let immediate = Network::new(Delay::each_way(0.0)?, 0.0, 0.0, h, network.computing_time())?;
    if !sampled_spectral_radius(&region.axis(&region.middle()), k, &immediate)?.is_stable() {
        return Ok(0.0);
    }
    let first = region.sampled_family(network).first_round_trip(k, 2.0 * limit + 2.0 * h);
    let periods = (first.value / h).ceil() - 1.0;
    // Two directions round up separately: together by less than two periods.
    Ok((0.5 * h * (periods - 1.0)).clamp(0.0, limit))
}

/// A damping (N·s/m), added to both robots, above which every member is stable under sampled controllers; `None` if
/// no rule gives one.
pub(super) fn stabilising_damping(region: &OperatorBox, network: &Network, k: f64) -> Option<f64> {
    let family = region.sampled_family(network);
    if family.coupling_damping > 0.0 {
        return None;
    }
    // With this much damping the rule of tier 2 holds on both sides.
    let own = network.oldest_own_sample();
    let oldest = 0.5 * network.held_round_trip() + 2.0 * own;
    let least = family.sides[0].damping.0.min(family.sides[1].damping.0);
    let enough = (k * oldest * (1.0 + 1e-9) - least).max(0.0);
    Some(if enough == 0.0 { 0.0 } else { family.last_damping(k, network.held_round_trip(), enough).value })
}
