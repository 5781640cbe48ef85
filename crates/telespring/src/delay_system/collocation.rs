//! Collocation of the infinitesimal generator of a delay system at Chebyshev nodes.

use nalgebra::DMatrix;
use nalgebra::linalg::Schur;
use num_complex::Complex64;
use std::f64::consts::PI;

use super::matrix::CharacteristicMatrix;

/// The indices of the states with a delayed term, which collocation needs in the past.
pub(super) fn delayed_states(system: &CharacteristicMatrix) -> Vec<usize> {
    (0..system.size())
        .filter(|&column| system.delayed.iter().any(|(_, matrix)| matrix.column(column).amax() > 0.0))
        .collect()
}

/// The eigenvalues of the generator collocated at `nodes` + 1 Chebyshev points of the longest delay (Breda,
/// Maset and Vermiglio 2005); only states with a delayed term are unknowns at past points.
///
/// `None` if the eigenvalue iteration does not converge.
pub(super) fn collocation_eigenvalues(system: &CharacteristicMatrix, nodes: usize) -> Option<Vec<Complex64>> {
    let generator = collocation_matrix(system, nodes);
    let max_iterations = 60 * generator.nrows();
    // These eigenvalues only start Newton's method, so a coarser tolerance than rounding is enough.
    let schur = Schur::try_new(generator, 1e-13, max_iterations)?;
    Some(schur.complex_eigenvalues().iter().copied().collect())
}

/// The collocated generator: past points and present states as one matrix.
fn collocation_matrix(system: &CharacteristicMatrix, nodes: usize) -> DMatrix<f64> {
    let size = system.size();
    let past = delayed_states(system);
    let span = system.longest_delay();
    if past.is_empty() || span == 0.0 {
        return system.instantaneous.clone();
    }
    // Points from 1 (now) to −1 (one longest delay ago), with barycentric weights.
    let point = |i: usize| (PI * i as f64 / nodes as f64).cos();
    let weight = |i: usize| {
        let sign = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        if i == 0 || i == nodes { 0.5 * sign } else { sign }
    };
    let index = |node: usize, state: usize| {
        if node == 0 { past[state] } else { size + (node - 1) * past.len() + state }
    };
    let order = size + nodes * past.len();
    let mut generator = DMatrix::zeros(order, order);
    generator.view_mut((0, 0), (size, size)).copy_from(&system.instantaneous);
    for (delay, matrix) in &system.delayed {
        let at = 1.0 - 2.0 * delay / span;
        let hit = (0..=nodes).find(|&i| (point(i) - at).abs() < 1e-15);
        let total: f64 = (0..=nodes).map(|i| weight(i) / (at - point(i))).sum();
        for node in 0..=nodes {
            let share = match hit {
                Some(i) => f64::from(u8::from(i == node)),
                None => weight(node) / (at - point(node)) / total,
            };
            for (state, &column) in past.iter().enumerate() {
                for row in 0..size {
                    generator[(row, index(node, state))] += share * matrix[(row, column)];
                }
            }
        }
    }
    for row in 1..=nodes {
        let mut diagonal = 0.0;
        for column in (0..=nodes).filter(|&column| column != row) {
            // cos a − cos b without cancellation.
            let (a, b) = (PI * row as f64 / nodes as f64, PI * column as f64 / nodes as f64);
            let distance = -2.0 * (0.5 * (a + b)).sin() * (0.5 * (a - b)).sin();
            let entry = weight(column) / weight(row) / distance * 2.0 / span;
            diagonal -= entry;
            for state in 0..past.len() {
                generator[(index(row, state), index(column, state))] += entry;
            }
        }
        for state in 0..past.len() {
            generator[(index(row, state), index(row, state))] += diagonal;
        }
    }
    generator
}
