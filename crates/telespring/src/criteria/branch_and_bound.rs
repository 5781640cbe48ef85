//! Branch and bound for all crossings of a vertical line over a range of one parameter.
//!
//! A root s = −σ + jω gives two real equations for the frequency ω and the parameter p (a stiffness or an
//! added damping). A second-order Taylor bound discards boxes of (ω, p) without a solution. A box with at
//! most one solution goes to Newton's iteration; any other box is halved. No solution is missed, and the
//! extreme one needs no bisection on stability.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use num_complex::Complex64;

/// The value and first derivatives of a characteristic function on the line.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineJet {
    pub value: Complex64,
    pub by_frequency: Complex64,
    pub by_parameter: Complex64,
}

/// Bounds on the magnitudes of the second derivatives over a box.
#[derive(Debug, Clone, Copy)]
pub(super) struct Curvature {
    pub frequency: f64,
    pub mixed: f64,
    pub parameter: f64,
}

/// A characteristic function on a vertical line, as a function of frequency and parameter.
pub(super) trait LineFunction {
    /// The value and derivatives on the line that the box search scans, at a frequency and a parameter.
    fn jet(&self, frequency: f64, parameter: f64) -> LineJet;
    /// Bounds on the second derivatives over a box of the search.
    fn curvature(&self, region: &Region) -> Curvature;
    /// Whether the magnitudes of the two terms alone exclude a zero in a box of the search, for any delay phase.
    fn magnitudes_differ(&self, region: &Region) -> bool;
}

/// A box of frequencies and parameters.
#[derive(Debug, Clone, Copy)]
pub(super) struct Region {
    pub frequency: (f64, f64),
    pub parameter: (f64, f64),
}

/// Which solutions to compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wanted {
    /// The solution with the smallest parameter.
    Least,
    /// The solution with the largest parameter.
    Greatest,
    /// All solutions.
    All,
}

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

/// The parameters at which a root lies on the line, by box search, ascending; a single value if only an
/// extreme is wanted.
pub(super) fn crossing_parameters(function: &impl LineFunction, region: Region, wanted: Wanted) -> Vec<f64> {
    let mut solutions: Vec<(f64, f64)> = Vec::new();
    let mut waiting = BinaryHeap::new();
    let priority = |region: &Region| match wanted {
        Wanted::Least => -region.parameter.0,
        Wanted::Greatest => region.parameter.1,
        Wanted::All => 0.0,
    };
    waiting.push(QueuedBox { priority: priority(&region), region });
    while let Some(QueuedBox { region: part, priority: reach }) = waiting.pop() {
        let settled = solutions.iter().any(|&(_, parameter)| match wanted {
            Wanted::Least => -parameter >= reach,
            Wanted::Greatest => parameter >= reach,
            Wanted::All => false,
        });
        if settled {
            break;
        }
        match examine_box(function, &part, &region) {
            BoxContent::Nothing => {}
            BoxContent::Solution(frequency, parameter) => {
                let known = |&(w, p): &(f64, f64)| nearly_equal(w, frequency) && nearly_equal(p, parameter);
                if !solutions.iter().any(known) {
                    solutions.push((frequency, parameter));
                }
            }
            BoxContent::Undecided { halve_frequency } => {
                for part in split_region(&part, halve_frequency) {
                    waiting.push(QueuedBox { priority: priority(&part), region: part });
                }
            }
        }
    }
    let mut parameters: Vec<f64> = solutions.into_iter().map(|(_, parameter)| parameter).collect();
    parameters.sort_by(f64::total_cmp);
    match wanted {
        Wanted::Least => parameters.truncate(1),
        Wanted::Greatest => drop(parameters.drain(..parameters.len().saturating_sub(1))),
        Wanted::All => {}
    }
    parameters
}

