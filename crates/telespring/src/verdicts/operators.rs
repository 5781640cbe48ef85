//! Verdicts over a range of operators: a grip varies, and the worst operator counts.

use super::zero_order_hold::SampledPlant;
use super::{Network, Tier, any_network, bounded_delay, sampled_gain};
use crate::criteria::is_in_any;
use crate::criteria::{critical_stiffness, is_delay_independent, maximum_stiffness, stable_delays};
use crate::error::{InvalidInput, Result};
use crate::model::{Dyad, DyadAxis, Operator, Side};

/// A range of operators: a box in mass, damping and stiffness per axis.
#[derive(Debug, Clone, PartialEq)]
pub struct OperatorRange {
    low: Operator,
    high: Operator,
}

impl OperatorRange {
    /// Creates the range from `low` to `high`, both included.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the two have different axes or a lower end exceeds the upper one.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::{Operator, verdicts::OperatorRange};
    /// let loose = Operator::new(vec![0.0], vec![0.0], vec![0.0])?;
    /// let firm = Operator::new(vec![1.5], vec![10.0], vec![300.0])?;
    /// assert!(OperatorRange::new(loose.clone(), firm.clone()).is_ok());
    /// assert!(OperatorRange::new(firm, loose).is_err());
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn new(low: Operator, high: Operator) -> Result<Self> {
        if low.mass().len() != high.mass().len() {
            return Err(InvalidInput::new(
                "high",
                format!("{} value(s)", high.mass().len()),
                format!("both ends of a range need the same axes, here {}", low.mass().len()),
                "Give every list one value per axis.",
            ));
        }
        let pairs = [
            ("mass", low.mass(), high.mass()),
            ("damping", low.damping(), high.damping()),
            ("stiffness", low.stiffness(), high.stiffness()),
        ];
        for (name, from, to) in pairs {
            for (i, (from, to)) in from.iter().zip(to).enumerate() {
                if from > to {
                    return Err(InvalidInput::new(
                        format!("{name}[{i}]"),
                        format!("{from} to {to}"),
                        "the lower end of a range must not exceed the upper",
                        "Swap the two.",
                    ));
                }
            }
        }
        Ok(Self { low, high })
    }

    /// The lower end of the operator range.
    pub fn low(&self) -> &Operator {
        &self.low
    }

    /// The upper end of the operator range.
    pub fn high(&self) -> &Operator {
        &self.high
    }

    /// The operator in the middle of the range.
    pub fn middle(&self) -> Operator {
        let mean = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect();
        Operator::new(
            mean(self.low.mass(), self.high.mass()),
            mean(self.low.damping(), self.high.damping()),
            mean(self.low.stiffness(), self.high.stiffness()),
        )
        .expect("the mean of two valid values is valid")
    }

    /// The lower and upper mass, damping and stiffness on one axis.
    fn ends(&self, axis: usize) -> [[f64; 2]; 3] {
        let (low, high) = (&self.low, &self.high);
        [
            [low.mass()[axis], high.mass()[axis]],
            [low.damping()[axis], high.damping()[axis]],
            [low.stiffness()[axis], high.stiffness()[axis]],
        ]
    }
}

/// One operator on one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatorPoint {
    /// Mass, kg.
    pub mass: f64,
    /// Damping, N·s/m.
    pub damping: f64,
    /// Stiffness to ground, N/m.
    pub stiffness: f64,
}

/// Both operators as six numbers: mass, damping and stiffness of the first, then of the second.
type OperatorPair = [f64; 6];

/// The box of both operators on one axis, with the robots that they hold.
pub(super) struct OperatorBox {
    robots: [Side; 2],
    ends: [[f64; 2]; 6],
    coupling_damping: f64,
}

/// The grid values per side of the box with nonzero length.
const LEVELS: usize = 3;
/// The pattern search ends at this fraction of the box.
const FINEST: f64 = 1e-4;

impl OperatorBox {
    /// Creates the box of one axis from the ranges, or from the dyad's own operators as a single point.
    pub fn new(dyad: &Dyad, ranges: Option<&[OperatorRange; 2]>, axis: usize) -> Self {
        let point = |operator: &Operator| {
            [operator.mass()[axis], operator.damping()[axis], operator.stiffness()[axis]].map(|v| [v, v])
        };
        let [[m1, b1, k1], [m2, b2, k2]] = match ranges {
            Some(ranges) => ranges.each_ref().map(|range| range.ends(axis)),
            None => dyad.operators().each_ref().map(point),
        };
        Self {
            robots: dyad.robots().each_ref().map(|robot| Side {
                mass: robot.mass()[axis],
                damping: robot.damping()[axis],
                ground_stiffness: 0.0,
            }),
            ends: [m1, b1, k1, m2, b2, k2],
            coupling_damping: dyad.coupling_damping(),
        }
    }

