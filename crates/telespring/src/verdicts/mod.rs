//! The four verdicts on a dyad, side by side with the paper's.
//!
//! | tier | what the network may do | rule |
//! |---|---|---|
//! | 1 [`Tier::AnyNetwork`] | anything with bounded gaps | each side alone does not amplify |
//! | 2 [`Tier::BoundedVaryingDelay`] | anything that leaves no sample older than a bound | Lyapunov–Krasovskii |
//! | 3 [`Tier::AnyConstantDelay`] | one constant delay, however long | no root crosses for any delay |
//! | 4 [`Tier::ConstantDelay`] | one known constant delay | it lies in a stable interval |
//!
//! The tiers are not nested: the stiffness allowed is the largest that any of them gives whose
//! assumption the network keeps.

mod any_network;
mod bounded_delay;
mod contour;
mod gain;
mod network;
mod operators;
mod paper;
mod sampled;
mod sampled_characteristic;
mod sampled_gain;
mod sampled_roots;
mod zero_order_hold;

pub use network::{DelayBudget, Network};
pub use operators::{AxisTier, OperatorPoint, OperatorRange};
pub use paper::PaperVerdict;
pub use sampled::sampled_spectral_radius;
pub use sampled_roots::{SampledCertificate, SampledSpectrum};

use operators::{Examined, OperatorBox};

use crate::criteria::{maximum_delay, minimum_damping};
use crate::error::{InvalidInput, Result};
use crate::model::{Dyad, DyadAxis};
use crate::quantity;

/// One of the four verdicts, by what it lets the network do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Tier {
    /// 1: anything at all, with bounded gaps.
    AnyNetwork,
    /// 2: any variation, jumps, loss with hold and reordering, no sample older than a bound.
    BoundedVaryingDelay,
    /// 3: any constant delay.
    AnyConstantDelay,
    /// 4: one known constant delay.
    ConstantDelay,
}

impl Tier {
    /// All four, from 1 to 4.
    pub const ALL: [Self; 4] =
        [Self::AnyNetwork, Self::BoundedVaryingDelay, Self::AnyConstantDelay, Self::ConstantDelay];

    /// 1 to 4.
    pub fn number(self) -> u8 {
        self as u8 + 1
    }

    /// The name in text and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::AnyNetwork => "any network",
            Self::BoundedVaryingDelay => "bounded varying delay",
            Self::AnyConstantDelay => "any constant delay",
            Self::ConstantDelay => "constant delay",
        }
    }
}

/// Whether the stated network keeps what a tier assumes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Assumption {
    /// It does.
    Met,
    /// Only behind a playout buffer that holds every packet until these one-way delays (s, forward and
    /// backward) are over, which makes the delay constant.
    MetBehindPlayoutBuffer {
        /// Delay plus jitter plus longest gap, per direction.
        delay: [f64; 2],
    },
}

/// Why a tier has no rule for a dyad.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unavailable {
    /// Tier 1 with a coupling damper and an operator that holds its handle to the ground.
    CouplingDampingWithGroundedOperator,
    /// Tier 1 with a coupling damper and a controller that takes time to compute.
    CouplingDampingWithComputingTime,
    /// Tier 2 with a coupling damper.
    CouplingDamping,
}

/// How far a stiffness is from a bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StiffnessMargin {
    /// Bound over stiffness: above 1 is inside.
    pub ratio: f64,
    /// Bound minus stiffness, N/m.
    pub difference: f64,
}

/// The verdict of one tier on the whole dyad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// Which tier.
    pub tier: Tier,
    /// The largest stiffness (N/m) of the tier, every smaller one included; infinite where nothing
    /// limits it, `None` where the tier is unavailable.
    pub stiffness_bound: Option<f64>,
    /// True where that stiffness is itself allowed.
    pub attained: bool,
    /// True where the stiffness in question keeps the rule on every axis, for every operator examined.
    /// A constant delay (tier 4) may be stable above the bound: it can lie in a later stable interval.
    pub satisfied: bool,
    /// How far the stiffness is from the bound.
    pub margin: Option<StiffnessMargin>,
    /// The axis with the least bound.
    pub worst_axis: Option<usize>,
    /// The operators with the least bound on that axis.
    pub worst_operators: Option<[OperatorPoint; 2]>,
    /// Whether the network keeps what the tier assumes.
    pub assumption: Assumption,
    /// Why the tier is unavailable, where it is.
    pub unavailable: Option<Unavailable>,
}

/// A stiffness and the tier that allows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowed {
    /// Every smaller stiffness (N/m) is allowed.
    pub stiffness: f64,
    /// True where this very stiffness is allowed too.
    pub attained: bool,
    /// The tier that gives it.
    pub tier: Tier,
}

