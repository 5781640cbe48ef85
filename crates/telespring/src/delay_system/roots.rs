//! From eigenvalues of the collocated generator to certified characteristic roots.

use num_complex::Complex64;

use super::DelaySystem;
use super::collocation::{delayed_states, eigenvalues};
use super::matrix::CharacteristicMatrix;
use super::search::{MOST_TO_FIND, fill, line_with};
use super::zero;
use crate::spectrum::contour::{Stop, zeros_in_rectangle};
use crate::spectrum::{Certificate, Spectrum};

/// The largest order of a collocation matrix: its eigenvalues take about a second.
const LARGEST_ORDER: usize = 400;
/// How many steps a contour may take.
const STEPS: usize = 400_000;
/// Two approximations of one root differ by less than this, relatively to root and system.
const SAME: f64 = 1e-7;

/// A root in the closed upper half-plane and how often it counts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Known {
    pub s: Complex64,
    pub multiplicity: usize,
}

impl Known {
    fn weight(&self) -> usize {
        if self.s.im == 0.0 { self.multiplicity } else { 2 * self.multiplicity }
    }
}

/// The `count` rightmost roots with their certificate.
pub(super) fn rightmost(system: &DelaySystem, count: usize) -> Spectrum {
    let matrix = CharacteristicMatrix::balanced(system, 0.0);
    let states = delayed_states(&matrix).len();
    let size = matrix.size();
    if states == 0 || matrix.longest_delay() == 0.0 {
        return without_delay(&matrix, count);
    }
    let most_nodes = ((LARGEST_ORDER.max(4 * size) - size) / states).max(8);
    let mut nodes = (12 + count / states).min(most_nodes);
    let mut known = at_zero(&matrix);
    let mut searched = false;
    loop {
        // The shifts of the eigenvalue iteration can go in circles; another size breaks the circle.
        let starts = eigenvalues(&matrix, nodes).or_else(|| eigenvalues(&matrix, nodes + 1));
        if let Some(mut starts) = starts {
            starts.retain(|start| start.im >= 0.0);
            starts.sort_by(|a, b| b.re.total_cmp(&a.re));
            // The generator has eigenvalues of its own besides; a margin of good ones is kept.
            starts.truncate(2 * count + 24);
            for start in starts {
                keep(&matrix, &mut known, start);
            }
        }
        sort(&mut known);
        let last = nodes >= most_nodes;
        // A missing root is more often one that needs more nodes than one that counts twice.
        let mut outcome = certify(&matrix, &mut known, count, last || nodes > 60);
        let complete = matches!(outcome, Some((_, Certificate::Complete)));
        // Once: what it cannot find, it cannot find from a few starts more.
        if !complete && !searched && (last || nodes > 60) {
            searched = true;
            outcome = search(&matrix, &mut known, count, outcome);
        }
        match outcome {
            Some((depth, Certificate::Complete)) => {
                return list(&known, count, depth, Certificate::Complete);
            }
            Some((depth, certificate)) if last => return list(&known, count, depth, certificate),
            None if last => {
                let depth = known.last().map_or(f64::INFINITY, |known| known.s.re);
                let reason = format!("fewer than {count} roots were found with {nodes} nodes");
                return list(&known, count, depth, Certificate::NotCounted { reason });
            }
            _ => nodes = (2 * nodes).min(most_nodes),
        }
    }
}

/// Where collocation fell short: finds the roots that the count speaks of.
fn search(
    matrix: &CharacteristicMatrix,
    known: &mut Vec<Known>,
    count: usize,
    outcome: Option<(f64, Certificate)>,
) -> Option<(f64, Certificate)> {
    let hint = known.last().map_or(0.0, |root| root.s.re);
    let line = match outcome {
        Some((depth, Certificate::Failed { counted, .. })) if counted <= MOST_TO_FIND => {
            Some((depth, counted))
        }
        // A line far too deep, or one that cannot be counted: the search goes on from the axis.
        Some(_) => line_with(matrix, count, 0.0),
        None => line_with(matrix, count, hint),
    };
    let Some((depth, counted)) = line.filter(|&(_, counted)| counted <= MOST_TO_FIND) else { return outcome };
    if right_of(known, depth) < counted {
        fill(matrix, known, depth, counted);
    }
    if right_of(known, depth) < counted {
        weigh(matrix, known, depth);
    }
    sort(known);
    let found = right_of(known, depth);
    let certificate =
        if found == counted { Certificate::Complete } else { Certificate::Failed { counted, found } };
    Some((depth, certificate))
}

