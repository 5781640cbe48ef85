//! Age in a range: the network keeps the age of every sample in use within a range, and samples are never played
//! backwards.
//!
//! The difference between a played sample and one of constant age d has at most J times the energy of the
//! signal's rate, and a scaled small gain bounds the loop. The rule holds for every network whose ages lie in
//! [d − J, d + J]; docs/age-range.md proves it. The family of rules is Kao and Lincoln's (Automatica 40, 2004); without the
//! order of the samples J counts √2-fold.
//!
//! | module | content |
//! |---|---|
//! | `attack` | a network that makes the motion grow, above the bound |
//! | `jet` | intervals with their derivatives |
//! | `range` | a bound of it over all operators of a range |
//! | `rule` | the rule as the sign of one function, and a bound of it over a cell |
//! | `search` | the stiffness up to which it is proven |

mod attack;
mod jet;
mod range;
mod rule;
mod search;

use rule::Rule;

use super::operators::{OperatorBox, operator_points};
use super::ranges::SideRange;
use super::{AxisTier, AxisVerdict, Network, Tier, Unavailable};
use crate::criteria::maximum_stiffness;
use crate::error::{InvalidInput, Result};
use crate::model::{Dyad, DyadAxis, Side};
use crate::quantity;

/// The range of the age of the partner samples that one side uses, s.
///
/// # Examples
///
/// ```
/// use telespring::verdicts::AgeRange;
/// let range = AgeRange::new(0.08, 0.12)?;
/// assert_eq!((range.least(), range.greatest()), (0.08, 0.12));
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AgeRange {
    least: f64,
    greatest: f64,
}

impl AgeRange {
    /// The ages from `least` to `greatest`, s.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if an age is out of the range of a delay, or `least` exceeds `greatest`.
    pub fn new(least: f64, greatest: f64) -> Result<Self> {
        quantity::DELAY.check("least", least)?;
        quantity::DELAY.check("greatest", greatest)?;
        if least > greatest {
            return Err(InvalidInput::new(
                "least",
                least,
                format!("the lower end of a range must not exceed the upper, {greatest} s"),
                "Swap the two.",
            ));
        }
        Ok(Self { least, greatest })
    }

    /// The smallest age, s.
    pub fn least(&self) -> f64 {
        self.least
    }

    /// The largest age, s.
    pub fn greatest(&self) -> f64 {
        self.greatest
    }

    /// The age in the middle of the range, s.
    fn middle(&self) -> f64 {
        0.5 * (self.least + self.greatest)
    }

    /// Half the width of the range, s.
    fn reach(&self) -> f64 {
        0.5 * (self.greatest - self.least)
    }
}

/// The stiffness that a range of ages allows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AgeRangeBound {
    /// Every smaller stiffness (N/m) is stable on every network that keeps the ages.
    pub stiffness: f64,
    /// A stiffness (N/m) at which the rule fails; the bound lies just below it. `None` if the search ended before it met one.
    pub failing: Option<f64>,
}

/// The largest stiffness (N/m) at which an axis is stable on every network that keeps the age of each partner
/// sample in a range and never plays samples backwards, under continuous controllers.
///
/// `ages` are those of the samples that arrive at robot 1 and at robot 2. Without a width of both ranges the bound is
/// that of a constant delay.
///
/// # Errors
///
/// [`InvalidInput`] if the search for the limit of a constant delay does not end, as for [`maximum_stiffness`].
///
/// # Examples
///
/// ```
/// use telespring::{hman, verdicts::{AgeRange, age_range_stiffness}};
/// let axis = hman().axis(0)?;
/// let bound = age_range_stiffness(&axis, &[AgeRange::new(0.08, 0.12)?; 2])?;
/// assert!((bound.stiffness - 76.23).abs() < 0.01);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn age_range_stiffness(axis: &DyadAxis, ages: &[AgeRange; 2]) -> Result<AgeRangeBound> {
    axis.check()?;
    let round_trip = ages[0].middle() + ages[1].middle();
    if ages.iter().all(|range| range.reach() == 0.0) {
        let stiffness = maximum_stiffness(axis, 0.5 * round_trip)?;
        return Ok(AgeRangeBound { stiffness, failing: Some(stiffness) });
    }
    let rule = Rule {
        sides: point(axis),
        coupling_damping: axis.coupling_damping,
        round_trip,
        reach: [ages[0].reach(), ages[1].reach()],
        own_delay: 0.0,
        own_reach: 0.0,
    };
    let found = rule.proven_stiffness();
    // With a coupling damper the rule alone does not tell whether soft springs are stable.
    let stiffness = if axis.coupling_damping > 0.0 && found.stiffness > 0.0 {
        found.stiffness.min(maximum_stiffness(axis, 0.5 * round_trip)?)
    } else {
        found.stiffness
    };
    Ok(AgeRangeBound { stiffness, failing: found.failing.map(|(failing, _)| failing) })
}

