//! The characteristic matrix of a delay system, its inverse, and the count of its roots.

use nalgebra::DMatrix;
use num_complex::Complex64;
use std::f64::consts::PI;

use super::DelaySystem;
use crate::spectrum::contour::{ContourError, Probe, Winding, argument_change, taylor_step};

/// The characteristic matrix Δ(s) = s I − A₀ − Σⱼ Aⱼ e^(−s τⱼ), with balanced states.
pub(super) struct CharacteristicMatrix {
    pub instantaneous: DMatrix<f64>,
    pub delayed: Vec<(f64, DMatrix<f64>)>,
}

/// Δ⁻¹(s) by rows, with the argument of det Δ(s).
struct Inverse {
    entries: Vec<Complex64>,
    /// A positive multiple of the determinant.
    determinant: Complex64,
}

impl CharacteristicMatrix {
    /// Balances the states by powers of two, over all matrices at once (Parlett and Reinsch 1969,
    /// doi:10.1007/BF02165404): the roots stay exactly the same.
    ///
    /// Delayed terms are weighted as on the line Re s = `sigma`, which keeps the bound on |s| small there.
    pub(super) fn balanced(system: &DelaySystem, sigma: f64) -> Self {
        Self { instantaneous: system.instantaneous.clone(), delayed: system.delayed.clone() }
            .rebalanced(sigma)
    }

    /// The characteristic matrix balanced for another vertical line.
    pub(super) fn rebalanced(&self, sigma: f64) -> Self {
        let mut instantaneous = self.instantaneous.clone();
        let mut delayed = self.delayed.clone();
        let weights: Vec<f64> = std::iter::once(1.0)
            .chain(delayed.iter().map(|(delay, _)| (-delay * sigma).exp().min(1e200)))
            .collect();
        let size = instantaneous.nrows();
        for _ in 0..100 {
            let mut settled = true;
            for i in 0..size {
                let (mut row, mut column) = (0.0, 0.0);
                for j in (0..size).filter(|&j| j != i) {
                    let matrices = std::iter::once(&instantaneous).chain(delayed.iter().map(|(_, m)| m));
                    for (matrix, weight) in matrices.zip(&weights) {
                        row += weight * matrix[(i, j)].abs();
                        column += weight * matrix[(j, i)].abs();
                    }
                }
                if row == 0.0 || column == 0.0 {
                    continue;
                }
                let exponent = (0.5 * (row / column).log2()).round();
                if exponent.abs() < 1.0 {
                    continue;
                }
                let factor = exponent.exp2();
                settled = false;
                for matrix in std::iter::once(&mut instantaneous).chain(delayed.iter_mut().map(|(_, m)| m)) {
                    matrix.row_mut(i).scale_mut(factor.recip());
                    matrix.column_mut(i).scale_mut(factor);
                }
            }
            if settled {
                break;
            }
        }
        Self { instantaneous, delayed }
    }

    /// The number of rows of the characteristic matrix: the states.
    pub(super) fn size(&self) -> usize {
        self.instantaneous.nrows()
    }

    /// The longest delay of the characteristic matrix, 0 if there is none.
    pub(super) fn longest_delay(&self) -> f64 {
        self.delayed.last().map_or(0.0, |(delay, _)| *delay)
    }

    /// A rate of the characteristic matrix that roots can be compared with, 1/s.
    pub(super) fn scale(&self) -> f64 {
        let size = self.instantaneous.norm() + self.delayed.iter().map(|(_, m)| m.norm()).sum::<f64>();
        if size > 0.0 { size } else { 1.0 }
    }

    /// An upper bound on |s| of every root of the characteristic matrix with Re s ≥ `sigma`.
    pub(super) fn root_radius(&self, sigma: f64) -> f64 {
        self.instantaneous.norm()
            + self.delayed.iter().map(|(delay, matrix)| matrix.norm() * (-delay * sigma).exp()).sum::<f64>()
    }

    /// The characteristic matrix Δ(s) by rows.
    fn evaluate(&self, s: Complex64) -> Vec<Complex64> {
        let size = self.size();
        let mut entries = vec![Complex64::ZERO; size * size];
        for (row, line) in entries.chunks_exact_mut(size).enumerate() {
            for (column, entry) in line.iter_mut().enumerate() {
                entry.re = -self.instantaneous[(row, column)];
            }
            line[row] += s;
        }
        for (delay, matrix) in &self.delayed {
            let shift = (-s * delay).exp();
            for (row, line) in entries.chunks_exact_mut(size).enumerate() {
                for (column, entry) in line.iter_mut().enumerate() {
                    *entry -= shift * matrix[(row, column)];
                }
            }
        }
        entries
    }

    /// The logarithmic derivative Δ⁻¹ Δ′ of the characteristic matrix at `s`, by rows.
    fn logarithmic_derivative(&self, s: Complex64, inverse: &[Complex64]) -> Vec<Complex64> {
        let size = self.size();
        let mut product = inverse.to_vec();
        for (delay, matrix) in &self.delayed {
            let shift = (-s * delay).exp() * *delay;
            for row in 0..size {
                for inner in 0..size {
                    let left = inverse[row * size + inner] * shift;
                    for column in 0..size {
                        product[row * size + column] += left * matrix[(inner, column)];
                    }
                }
            }
        }
        product
    }

