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
use std::f64::consts::TAU;

use num_complex::Complex64;

use super::complex_box::{Disc, Interval, Rectangle};

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

/// L at a point and a bound on its rounding error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Logarithm {
    pub value: Complex64,
    pub error: f64,
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

/// What a box of the search holds.
enum BoxContent {
    Nothing,
    Solution(f64, f64),
    Undecided { split_frequency: bool },
}

/// Relative slack of the tests on moduli and phases, which keeps their rounding from deciding.
const SLACK: f64 = 1e-13;

/// Whether the moduli of the factors differ everywhere in a box.
fn moduli_differ(factors: &FactorBox, log_growth: f64) -> bool {
    let [first, second] =
        factors.sides.each_ref().map(|side| (side.whole.modulus(), side.coupling.modulus()));
    let whole = (first.0.0 * second.0.0, first.0.1 * second.0.1);
    let growth = log_growth.exp();
    let returned = (first.1.0 * second.1.0 * growth, first.1.1 * second.1.1 * growth);
    whole.0 > returned.1 * (1.0 + SLACK) || whole.1 * (1.0 + SLACK) < returned.0
}

/// Whether an interval of phases, known to `error`, holds no whole number of turns.
fn is_between_turns(low: f64, high: f64, error: f64) -> bool {
    ((low - error) / TAU).ceil() > ((high + error) / TAU).floor()
}

/// Whether the arguments of the factors and the delay never add up to whole turns in a box.
fn phases_differ(factors: &FactorBox) -> bool {
    let Interval { mut low, mut high } = factors.turn;
    let mut size = high.abs();
    for side in &factors.sides {
        let (whole, coupling) = (side.whole.argument(), side.coupling.argument());
        low += whole.low - coupling.high;
        high += whole.high - coupling.low;
        size += whole.low.abs().max(whole.high.abs()) + coupling.low.abs().max(coupling.high.abs());
    }
    is_between_turns(low, high, SLACK * size)
}

/// A disc around a derivative of L; `None` if a factor may be 0.
fn log_derivative(sides: &[SideFactors; 2], (slopes, turn): &([SideSlopes; 2], Interval)) -> Option<Disc> {
    let mut sum = Disc {
        centre: Complex64::new(0.0, 0.5 * (turn.low + turn.high)),
        radius: 0.5 * (turn.high - turn.low),
    };
    for (side, slope) in sides.iter().zip(slopes) {
        // With N = A + D: N'/N − D'/D = (A' − D' A/D)/N, which keeps the digits where A is small.
        let ratio = Disc::around(&side.alone).times(Disc::around(&side.coupling).reciprocal()?);
        let change = Disc::around(&slope.alone).minus(Disc::around(&slope.coupling).times(ratio));
        sum = sum.plus(change.times(Disc::around(&side.whole).reciprocal()?));
    }
    Some(sum)
}

/// Im(conj(a) b), the component of b perpendicular to a times |a|, for the box search.
fn cross_product(a: Complex64, b: Complex64) -> f64 {
    a.re * b.im - a.im * b.re
}

