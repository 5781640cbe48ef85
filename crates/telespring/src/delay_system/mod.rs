//! Linear systems with several constant delays, and a dyad as such a system.
//!
//! x′(t) = A₀ x(t) + Σⱼ Aⱼ x(t − τⱼ). Its characteristic roots are the zeros of det(s I − A₀ − Σⱼ Aⱼ e^(−s
//! τⱼ)). The module is independent of springs and robots and therefore also serves three or more partners.

mod collocation;
mod known_roots;
mod matrix;
mod predicted;
mod roots;
mod search;
mod zero;

use nalgebra::DMatrix;

use matrix::CharacteristicMatrix;

use crate::error::{InvalidInput, Result};
use crate::model::{Delay, DyadAxis};
use crate::quantity;
use crate::spectrum::{Abscissa, Spectrum, check_root_count};

/// The largest number of states of a system.
pub const MAX_STATES: usize = 64;

/// A linear delay system x′(t) = A₀ x(t) + Σⱼ Aⱼ x(t − τⱼ), with constant delays τⱼ in s and matrices in
/// 1/s for states of one unit.
///
/// # Examples
///
/// ```
/// use nalgebra::dmatrix;
/// use telespring::delay_system::DelaySystem;
/// // x′(t) = −x(t − 1): stable, as the delay is below π/2.
/// let system = DelaySystem::new(dmatrix![0.0], vec![(1.0, dmatrix![-1.0])])?;
/// let abscissa = system.spectral_abscissa();
/// assert!(abscissa.certificate.is_complete());
/// assert!((abscissa.value + 0.3181315052047641).abs() < 1e-14);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct DelaySystem {
    instantaneous: DMatrix<f64>,
    delayed: Vec<(f64, DMatrix<f64>)>,
}

impl DelaySystem {
    /// Creates a delay system from A₀ and the pairs (τⱼ, Aⱼ).
    ///
    /// Terms with equal delay are added, those of delay 0 to A₀; the rest is sorted by delay.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a matrix is not square, differs in size from A₀ or has more than [`MAX_STATES`]
    /// rows, if an entry is not finite or exceeds 1e12 in size, or if a delay is negative, not finite or
    /// longer than 100 s.
    pub fn new(a0: DMatrix<f64>, delayed: Vec<(f64, DMatrix<f64>)>) -> Result<Self> {
        let size = a0.nrows();
        if !(1..=MAX_STATES).contains(&size) {
            return Err(InvalidInput::new(
                "a0",
                format!("{} rows", size),
                format!("a system has from 1 to {MAX_STATES} states"),
                "Check the matrix.",
            ));
        }
        check_matrix("a0", &a0, size)?;
        let mut instantaneous = a0;
        let mut kept: Vec<(f64, DMatrix<f64>)> = Vec::with_capacity(delayed.len());
        for (j, (delay, matrix)) in delayed.into_iter().enumerate() {
            quantity::DELAY.check(&format!("delayed[{j}].delay"), delay)?;
            check_matrix(&format!("delayed[{j}].matrix"), &matrix, size)?;
            if delay == 0.0 {
                instantaneous += matrix;
            } else if let Some(same) = kept.iter_mut().find(|(other, _)| *other == delay) {
                same.1 += matrix;
            } else {
                kept.push((delay, matrix));
            }
        }
        kept.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(Self { instantaneous, delayed: kept })
    }

    /// The matrix A₀ of the delay system, including the terms of delay 0.
    pub fn instantaneous(&self) -> &DMatrix<f64> {
        &self.instantaneous
    }

    /// The delayed terms as pairs (τⱼ in s, Aⱼ), sorted by delay.
    pub fn delayed(&self) -> &[(f64, DMatrix<f64>)] {
        &self.delayed
    }

    /// The number of states of the delay system.
    pub fn size(&self) -> usize {
        self.instantaneous.nrows()
    }

    /// The `count` rightmost characteristic roots of the delay system, each refined by Newton's method.
    ///
    /// A root at s = 0, such as the rigid-body motion of free robots, is listed like any other, as exactly
    /// 0 ([`Spectrum::rigid_body`] is false); [`crate::spectrum::characteristic_roots`] divides it out. A
    /// system without delay has as many roots as states: fewer than `count` may then be returned, and
    /// `depth` is minus infinity.
    ///
    /// Newton's method starts from the eigenvalues of the infinitesimal generator collocated at Chebyshev
    /// nodes (Breda, Maset and Vermiglio 2005, doi:10.1137/030601600). Nodes are added until the argument
    /// principle counts no more roots than were found. Roots far beyond 300 divided by the largest delay
    /// need more nodes than allowed: then a vertical line is counted, and Newton's method starts along it
    /// and in halved rectangles until as many roots are found. If there are too many (thousands of roots),
    /// the certificate says so.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if `count` is not from 1 to [`crate::spectrum::MAX_ROOTS`].
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::{Delay, hman};
    /// let system = hman().axis(0)?.delay_system(71.2, &Delay::new(0.1, 0.2)?)?;
    /// let spectrum = system.characteristic_roots(5)?;
    /// assert!(spectrum.certificate.is_complete());
    /// assert!(spectrum.roots.iter().any(|root| root.norm() == 0.0)); // the rigid-body root
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn characteristic_roots(&self, count: usize) -> Result<Spectrum> {
        check_root_count(count)?;
        Ok(roots::rightmost_roots(self, count))
    }