/// What to change so that the constant delay (tier 4) is stable, one thing at a time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Remedies {
    /// Lower the stiffness below this, N/m.
    pub stiffness: Option<f64>,
    /// Bring the mean one-way delay below this, s.
    pub delay: Option<f64>,
    /// Add more than this damping to each robot, N·s/m.
    pub damping: Option<f64>,
}

/// One axis in detail.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisVerdict {
    /// Its name.
    pub name: String,
    /// True where an operator, or one in the range, holds a handle to the ground.
    pub grounded: bool,
    /// The four tiers.
    pub tiers: [AxisTier; 4],
    /// Eq. 5 of the paper, N/m.
    pub paper_critical_stiffness: f64,
    /// Eq. 6 of the paper, s; 0 where its Eq. 9 breaks down.
    pub paper_maximum_delay: f64,
    /// The end of the first stable interval, s, the shortest over the operators examined.
    pub maximum_delay: f64,
    /// The slowest multiplier under sampled controllers, the largest over the operators' corners and the
    /// worst of tier 4; `None` without a sample period.
    pub sampled: Option<SampledSpectrum>,
    /// The largest stiffness (N/m) up to the bound of tier 4 that the sampled dyad keeps, the least over
    /// the operators' corners and the worst of tier 4.
    pub sampled_stiffness_bound: Option<f64>,
}

/// The four verdicts, the paper's beside them, and what follows.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdicts {
    /// The stiffness in question, N/m.
    pub stiffness: f64,
    /// The network in question.
    pub network: Network,
    /// Tiers 1 to 4.
    pub tiers: [Verdict; 4],
    /// The bound of tier 2 from the robots' own damping, N/m: it holds for every passive operator.
    pub any_passive_operator: Option<f64>,
    /// True where the sampled dyad is stable at this constant delay on every axis; `None` without a
    /// sample period.
    pub sampled_stable: Option<bool>,
    /// What the paper says.
    pub paper: PaperVerdict,
    /// The largest stiffness over the tiers whose assumption the bare network keeps. Sampling counts:
    /// tiers 3 and 4 give no more than the sampled dyad bears at this delay.
    pub stiffness_allowed: Option<Allowed>,
    /// The same with the playout buffer in place that makes the delay constant.
    pub stiffness_allowed_behind_buffer: Option<Allowed>,
    /// Where the age of a partner sample comes from, forward and backward.
    pub delay_budget: [DelayBudget; 2],
    /// Every axis.
    pub axes: Vec<AxisVerdict>,
    /// How many pairs of operators were examined per axis: one without a range.
    pub operators_examined: usize,
    /// What to change, where tier 4 is not satisfied.
    pub remedies: Remedies,
}

impl Verdicts {
    /// The verdict of one tier.
    pub fn tier(&self, tier: Tier) -> &Verdict {
        &self.tiers[tier as usize]
    }
}

/// The four verdicts on a dyad at a stiffness (N/m) over a network.
///
/// With `operators` every verdict is the worst over both ranges, which take the place of the dyad's
/// own operators: tiers 1 and 2 exactly, tiers 3 and 4 over corners and a grid, refined at its worst point.
///
/// # Errors
///
/// [`InvalidInput`] where the stiffness is out of range or a range does not have the dyad's axes.
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
    let count = dyad.axis_names().len();
    let mut axes = Vec::with_capacity(count);
    let mut remedies = Remedies::default();
    let mut operators_examined = 0;
    for index in 0..count {
        let region = OperatorBox::new(dyad, operators, index);
        let examined = operators::examine(&region, network, k)?;
        operators_examined = operators_examined.max(examined.count);
        axes.push(axis_verdict(dyad, index, &region, &examined, network, k, &mut remedies)?);
    }
    let tiers = Tier::ALL.map(|tier| worst_axis(&axes, tier, network, k));
    if tiers[3].satisfied {
        remedies = Remedies::default();
    } else {
        let bound = tiers[3].stiffness_bound.filter(|&bound| bound > 0.0);
        remedies.stiffness = bound;
    }
    let paper = paper_verdict(&axes, network, k, tiers[3].satisfied);
    let sampled_bound =
        axes.iter().filter_map(|axis| axis.sampled_stiffness_bound).fold(f64::INFINITY, f64::min);
    Ok(Verdicts {
        stiffness: k,
        network: *network,
        tiers,
        any_passive_operator: any_passive_operator(dyad, network),
        sampled_stable: (network.sample_period() > 0.0)
            .then(|| axes.iter().all(|axis| axis.sampled.is_some_and(|sampled| sampled.is_stable()))),
        paper,
        stiffness_allowed: allowed(&tiers, sampled_bound, false),
        stiffness_allowed_behind_buffer: allowed(&tiers, sampled_bound, true),
        delay_budget: network.budget(),
        axes,
        operators_examined,
        remedies,
    })
}