/// Decides whether a box of the search holds no solution, at most one, or must be split.
fn examine_box(function: &impl LineFunction, part: &Region) -> BoxContent {
    if function.is_excluded(part) {
        return BoxContent::Nothing;
    }
    let factors = function.factors(part);
    if moduli_differ(&factors, function.log_growth()) || phases_differ(&factors) {
        return BoxContent::Nothing;
    }
    let (w, p) = (0.5 * (part.frequency.0 + part.frequency.1), 0.5 * (part.parameter.0 + part.parameter.1));
    let (dw, dp) = (w - part.frequency.0, p - part.parameter.0);
    let derivatives = log_derivative(&factors.sides, &factors.by_frequency)
        .zip(log_derivative(&factors.sides, &factors.by_parameter));
    let Some((by_w, by_p)) = derivatives else {
        if dw <= 1e-15 * w && dp <= 1e-15 * p {
            return BoxContent::Solution(w, p);
        }
        return BoxContent::Undecided { split_frequency: frequency_moves_more(&factors, dw, dp) };
    };

    // Where the function is real its phase is a multiple of π, and leaves it at once if it is monotone.
    let ends = [part.frequency.0, part.frequency.1];
    let mut waits_for_parameter = false;
    if ends.iter().any(|&end| function.is_real_at(end)) {
        let slope = by_w.centre.im.abs() - by_w.radius;
        let size = by_w.centre.im.abs() + by_w.radius;
        if slope > SLACK * size && 2.0 * dw * size < 0.99 * std::f64::consts::PI {
            return BoxContent::Nothing;
        }
        // Where one value of the parameter leaves no doubt about the slope, the range of the parameter does.
        let single = function.factors(&Region { parameter: (p, p), ..*part });
        waits_for_parameter = log_derivative(&single.sides, &single.by_frequency).is_some_and(|by_w| {
            let size = by_w.centre.im.abs() + by_w.radius;
            by_w.centre.im.abs() - by_w.radius > SLACK * size && 2.0 * dw * size < 0.99 * std::f64::consts::PI
        });
    }

    // The value at the centre, less the nearest multiple of 2πj, and its possible change over the box.
    let Logarithm { value, error } = function.logarithm(w, p);
    let turns = (value.im / TAU).round();
    let value = Complex64::new(value.re, value.im - turns * TAU);
    let reach = |disc: &Disc, component: f64| component.abs() + disc.radius;
    let real_change = reach(&by_w, by_w.centre.re) * dw + reach(&by_p, by_p.centre.re) * dp + error;
    let phase_change = reach(&by_w, by_w.centre.im) * dw + reach(&by_p, by_p.centre.im) * dp + error;
    if value.re.abs() > real_change
        || is_between_turns(
            value.im - phase_change,
            value.im + phase_change,
            f64::EPSILON * TAU * turns.abs(),
        )
    {
        return BoxContent::Nothing;
    }
    // Another multiple of 2πj may be reached, too.
    let one_turn = phase_change + value.im.abs() < 0.99 * TAU;

    // Along the direction of one derivative only the other one and the curvature change the value.
    let determinant = cross_product(by_w.centre, by_p.centre);
    let (w_size, p_size) = (by_w.centre.norm(), by_p.centre.norm());
    let remainder = by_w.radius * dw + by_p.radius * dp + error;
    if one_turn
        && (cross_product(by_w.centre, value).abs() > determinant.abs() * dp + w_size * remainder
            || cross_product(by_p.centre, value).abs() > determinant.abs() * dw + p_size * remainder)
    {
        return BoxContent::Nothing;
    }
    // At most one solution if the derivative stays invertible over the box.
    let injective = one_turn
        && by_w.radius * p_size + by_p.radius * w_size + by_w.radius * by_p.radius < 0.5 * determinant.abs();
    if injective && let Some(content) = newton_in_box(function, part, (w, p), turns) {
        return content;
    }
    // A box this narrow holds at most a double solution, where two branches touch.
    if dw <= 1e-13 * w && dp <= 1e-13 * p {
        return BoxContent::Solution(w, p);
    }
    let frequency_matters = (w_size + by_w.radius) * dw > (p_size + by_p.radius) * dp;
    BoxContent::Undecided { split_frequency: frequency_matters && !waits_for_parameter }
}

/// Whether the frequency changes the factors of a box more than the parameter does, relative to their size.
fn frequency_moves_more(factors: &FactorBox, dw: f64, dp: f64) -> bool {
    let largest = |slopes: &[SideSlopes; 2], d: f64| {
        let sides = slopes.iter().zip(&factors.sides);
        sides
            .flat_map(|(slope, side)| {
                let own = slope.alone.modulus().1 + slope.coupling.modulus().1;
                [own / side.whole.modulus().1, slope.coupling.modulus().1 / side.coupling.modulus().1]
            })
            .map(|change| change * d)
            .filter(|change| !change.is_nan())
            .fold(0.0, f64::max)
    };
    largest(&factors.by_frequency.0, dw) > largest(&factors.by_parameter.0, dp)
}

/// Newton's iteration in a box of the search with at most one solution; `None` if it leaves the box.
fn newton_in_box(
    function: &impl LineFunction,
    part: &Region,
    (mut w, mut p): (f64, f64),
    turns: f64,
) -> Option<BoxContent> {
    let inside = |(low, high): (f64, f64), x: f64, slack: f64| {
        let margin = slack * (high - low) + 1e-13 * x.abs();
        x >= low - margin && x <= high + margin
    };
    let mut previous = f64::INFINITY;
    for _ in 0..30 {
        let factors = function.factors(&Region { frequency: (w, w), parameter: (p, p) });
        let by_w = log_derivative(&factors.sides, &factors.by_frequency)?.centre;
        let by_p = log_derivative(&factors.sides, &factors.by_parameter)?.centre;
        let value = function.logarithm(w, p).value - Complex64::new(0.0, turns * TAU);
        let determinant = cross_product(by_w, by_p);
        let step_w = cross_product(by_p, value) / determinant;
        let step_p = -cross_product(by_w, value) / determinant;
        w += step_w;
        p += step_p;
        let size = (step_w / w).abs() + (step_p / p).abs();
        if !inside(part.frequency, w, 1.0) || !inside(part.parameter, p, 1.0) {
            return None;
        }
        if size < 1e-15 || size < 1e-9 && size >= 0.5 * previous {
            let own = inside(part.frequency, w, 1e-9) && inside(part.parameter, p, 1e-9);
            return Some(if own { BoxContent::Solution(w, p) } else { BoxContent::Nothing });
        }
        previous = size;
    }
    None
}
