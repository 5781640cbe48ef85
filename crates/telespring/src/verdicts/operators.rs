//! Verdicts over a range of operators: a grip varies, and the worst one counts.

use super::zero_order_hold::SampledPlant;
use super::{Network, Tier, any_network, bounded_delay, sampled_gain};
use crate::criteria::is_in_any;
use crate::criteria::{critical_stiffness, is_delay_independent, maximum_stiffness, stable_delays};
use crate::error::{InvalidInput, Result};
use crate::model::{Dyad, DyadAxis, Operator, Side};

/// All operators between two: a box in mass, damping and stiffness, per axis.
#[derive(Debug, Clone, PartialEq)]
pub struct OperatorRange {
    low: Operator,
    high: Operator,
}

impl OperatorRange {
    /// The operators from `low` to `high`, both included.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where the two differ in their number of axes or a lower end lies above the upper.
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
                        "Exchange the two.",
                    ));
                }
            }
        }
        Ok(Self { low, high })
    }

    /// The lower end.
    pub fn low(&self) -> &Operator {
        &self.low
    }

    /// The upper end.
    pub fn high(&self) -> &Operator {
        &self.high
    }

    /// The middle of the range.
    pub fn middle(&self) -> Operator {
        let mean = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect();
        Operator::new(
            mean(self.low.mass(), self.high.mass()),
            mean(self.low.damping(), self.high.damping()),
            mean(self.low.stiffness(), self.high.stiffness()),
        )
        .expect("the mean of two valid values is valid")
    }

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
    /// Stiffness to the ground, N/m.
    pub stiffness: f64,
}

/// Both operators in six numbers: mass, damping, stiffness of the first, then of the second.
type Six = [f64; 6];

/// The box of both operators on one axis, with the robots they hold.
pub(super) struct OperatorBox {
    robots: [Side; 2],
    ends: [[f64; 2]; 6],
    coupling_damping: f64,
}

/// Steps per side of the grid inside the box, where a side has a length.
const LEVELS: usize = 3;
/// The pattern search ends at this part of the box.
const FINEST: f64 = 1e-4;

impl OperatorBox {
    /// The box of one axis: the ranges, or the dyad's own operators as a single point.
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

    /// The axis held by these operators.
    pub fn axis(&self, at: &Six) -> DyadAxis {
        let side = |i: usize| Side {
            mass: self.robots[i].mass + at[3 * i],
            damping: self.robots[i].damping + at[3 * i + 1],
            ground_stiffness: at[3 * i + 2],
        };
        DyadAxis { sides: [side(0), side(1)], coupling_damping: self.coupling_damping }
    }

    /// The grid with `levels` values on each side that has a length; its corners with 2.
    fn grid(&self, levels: usize) -> Vec<Six> {
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

    /// The corners of the box.
    pub fn corners(&self) -> Vec<Six> {
        self.grid(2)
    }

    /// The most mass with the least damping and stiffness: the worst of tiers 1 and 2 in closed form.
    fn limpest(&self) -> Six {
        let [m1, b1, k1, m2, b2, k2] = self.ends;
        [m1[1], b1[0], k1[0], m2[1], b2[0], k2[0]]
    }
}

pub(super) fn as_operators(at: &Six) -> [OperatorPoint; 2] {
    [0, 3].map(|i| OperatorPoint { mass: at[i], damping: at[i + 1], stiffness: at[i + 2] })
}

/// One tier on one axis, the worst over all operators.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisTier {
    /// Which tier.
    pub tier: Tier,
    /// The largest stiffness, N/m; `None` where the tier has no rule for this dyad.
    pub stiffness_bound: Option<f64>,
    /// True where that stiffness is itself allowed.
    pub attained: bool,
    /// True where the stiffness in question keeps the tier's rule, for every operator examined.
    pub satisfied: bool,
    /// The operators with the least bound.
    pub operators: [OperatorPoint; 2],
}

/// All tiers on one axis and how many pairs of operators were examined.
pub(super) struct Examined {
    pub tiers: [AxisTier; 4],
    pub worst_constant: Six,
    pub count: usize,
}

fn keeps(bound: f64, attained: bool, k: f64) -> bool {
    k < bound || (attained && k == bound)
}

/// Tier 1: exact at the limpest corner for continuous controllers; sampled ones see every corner.
fn any_network(region: &OperatorBox, network: &Network, k: f64) -> AxisTier {
    let limpest = region.limpest();
    let corners = region.corners();
    let none = AxisTier {
        tier: Tier::AnyNetwork,
        stiffness_bound: None,
        attained: false,
        satisfied: false,
        operators: as_operators(&limpest),
    };
    let Some((mut bound, mut attained)) = any_network::stiffness_bound(&region.axis(&limpest), network)
    else {
        return none;
    };
    let mut worst = limpest;
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
        satisfied: keeps(bound, attained, k),
        operators: as_operators(&worst),
    }
}

/// Tier 2: the least damping, exactly.
fn bounded_delay(region: &OperatorBox, network: &Network, k: f64) -> AxisTier {
    let worst = region.limpest();
    let damping = region.axis(&worst).sides.map(|side| side.damping);
    let bound = (region.coupling_damping == 0.0).then(|| {
        bounded_delay::stiffness_bound(damping, network.oldest_partner_sample(), network.oldest_own_sample())
    });
    AxisTier {
        tier: Tier::BoundedVaryingDelay,
        stiffness_bound: bound,
        attained: false,
        satisfied: bound.is_some_and(|bound| k < bound),
        operators: as_operators(&worst),
    }
}

/// True where F enters its first positive root at ξ = 0 when k reaches `critical`: still stable there.
fn is_attained(axis: &DyadAxis, critical: f64) -> bool {
    let [first, second] = axis.sides;
    let (b1, b2, c) = (first.damping, second.damping, axis.coupling_damping);
    let entry = (b1 * b1 + b2 * b2 + 2.0 * c * (b1 + b2)) / (2.0 * (first.mass + second.mass));
    // A tangency comes before this entry; 1e-12 parts the two in rounding.
    axis.is_free() && (entry - critical).abs() <= 1e-12 * entry
}

/// Tiers 3 and 4: a grid through the box, corners included, then a pattern search from its worst point.
fn constant_delay(region: &OperatorBox, tier: Tier, delay: f64, k: f64) -> Result<(AxisTier, Six, usize)> {
    let bound = |at: &Six| -> Result<f64> {
        let axis = region.axis(at);
        if tier == Tier::AnyConstantDelay {
            Ok(critical_stiffness(&axis))
        } else {
            maximum_stiffness(&axis, delay)
        }
    };
    let holds = |at: &Six, bound: f64| -> Result<bool> {
        let axis = region.axis(at);
        if k < bound {
            return Ok(true);
        }
        if tier == Tier::AnyConstantDelay {
            // Grounded handles may have bands above the first stiffness that some delay destabilises.
            Ok(keeps(bound, is_attained(&axis, bound), k) || is_delay_independent(&axis, k)?)
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
        operators: as_operators(&worst.0),
    };
    Ok((verdict, worst.0, count))
}

/// All four tiers on one axis.
pub(super) fn examine(region: &OperatorBox, network: &Network, k: f64) -> Result<Examined> {
    let delay = network.buffered_mean();
    let (third, _, third_count) = constant_delay(region, Tier::AnyConstantDelay, delay, k)?;
    let (fourth, worst_constant, fourth_count) = constant_delay(region, Tier::ConstantDelay, delay, k)?;
    Ok(Examined {
        tiers: [any_network(region, network, k), bounded_delay(region, network, k), third, fourth],
        worst_constant,
        count: third_count.max(fourth_count),
    })
}
