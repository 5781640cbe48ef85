//! The characteristic roots found so far: refined by Newton's method, without duplicates, with
//! multiplicity.

use num_complex::Complex64;

use super::matrix::CharacteristicMatrix;
use super::zero;
use crate::spectrum::contour::zeros_in_rectangle;

/// Two approximations of one root differ by less than this, relative to root and system.
const SAME: f64 = 1e-7;

/// A root in the closed upper half-plane with its multiplicity.
#[derive(Debug, Clone, Copy)]
pub(super) struct KnownRoot {
    pub s: Complex64,
    pub multiplicity: usize,
}

impl KnownRoot {
    /// The number of characteristic roots that a known root stands for, the conjugate included.
    pub fn weight(&self) -> usize {
        if self.s.im == 0.0 { self.multiplicity } else { 2 * self.multiplicity }
    }
}

/// The root s = 0 of a delay system with its multiplicity, if it is one of the known roots.
pub(super) fn root_at_zero(matrix: &CharacteristicMatrix) -> Vec<KnownRoot> {
    match zero::multiplicity_at_zero(matrix) {
        0 => Vec::new(),
        multiplicity => vec![KnownRoot { s: Complex64::ZERO, multiplicity }],
    }
}

/// Sorts the known roots by descending real part.
pub(super) fn sort_by_real_part(known: &mut [KnownRoot]) {
    known.sort_by(|a, b| b.s.re.total_cmp(&a.s.re).then(a.s.im.total_cmp(&b.s.im)));
}

/// Newton's method on the determinant towards a known root, with a multiplied step at a multiple one.
fn refine_by_newton(matrix: &CharacteristicMatrix, start: Complex64) -> Option<KnownRoot> {
    let scale = matrix.scale();
    let mut s = start;
    let mut multiplicity = 1;
    let (mut previous, mut last_guess) = (f64::INFINITY, 1.0);
    let mut smallest = f64::INFINITY;
    let mut idle = 0;
    for _ in 0..80 {
        let newton = matrix.newton_step(s);
        if newton == Complex64::ZERO {
            return Some(KnownRoot { s, multiplicity });
        }
        let size = newton.norm();
        if !size.is_finite() {
            return None;
        }
        let step = size * multiplicity as f64;
        // Rounding ends the convergence.
        idle = if size < 0.5 * smallest { 0 } else { idle + 1 };
        smallest = smallest.min(size);
        let rounding = 4.0 * f64::EPSILON * s.norm() + 1e-24 * scale;
        if step <= rounding || (idle >= 3 && step <= 1e-7 * (s.norm() + 1e-6 * scale)) {
            return Some(KnownRoot { s, multiplicity });
        }
        // Near an m-fold root a plain step reduces the error by a factor 1 − 1/m, two steps alike.
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

/// Refines a start and stores the root among the known ones if it is new; returns whether it was.
pub(super) fn refine_and_insert(
    matrix: &CharacteristicMatrix,
    known: &mut Vec<KnownRoot>,
    start: Complex64,
) -> bool {
    let Some(mut root) = refine_by_newton(matrix, start) else { return false };
    if root.multiplicity > 1 {
        // Newton's pace suggests a multiplicity, a count decides it.
        let half = 1e-5 * root.s.norm();
        let corner = Complex64::new(half, half);
        root.multiplicity = zeros_in_rectangle(matrix, root.s - corner, root.s + corner, 10_000)
            .map_or(1, |inside| inside.max(1));
    }
    root.s.im = root.s.im.abs();
    let scale = matrix.scale();
    let reach = |s: Complex64| SAME * (s.norm() + 1e-4 * scale);
    if root.s.im > 0.0 && root.s.im <= reach(root.s) {
        match refine_by_newton(matrix, Complex64::new(root.s.re, 0.0)) {
            Some(real) if real.s.im == 0.0 && (real.s - root.s).norm() <= 2.0 * reach(root.s) => root = real,
            _ => {}
        }
    }
    let same = |other: &&mut KnownRoot| {
        let reach = if root.multiplicity.max(other.multiplicity) > 1 { 1e3 } else { 1.0 } * reach(root.s);
        (other.s - root.s).norm() <= reach
    };
    match known.iter_mut().find(same) {
        // The multiplicity of s = 0 is known exactly.
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

/// The number of known roots right of a vertical line, with multiplicity.
pub(super) fn count_right_of(known: &[KnownRoot], depth: f64) -> usize {
    known.iter().filter(|root| root.s.re > depth).map(KnownRoot::weight).sum()
}

/// The number of known roots in a rectangle, with multiplicity.
pub(super) fn count_in_rectangle(known: &[KnownRoot], low: Complex64, high: Complex64) -> usize {
    let within = |s: Complex64| s.re > low.re && s.re < high.re && s.im > low.im && s.im < high.im;
    known
        .iter()
        .map(|root| {
            let both = usize::from(within(root.s)) + usize::from(root.s.im > 0.0 && within(root.s.conj()));
            both * root.multiplicity
        })
        .sum()
}

/// Sets the multiplicity of each known root from a count in a small square around it.
pub(super) fn assign_multiplicities(matrix: &CharacteristicMatrix, known: &mut [KnownRoot], depth: f64) {
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