fn sort(known: &mut [Known]) {
    known.sort_by(|a, b| b.s.re.total_cmp(&a.s.re).then(a.s.im.total_cmp(&b.s.im)));
}

/// How often s = 0 is a root.
pub(super) fn at_zero_in(system: &DelaySystem) -> usize {
    zero::multiplicity(&CharacteristicMatrix::balanced(system, 0.0))
}

/// The root s = 0, where it is one.
fn at_zero(matrix: &CharacteristicMatrix) -> Vec<Known> {
    match zero::multiplicity(matrix) {
        0 => Vec::new(),
        multiplicity => vec![Known { s: Complex64::ZERO, multiplicity }],
    }
}

/// Newton on the determinant, with the step of a multiple root where it creeps like one.
fn refine(matrix: &CharacteristicMatrix, start: Complex64) -> Option<Known> {
    let scale = matrix.scale();
    let mut s = start;
    let mut multiplicity = 1;
    let (mut previous, mut last_guess) = (f64::INFINITY, 1.0);
    let mut smallest = f64::INFINITY;
    let mut idle = 0;
    for _ in 0..80 {
        let newton = matrix.newton_step(s);
        if newton == Complex64::ZERO {
            return Some(Known { s, multiplicity });
        }
        let size = newton.norm();
        if !size.is_finite() {
            return None;
        }
        let step = size * multiplicity as f64;
        // Rounding ends the descent.
        idle = if size < 0.5 * smallest { 0 } else { idle + 1 };
        smallest = smallest.min(size);
        let rounding = 4.0 * f64::EPSILON * s.norm() + 1e-24 * scale;
        if step <= rounding || (idle >= 3 && step <= 1e-7 * (s.norm() + 1e-6 * scale)) {
            return Some(Known { s, multiplicity });
        }
        // Near an m-fold root a plain step leaves 1 − 1/m of the error, twice alike.
        if multiplicity == 1 {
            let ratio = size / previous;
            let guess = (1.0 / (1.0 - ratio)).round();
            let alike = (2.0..=64.0).contains(&guess) && (ratio - (1.0 - 1.0 / guess)).abs() < 0.02;
            let near = size < 1e-2 * s.norm() && size > 1e-9 * (s.norm() + 1e-6 * scale);
            if near && alike && guess == last_guess {
                multiplicity = guess as usize;
            }
            last_guess = if near && alike { guess } else { 1.0 };
        }
        previous = size;
        s -= newton * multiplicity as f64;
        if !s.is_finite() || s.norm() > 1e18 {
            return None;
        }
    }
    None
}

/// Refines a start and keeps the root if it is new; whether it did.
pub(super) fn keep(matrix: &CharacteristicMatrix, known: &mut Vec<Known>, start: Complex64) -> bool {
    let Some(mut root) = refine(matrix, start) else { return false };
    if root.multiplicity > 1 {
        // What Newton's pace suggests, a count decides.
        let half = 1e-5 * root.s.norm();
        let corner = Complex64::new(half, half);
        root.multiplicity = zeros_in_rectangle(matrix, root.s - corner, root.s + corner, 10_000)
            .map_or(1, |inside| inside.max(1));
    }
    root.s.im = root.s.im.abs();
    let scale = matrix.scale();
    let reach = |s: Complex64| SAME * (s.norm() + 1e-4 * scale);
    if root.s.im > 0.0 && root.s.im <= reach(root.s) {
        match refine(matrix, Complex64::new(root.s.re, 0.0)) {
            Some(real) if real.s.im == 0.0 && (real.s - root.s).norm() <= 2.0 * reach(root.s) => root = real,
            _ => {}
        }
    }
    let same = |other: &&mut Known| {
        let reach = if root.multiplicity.max(other.multiplicity) > 1 { 1e3 } else { 1.0 } * reach(root.s);
        (other.s - root.s).norm() <= reach
    };
    match known.iter_mut().find(same) {
        // That s = 0 is a root is known exactly.
        Some(other) if other.multiplicity < root.multiplicity && other.s != Complex64::ZERO => {
            *other = root;
            true
        }
        Some(_) => false,
        None => {
            known.push(root);
            true
        }
    }
}

