//! Characteristic roots to a wanted depth, with a certificate that none is missing.
//!
//! With a delay there are infinitely many roots, but only finitely many right of any vertical line.
//! The argument principle counts those without finding them; a list of roots is trusted only where
//! the two numbers agree.

pub mod contour;
mod dyad;
mod line;
mod newton;
mod polynomial;

use num_complex::Complex64;

use crate::characteristic::Characteristic;
use crate::error::{InvalidInput, Result};
use crate::{Delay, DyadAxis, quantity};

/// The largest number of roots that may be asked for.
pub const MAX_ROOTS: usize = 1000;

/// Whether the roots right of a line are all known.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Certificate {
    /// The argument principle counted exactly as many roots right of the depth as were found: none
    /// is missing.
    Complete,
    /// The two numbers differ: a root may be missing, or stand twice in the list.
    Failed {
        /// Roots right of the depth by the argument principle, multiplicity counted.
        counted: usize,
        /// Roots found there.
        found: usize,
    },
    /// The roots were not counted, so that nothing is known about missing ones.
    NotCounted {
        /// What stood in the way.
        reason: String,
    },
}

impl Certificate {
    /// True for [`Certificate::Complete`].
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::spectrum::Certificate;
    /// assert!(!Certificate::Failed { counted: 4, found: 2 }.is_complete());
    /// ```
    pub fn is_complete(&self) -> bool {
        matches!(self, Self::Complete)
    }
}

impl std::fmt::Display for Certificate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Complete => write!(f, "complete"),
            Self::Failed { counted, found } => {
                write!(f, "failed: {found} roots were found where {counted} were counted")
            }
            Self::NotCounted { reason } => write!(f, "not counted: {reason}"),
        }
    }
}

/// The rightmost characteristic roots.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// The roots, 1/s: real part descending, the upper member of a conjugate pair first, a multiple
    /// root as often as it counts. The last pair is cut where an odd place is left for it.
    pub roots: Vec<Complex64>,
    /// Whether s = 0 is a root besides (both handles free: the robots can be carried off together);
    /// it is divided out and not in the list.
    pub rigid_body: bool,
    /// Whether every root right of `depth` is known.
    pub certificate: Certificate,
    /// The line Re s = `depth`, 1/s, right of which the roots were counted. It lies left of every
    /// listed root; found roots beyond the number asked for may lie between. Minus infinity where
    /// there is no delay: all roots are then known.
    pub depth: f64,
}

/// The largest real part of the characteristic roots.
#[derive(Debug, Clone, PartialEq)]
pub struct Abscissa {
    /// The spectral abscissa, 1/s: below zero means that every motion but the common rigid one decays.
    /// Minus infinity where no root was found; the certificate then is not complete.
    pub value: f64,
    /// Whether no root was missed.
    pub certificate: Certificate,
}

/// The `count` rightmost roots of one axis, the rigid-body root s = 0 left out.
///
/// They are the zeros of P₁(s) P₂(s) − (k + c s)² e^(−T s), T the sum of both delays and
/// Pᵢ(s) = mᵢ s² + (bᵢ + c) s + k + k_h,i (the denominator of Eq. 2 of Du, Kulkarni, Kager and
/// Campolo, with operators and a coupling damper), each refined to about 1e-12 relative, or as far
/// as rounding allows for a multiple root. `stiffness` in N/m. Without any delay there are four
/// roots, three besides the rigid-body root; fewer than `count` are then returned.
///
/// The count behind the certificate is the argument principle in closed form and costs about as much
/// as a few roots, for any delay.
///
/// # Errors
///
/// [`InvalidInput`] where the axis, the stiffness or `count` (1 to [`MAX_ROOTS`]) is out of range.
///
/// # Examples
///
/// ```
/// use telespring::{Delay, hman, spectrum};
/// let x = hman().axis(0)?;
/// let spectrum = spectrum::characteristic_roots(&x, 71.2, &Delay::each_way(0.167)?, 8)?;
/// assert_eq!(spectrum.roots.len(), 8);
/// assert!(spectrum.certificate.is_complete() && spectrum.rigid_body);
/// assert_eq!(spectrum.roots[1], spectrum.roots[0].conj());
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn characteristic_roots(
    axis: &DyadAxis,
    stiffness: f64,
    delay: &Delay,
    count: usize,
) -> Result<Spectrum> {
    check_count(count)?;
    let chi = characteristic(axis, stiffness, delay)?;
    let dyad::Found { roots, certificate, depth } = dyad::rightmost(&chi, count);
    Ok(Spectrum { roots, rigid_body: chi.rigid_body, certificate, depth })
}

/// The largest real part of the roots of one axis, the rigid-body root left out.
///
/// Below zero the dyad is stable at this constant delay; `stiffness` in N/m.
///
/// # Errors
///
/// [`InvalidInput`] where the axis or the stiffness is out of range.
///
/// # Examples
///
/// ```
/// use telespring::{Delay, hman, spectrum};
/// let x = hman().axis(0)?;
/// assert!(spectrum::spectral_abscissa(&x, 71.2, &Delay::each_way(0.160)?)?.value < 0.0);
/// assert!(spectrum::spectral_abscissa(&x, 71.2, &Delay::each_way(0.175)?)?.value > 0.0);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn spectral_abscissa(axis: &DyadAxis, stiffness: f64, delay: &Delay) -> Result<Abscissa> {
    let chi = characteristic(axis, stiffness, delay)?;
    let found = dyad::rightmost(&chi, 1);
    // An empty list comes with a failed certificate, which says that the value is no abscissa.
    Ok(Abscissa {
        value: found.roots.first().map_or(f64::NEG_INFINITY, |root| root.re),
        certificate: found.certificate,
    })
}

pub(crate) fn check_count(count: usize) -> Result<()> {
    if (1..=MAX_ROOTS).contains(&count) {
        return Ok(());
    }
    Err(InvalidInput::new(
        "count",
        count,
        format!("the number of roots must be from 1 to {MAX_ROOTS}"),
        "Ask for fewer roots, or for at least one.",
    ))
}

/// The checked characteristic function of one axis.
fn characteristic(axis: &DyadAxis, stiffness: f64, delay: &Delay) -> Result<Characteristic> {
    axis.check()?;
    quantity::STIFFNESS.check("stiffness", stiffness)?;
    Ok(Characteristic::new(axis, stiffness, delay.round_trip()).normalised())
}

#[cfg(test)]
mod tests;
