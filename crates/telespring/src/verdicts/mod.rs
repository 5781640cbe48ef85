//! The five verdicts on a dyad over a network, next to the paper's verdict.
//!
//! | tier | what the network may do | rule |
//! |---|---|---|
//! | 1 [`Tier::AnyNetwork`] | anything, with bounded gaps | each side alone does not amplify |
//! | 2 [`Tier::BoundedVaryingDelay`] | anything that keeps the age of every sample below a bound | Lyapunov–Krasovskii |
//! | 5 [`Tier::AgeInRange`] | anything that keeps the ages in a range, played in order | a scaled small gain around the mean age |
//! | 3 [`Tier::AnyConstantDelay`] | one constant delay, however long | no root crosses for any delay |
//! | 4 [`Tier::ConstantDelay`] | one known constant delay | the delay lies in a stable interval |
//!
//! The tiers are not nested. The allowed stiffness is the largest bound over the tiers whose assumption the
//! network meets.

mod age_range;
mod any_network;
mod any_network_range;
mod axis_tiers;
mod bounded_delay;
mod contour;
mod delay_limit;
mod gain;
mod islands;
mod network;
mod operators;
mod paper;
mod ranges;
mod remedies;
mod sampled;
mod sampled_characteristic;
mod sampled_crossings;
mod sampled_delays;
mod sampled_gain;
mod sampled_line;
mod sampled_range;
mod sampled_roots;
mod tightness;
mod zero_order_hold;

pub use age_range::{AgeRange, AgeRangeBound, age_range_stiffness};
pub use axis_tiers::AxisTier;
pub use delay_limit::{DelayLimit, delay_limit};
pub use islands::{is_stable_over_delays, is_stable_over_stiffnesses};
pub use network::{DelayBudget, Network};
pub use operators::{OperatorPoint, OperatorRange};
pub use paper::PaperVerdict;
pub use remedies::Remedies;
pub use sampled::sampled_spectral_radius;
pub use sampled_delays::{sampled_maximum_delay, sampled_stable_delays};
pub use sampled_roots::{SampledCertificate, SampledSpectrum};

use operators::OperatorBox;

use crate::error::{InvalidInput, Result};
use crate::model::Dyad;
use crate::quantity;

/// A tier: one of the five verdicts, named by what the network may do, the strongest guarantee first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Tier {
    /// 1: any behaviour, with bounded gaps.
    AnyNetwork,
    /// 2: any variation, jumps, losses with hold and reordering; no sample older than a bound.
    BoundedVaryingDelay,
    /// 5: any variation of the age within a range, jumps and losses with hold included; no sample is played after a newer
    /// one.
    AgeInRange,
    /// 3: any constant delay.
    AnyConstantDelay,
    /// 4: one known constant delay.
    ConstantDelay,
}

impl Tier {
    /// All five, the strongest guarantee first.
    pub const ALL: [Self; 5] = [
        Self::AnyNetwork,
        Self::BoundedVaryingDelay,
        Self::AgeInRange,
        Self::AnyConstantDelay,
        Self::ConstantDelay,
    ];

    /// The number of the tier, 1 to 5.
    pub fn number(self) -> u8 {
        match self {
            Self::AnyNetwork => 1,
            Self::BoundedVaryingDelay => 2,
            Self::AnyConstantDelay => 3,
            Self::ConstantDelay => 4,
            Self::AgeInRange => 5,
        }
    }

    /// The name of the tier in text and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::AnyNetwork => "any network",
            Self::BoundedVaryingDelay => "bounded varying delay",
            Self::AgeInRange => "age in a range",
            Self::AnyConstantDelay => "any constant delay",
            Self::ConstantDelay => "constant delay",
        }
    }
}

/// Whether the network meets the assumption of a tier.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Assumption {
    /// It does.
    Met,
    /// It does behind a playout buffer that holds every packet until these one-way delays (s, forward and
    /// backward) have passed, which makes the delay constant.
    MetBehindPlayoutBuffer {
        /// Delay plus jitter plus longest gap, per direction.
        delay: [f64; 2],
    },
}

