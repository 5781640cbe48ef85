//! All points at which a characteristic root lies on a vertical line, over a range of one parameter.
//!
//! A root s = −σ + jω gives two real equations for the frequency ω and the parameter p (the stiffness
//! or an added damping). A box of (ω, p) without a solution is discarded by a Taylor bound of
//! second order, one with at most one solution is handed to Newton's iteration, any other is halved: no
//! solution is missed, and the extreme one needs no search on stable and unstable.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use num_complex::Complex64;

/// The value of a characteristic function on the line and its first derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct Jet {
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

/// A characteristic function restricted to a vertical line, as a function of frequency and parameter.
pub(super) trait LineFunction {
    fn jet(&self, frequency: f64, parameter: f64) -> Jet;
    fn curvature(&self, region: &Region) -> Curvature;
    /// Whether the magnitudes of the two terms alone rule out a zero in the box, however fast the
    /// delay turns their phases.
    fn magnitudes_differ(&self, region: &Region) -> bool;
}

/// A box of frequencies and parameters.
#[derive(Debug, Clone, Copy)]
pub(super) struct Region {
    pub frequency: (f64, f64),
    pub parameter: (f64, f64),
}

/// Which solutions are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wanted {
    /// The one of the least parameter.
    Least,
    /// The one of the greatest parameter.
    Greatest,
    /// All of them.
    All,
}

/// A box waiting for its examination, ordered so that the most promising parameter comes first.
struct Waiting {
    priority: f64,
    region: Region,
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.priority == other.priority
    }
}
impl Eq for Waiting {}
impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        self.priority.total_cmp(&other.priority)
    }
}

/// The parameters at which a root lies on the line, ascending; one value for an extreme one.
pub(super) fn solve(function: &impl LineFunction, region: Region, wanted: Wanted) -> Vec<f64> {
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut waiting = BinaryHeap::new();
    let priority = |region: &Region| match wanted {
        Wanted::Least => -region.parameter.0,
        Wanted::Greatest => region.parameter.1,
        Wanted::All => 0.0,
    };
    waiting.push(Waiting { priority: priority(&region), region });
    while let Some(Waiting { region: part, priority: reach }) = waiting.pop() {
        let settled = found.iter().any(|&(_, parameter)| match wanted {
            Wanted::Least => -parameter >= reach,
            Wanted::Greatest => parameter >= reach,
            Wanted::All => false,
        });
        if settled {
            break;
        }
        match examine(function, &part, &region) {
            Finding::Nothing => {}
            Finding::Solution(frequency, parameter) => {
                let known = |&(w, p): &(f64, f64)| close(w, frequency) && close(p, parameter);
                if !found.iter().any(known) {
                    found.push((frequency, parameter));
                }
            }
            Finding::Undecided { halve_frequency } => {
                for part in halves(&part, halve_frequency) {
                    waiting.push(Waiting { priority: priority(&part), region: part });
                }
            }
        }
    }
    let mut parameters: Vec<f64> = found.into_iter().map(|(_, parameter)| parameter).collect();
    parameters.sort_by(f64::total_cmp);
    match wanted {
        Wanted::Least => parameters.truncate(1),
        Wanted::Greatest => drop(parameters.drain(..parameters.len().saturating_sub(1))),
        Wanted::All => {}
    }
    parameters
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

fn halves(region: &Region, frequency: bool) -> [Region; 2] {
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

enum Finding {
    Nothing,
    Solution(f64, f64),
    Undecided { halve_frequency: bool },
}

/// Im(conj(a) b): the part of b across the direction of a, times |a|.
fn across(a: Complex64, b: Complex64) -> f64 {
    a.re * b.im - a.im * b.re
}

fn examine(function: &impl LineFunction, part: &Region, whole: &Region) -> Finding {
    if function.magnitudes_differ(part) {
        return Finding::Nothing;
    }
    let middle = |(low, high): (f64, f64)| 0.5 * (low + high);
    let (w, p) = (middle(part.frequency), middle(part.parameter));
    let (dw, dp) = (w - part.frequency.0, p - part.parameter.0);
    let jet = function.jet(w, p);
    let bound = function.curvature(part);
    let remainder =
        0.5 * (bound.frequency * dw * dw + 2.0 * bound.mixed * dw * dp + bound.parameter * dp * dp);
    let (by_w, by_p) = (jet.by_frequency.norm(), jet.by_parameter.norm());

    // No solution where the value exceeds what the box can change, in size or across one direction.
    let determinant = across(jet.by_frequency, jet.by_parameter);
    if jet.value.norm() > by_w * dw + by_p * dp + remainder
        || across(jet.by_frequency, jet.value).abs() > determinant.abs() * dp + by_w * remainder
        || across(jet.by_parameter, jet.value).abs() > determinant.abs() * dw + by_p * remainder
    {
        return Finding::Nothing;
    }

    // At most one solution where the derivative stays invertible over the box.
    let change_by_w = bound.frequency * dw + bound.mixed * dp;
    let change_by_p = bound.mixed * dw + bound.parameter * dp;
    let injective =
        change_by_w * by_p < 0.5 * determinant.abs() && change_by_p * by_w < 0.5 * determinant.abs();
    // A box this narrow holds, if anything, a double solution, where two branches touch.
    let exhausted = dw <= 1e-12 * whole.frequency.1 && dp <= 1e-12 * p.abs();
    if injective || exhausted {
        return newton(function, w, p, part, injective);
    }
    Finding::Undecided {
        halve_frequency: by_w * dw + bound.frequency * dw * dw > by_p * dp + bound.parameter * dp * dp,
    }
}

/// Newton's iteration from the middle of a box that holds at most one solution.
fn newton(function: &impl LineFunction, mut w: f64, mut p: f64, part: &Region, injective: bool) -> Finding {
    let inside = |(low, high): (f64, f64), x: f64, slack: f64| {
        let margin = slack * (high - low) + 1e-12 * x.abs();
        x >= low - margin && x <= high + margin
    };
    if !injective {
        return Finding::Solution(w, p);
    }
    let mut previous = f64::INFINITY;
    for _ in 0..60 {
        let jet = function.jet(w, p);
        let determinant = across(jet.by_frequency, jet.by_parameter);
        let step_w = across(jet.by_parameter, jet.value) / determinant;
        let step_p = -across(jet.by_frequency, jet.value) / determinant;
        w += step_w;
        p += step_p;
        let size = (step_w / w).abs() + (step_p / p).abs();
        if !inside(part.frequency, w, 1.0) || !inside(part.parameter, p, 1.0) {
            break;
        }
        if size < 1e-15 || size < 1e-11 && size >= 0.5 * previous {
            let own = inside(part.frequency, w, 1e-9) && inside(part.parameter, p, 1e-9);
            return if own { Finding::Solution(w, p) } else { Finding::Nothing };
        }
        previous = size;
    }
    // The iteration left the box: whether it holds the solution is for its halves to say.
    let (dw, dp) = (part.frequency.1 - part.frequency.0, part.parameter.1 - part.parameter.0);
    if dw <= 1e-13 * w.abs() && dp <= 1e-13 * p.abs() {
        return Finding::Nothing;
    }
    let jet = function
        .jet(0.5 * (part.frequency.0 + part.frequency.1), 0.5 * (part.parameter.0 + part.parameter.1));
    Finding::Undecided { halve_frequency: jet.by_frequency.norm() * dw > jet.by_parameter.norm() * dp }
}
