//! The multiplicity of the root s = 0, from matrix ranks.

use nalgebra::DMatrix;

use super::matrix::CharacteristicMatrix;

/// The largest order of a block Toeplitz matrix.
const LARGEST_ORDER: usize = 256;

/// The multiplicity of s = 0 as a zero of det Δ, from numerical ranks.
///
/// With Δ(s) = Σ Δₗ sˡ, the block Toeplitz matrix of Δ₀ … Δₖ₋₁ has rank deficiency Σ min(k, κᵢ), where κᵢ
/// are the partial multiplicities of s = 0 and their sum is the result (Gohberg, Lancaster and Rodman 1982,
/// "Matrix Polynomials", section 1.4). It is reached when another block changes nothing.
pub(super) fn multiplicity_at_zero(matrix: &CharacteristicMatrix) -> usize {
    let size = matrix.size();
    let most = (LARGEST_ORDER / size).max(1);
    let mut missing = 0;
    for blocks in 1..=most {
        let now = rank_deficiency(&block_toeplitz(matrix, blocks));
        if now == missing {
            break;
        }
        missing = now;
    }
    missing
}

/// The block Toeplitz matrix of the first Taylor coefficients of Δ(s) at the zero s = 0.
fn block_toeplitz(matrix: &CharacteristicMatrix, blocks: usize) -> DMatrix<f64> {
    let size = matrix.size();
    let norm = matrix.scale();
    // The unit of s: the faster of system and delays, so that no coefficient exceeds Δ₀.
    let unit = if matrix.longest_delay() > 0.0 { norm.min(matrix.longest_delay().recip()) } else { norm };
    let coefficient = |order: usize| {
        let mut sum = match order {
            0 => -&matrix.instantaneous,
            1 => DMatrix::identity(size, size),
            _ => DMatrix::zeros(size, size),
        };
        let factorial: f64 = (1..=order).map(|i| i as f64).product();
        for (delay, term) in &matrix.delayed {
            sum -= term * ((-delay).powi(order as i32) / factorial);
        }
        sum * (unit.powi(order as i32) / norm)
    };
    let coefficients: Vec<DMatrix<f64>> = (0..blocks).map(coefficient).collect();
    let mut whole = DMatrix::zeros(blocks * size, blocks * size);
    for row in 0..blocks {
        for column in 0..=row {
            whole.view_mut((row * size, column * size), (size, size)).copy_from(&coefficients[row - column]);
        }
    }
    whole
}

/// The number of singular values of a block Toeplitz matrix that are zero within rounding.
fn rank_deficiency(matrix: &DMatrix<f64>) -> usize {
    let order = matrix.nrows();
    let values = matrix.singular_values();
    let rounding = 8.0 * order as f64 * f64::EPSILON * values.max();
    values.iter().filter(|value| **value <= rounding).count()
}