/// Why a tier has no bound for a dyad.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unavailable {
    /// Tier 1 with a coupling damper and a grounded operator.
    CouplingDampingWithGroundedOperator,
    /// Tier 1 with a coupling damper and a computing time.
    CouplingDampingWithComputingTime,
    /// Tier 2 with a coupling damper.
    CouplingDamping,
    /// Tier 5 of sampled controllers with a coupling damper.
    CouplingDampingWithSampledControllers,
    /// Tier 1 of sampled controllers over a range of operators: free ones with a coupling damper, or, with a computing
    /// time, grounded ones some of which may be free. Single pairs have a bound, but the worst pair is not known.
    UnprovenOverRange,
}

/// The margin of a stiffness to a bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StiffnessMargin {
    /// Bound divided by stiffness; above 1 is inside.
    pub ratio: f64,
    /// Bound minus stiffness, N/m.
    pub difference: f64,
}

/// The verdict of one tier on the whole dyad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// The tier.
    pub tier: Tier,
    /// The stiffness bound (N/m) of the tier; every smaller stiffness satisfies it. Infinite if there is no
    /// limit, `None` if the tier is unavailable.
    pub stiffness_bound: Option<f64>,
    /// True if the bound itself is allowed.
    pub attained: bool,
    /// True if the given stiffness is proven to satisfy the rule on every axis for every operator of the range. A
    /// constant delay (tier 4) may be stable above the bound, in a later stable interval.
    pub satisfied: bool,
    /// False if a search over the range of operators was cut off, or the bound may be more than 5 % below the truth or
    /// is not known. A bound that is given holds all the same.
    pub proven: bool,
    /// The smallest bound found for a single pair of operators, N/m: no bound over the range is larger.
    pub least_found: Option<f64>,
    /// The margin of the given stiffness to the bound.
    pub margin: Option<StiffnessMargin>,
    /// The axis with the smallest bound.
    pub worst_axis: Option<usize>,
    /// The operators on that axis whose own bound is `least_found`.
    pub worst_operators: Option<[OperatorPoint; 2]>,
    /// Whether the network meets the assumption of the tier.
    pub assumption: Assumption,
    /// Why the tier is unavailable, if it is.
    pub unavailable: Option<Unavailable>,
    /// The smallest and largest age (s) of the partner samples in use, forward and backward; of [`Tier::AgeInRange`] only.
    pub ages: Option<[[f64; 2]; 2]>,
    /// The lowest stiffness (N/m) at which an attack was seen to make the motion grow, if one was searched and found:
    /// see [`Verdicts::with_attack`].
    pub attack: Option<f64>,
}

/// The allowed stiffness and the tier that gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowed {
    /// Every smaller stiffness (N/m) is allowed.
    pub stiffness: f64,
    /// True if this stiffness itself is allowed.
    pub attained: bool,
    /// The tier that gives it.
    pub tier: Tier,
}

/// The verdicts on one axis in detail.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisVerdict {
    /// The name of the axis.
    pub name: String,
    /// True if an operator, or one in the range, is grounded.
    pub grounded: bool,
    /// The tiers, in the order of [`Tier::ALL`].
    pub tiers: [AxisTier; 5],
    /// The paper's critical stiffness (Eq. 5), N/m.
    pub paper_critical_stiffness: f64,
    /// The paper's maximum delay (Eq. 6), s; 0 if its Eq. 9 fails.
    pub paper_maximum_delay: f64,
    /// Every shorter one-way delay (s) is stable for every operator: the end of the first stable interval.
    pub maximum_delay: f64,
    /// False if the search over the range of operators was cut off, or `maximum_delay` may be more than 5 % low.
    pub maximum_delay_proven: bool,
    /// The smallest end of the first stable interval found for a single pair of operators, s: `maximum_delay` over the
    /// range cannot be larger.
    pub least_maximum_delay: f64,
    /// The slowest multiplier under sampled controllers, the worst over the operators with the smallest bounds,
    /// the weakest and the middle ones; `None` without a sample period.
    pub sampled: Option<SampledSpectrum>,
    /// The largest stiffness (N/m), up to the bound of tier 4, that is stable under sampled controllers for every
    /// operator; 0 if none is proven. With a coupling damper and a range of operators the softest springs, of at most
    /// 0.1 N/m, are not examined: the bound says nothing about them.
    pub sampled_stiffness_bound: Option<f64>,
    /// True if the given stiffness is proven to be stable under sampled controllers for every operator.
    pub sampled_stable: Option<bool>,
    /// False if a search was cut off before it decided, as for masses and dampings that differ by many decades, or the
    /// bound may be more than 5 % low.
    pub sampled_proven: Option<bool>,
}

