//! Changes that make the constant delay stable, each proven for every operator of the range.

use super::operators::OperatorBox;
use super::{AxisVerdict, Network, Tier, sampled_range};
use crate::criteria::minimum_damping;
use crate::error::Result;
use crate::quantity;

/// Alternative changes that make the constant delay (tier 4) stable, and with sampled controllers the sampled dyad,
/// for every operator of the range.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Remedies {
    /// A stiffness below this, N/m.
    pub stiffness: Option<f64>,
    /// A mean one-way delay below this, s.
    pub delay: Option<f64>,
    /// More added damping per robot than this, N·s/m.
    pub damping: Option<f64>,
}

/// A damping (N·s/m), added to both robots, above which every operator is stable at a stiffness (N/m) and a one-way
/// delay (s).
fn stabilising_damping(region: &OperatorBox, k: f64, delay: f64) -> Result<f64> {
    if region.is_point() {
        return minimum_damping(&region.axis(&region.middle()), k, delay);
    }
    let family = region.family();
    let c = family.coupling_damping;
    // With bᵢ² + 2 bᵢ c ≥ 2 mᵢ (k + k_h,i) on both sides no delay destabilises.
    let enough = family.sides.iter().fold(0.0_f64, |enough, side| {
        let elastic = k + side.stiffness.1;
        enough.max((2.0 * side.mass.1 * elastic + c * c).sqrt() - c - side.damping.0)
    });
    Ok(if delay == 0.0 || enough == 0.0 {
        0.0
    } else {
        family.last_damping(k, 2.0 * delay, enough * (1.0 + 1e-9)).value
    })
}

/// The remedies at a stiffness `k` (N/m) that is not stable on every axis.
pub(super) fn remedies(
    regions: &[OperatorBox],
    axes: &[AxisVerdict],
    network: &Network,
    k: f64,
) -> Result<Remedies> {
    let is_sampled = network.sample_period() > 0.0;
    let (mut stiffness, mut delay, mut damping) = (f64::INFINITY, f64::INFINITY, Some(0.0_f64));
    for (region, axis) in regions.iter().zip(axes) {
        let bounds = [axis.tiers[Tier::ConstantDelay as usize].stiffness_bound, axis.sampled_stiffness_bound];
        stiffness = bounds.into_iter().flatten().fold(stiffness, f64::min);
        delay = delay.min(axis.maximum_delay);
        // An axis that is stable now may, with more damping, be so in a later stable interval only.
        // A search that does not end leaves the verdicts, and no remedy.
        let continuous = stabilising_damping(region, k, network.buffered_mean()).ok();
        let held =
            if is_sampled { sampled_range::stabilising_damping(region, network, k) } else { Some(0.0) };
        damping = damping
            .zip(continuous)
            .zip(held)
            .map(|((most, continuous), held)| most.max(continuous).max(held));
    }
    if is_sampled {
        let longest = delay.min(network.buffered_mean());
        for region in regions {
            delay = delay.min(sampled_range::stable_delay(region, network, k, longest)?);
        }
    }
    Ok(Remedies {
        stiffness: Some(stiffness).filter(|&bound| bound > 0.0 && bound.is_finite()),
        delay: Some(delay).filter(|&bound| bound > 0.0 && bound.is_finite()),
        damping: damping.filter(|&added| added > 0.0 && added < quantity::DAMPING.maximum()),
    })
}