    /// The axis of the dyad held by these operators.
    pub fn axis(&self, at: &OperatorPair) -> DyadAxis {
        let side = |i: usize| Side {
            mass: self.robots[i].mass + at[3 * i],
            damping: self.robots[i].damping + at[3 * i + 1],
            ground_stiffness: at[3 * i + 2],
        };
        DyadAxis { sides: [side(0), side(1)], coupling_damping: self.coupling_damping }
    }

    /// The grid with `levels` values per side with nonzero length; 2 gives the corners.
    fn grid(&self, levels: usize) -> Vec<OperatorPair> {
        let mut points = vec![[0.0; 6]];
        for (dimension, [low, high]) in self.ends.iter().enumerate() {
            let count = if low == high { 1 } else { levels };
            points = points
                .iter()
                .flat_map(|point| {
                    (0..count).map(move |level| {
                        let part = if count == 1 { 0.0 } else { level as f64 / (count - 1) as f64 };
                        let mut point = *point;
                        point[dimension] = low + part * (high - low);
                        point
                    })
                })
                .collect();
        }
        points
    }

    /// The corners of the box of operators.
    pub fn corners(&self) -> Vec<OperatorPair> {
        self.grid(2)
    }

    /// The corner with the largest mass and smallest damping and stiffness: the worst case of tiers 1 and
    /// 2.
    fn weakest_corner(&self) -> OperatorPair {
        let [m1, b1, k1, m2, b2, k2] = self.ends;
        [m1[1], b1[0], k1[0], m2[1], b2[0], k2[0]]
    }
}

/// Converts the six numbers of an operator pair to two operators.
pub(super) fn operator_points(at: &OperatorPair) -> [OperatorPoint; 2] {
    [0, 3].map(|i| OperatorPoint { mass: at[i], damping: at[i + 1], stiffness: at[i + 2] })
}

/// One tier on one axis, for the worst operators.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisTier {
    /// Which tier.
    pub tier: Tier,
    /// The largest stiffness, N/m; `None` if the tier has no rule for this dyad.
    pub stiffness_bound: Option<f64>,
    /// True if that stiffness itself is allowed.
    pub attained: bool,
    /// True if the given stiffness satisfies the tier's rule for every operator examined.
    pub satisfied: bool,
    /// The operators with the smallest bound.
    pub operators: [OperatorPoint; 2],
}

/// All tiers on one axis, and the number of operator pairs examined.
pub(super) struct ExaminedTiers {
    pub tiers: [AxisTier; 4],
    pub worst_constant: OperatorPair,
    pub count: usize,
}

/// Whether a stiffness is below a bound over the operators, or equal to an attained one.
fn is_within(bound: f64, attained: bool, k: f64) -> bool {
    k < bound || (attained && k == bound)
}

/// Tier 1 over a range of operators: exact at the weakest corner for continuous controllers; for sampled
/// controllers every corner is examined.
fn any_network_tier(region: &OperatorBox, network: &Network, k: f64) -> AxisTier {
    let weakest = region.weakest_corner();
    let corners = region.corners();
    let none = AxisTier {
        tier: Tier::AnyNetwork,
        stiffness_bound: None,
        attained: false,
        satisfied: false,
        operators: operator_points(&weakest),
    };
    let Some((mut bound, mut attained)) = any_network::stiffness_bound(&region.axis(&weakest), network)
    else {
        return none;
    };
    let mut worst = weakest;
    for corner in corners {
        let axis = region.axis(&corner);
        // One gain decides whether a sampled, grounded corner can be worse at all.
        if network.sample_period() > 0.0 && !axis.is_free() && axis.coupling_damping == 0.0 {
            let held = axis
                .sides
                .map(|side| SampledPlant::new(&side, network.sample_period(), network.computing_time()));
            if held.iter().map(|side| sampled_gain::sampled_gain(side, bound)).product::<f64>() < 1.0 {
                continue;
            }
        }
        let Some((other, other_attained)) = any_network::stiffness_bound(&axis, network) else {
            return none;
        };
        if other < bound {
            (bound, attained, worst) = (other, other_attained, corner);
        }
    }
    AxisTier {
        tier: Tier::AnyNetwork,
        stiffness_bound: Some(bound),
        attained,
        satisfied: is_within(bound, attained, k),
        operators: operator_points(&worst),
    }
}