    /// The spectral abscissa: the largest real part of the characteristic roots, 1/s, including a root at s
    /// = 0.
    pub fn spectral_abscissa(&self) -> Abscissa {
        let spectrum = roots::rightmost_roots(self, 1);
        Abscissa {
            value: spectrum.roots.first().map_or(f64::NEG_INFINITY, |root| root.re),
            certificate: spectrum.certificate,
        }
    }

    /// The multiplicity of the root s = 0: 1 for two free robots, with their rigid-body motion.
    ///
    /// Decided by the ranks of the Taylor coefficients of the characteristic matrix at 0, within rounding.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::{Delay, hman};
    /// let system = hman().axis(0)?.delay_system(71.2, &Delay::new(0.1, 0.2)?)?;
    /// assert_eq!(system.roots_at_zero(), 1);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn roots_at_zero(&self) -> usize {
        zero::multiplicity_at_zero(&CharacteristicMatrix::balanced(self, 0.0))
    }

    /// The delay system's largest real part of the roots other than s = 0, 1/s.
    ///
    /// If negative, every motion decays but those counted by [`DelaySystem::roots_at_zero`]. Minus infinity
    /// if s = 0 is the only root.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::{Delay, hman};
    /// let system = hman().axis(0)?.delay_system(71.2, &Delay::new(0.1, 0.2)?)?;
    /// assert_eq!(system.spectral_abscissa().value, 0.0);
    /// assert!(system.spectral_abscissa_without_zero().value < -0.1);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn spectral_abscissa_without_zero(&self) -> Abscissa {
        let spectrum = roots::rightmost_roots(self, 1 + self.roots_at_zero());
        let moving = spectrum.roots.iter().find(|root| root.norm() > 0.0);
        Abscissa {
            value: moving.map_or(f64::NEG_INFINITY, |root| root.re),
            certificate: spectrum.certificate,
        }
    }
}

/// Larger entries are rejected, so that no determinant overflows.
const LARGEST_ENTRY: f64 = 1e12;

/// Checks the shape and the entries of a matrix of a delay system.
fn check_matrix(field: &str, matrix: &DMatrix<f64>, size: usize) -> Result<()> {
    if matrix.shape() != (size, size) {
        return Err(InvalidInput::new(
            field,
            format!("{} x {}", matrix.nrows(), matrix.ncols()),
            format!("every matrix must be {size} x {size}, as many rows and columns as a0 has rows"),
            "Check the shape.",
        ));
    }
    for row in 0..size {
        for column in 0..size {
            let entry = matrix[(row, column)];
            if entry.is_nan() || entry.abs() > LARGEST_ENTRY {
                return Err(InvalidInput::new(
                    format!("{field}[{row}][{column}]"),
                    entry,
                    format!("an entry must be a number of size up to {LARGEST_ENTRY:e}"),
                    "Replace it by a number, or choose a smaller unit of time.",
                ));
            }
        }
    }
    Ok(())
}

impl DyadAxis {
    /// This axis as a delay system with states x₁, v₁, x₂, v₂ (m, m/s); `stiffness` is in N/m.
    ///
    /// Robot 1 is coupled to its partner one `backward` delay ago, robot 2 one `forward` delay ago.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the stiffness or a field of the axis is out of range.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::{Delay, DyadAxis};
    /// let axis = DyadAxis::new(1.0, 4.0, 2.0, 4.0)?;
    /// let system = axis.delay_system(10.0, &Delay::new(0.1, 0.2)?)?;
    /// assert_eq!(system.delayed()[0].0, 0.1);
    /// assert_eq!(system.delayed()[0].1[(3, 0)], 5.0); // robot 2 is pulled towards x₁(t − 0.1)
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn delay_system(&self, stiffness: f64, delay: &Delay) -> Result<DelaySystem> {
        quantity::STIFFNESS.check("stiffness", stiffness)?;
        let c = self.coupling_damping;
        let mut a0 = DMatrix::zeros(4, 4);
        let mut terms = Vec::with_capacity(2);
        for (own, partner, lag) in [(0, 1, delay.backward()), (1, 0, delay.forward())] {
            let side = self.sides[own];
            let (x, v) = (2 * own, 2 * own + 1);
            a0[(x, v)] = 1.0;
            a0[(v, x)] = -(stiffness + side.ground_stiffness) / side.mass;
            a0[(v, v)] = -(side.damping + c) / side.mass;
            let mut delayed = DMatrix::zeros(4, 4);
            delayed[(v, 2 * partner)] = stiffness / side.mass;
            delayed[(v, 2 * partner + 1)] = c / side.mass;
            terms.push((lag, delayed));
        }
        DelaySystem::new(a0, terms)
    }
}