/// The five verdicts, the paper's verdict and the conclusions.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdicts {
    /// The given stiffness, N/m.
    pub stiffness: f64,
    /// The given network.
    pub network: Network,
    /// The tiers, in the order of [`Tier::ALL`].
    pub tiers: [Verdict; 5],
    /// The bound of tier 2 from the robots' own damping, N/m, valid for every passive operator.
    pub any_passive_operator: Option<f64>,
    /// True if the sampled dyad is proven to be stable at this constant delay on every axis for every operator;
    /// `None` without a sample period.
    pub sampled_stable: Option<bool>,
    /// False if a search over the range of operators was cut off before it decided.
    pub sampled_proven: Option<bool>,
    /// The paper's verdict.
    pub paper: PaperVerdict,
    /// The largest stiffness bound over the tiers whose assumption the network meets without a buffer.
    /// Tiers 3 and 4 are limited to what the sampled dyad allows at this delay.
    pub stiffness_allowed: Option<Allowed>,
    /// The same behind a playout buffer that makes the delay constant.
    pub stiffness_allowed_behind_buffer: Option<Allowed>,
    /// The contributions to the age of a partner sample, forward and backward.
    pub delay_budget: [DelayBudget; 2],
    /// The verdicts per axis.
    pub axes: Vec<AxisVerdict>,
    /// Changes that would make the dyad stable, if tier 4 is not satisfied or the sampled dyad is not stable.
    pub remedies: Remedies,
}

impl Verdicts {
    /// The verdict of one tier.
    pub fn tier(&self, tier: Tier) -> &Verdict {
        &self.tiers[tier as usize]
    }

    /// The same verdicts with an attack searched for: a network that keeps the ages in their range and the order of the
    /// samples, and still makes the motion of this dyad grow, at the lowest stiffness that was found.
    ///
    /// The attack is simulated with the operators whose age in a range allows least. It is greedy: in each step it plays
    /// the sample that gives each side most power. `seed` draws the starts. A lower attack may exist, down to the bound,
    /// and nothing is proven for stiffer springs. Takes up to some seconds.
    ///
    /// # Panics
    ///
    /// If `dyad` does not have the axes of the verdicts.
    pub fn with_attack(mut self, dyad: &Dyad, seed: u64) -> Self {
        let attack = self
            .axes
            .iter()
            .enumerate()
            .filter_map(|(index, axis)| age_range::attack(dyad, index, axis, &self.network, seed))
            .reduce(f64::min);
        self.tiers[Tier::AgeInRange as usize].attack = attack;
        self
    }
}