/// Tier 2 over a range of operators: exact at the smallest damping.
fn bounded_delay_tier(region: &OperatorBox, network: &Network, k: f64) -> AxisTier {
    let worst = region.weakest_corner();
    let damping = region.axis(&worst).sides.map(|side| side.damping);
    let bound = (region.coupling_damping == 0.0).then(|| {
        bounded_delay::stiffness_bound(damping, network.oldest_partner_sample(), network.oldest_own_sample())
    });
    AxisTier {
        tier: Tier::BoundedVaryingDelay,
        stiffness_bound: bound,
        attained: false,
        satisfied: bound.is_some_and(|bound| k < bound),
        operators: operator_points(&worst),
    }
}

/// For some operators, true if the first positive root of F appears at ξ = 0 when k reaches `critical`: the
/// dyad is then stable at that stiffness.
fn is_attained(axis: &DyadAxis, critical: f64) -> bool {
    let [first, second] = axis.sides;
    let (b1, b2, c) = (first.damping, second.damping, axis.coupling_damping);
    let entry = (b1 * b1 + b2 * b2 + 2.0 * c * (b1 + b2)) / (2.0 * (first.mass + second.mass));
    // A tangency comes before this root; 1e-12 separates the two in rounding.
    axis.is_free() && (entry - critical).abs() <= 1e-12 * entry
}

/// Tiers 3 and 4 over a range of operators: a grid through the box, corners included, then a pattern search
/// from its worst point.
fn constant_delay_tier(
    region: &OperatorBox,
    tier: Tier,
    delay: f64,
    k: f64,
) -> Result<(AxisTier, OperatorPair, usize)> {
    let bound = |at: &OperatorPair| -> Result<f64> {
        let axis = region.axis(at);
        if tier == Tier::AnyConstantDelay {
            Ok(critical_stiffness(&axis))
        } else {
            maximum_stiffness(&axis, delay)
        }
    };
    let holds = |at: &OperatorPair, bound: f64| -> Result<bool> {
        let axis = region.axis(at);
        if k < bound {
            return Ok(true);
        }
        if tier == Tier::AnyConstantDelay {
            // With grounded operators there may be bands above the first destabilised stiffness.
            Ok(is_within(bound, is_attained(&axis, bound), k) || is_delay_independent(&axis, k)?)
        } else {
            // Above the bound the delay may lie in a later stable interval.
            Ok(is_in_any(&stable_delays(&axis, k, 2.0 * delay + 1.0)?, delay))
        }
    };
    let grid = region.grid(LEVELS);
    let mut count = grid.len();
    let mut worst = (grid[0], f64::INFINITY);
    let mut satisfied = true;
    for at in &grid {
        let value = bound(at)?;
        satisfied = satisfied && holds(at, value)?;
        if value < worst.1 {
            worst = (*at, value);
        }
    }
    if count > 1 {
        let mut step = 0.25;
        while step > FINEST {
            let mut moved = false;
            for dimension in 0..6 {
                let [low, high] = region.ends[dimension];
                if low == high {
                    continue;
                }
                for sign in [-1.0, 1.0] {
                    let mut at = worst.0;
                    at[dimension] = (at[dimension] + sign * step * (high - low)).clamp(low, high);
                    if at == worst.0 {
                        continue;
                    }
                    let value = bound(&at)?;
                    count += 1;
                    satisfied = satisfied && holds(&at, value)?;
                    if value < worst.1 {
                        worst = (at, value);
                        moved = true;
                    }
                }
            }
            if !moved {
                step *= 0.5;
            }
        }
    }
    let attained = tier == Tier::AnyConstantDelay && is_attained(&region.axis(&worst.0), worst.1);
    let verdict = AxisTier {
        tier,
        stiffness_bound: Some(worst.1),
        attained,
        satisfied,
        operators: operator_points(&worst.0),
    };
    Ok((verdict, worst.0, count))
}

/// Evaluates all four tiers on one axis over a range of operators.
pub(super) fn examine_tiers(region: &OperatorBox, network: &Network, k: f64) -> Result<ExaminedTiers> {
    let delay = network.buffered_mean();
    let (third, _, third_count) = constant_delay_tier(region, Tier::AnyConstantDelay, delay, k)?;
    let (fourth, worst_constant, fourth_count) = constant_delay_tier(region, Tier::ConstantDelay, delay, k)?;
    Ok(ExaminedTiers {
        tiers: [any_network_tier(region, network, k), bounded_delay_tier(region, network, k), third, fourth],
        worst_constant,
        count: third_count.max(fourth_count),
    })
}