/// Whether two solutions of the box search agree to a relative 1e-9.
fn nearly_equal(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

/// Halves a box of the search along its frequency or its parameter.
fn split_region(region: &Region, frequency: bool) -> [Region; 2] {
    let halve = |(low, high): (f64, f64)| {
        let middle = 0.5 * (low + high);
        ((low, middle), (middle, high))
    };
    if frequency {
        let (low, high) = halve(region.frequency);
        [Region { frequency: low, ..*region }, Region { frequency: high, ..*region }]
    } else {
        let (low, high) = halve(region.parameter);
        [Region { parameter: low, ..*region }, Region { parameter: high, ..*region }]
    }
}

enum BoxContent {
    Nothing,
    Solution(f64, f64),
    Undecided { halve_frequency: bool },
}

/// Im(conj(a) b), the component of b perpendicular to a times |a|, for the box search.
fn cross_product(a: Complex64, b: Complex64) -> f64 {
    a.re * b.im - a.im * b.re
}

/// Decides whether a box of the search holds no solution, at most one, or must be halved.
fn examine_box(function: &impl LineFunction, part: &Region, whole: &Region) -> BoxContent {
    if function.magnitudes_differ(part) {
        return BoxContent::Nothing;
    }
    let middle = |(low, high): (f64, f64)| 0.5 * (low + high);
    let (w, p) = (middle(part.frequency), middle(part.parameter));
    let (dw, dp) = (w - part.frequency.0, p - part.parameter.0);
    let jet = function.jet(w, p);
    let bound = function.curvature(part);
    let remainder =
        0.5 * (bound.frequency * dw * dw + 2.0 * bound.mixed * dw * dp + bound.parameter * dp * dp);
    let (by_w, by_p) = (jet.by_frequency.norm(), jet.by_parameter.norm());

    // No solution if the value exceeds its possible change over the box, in size or along one direction.
    let determinant = cross_product(jet.by_frequency, jet.by_parameter);
    if jet.value.norm() > by_w * dw + by_p * dp + remainder
        || cross_product(jet.by_frequency, jet.value).abs() > determinant.abs() * dp + by_w * remainder
        || cross_product(jet.by_parameter, jet.value).abs() > determinant.abs() * dw + by_p * remainder
    {
        return BoxContent::Nothing;
    }

    // At most one solution if the derivative stays invertible over the box.
    let change_by_w = bound.frequency * dw + bound.mixed * dp;
    let change_by_p = bound.mixed * dw + bound.parameter * dp;
    let injective =
        change_by_w * by_p < 0.5 * determinant.abs() && change_by_p * by_w < 0.5 * determinant.abs();
    // A box this narrow holds at most a double solution, where two branches touch.
    let exhausted = dw <= 1e-12 * whole.frequency.1 && dp <= 1e-12 * p.abs();
    if injective || exhausted {
        return newton_in_box(function, w, p, part, injective);
    }
    BoxContent::Undecided {
        halve_frequency: by_w * dw + bound.frequency * dw * dw > by_p * dp + bound.parameter * dp * dp,
    }
}

/// Newton's iteration from the middle of a box of the search with at most one solution.
fn newton_in_box(
    function: &impl LineFunction,
    mut w: f64,
    mut p: f64,
    part: &Region,
    injective: bool,
) -> BoxContent {
    let inside = |(low, high): (f64, f64), x: f64, slack: f64| {
        let margin = slack * (high - low) + 1e-12 * x.abs();
        x >= low - margin && x <= high + margin
    };
    if !injective {
        return BoxContent::Solution(w, p);
    }
    let mut previous = f64::INFINITY;
    for _ in 0..60 {
        let jet = function.jet(w, p);
        let determinant = cross_product(jet.by_frequency, jet.by_parameter);
        let step_w = cross_product(jet.by_parameter, jet.value) / determinant;
        let step_p = -cross_product(jet.by_frequency, jet.value) / determinant;
        w += step_w;
        p += step_p;
        let size = (step_w / w).abs() + (step_p / p).abs();
        if !inside(part.frequency, w, 1.0) || !inside(part.parameter, p, 1.0) {
            break;
        }
        if size < 1e-15 || size < 1e-11 && size >= 0.5 * previous {
            let own = inside(part.frequency, w, 1e-9) && inside(part.parameter, p, 1e-9);
            return if own { BoxContent::Solution(w, p) } else { BoxContent::Nothing };
        }
        previous = size;
    }
    // The iteration left the box: its halves decide whether it holds the solution.
    let (dw, dp) = (part.frequency.1 - part.frequency.0, part.parameter.1 - part.parameter.0);
    if dw <= 1e-13 * w.abs() && dp <= 1e-13 * p.abs() {
        return BoxContent::Nothing;
    }
    let jet = function
        .jet(0.5 * (part.frequency.0 + part.frequency.1), 0.5 * (part.parameter.0 + part.parameter.1));
    BoxContent::Undecided { halve_frequency: jet.by_frequency.norm() * dw > jet.by_parameter.norm() * dp }
}
