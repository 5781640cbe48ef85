//! Tier 1, "any network", over a range of operators.
//!
//! | controllers | handles | rule |
//! |---|---|---|
//! | continuous | any | exact at the weakest corner: largest mass, smallest damping, smallest ground stiffness |
//! | sampled | free, no coupling damper | exact at the weakest corner |
//! | sampled | grounded | a bound on the gain, see [`held_gain`]; at most a few percent low at usual sample periods |
//! | sampled | free, with a coupling damper | the corners are examined: not proven |
//!
//! Continuous: with a = πB/√(4M(k + k_h) − B²) the gain is k/(k + k_h) coth(a/2). It grows with M and falls with
//! B. It falls with k_h, since a/sinh a · (1 + a²/π²) < 2.
//!
//! Sampled, free: with x = B h/M the bound without computing time is (B/h)/(x^(−1/2) + (1 − e^(−x))^(−1/2))²,
//! which falls with M and grows with B. With a computing time it is the largest 1/|G(z)| over E < z < 1, where
//! |G| = ∫ e^(−Br/M) Φ(r) dr/M with a growing Φ > 0: it grows with M and falls with B.

use super::Network;
use super::any_network;
use super::gain::{largest_holding, log_gain};
use super::operators::{OperatorBox, OperatorPair};
use super::ranges::{Family, SideRange};
use super::sampled_gain::free_stiffness;
use super::zero_order_hold::SampledPlant;
use crate::model::Side;

/// A bound counts as tight if the rule fails at this multiple of it.
const LOOSE: f64 = 1.05;

/// A bound of tier 1 over a range of operators.
pub(super) struct RangeBound {
    /// The largest stiffness, N/m, and whether it is attained; `None` if there is no rule.
    pub bound: Option<(f64, bool)>,
    /// The bound of the operators `worst` alone.
    pub least_found: Option<f64>,
    /// The operators with the smallest bound known.
    pub worst: OperatorPair,
    /// True if the bound holds for every operator.
    pub is_proven: bool,
}

/// The bound of tier 1 over a range of operators.
pub(super) fn range_bound(region: &OperatorBox, network: &Network) -> RangeBound {
    let worst = region.weakest_corner();
    let axis = region.axis(&worst);
    let exact = |is_proven: bool, worst: OperatorPair| {
        let bound = any_network::stiffness_bound(&region.axis(&worst), network);
        RangeBound {
            bound: bound.map(|bound| (bound.proven, bound.attained)),
            least_found: bound.map(|bound| bound.found),
            worst,
            // A proof that ends early says so.
            is_proven: is_proven && bound.is_none_or(|bound| LOOSE * bound.proven >= bound.found),
        }
    };
    if axis.coupling_damping > 0.0 && region.has_grounded() {
        return RangeBound { bound: None, least_found: None, worst, is_proven: true };
    }
    if region.is_point() || network.sample_period() == 0.0 {
        return exact(true, worst);
    }
    if axis.coupling_damping > 0.0 {
        let bound = |at: &OperatorPair| {
            any_network::stiffness_bound(&region.axis(at), network)
                .map_or(f64::INFINITY, |bound| bound.proven)
        };
        let corners = region.corners();
        let least = corners.into_iter().min_by(|a, b| bound(a).total_cmp(&bound(b))).unwrap_or(worst);
        return exact(false, least);
    }
    if !region.has_grounded() {
        return exact(true, worst);
    }
    let family = region.family();
    let bound = grounded_stiffness(&family, network);
    // With a computing time it is not proven that a weakly grounded handle keeps the hull.
    let is_proven = network.computing_time() == 0.0 || family.sides.iter().all(|side| side.stiffness.0 > 0.0);
    RangeBound { bound: Some((bound, false)), least_found: None, worst, is_proven }
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