fn check_ranges(dyad: &Dyad, operators: Option<&[OperatorRange; 2]>) -> Result<()> {
    let axes = dyad.axis_names().len();
    for (range, name) in operators.into_iter().flatten().zip(["operators[0]", "operators[1]"]) {
        let got = range.low().mass().len();
        if got != axes {
            return Err(InvalidInput::new(
                name,
                format!("{got} value(s)"),
                format!("one value per axis of the robots is needed, that is {axes}"),
                "Give every list one value per axis.",
            ));
        }
    }
    Ok(())
}

/// One axis in detail; what would help it tightens the remedies.
fn axis_verdict(
    dyad: &Dyad,
    index: usize,
    region: &OperatorBox,
    examined: &Examined,
    network: &Network,
    k: f64,
    remedies: &mut Remedies,
) -> Result<AxisVerdict> {
    let nominal = region.axis(&examined.worst_constant);
    let mut held: Vec<DyadAxis> = region.corners().iter().map(|corner| region.axis(corner)).collect();
    if !held.contains(&nominal) {
        held.push(nominal);
    }
    let delay = network.buffered_mean();
    let mut shortest = f64::INFINITY;
    let mut sampled: Option<SampledSpectrum> = None;
    for axis in &held {
        shortest = shortest.min(maximum_delay(axis, k)?);
        if network.sample_period() > 0.0 {
            let spectrum = sampled_spectral_radius(axis, k, network)?;
            if sampled.is_none_or(|worst| spectrum.radius > worst.radius) {
                sampled = Some(spectrum);
            }
        }
        if !examined.tiers[3].satisfied {
            let added = minimum_damping(axis, k, delay)?;
            let added = added.max(remedies.damping.unwrap_or(0.0));
            remedies.damping = (added > 0.0).then_some(added);
        }
    }
    if !examined.tiers[3].satisfied {
        remedies.delay = (shortest > 0.0)
            .then(|| remedies.delay.unwrap_or(f64::INFINITY).min(shortest))
            .filter(|d| d.is_finite());
    }
    let sampled_stiffness_bound = sampled.map(|_| {
        let limit = examined.tiers[3].stiffness_bound.unwrap_or(f64::INFINITY);
        // The nominal one first: it is often the worst, and a lower limit shortens the other searches.
        let nominal_bound = sampled::stiffness_bound(&nominal, network, limit);
        held.iter()
            .filter(|&axis| *axis != nominal)
            .fold(nominal_bound, |bound, axis| sampled::stiffness_bound(axis, network, bound))
    });
    Ok(AxisVerdict {
        name: dyad.axis_names()[index].clone(),
        grounded: held.iter().any(|axis| !axis.is_free()),
        tiers: examined.tiers,
        paper_critical_stiffness: paper::critical_stiffness(&nominal)?,
        paper_maximum_delay: paper::maximum_delay(&nominal, k)?,
        maximum_delay: shortest,
        sampled,
        sampled_stiffness_bound,
    })
}

/// One tier over all axes: the least bound counts, and every axis must keep the rule.
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
        margin: None,
        worst_axis: None,
        worst_operators: None,
        assumption,
        unavailable: None,
    };
    if axes.iter().any(|axis| axis.tiers[index].stiffness_bound.is_none()) {
        verdict.unavailable = Some(match tier {
            Tier::BoundedVaryingDelay => Unavailable::CouplingDamping,
            _ if axes.iter().all(|axis| !axis.grounded) => Unavailable::CouplingDampingWithComputingTime,
            _ => Unavailable::CouplingDampingWithGroundedOperator,
        });
        return verdict;
    }
    for (i, axis) in axes.iter().enumerate() {
        let here = &axis.tiers[index];
        let Some(bound) = here.stiffness_bound else { continue };
        if verdict.stiffness_bound.is_none_or(|least| bound < least) {
            verdict.stiffness_bound = Some(bound);
            verdict.attained = here.attained;
            verdict.worst_axis = Some(i);
            verdict.worst_operators = Some(here.operators);
            verdict.margin = Some(StiffnessMargin { ratio: bound / k, difference: bound - k });
        }
    }
    verdict.satisfied = axes.iter().all(|axis| axis.tiers[index].satisfied);
    verdict
}

/// The bound of tier 2 from the robots alone, the worst axis.
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

/// The largest bound over the tiers whose assumption holds.
fn allowed(tiers: &[Verdict; 4], sampled_bound: f64, buffered: bool) -> Option<Allowed> {
    tiers
        .iter()
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
