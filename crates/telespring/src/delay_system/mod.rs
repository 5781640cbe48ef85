//! A linear system with several constant delays: what a dyad lowers to.
//!
//! x′(t) = A₀ x(t) + Σⱼ Aⱼ x(t − τⱼ). Its characteristic roots are the zeros of
//! det(s I − A₀ − Σⱼ Aⱼ e^(−s τⱼ)). Nothing here knows of springs or robots, so that three or more
//! partners need no other engine.

mod collocation;
mod known_roots;
mod matrix;
mod roots;
mod search;
mod zero;

use nalgebra::DMatrix;

use matrix::CharacteristicMatrix;

use crate::error::{InvalidInput, Result};
use crate::spectrum::{Abscissa, Spectrum, check_count};
use crate::{Delay, DyadAxis, quantity};

/// The largest number of states that a system may have.
pub const MAX_STATES: usize = 64;

/// x′(t) = A₀ x(t) + Σⱼ Aⱼ x(t − τⱼ), with constant delays τⱼ in s and matrices in 1/s for states of
/// one unit.
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
    /// A system from A₀ and the pairs (τⱼ, Aⱼ).
    ///
    /// Terms of one delay are added up, those of delay 0 to A₀; the rest is sorted by delay.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where a matrix is not square, of another size than A₀ or of more than
    /// [`MAX_STATES`] rows, an entry is not finite or beyond 1e12 in size, or a delay is negative,
    /// not finite or longer than 100 s.
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

    /// A₀, terms of delay 0 added.
    pub fn instantaneous(&self) -> &DMatrix<f64> {
        &self.instantaneous
    }

    /// The pairs (τⱼ in s, Aⱼ), by delay.
    pub fn delayed(&self) -> &[(f64, DMatrix<f64>)] {
        &self.delayed
    }

    /// The number of states.
    pub fn size(&self) -> usize {
        self.instantaneous.nrows()
    }

    /// The `count` rightmost characteristic roots, each refined by Newton.
    ///
    /// A root at s = 0, such as the common motion of free robots, is a root like any other here and
    /// stays in the list, as exactly 0 ([`Spectrum::rigid_body`] is false);
    /// [`crate::spectrum::characteristic_roots`] divides it out. A system without delay has as many
    /// roots as states; fewer than `count` are then returned, and `depth` is minus infinity.
    ///
    /// Starts are the eigenvalues of the infinitesimal generator collocated at Chebyshev nodes
    /// (Breda, Maset and Vermiglio 2005, doi:10.1137/030601600), nodes being added until the
    /// argument principle counts no more roots than were found. Roots much beyond 300 divided by the
    /// largest delay need more nodes than are allowed: a line is then counted on, Newton started
    /// along it and in halved rectangles, until as many were found. Where that work has no end in
    /// reach (thousands of roots), the certificate says so.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where `count` is not from 1 to [`crate::spectrum::MAX_ROOTS`].
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::{Delay, hman};
    /// let system = hman().axis(0)?.delay_system(71.2, &Delay::new(0.1, 0.2)?)?;
    /// let spectrum = system.characteristic_roots(5)?;
    /// assert!(spectrum.certificate.is_complete());
    /// assert!(spectrum.roots.iter().any(|root| root.norm() == 0.0)); // both carried off together
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn characteristic_roots(&self, count: usize) -> Result<Spectrum> {
        check_count(count)?;
        Ok(roots::rightmost(self, count))
    }

    /// The largest real part of the characteristic roots, 1/s, a root at s = 0 included.
    pub fn spectral_abscissa(&self) -> Abscissa {
        let spectrum = roots::rightmost(self, 1);
        Abscissa {
            value: spectrum.roots.first().map_or(f64::NEG_INFINITY, |root| root.re),
            certificate: spectrum.certificate,
        }
    }

    /// How often s = 0 is a root: 1 for two free robots, which can be carried off together.
    ///
    /// Decided by the ranks of the characteristic matrix' Taylor coefficients at 0, to rounding.
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
        zero::multiplicity(&CharacteristicMatrix::balanced(self, 0.0))
    }

    /// The largest real part of the roots other than s = 0, 1/s.
    ///
    /// Below zero every motion dies out but those that [`DelaySystem::roots_at_zero`] counts. Minus
    /// infinity where s = 0 is the only root.
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
        let spectrum = roots::rightmost(self, 1 + self.roots_at_zero());
        let moving = spectrum.roots.iter().find(|root| root.norm() > 0.0);
        Abscissa {
            value: moving.map_or(f64::NEG_INFINITY, |root| root.re),
            certificate: spectrum.certificate,
        }
    }
}

/// Entries beyond this are refused, so that no determinant overflows.
const LARGEST_ENTRY: f64 = 1e12;

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
    /// This axis as a delay system with the states x₁, v₁, x₂, v₂ (m, m/s); `stiffness` in N/m.
    ///
    /// Robot 1 feels its partner as it was one `backward` delay ago, robot 2 one `forward` delay ago.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where the stiffness or a field of the axis is out of range.
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
