//! Tier 1, "any network", over a range of operators.
//!
//! | controllers | handles | rule |
//! |---|---|---|
//! | continuous | any | exact at the weakest corner: largest mass, smallest damping, smallest ground stiffness |
//! | sampled | free, no coupling damper | exact at the weakest corner |
//! | sampled | grounded | a bound on the gain, see [`held_gain`]; at most a few percent low at usual sample periods |
//! | sampled | grounded, one at 0 N/m, with a computing time | none: [`Unavailable::UnprovenOverRange`] |
//! | sampled | free, with a coupling damper | none: [`Unavailable::UnprovenOverRange`] |
//!
//! Continuous: with a = πB/√(4M(k + k_h) − B²) the gain is k/(k + k_h) coth(a/2). It grows with M and falls with
//! B. It falls with k_h, since a/sinh a · (1 + a²/π²) < 2.
//!
//! Sampled, free: with x = B h/M the bound without computing time is (B/h)/(x^(−1/2) + (1 − e^(−x))^(−1/2))²,
//! which falls with M and grows with B. With a computing time it is the largest 1/|G(z)| over E < z < 1, where
//! |G| = ∫ e^(−Br/M) Φ(r) dr/M with a growing Φ > 0: it grows with M and falls with B.

use super::any_network;
use super::gain::{largest_holding, log_gain};
use super::operators::{OperatorBox, OperatorPair};
use super::ranges::{Family, SideRange};
use super::sampled_gain::free_stiffness;
use super::tightness::is_tight;
use super::zero_order_hold::SampledPlant;
use super::{Network, Unavailable};
use crate::model::Side;

/// A bound of tier 1 over a range of operators.
pub(super) struct RangeBound {
    /// A stiffness (N/m) that every operator allows, and whether it is attained; or why there is none.
    pub bound: Result<(f64, bool), Unavailable>,
    /// The bound of the operators `worst` alone.
    pub least_found: Option<f64>,
    /// The operators with the smallest bound known.
    pub worst: OperatorPair,
    /// False if the bound may be more than 5 % low, or none is proven.
    pub is_tight: bool,
}

/// The bound of tier 1 over a range of operators.
pub(super) fn range_bound(region: &OperatorBox, network: &Network) -> RangeBound {
    let worst = region.weakest_corner();
    let damper = region.axis(&worst).coupling_damping;
    if let Some(reason) = any_network::unavailable(damper, region.has_grounded(), network) {
        return RangeBound { bound: Err(reason), least_found: None, worst, is_tight: true };
    }
    let of_pair = |at: &OperatorPair| any_network::stiffness_bound(&region.axis(at), network);
    if region.is_point() || network.sample_period() == 0.0 || damper == 0.0 && !region.has_grounded() {
        let bound = of_pair(&worst);
        return RangeBound {
            bound: Ok((bound.proven, bound.attained)),
            least_found: Some(bound.found),
            worst,
            is_tight: is_tight(bound.proven, bound.found),
        };
    }
    if damper > 0.0 {
        // The worst operator is not known to be a corner.
        return unproven(region, |at| of_pair(at).found);
    }
    let family = region.family();
    // With a computing time it is not proven that a weakly grounded handle keeps the hull.
    if network.computing_time() > 0.0 && family.sides.iter().any(|side| side.stiffness.0 == 0.0) {
        return unproven(region, |at| of_pair(at).found);
    }
    let bound = grounded_stiffness(&family, network);
    RangeBound { bound: Ok((bound, false)), least_found: None, worst, is_tight: true }
}

/// No bound over a range, with the smallest one of its corners.
fn unproven(region: &OperatorBox, bound_at: impl Fn(&OperatorPair) -> f64) -> RangeBound {
    let (worst, least) = region
        .corners()
        .into_iter()
        .map(|at| (at, bound_at(&at)))
        .min_by(|(_, one), (_, other)| one.total_cmp(other))
        .unwrap_or_else(|| (region.weakest_corner(), f64::INFINITY));
    RangeBound {
        bound: Err(Unavailable::UnprovenOverRange),
        least_found: Some(least),
        worst,
        is_tight: false,
    }
}

/// A stiffness up to which no pair of sides of the family amplifies on any network under sampled controllers.
fn grounded_stiffness(family: &Family, network: &Network) -> f64 {
    let free = family.sides.map(|side| {
        let weakest = Side { mass: side.mass.1, damping: side.damping.0, ground_stiffness: 0.0 };
        let plant = SampledPlant::new(&weakest, network.sample_period(), network.computing_time());
        free_stiffness(&[plant, plant], 0.0)
    });
    largest_holding(|k| {
        let [first, second] =
            [0, 1].map(|i| held_gain(&family.sides[i], free[i], network.oldest_own_sample(), k));
        first <= 1.0 && second <= 1.0 || first * second < 1.0
    })
}

/// A bound on the gain of every side of a range under a sampled controller whose own sample is at most `age` old.
///
/// Up to k + k_h = `free`, the bound of the weakest free side, no response overshoots: the ground spring takes
/// no more weight from the own sample than the virtual spring would, so that position and x + v/λ stay weighted means
/// of themselves, the partner's past and 0, and the gain is at most 1. A stiffer operator leaves the continuous gain
/// γ, with the own sample's error at most age · ‖v‖ and ‖v‖ ≤ γ_v (‖u‖ + age ‖v‖): in all γ/(1 − age γ_v).
fn held_gain(side: &SideRange, free: f64, age: f64, stiffness: f64) -> f64 {
    let (mass, damping, ground) = (side.mass, side.damping, side.stiffness);
    let keeps_hull = stiffness + ground.0 <= free;
    if keeps_hull && stiffness + ground.1 <= free {
        return 1.0;
    }
    let least_ground = if keeps_hull { free - stiffness } else { ground.0 };
    // The total variation of the impulse response: its first peak, at most k/B and k/√(MK), and all others, each
    // smaller by e^(−π B/√(4MK − B²)).
    let peak = (stiffness / damping.0).min(stiffness / (mass.0 * (stiffness + least_ground)).sqrt());
    let discriminant = 4.0 * mass.1 * (stiffness + ground.1) - damping.0 * damping.0;
    let decay = if discriminant > 0.0 {
        -(-std::f64::consts::PI * damping.0 / discriminant.sqrt()).exp_m1()
    } else {
        1.0
    };
    let lost = age * 2.0 * peak / decay;
    if lost.is_nan() || lost >= 1.0 {
        return f64::INFINITY;
    }
    let weakest = Side { mass: mass.1, damping: damping.0, ground_stiffness: least_ground };
    let gain = log_gain(&weakest, stiffness).exp() / (1.0 - lost);
    if keeps_hull { gain.max(1.0) } else { gain }
}