/// Counts right of a depth below the `count`-th root, in the widest of the next gaps.
///
/// `None` where fewer roots than wanted are known.
fn certify(
    matrix: &CharacteristicMatrix,
    known: &mut [Known],
    count: usize,
    weighed: bool,
) -> Option<(f64, Certificate)> {
    let mut total = 0;
    let mut gaps: Vec<(f64, f64)> = Vec::new();
    for (i, root) in known.iter().enumerate() {
        total += root.weight();
        if total >= count {
            let width = match known.get(i + 1) {
                Some(next) => root.s.re - next.s.re,
                None if gaps.is_empty() => {
                    // With no further root known, a step as long as the list reaches.
                    known.iter().map(|known| known.s.norm()).fold(1e-3 * matrix.scale(), f64::max)
                }
                None => break,
            };
            gaps.push((width, root.s.re - 0.4 * width));
        }
        if gaps.len() >= 4 {
            break;
        }
    }
    gaps.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut stopped = None;
    for (_, depth) in gaps {
        match matrix.roots_right_of(depth, STEPS) {
            Ok(counted) => {
                let found = right_of(known, depth);
                if weighed && counted > found {
                    weigh(matrix, known, depth);
                }
                let found = right_of(known, depth);
                let certificate = if found == counted {
                    Certificate::Complete
                } else {
                    Certificate::Failed { counted, found }
                };
                return Some((depth, certificate));
            }
            Err(stop @ Stop::NearZero { .. }) => {
                stopped = Some((depth, Certificate::NotCounted { reason: stop.to_string() }));
            }
            Err(stop) => return Some((depth, Certificate::NotCounted { reason: stop.to_string() })),
        }
    }
    stopped
}

pub(super) fn right_of(known: &[Known], depth: f64) -> usize {
    known.iter().filter(|root| root.s.re > depth).map(Known::weight).sum()
}

/// Sets multiplicities from a count in a small square around each root.
fn weigh(matrix: &CharacteristicMatrix, known: &mut [Known], depth: f64) {
    for i in 0..known.len() {
        let s = known[i].s;
        if s.re <= depth {
            continue;
        }
        let nearest = known
            .iter()
            .enumerate()
            .filter(|&(j, _)| j != i)
            .map(|(_, other)| (other.s - s).norm().min((other.s.conj() - s).norm()))
            .fold(if s.im > 0.0 { 2.0 * s.im } else { f64::INFINITY }, f64::min);
        let half = (0.3 * nearest).min(1e-3 * (s.norm() + matrix.scale()));
        let corner = Complex64::new(half, half);
        if let Ok(inside) = zeros_in_rectangle(matrix, s - corner, s + corner, 100_000)
            && inside > 0
        {
            known[i].multiplicity = inside;
        }
    }
}

/// No delay: as many roots as states.
fn without_delay(matrix: &CharacteristicMatrix, count: usize) -> Spectrum {
    let mut known = at_zero(matrix);
    for start in eigenvalues(matrix, 0).unwrap_or_default() {
        if start.im >= 0.0 {
            keep(matrix, &mut known, start);
        }
    }
    let size = matrix.size();
    if right_of(&known, f64::NEG_INFINITY) < size {
        weigh(matrix, &mut known, f64::NEG_INFINITY);
    }
    sort(&mut known);
    let found = right_of(&known, f64::NEG_INFINITY);
    let certificate =
        if found == size { Certificate::Complete } else { Certificate::Failed { counted: size, found } };
    list(&known, count, f64::NEG_INFINITY, certificate)
}

fn list(known: &[Known], count: usize, depth: f64, certificate: Certificate) -> Spectrum {
    let mut roots = Vec::with_capacity(count + 1);
    for root in known.iter().filter(|root| root.s.re >= depth) {
        for _ in 0..root.multiplicity {
            roots.push(root.s);
            if root.s.im > 0.0 {
                roots.push(root.s.conj());
            }
        }
        if roots.len() >= count {
            break;
        }
    }
    roots.truncate(count);
    Spectrum { roots, rigid_body: false, certificate, depth }
}
