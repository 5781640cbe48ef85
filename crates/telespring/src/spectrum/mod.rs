//! Characteristic roots down to a chosen depth, with a certificate that none is missing.
//!
//! With a delay there are infinitely many roots, but only finitely many right of any vertical line. The
//! argument principle counts those without computing them. A list of roots is certified only if both
//! numbers agree.

pub mod contour;
mod dyad;
mod line;
mod newton;
mod polynomial;

use num_complex::Complex64;

use crate::characteristic::Characteristic;
use crate::error::{InvalidInput, Result};
use crate::model::{Delay, DyadAxis};
use crate::quantity;

/// The largest number of roots that can be requested.
pub const MAX_ROOTS: usize = 1000;

/// Whether all roots right of a vertical line are known.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Certificate {
    /// The argument principle counted exactly the roots found right of the depth: none is missing.
    Complete,
    /// The two numbers differ: a root may be missing or listed twice.
    Failed {
        /// The number of roots right of the depth by the argument principle, with multiplicity.
        counted: usize,
        /// The number of roots found there.
        found: usize,
    },
    /// The roots were not counted; some may be missing.
    NotCounted {
        /// Why they were not counted.
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
    /// Writes the certificate of a spectrum.
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
    /// The roots, 1/s, by descending real part, the upper root of a conjugate pair first. A multiple root
    /// is listed with its multiplicity. The last pair is cut if only one place is left.
    pub roots: Vec<Complex64>,
    /// True if s = 0 is another root, the rigid-body motion with both handles free. It is divided out and
    /// not listed.
    pub rigid_body: bool,
    /// Whether every root right of `depth` is known.
    pub certificate: Certificate,
    /// The line Re s = `depth`, 1/s, right of which the roots were counted. It lies left of every listed
    /// root; found roots beyond the requested number may lie between. Minus infinity without delay: all
    /// roots are then known.
    pub depth: f64,
}

/// The largest real part of the characteristic roots.
#[derive(Debug, Clone, PartialEq)]
pub struct Abscissa {
    /// The spectral abscissa, 1/s: if negative, every motion but the rigid-body motion decays. Minus
    /// infinity if no root was found; the certificate is then not complete.
    pub value: f64,
    /// Whether no root was missed.
    pub certificate: Certificate,
}

/// The `count` rightmost characteristic roots of one axis, without the rigid-body root s = 0.
///
/// They are the zeros of P₁(s) P₂(s) − (k + c s)² e^(−T s) with the round-trip delay T and Pᵢ(s) = mᵢ s² +
/// (bᵢ + c) s + k + k_h,i (the denominator of Eq. 2 of Du, Kulkarni, Kager and Campolo, with operators and
/// a coupling damper). Each is refined to a relative error of about 1e-12, or as far as rounding allows for
/// a multiple root. `stiffness` is in N/m. Without delay there are four roots, three besides the rigid-body
/// root, so fewer than `count` may be returned.
///
/// The count behind the certificate is the argument principle in closed form. It costs about as much as a
/// few roots, for any delay.
///
/// # Errors
///
/// [`InvalidInput`] if the axis, the stiffness or `count` (1 to [`MAX_ROOTS`]) is out of range.
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
    check_root_count(count)?;
    let chi = checked_characteristic(axis, stiffness, delay)?;
    let dyad::RightmostRoots { roots, certificate, depth } = dyad::rightmost_roots(&chi, count);
    Ok(Spectrum { roots, rigid_body: chi.rigid_body, certificate, depth })
}

/// The spectral abscissa of one axis: the largest real part of its roots, without the rigid-body root.
///
/// The dyad is stable at this constant delay if it is negative; `stiffness` is in N/m.
///
/// # Errors
///
/// [`InvalidInput`] if the axis or the stiffness is out of range.
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
    let chi = checked_characteristic(axis, stiffness, delay)?;
    let rightmost = dyad::rightmost_roots(&chi, 1);
    // An empty list has a failed certificate, which marks the value as invalid.
    Ok(Abscissa {
        value: rightmost.roots.first().map_or(f64::NEG_INFINITY, |root| root.re),
        certificate: rightmost.certificate,
    })
}

/// The spectral abscissa at any stiffness, for searches over it; minus infinity if no root was found.
pub(crate) fn largest_real_part(axis: &DyadAxis, stiffness: f64, round_trip: f64) -> f64 {
    let chi = Characteristic::new(axis, stiffness, round_trip).normalised();
    dyad::rightmost_roots(&chi, 1).roots.first().map_or(f64::NEG_INFINITY, |root| root.re)
}

/// Checks the requested number of characteristic roots of a spectrum.
pub(crate) fn check_root_count(count: usize) -> Result<()> {
    if (1..=MAX_ROOTS).contains(&count) {
        return Ok(());
    }
    Err(InvalidInput::new(
        "count",
        count,
        format!("the number of roots must be from 1 to {MAX_ROOTS}"),
        "Request a number of roots in this range.",
    ))
}

/// The characteristic function of one axis with checked arguments, for its spectrum.
fn checked_characteristic(axis: &DyadAxis, stiffness: f64, delay: &Delay) -> Result<Characteristic> {
    axis.check()?;
    quantity::STIFFNESS.check("stiffness", stiffness)?;
    Ok(Characteristic::new(axis, stiffness, delay.round_trip()).normalised())
}

#[cfg(test)]
mod tests;
