//! Certified characteristic roots of a delay system, from the eigenvalues of the collocated generator.

use super::DelaySystem;
use super::collocation::{collocation_eigenvalues, delayed_states};
use super::known_roots::{
    KnownRoot, assign_multiplicities, count_right_of, refine_and_insert, root_at_zero, sort_by_real_part,
};
use super::matrix::CharacteristicMatrix;
use super::search::{MAX_TO_FIND, line_with_roots_right_of, search_right_of};
use crate::spectrum::contour::ContourError;
use crate::spectrum::{Certificate, Spectrum};

/// The largest order of a collocation matrix: its eigenvalues take about a second.
const LARGEST_ORDER: usize = 400;
/// The maximum number of steps along a contour.
const STEPS: usize = 400_000;
/// The `count` rightmost characteristic roots of a delay system with their certificate.
pub(super) fn rightmost_roots(system: &DelaySystem, count: usize) -> Spectrum {
    let matrix = CharacteristicMatrix::balanced(system, 0.0);
    let states = delayed_states(&matrix).len();
    let size = matrix.size();
    if states == 0 || matrix.longest_delay() == 0.0 {
        return roots_without_delay(&matrix, count);
    }
    let max_nodes = ((LARGEST_ORDER.max(4 * size) - size) / states).max(8);
    let mut nodes = (12 + count / states).min(max_nodes);
    let mut known = root_at_zero(&matrix);
    let mut searched = false;
    loop {
        // The shifts of the eigenvalue iteration can cycle; another size breaks the cycle.
        let starts =
            collocation_eigenvalues(&matrix, nodes).or_else(|| collocation_eigenvalues(&matrix, nodes + 1));
        if let Some(mut starts) = starts {
            starts.retain(|start| start.im >= 0.0);
            starts.sort_by(|a, b| b.re.total_cmp(&a.re));
            // The generator also has spurious eigenvalues, so a margin of starts is kept.
            starts.truncate(2 * count + 24);
            for start in starts {
                refine_and_insert(&matrix, &mut known, start);
            }
        }
        sort_by_real_part(&mut known);
        let last = nodes >= max_nodes;
        // A missing root more often needs more nodes than it is a multiple root.
        let mut outcome = certify_by_count(&matrix, &mut known, count, last || nodes > 60);
        let complete = matches!(outcome, Some((_, Certificate::Complete)));
        // Once only: a search that failed fails again with a few more starts.
        if !complete && !searched && (last || nodes > 60) {
            searched = true;
            outcome = find_missing_roots(&matrix, &mut known, count, outcome);
        }
        match outcome {
            Some((depth, Certificate::Complete)) => {
                return spectrum_of(&known, count, depth, Certificate::Complete);
            }
            Some((depth, certificate)) if last => return spectrum_of(&known, count, depth, certificate),
            None if last => {
                let depth = known.last().map_or(f64::INFINITY, |known| known.s.re);
                let reason = format!("fewer than {count} roots were found with {nodes} nodes");
                return spectrum_of(&known, count, depth, Certificate::NotCounted { reason });
            }
            _ => nodes = (2 * nodes).min(max_nodes),
        }
    }
}

/// Finds the roots of a delay system that collocation missed, guided by the count.
fn find_missing_roots(
    matrix: &CharacteristicMatrix,
    known: &mut Vec<KnownRoot>,
    count: usize,
    outcome: Option<(f64, Certificate)>,
) -> Option<(f64, Certificate)> {
    let hint = known.last().map_or(0.0, |root| root.s.re);
    let line = match outcome {
        Some((depth, Certificate::Failed { counted, .. })) if counted <= MAX_TO_FIND => {
            Some((depth, counted))
        }
        // A line far too deep, or one that cannot be counted: the search continues from the axis.
        Some(_) => line_with_roots_right_of(matrix, count, 0.0),
        None => line_with_roots_right_of(matrix, count, hint),
    };
    let Some((depth, counted)) = line.filter(|&(_, counted)| counted <= MAX_TO_FIND) else { return outcome };
    if count_right_of(known, depth) < counted {
        search_right_of(matrix, known, depth, counted);
    }
    if count_right_of(known, depth) < counted {
        assign_multiplicities(matrix, known, depth);
    }
    sort_by_real_part(known);
    let found = count_right_of(known, depth);
    let certificate =
        if found == counted { Certificate::Complete } else { Certificate::Failed { counted, found } };
    Some((depth, certificate))
}

/// Counts the delay system's roots right of a line below the `count`-th root, in the widest of the next gaps.
///
/// `None` if fewer roots than requested are known.
fn certify_by_count(
    matrix: &CharacteristicMatrix,
    known: &mut [KnownRoot],
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
                let found = count_right_of(known, depth);
                if weighed && counted > found {
                    assign_multiplicities(matrix, known, depth);
                }
                let found = count_right_of(known, depth);
                let certificate = if found == counted {
                    Certificate::Complete
                } else {
                    Certificate::Failed { counted, found }
                };
                return Some((depth, certificate));
            }
            Err(stop @ ContourError::NearZero { .. }) => {
                stopped = Some((depth, Certificate::NotCounted { reason: stop.to_string() }));
            }
            Err(stop) => return Some((depth, Certificate::NotCounted { reason: stop.to_string() })),
        }
    }
    stopped
}

/// The characteristic roots of a delay system without delay, as many as states.
fn roots_without_delay(matrix: &CharacteristicMatrix, count: usize) -> Spectrum {
    let mut known = root_at_zero(matrix);
    for start in collocation_eigenvalues(matrix, 0).unwrap_or_default() {
        if start.im >= 0.0 {
            refine_and_insert(matrix, &mut known, start);
        }
    }
    let size = matrix.size();
    if count_right_of(&known, f64::NEG_INFINITY) < size {
        assign_multiplicities(matrix, &mut known, f64::NEG_INFINITY);
    }
    sort_by_real_part(&mut known);
    let found = count_right_of(&known, f64::NEG_INFINITY);
    let certificate =
        if found == size { Certificate::Complete } else { Certificate::Failed { counted: size, found } };
    spectrum_of(&known, count, f64::NEG_INFINITY, certificate)
}

/// The list of the `count` rightmost known roots of a delay system with its certificate.
fn spectrum_of(known: &[KnownRoot], count: usize, depth: f64, certificate: Certificate) -> Spectrum {
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