    /// The Newton step det Δ / (det Δ)′ of the characteristic matrix at `s`; 0 if Δ is singular.
    pub(super) fn newton_step(&self, s: Complex64) -> Complex64 {
        let Some(inverse) = invert_complex(self.evaluate(s), self.size()) else { return Complex64::ZERO };
        let product = self.logarithmic_derivative(s, &inverse.entries);
        let trace: Complex64 = (0..self.size()).map(|i| product[i * self.size() + i]).sum();
        trace.inv()
    }

    /// How much Δ⁻¹ Δ of the characteristic matrix may change while the argument of the determinant changes
    /// by less than π.
    ///
    /// With X = Δ⁻¹(s)(Δ(s + h) − Δ(s)), det Δ(s + h) / det Δ(s) = Π (1 + μᵢ) over the eigenvalues of X,
    /// and Σ |arg(1 + μᵢ)| ≤ (π/2) Σ |μᵢ| ≤ (π/2) √n ‖X‖ (Weyl; Frobenius norm) if ‖X‖ < 1.
    fn argument_room(&self) -> f64 {
        (1.8 / (self.size() as f64).sqrt()).min(0.9)
    }

    /// The number of characteristic roots right of Re s = `sigma`, with multiplicity, by the argument
    /// principle.
    pub(super) fn roots_right_of(&self, sigma: f64, steps: usize) -> Result<usize, ContourError> {
        self.rebalanced(sigma).count_on_contour(sigma, steps)
    }

    /// Counts the roots of the characteristic matrix right of a line along a contour, with the balancing as it is.
    fn count_on_contour(&self, sigma: f64, mut steps: usize) -> Result<usize, ContourError> {
        // Beyond this, det Δ is sⁿ times a factor whose argument stays within π of its limit.
        let far = self.root_radius(sigma) / self.argument_room();
        let top = Complex64::new(sigma, far);
        let bottom = Complex64::new(sigma, 0.0);
        if !far.is_finite() {
            return Err(ContourError::StepsExhausted { at: bottom });
        }
        let turn = argument_change(self, bottom, top, &mut steps)?;
        let size = self.size();
        let Some(inverse) = invert_complex(self.evaluate(top), size) else {
            return Err(ContourError::NearZero { at: top });
        };
        let rest = (inverse.determinant * Complex64::from_polar(1.0, -(size as f64) * top.arg())).arg();
        Ok(((size as f64 * top.arg() + rest - turn) / PI).round().max(0.0) as usize)
    }
}

impl Winding for CharacteristicMatrix {
    /// Certifies a step of the characteristic matrix's determinant by the norm of Δ⁻¹ Δ′.
    fn probe(&self, s: Complex64, direction: Complex64, longest: f64) -> Probe {
        let Some(inverse) = invert_complex(self.evaluate(s), self.size()) else {
            return Probe { value: Complex64::ZERO, step: 0.0 };
        };
        let norm = |entries: &[Complex64]| entries.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
        let size = norm(&inverse.entries);
        let slope = norm(&self.logarithmic_derivative(s, &inverse.entries));
        let curvature = |radius: f64| {
            let leftmost = s.re + radius * direction.re.min(0.0);
            let bend = |(delay, matrix): &(f64, DMatrix<f64>)| {
                matrix.norm() * delay * delay * (-delay * leftmost).exp()
            };
            size * self.delayed.iter().map(bend).sum::<f64>()
        };
        // taylor_step uses 0.9 of the room it is given.
        let step = taylor_step(self.argument_room() / 0.9, slope, curvature, longest);
        Probe { value: inverse.determinant, step }
    }
}

/// The inverse of a complex matrix by Gauss-Jordan elimination with partial pivoting; `None` if it is
/// singular or not finite.
fn invert_complex(mut matrix: Vec<Complex64>, size: usize) -> Option<Inverse> {
    let mut inverse = vec![Complex64::ZERO; size * size];
    for i in 0..size {
        inverse[i * size + i] = Complex64::ONE;
    }
    let mut determinant = Complex64::ONE;
    for column in 0..size {
        let pivot = (column..size)
            .max_by(|&a, &b| {
                matrix[a * size + column].norm_sqr().total_cmp(&matrix[b * size + column].norm_sqr())
            })
            .unwrap_or(column);
        let value = matrix[pivot * size + column];
        if !(value.norm() > 0.0 && value.is_finite()) {
            return None;
        }
        if pivot != column {
            for j in 0..size {
                matrix.swap(pivot * size + j, column * size + j);
                inverse.swap(pivot * size + j, column * size + j);
            }
            determinant = -determinant;
        }
        determinant *= value / value.norm();
        let scale = value.inv();
        for j in 0..size {
            matrix[column * size + j] *= scale;
            inverse[column * size + j] *= scale;
        }
        for row in (0..size).filter(|&row| row != column) {
            let factor = matrix[row * size + column];
            if factor == Complex64::ZERO {
                continue;
            }
            for j in 0..size {
                let (a, b) = (matrix[column * size + j], inverse[column * size + j]);
                matrix[row * size + j] -= factor * a;
                inverse[row * size + j] -= factor * b;
            }
        }
    }
    Some(Inverse { entries: inverse, determinant })
}