/// The five verdicts on a dyad at a stiffness (N/m) over a network.
///
/// With `operators` every verdict holds for all operators of both ranges, which replace the dyad's own. Tiers 1 and 2
/// have a known worst operator; for tiers 3 and 4 and the sampled dyad a search excludes roots on the imaginary
/// axis for the whole range at once, and for tier 5 it proves the rule for it. Tier 1 of sampled controllers has no bound over a range of free
/// operators with a coupling damper, nor over grounded operators with a computing time if a ground stiffness may be 0:
/// [`Unavailable::UnprovenOverRange`]. Tier 5 has none for sampled controllers with a coupling damper.
///
/// # Errors
///
/// [`InvalidInput`] if the stiffness is out of range or a range does not have the dyad's axes, or if values span so
/// many decades that the search for a bound does not end, as for
/// [`maximum_stiffness`](crate::criteria::maximum_stiffness).
///
/// # Examples
///
/// ```
/// use telespring::{Delay, hman};
/// use telespring::verdicts::{Network, Tier, verdicts};
/// let network = Network::constant(Delay::each_way(0.1)?);
/// let verdicts = verdicts(&hman(), None, 71.2, &network)?;
/// assert!(verdicts.tier(Tier::ConstantDelay).satisfied);
/// assert!(!verdicts.tier(Tier::AnyConstantDelay).satisfied);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn verdicts(
    dyad: &Dyad,
    operators: Option<&[OperatorRange; 2]>,
    stiffness: f64,
    network: &Network,
) -> Result<Verdicts> {
    let k = quantity::STIFFNESS.check("stiffness", stiffness)?;
    check_ranges(dyad, operators)?;
    let regions: Vec<OperatorBox> =
        (0..dyad.axis_names().len()).map(|index| OperatorBox::new(dyad, operators, index)).collect();
    let axes = dyad
        .axis_names()
        .iter()
        .zip(&regions)
        .map(|(name, region)| axis_verdict(name, region, network, k))
        .collect::<Result<Vec<_>>>()?;
    let tiers = Tier::ALL.map(|tier| worst_axis(&axes, tier, network, k));
    let is_sampled = network.sample_period() > 0.0;
    let sampled_stable = is_sampled.then(|| axes.iter().all(|axis| axis.sampled_stable == Some(true)));
    let constant = tiers[Tier::ConstantDelay as usize].satisfied;
    let remedies = if constant && sampled_stable != Some(false) {
        Remedies::default()
    } else {
        remedies::remedies(&regions, &axes, network, k)?
    };
    let paper = paper_verdict(&axes, network, k, constant);
    let sampled_bound =
        axes.iter().filter_map(|axis| axis.sampled_stiffness_bound).fold(f64::INFINITY, f64::min);
    Ok(Verdicts {
        stiffness: k,
        network: *network,
        tiers,
        any_passive_operator: any_passive_operator(dyad, network),
        sampled_stable,
        sampled_proven: is_sampled.then(|| axes.iter().all(|axis| axis.sampled_proven == Some(true))),
        paper,
        stiffness_allowed: largest_allowed(&tiers, sampled_bound, false),
        stiffness_allowed_behind_buffer: largest_allowed(&tiers, sampled_bound, true),
        delay_budget: network.budget(),
        axes,
        remedies,
    })
}

/// Checks that both operator ranges of the verdicts have the axes of the dyad.
fn check_ranges(dyad: &Dyad, operators: Option<&[OperatorRange; 2]>) -> Result<()> {
    let axes = dyad.axis_names().len();
    for (range, name) in operators.into_iter().flatten().zip(["operators[0]", "operators[1]"]) {
        let got = range.low().mass().len();
        if got != axes {
            return Err(InvalidInput::new(
                name,
                format!("{got} value(s)"),
                format!("one value per axis of the robots is required: {axes}"),
                "Give every list one value per axis.",
            ));
        }
    }
    Ok(())
}

/// The verdicts on one axis.
fn axis_verdict(name: &str, region: &OperatorBox, network: &Network, k: f64) -> Result<AxisVerdict> {
    let constant = axis_tiers::constant_delay_tiers(region, network.buffered_mean(), k)?;
    let [third, fourth] = constant.tiers;
    let nominal = region.axis(&constant.worst);
    let in_range = age_range::tier(region, network, k, &fourth)?;
    let held = if network.sample_period() > 0.0 {
        let limit = fourth.stiffness_bound.unwrap_or(f64::INFINITY);
        Some(sampled_range::sampled_axis(region, &constant.worst, limit, network, k)?)
    } else {
        None
    };
    Ok(AxisVerdict {
        name: name.to_owned(),
        grounded: region.has_grounded(),
        tiers: [
            axis_tiers::any_network_tier(region, network, k),
            axis_tiers::bounded_delay_tier(region, network, k),
            in_range,
            third,
            fourth,
        ],
        paper_critical_stiffness: paper::critical_stiffness(&nominal)?,
        paper_maximum_delay: paper::maximum_delay(&nominal, k)?,
        maximum_delay: constant.maximum_delay.bound,
        maximum_delay_proven: constant.maximum_delay.is_proven,
        least_maximum_delay: constant.maximum_delay.least_found,
        sampled: held.as_ref().map(|held| held.spectrum),
        sampled_stiffness_bound: held.as_ref().map(|held| held.stiffness_bound),
        sampled_stable: held.as_ref().map(|held| held.is_stable),
        sampled_proven: held.as_ref().map(|held| held.is_proven),
    })
}

