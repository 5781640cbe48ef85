//! Ranges of operators: a grip varies, and the worst operator counts.

use super::Network;
use super::ranges::{Family, Hold, SideRange};
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
pub(super) type OperatorPair = [f64; 6];

/// The box of both operators on one axis, with the robots that they hold.
pub(super) struct OperatorBox {
    robots: [Side; 2],
    ends: [[f64; 2]; 6],
    coupling_damping: f64,
}

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

    /// True if the box holds one pair of operators only.
    pub fn is_point(&self) -> bool {
        self.ends.iter().all(|[low, high]| low == high)
    }

    /// True if the box holds an operator that ties a handle to the ground.
    pub fn has_grounded(&self) -> bool {
        self.ends[2][1] > 0.0 || self.ends[5][1] > 0.0
    }

    /// The corners of the box of operators.
    pub fn corners(&self) -> Vec<OperatorPair> {
        let mut points = vec![[0.0; 6]];
        for (dimension, [low, high]) in self.ends.iter().enumerate() {
            let values = if low == high { &[*low][..] } else { &[*low, *high][..] };
            points = points
                .iter()
                .flat_map(|point| {
                    values.iter().map(move |&value| {
                        let mut point = *point;
                        point[dimension] = value;
                        point
                    })
                })
                .collect();
        }
        points
    }

    /// The operators in the middle of the box.
    pub fn middle(&self) -> OperatorPair {
        self.ends.map(|[low, high]| 0.5 * (low + high))
    }

    /// The corner with the largest mass and smallest damping and stiffness: the worst case of tiers 1 and
    /// 2.
    pub fn weakest_corner(&self) -> OperatorPair {
        let [m1, b1, k1, m2, b2, k2] = self.ends;
        [m1[1], b1[0], k1[0], m2[1], b2[0], k2[0]]
    }

    /// The operators with which both sides have these values of mass, damping and stiffness.
    pub fn operators_of(&self, sides: &[[f64; 3]; 2]) -> OperatorPair {
        let mut at = [0.0; 6];
        for (i, side) in sides.iter().enumerate() {
            let robot = &self.robots[i];
            for (j, (value, own)) in side.iter().zip([robot.mass, robot.damping, 0.0]).enumerate() {
                let [low, high] = self.ends[3 * i + j];
                // The difference has the rounding of the side's value: an end stays the end.
                let rounding = 1e-12 * (own + low.abs().max(high.abs()));
                at[3 * i + j] = match value - own {
                    apart if apart <= low + rounding => low,
                    apart if apart >= high - rounding => high,
                    apart => apart,
                };
            }
        }
        at
    }

    /// All axes of the box at once, under continuous controllers.
    pub fn family(&self) -> Family {
        let side = |i: usize| {
            let [[m0, m1], [b0, b1], [k0, k1]] =
                [self.ends[3 * i], self.ends[3 * i + 1], self.ends[3 * i + 2]];
            let robot = &self.robots[i];
            SideRange {
                mass: (robot.mass + m0, robot.mass + m1),
                damping: (robot.damping + b0, robot.damping + b1),
                stiffness: (k0, k1),
            }
        };
        Family { sides: [side(0), side(1)], coupling_damping: self.coupling_damping, hold: None }
    }

    /// The same under the sampled controllers of a network.
    pub fn sampled_family(&self, network: &Network) -> Family {
        let hold = Hold { period: network.sample_period(), computing_time: network.computing_time() };
        Family { hold: Some(hold), ..self.family() }
    }
}

/// Converts the six numbers of an operator pair to two operators.
pub(super) fn operator_points(at: &OperatorPair) -> [OperatorPoint; 2] {
    [0, 3].map(|i| OperatorPoint { mass: at[i], damping: at[i + 1], stiffness: at[i + 2] })
}