/// Sample ages over a network: of the partner samples that each side uses, and of the own ones.
fn ages_of(network: &Network) -> ([AgeRange; 2], AgeRange) {
    let computing = network.computing_time();
    let [forward, backward] = network.ages().map(|[least, greatest]| AgeRange { least, greatest });
    ([backward, forward], AgeRange { least: computing, greatest: computing + network.sample_period() })
}

/// A bound counts as tight if it is at least this part of the smallest one found for a single pair of operators.
const TIGHT: f64 = 0.95;

/// The tier on one axis at a stiffness (N/m), given that of the constant delay behind a playout buffer.
pub(super) fn tier(
    region: &OperatorBox,
    network: &Network,
    stiffness: f64,
    constant: &AxisTier,
) -> Result<AxisTier> {
    let (ages, own) = ages_of(network);
    let tier = Tier::AgeInRange;
    if own.greatest == 0.0 && ages.iter().all(|range| range.reach() == 0.0) {
        return Ok(AxisTier { tier, ..*constant });
    }
    let family = region.family();
    if family.coupling_damping > 0.0 && own.greatest > 0.0 {
        return Ok(AxisTier {
            tier,
            stiffness_bound: None,
            attained: false,
            satisfied: false,
            proven: true,
            least_found: None,
            operators: operator_points(&region.weakest_corner()),
            unavailable: Some(Unavailable::CouplingDampingWithSampledControllers),
        });
    }
    let rule = |sides: [SideRange; 2]| Rule {
        sides,
        coupling_damping: family.coupling_damping,
        round_trip: ages[0].middle() + ages[1].middle(),
        reach: ages.map(|range| range.reach()),
        own_delay: own.middle(),
        own_reach: own.reach(),
    };
    let found = rule(family.sides).proven_stiffness();
    let mut bound = found.stiffness;
    if family.coupling_damping > 0.0 && bound > 0.0 {
        // No root crosses over the whole range, so that one pair of operators speaks for all.
        let member = region.axis(&region.middle());
        bound = bound.min(maximum_stiffness(&member, 0.5 * (ages[0].middle() + ages[1].middle()))?);
    }
    let mut worst = (region.weakest_corner(), found.failing.map(|(failing, _)| failing));
    if let Some((_, sides)) = &found.failing {
        worst.0 = region.operators_of(sides);
    } else if !region.is_point() {
        for at in [region.weakest_corner(), region.middle()] {
            let single =
                rule(point(&region.axis(&at))).proven_stiffness().failing.map(|(failing, _)| failing);
            if single.is_some_and(|single| worst.1.is_none_or(|least| single < least)) {
                worst = (at, single);
            }
        }
    }
    Ok(AxisTier {
        tier,
        stiffness_bound: Some(bound),
        attained: false,
        satisfied: stiffness < bound,
        proven: worst.1.is_some_and(|least| bound >= TIGHT * least),
        least_found: worst.1,
        operators: operator_points(&worst.0),
        unavailable: None,
    })
}

/// The lowest stiffness (N/m) at which an attack on one axis makes the motion grow, searched from the largest bound that
/// is proven for the network as it is.
pub(super) fn attack(
    dyad: &Dyad,
    index: usize,
    verdict: &AxisVerdict,
    network: &Network,
    seed: u64,
) -> Option<f64> {
    let here = &verdict.tiers[Tier::AgeInRange as usize];
    let [first, second] = [0, 1].map(|i| {
        let (robot, operator) = (&dyad.robots()[i], &here.operators[i]);
        Side {
            mass: robot.mass()[index] + operator.mass,
            damping: robot.damping()[index] + operator.damping,
            ground_stiffness: operator.stiffness,
        }
    });
    let axis = DyadAxis { sides: [first, second], coupling_damping: dyad.coupling_damping() };
    let safe = [Tier::AnyNetwork, Tier::BoundedVaryingDelay, Tier::AgeInRange]
        .into_iter()
        .filter_map(|tier| verdict.tiers[tier as usize].stiffness_bound)
        .fold(0.0, f64::max);
    let most = verdict.tiers[Tier::ConstantDelay as usize].least_found?;
    if safe == 0.0 || most.is_infinite() {
        return None;
    }
    // Held samples grow older by one period; the simulation holds them itself.
    let [forward, backward] = [0, 1].map(|way| (network.budget()[way].network, network.buffered()[way]));
    let controllers =
        attack::Controllers { period: network.sample_period(), computing_time: network.computing_time() };
    attack::lowest_stiffness(&axis, &[backward, forward], &controllers, (safe, BEYOND * most), seed)
}

/// An attack is searched up to this multiple of what the longest delay alone allows.
const BEYOND: f64 = 1.1;

/// The sides of one axis as ranges without a width.
fn point(axis: &DyadAxis) -> [SideRange; 2] {
    let point = |value: f64| (value, value);
    axis.sides.map(|side| SideRange {
        mass: point(side.mass),
        damping: point(side.damping),
        stiffness: point(side.ground_stiffness),
    })
}