/// The verdict of one tier over all axes: the smallest bound counts, and every axis must satisfy the rule.
fn worst_axis(axes: &[AxisVerdict], tier: Tier, network: &Network, k: f64) -> Verdict {
    let index = tier as usize;
    let assumption = match tier {
        Tier::AnyConstantDelay | Tier::ConstantDelay if !network.is_constant() => {
            Assumption::MetBehindPlayoutBuffer { delay: network.buffered() }
        }
        _ => Assumption::Met,
    };
    let mut verdict = Verdict {
        tier,
        stiffness_bound: None,
        attained: false,
        satisfied: false,
        proven: axes.iter().all(|axis| axis.tiers[index].proven),
        least_found: None,
        margin: None,
        worst_axis: None,
        worst_operators: None,
        assumption,
        unavailable: None,
        ages: (tier == Tier::AgeInRange).then(|| network.ages()),
        attack: None,
    };
    verdict.unavailable = axes.iter().find_map(|axis| axis.tiers[index].unavailable);
    if verdict.unavailable.is_some() {
        return verdict;
    }
    for (i, axis) in axes.iter().enumerate() {
        let here = &axis.tiers[index];
        let Some(bound) = here.stiffness_bound else { continue };
        if verdict.stiffness_bound.is_none_or(|least| bound < least) {
            verdict.stiffness_bound = Some(bound);
            verdict.attained = here.attained;
            verdict.least_found = here.least_found;
            verdict.worst_axis = Some(i);
            verdict.worst_operators = Some(here.operators);
            verdict.margin = Some(StiffnessMargin { ratio: bound / k, difference: bound - k });
        }
    }
    verdict.satisfied = axes.iter().all(|axis| axis.tiers[index].satisfied);
    verdict
}

/// The bound of tier 2 from the robots' damping alone, over all axes.
fn any_passive_operator(dyad: &Dyad, network: &Network) -> Option<f64> {
    let [first, second] = dyad.robots();
    (dyad.coupling_damping() == 0.0).then(|| {
        first
            .damping()
            .iter()
            .zip(second.damping())
            .map(|(&b1, &b2)| {
                bounded_delay::stiffness_bound(
                    [b1, b2],
                    network.oldest_partner_sample(),
                    network.oldest_own_sample(),
                )
            })
            .fold(f64::INFINITY, f64::min)
    })
}

/// The paper's verdict over all axes, compared with the exact one.
fn paper_verdict(axes: &[AxisVerdict], network: &Network, k: f64, truth: bool) -> PaperVerdict {
    let least = |values: Vec<f64>| {
        values
            .into_iter()
            .enumerate()
            .fold((0, f64::INFINITY), |least, (i, value)| if value < least.1 { (i, value) } else { least })
    };
    let (critical_axis, critical_stiffness) =
        least(axes.iter().map(|axis| axis.paper_critical_stiffness).collect());
    let (delay_axis, maximum_delay) = least(axes.iter().map(|axis| axis.paper_maximum_delay).collect());
    let stable = k <= critical_stiffness || network.buffered_mean() < maximum_delay;
    PaperVerdict {
        critical_stiffness,
        critical_axis,
        maximum_delay,
        delay_axis,
        stable,
        agrees: stable == truth,
    }
}

/// The largest stiffness bound over the verdicts whose assumption is met.
fn largest_allowed(tiers: &[Verdict; 5], sampled_bound: f64, buffered: bool) -> Option<Allowed> {
    // Of equal bounds that with the stronger guarantee; age in a range last, since without a range it is a constant delay.
    let mut ordered = tiers.each_ref();
    ordered.sort_by_key(|verdict| verdict.tier.number());
    ordered
        .into_iter()
        .filter(|verdict| buffered || verdict.assumption == Assumption::Met)
        .filter_map(|verdict| {
            let bound = verdict.stiffness_bound?;
            let constant = matches!(verdict.tier, Tier::AnyConstantDelay | Tier::ConstantDelay);
            let lowered = constant && sampled_bound < bound;
            Some(Allowed {
                stiffness: if lowered { sampled_bound } else { bound },
                attained: verdict.attained && !lowered,
                tier: verdict.tier,
            })
        })
        .reduce(|best, next| if next.stiffness > best.stiffness { next } else { best })
}
