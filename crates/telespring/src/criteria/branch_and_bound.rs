//! Branch and bound for all crossings of a line or circle over a range of one parameter.
//!
//! At a crossing N₁ N₂ = D₁ D₂ g e^(−jωT): the factors of both sides, a constant growth g, and the delay. Its
//! logarithm L(ω, p) = ln(N₁ N₂/(D₁ D₂ g)) + jωT is then a multiple of 2πj. A box of frequencies ω and
//! parameters p (a stiffness or an added damping) holds no crossing
//!
//! * if the moduli or the arguments of the factors exclude it. Both come from rectangles around the factors,
//!   whatever the scales of the two variables are;
//! * if the derivatives of L exclude it. The delay is linear in L, so that a long one costs nothing.
//!
//! A box with at most one crossing goes to Newton's iteration; any other box is split. No crossing is missed,
//! and the extreme one needs no bisection on stability.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

use num_complex::Complex64;

use super::box_tests::{BoxContent, examine_box};
use super::complex_box::{Interval, Rectangle};

/// The three factors of one side: N = A + D.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SideFactors {
    /// A: the side without the coupling.
    pub alone: Rectangle,
    /// D: the coupling, as the delayed term has it.
    pub coupling: Rectangle,
    /// N: both, enclosed as one.
    pub whole: Rectangle,
}

/// A derivative of the factors of one side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SideSlopes {
    /// The derivative of A.
    pub alone: Rectangle,
    /// The derivative of D.
    pub coupling: Rectangle,
}

/// The factors of both sides over a box, the phase of the delay, and their derivatives by both variables.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FactorBox {
    pub sides: [SideFactors; 2],
    pub turn: Interval,
    pub by_frequency: ([SideSlopes; 2], Interval),
    pub by_parameter: ([SideSlopes; 2], Interval),
}

/// L at a point, and bounds on the rounding errors of its real and its imaginary part.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Logarithm {
    /// L without its half turns.
    pub value: Complex64,
    /// Half turns of the factors, kept apart so that the rest keeps its digits.
    pub half_turns: i32,
    pub error: Complex64,
}

impl Logarithm {
    /// The nearest whole number of turns, as half turns.
    pub fn nearest_turns(&self) -> f64 {
        let whole = 0.5 * (self.value.im / PI + f64::from(self.half_turns));
        2.0 * whole.round()
    }

    /// L less a number of half turns.
    pub fn less(&self, half_turns: f64) -> Complex64 {
        Complex64::new(self.value.re, self.value.im - (half_turns - f64::from(self.half_turns)) * PI)
    }
}

/// A characteristic function on a line or circle, as a function of two variables: one that grows with the
/// frequency, and the parameter.
pub(crate) trait LineFunction {
    /// The factors and their derivatives over a box of the search.
    fn factors(&self, region: &Region) -> FactorBox;
    /// L = ln(N₁ N₂/(D₁ D₂ g)) + jωT at a point.
    fn logarithm(&self, frequency: f64, parameter: f64) -> Logarithm;
    /// ln g, the constant growth of the delayed term.
    fn log_growth(&self) -> f64;
    /// True where the function is real for every parameter: crossings at this frequency are not searched.
    fn is_real_at(&self, frequency: f64) -> bool;
    /// True if crossings anywhere in this box are not wanted.
    fn is_excluded(&self, region: &Region) -> bool;
    /// True if D is the same function for both sides.
    fn has_common_coupling(&self) -> bool {
        false
    }
    /// The largest number of boxes of one search.
    fn most_boxes(&self) -> usize {
        MAX_BOXES
    }
}

/// A box of frequencies and parameters.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Region {
    pub frequency: (f64, f64),
    pub parameter: (f64, f64),
}

/// Which crossings to compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// The crossing with the smallest parameter.
    Least,
    /// The crossing with the largest parameter.
    Greatest,
    /// All crossings.
    All,
}

/// The outcome of a search.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Found {
    /// The parameters of the crossings, ascending; at most one if only an extreme is wanted.
    All(Vec<f64>),
    /// The search ended at its largest number of boxes. No crossing lies before this parameter, from the end at
    /// which the search starts.
    Unfinished(f64),
}

/// The usual largest number of boxes of one search: less than a second.
const MAX_BOXES: usize = 250_000;

/// A box in the queue, ordered by the most promising parameter.
struct QueuedBox {
    priority: f64,
    region: Region,
}

impl PartialEq for QueuedBox {
    /// Whether two boxes in the search's queue have the same priority.
    fn eq(&self, other: &Self) -> bool {
        self.priority == other.priority
    }
}
impl Eq for QueuedBox {}
impl PartialOrd for QueuedBox {
    /// The order of two boxes in the search's queue.
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for QueuedBox {
    /// The order of two boxes in the search's queue, largest priority last.
    fn cmp(&self, other: &Self) -> Ordering {
        self.priority.total_cmp(&other.priority)
    }
}

/// The parameters at which a root lies on the line, by box search.
pub(crate) fn crossing_parameters(function: &impl LineFunction, region: Region, wanted: Wanted) -> Found {
    let mut solutions: Vec<f64> = Vec::new();
    let mut waiting = BinaryHeap::new();
    // The larger, the more promising; an extreme solution settles all boxes that cannot beat it.
    let promise = |least: f64, greatest: f64| match wanted {
        Wanted::Least => -least,
        Wanted::Greatest => greatest,
        Wanted::All => 0.0,
    };
    let mut settled = f64::NEG_INFINITY;
    let priority = |region: &Region| promise(region.parameter.0, region.parameter.1);
    waiting.push(QueuedBox { priority: priority(&region), region });
    let mut examined = 0;
    while let Some(QueuedBox { region: part, priority: reach }) = waiting.pop() {
        if reach <= settled && wanted != Wanted::All {
            break;
        }
        examined += 1;
        if examined > function.most_boxes() {
            return Found::Unfinished(reach.abs());
        }
        match examine_box(function, &part) {
            BoxContent::Nothing => {}
            BoxContent::Solution(frequency, parameter) => {
                let point = Region { frequency: (frequency, frequency), parameter: (parameter, parameter) };
                if function.is_excluded(&point) {
                    continue;
                }
                if wanted != Wanted::All {
                    if promise(parameter, parameter) <= settled {
                        continue;
                    }
                    settled = promise(parameter, parameter);
                    solutions.clear();
                }
                solutions.push(parameter);
            }
            BoxContent::Undecided { split_frequency } => {
                for part in split_region(&part, split_frequency) {
                    waiting.push(QueuedBox { priority: priority(&part), region: part });
                }
            }
        }
    }
    solutions.sort_by(f64::total_cmp);
    solutions.dedup_by(|next, last| (*next - *last).abs() <= 1e-9 * *last);
    Found::All(solutions)
}

/// A point between two positive ends: in the middle, or by its logarithm where they are decades apart.
fn middle((low, high): (f64, f64)) -> f64 {
    if high <= 4.0 * low {
        0.5 * (low + high)
    } else if low > 0.0 {
        low.sqrt() * high.sqrt()
    } else {
        0.125 * high
    }
}

/// Splits a box of the search along its frequency or its parameter.
fn split_region(region: &Region, frequency: bool) -> [Region; 2] {
    let split = |(low, high): (f64, f64)| {
        let middle = middle((low, high));
        ((low, middle), (middle, high))
    };
    if frequency {
        let (low, high) = split(region.frequency);
        [Region { frequency: low, ..*region }, Region { frequency: high, ..*region }]
    } else {
        let (low, high) = split(region.parameter);
        [Region { parameter: low, ..*region }, Region { parameter: high, ..*region }]
    }
}
