//! The spectrum of one axis of a dyad as Python functions.

use num_complex::Complex64;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use telespring::{Delay, DyadAxis, spectrum};

use crate::arguments::{Argument, AxisChoice, Count, DelayChoice, Number};
use crate::errors::Outcome;
use crate::interrupt::apart;
use crate::model::Dyad;
use crate::spectrum::{Spectrum, warn};

/// The arguments of the functions on a dyad's roots, checked.
fn check(
    dyad: Argument<Bound<'_, Dyad>>,
    stiffness: Number,
    delay: &DelayChoice,
    axis: &AxisChoice,
) -> Outcome<(DyadAxis, f64, Delay)> {
    Ok((axis.of(&dyad.named("dyad")?.get().0)?, stiffness.named("stiffness")?, delay.check()?))
}

/// Rightmost characteristic roots together with their certificate.
///
/// Parameters
/// ----------
/// dyad : Dyad
///     Robots and operators.
/// stiffness : float
///     Stiffness of the virtual spring, N/m.
/// delay : float or (float, float)
///     One-way delay, s, or the pair (forward, backward).
/// count : int
///     How many roots to return, 1 to 1000; without any delay there are four in all.
/// axis : int or str
///     The axis by its index or its name.
///
/// Returns
/// -------
/// Spectrum
///     A failed certificate is reported in it; there is no warning.
///
/// Raises
/// ------
/// InvalidInput
///     If a value is out of its range.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> spectrum = ts.certified_roots(ts.hman(), 71.2, 0.167)
/// >>> spectrum.complete, spectrum.rigid_body, spectrum.roots.shape
/// (True, True, (8,))
#[pyfunction]
#[pyo3(signature = (dyad, stiffness, delay, count=Count::Given(8), axis=AxisChoice::FIRST),
       text_signature = "(dyad, stiffness, delay, count=8, axis=0)")]
pub fn certified_roots(
    py: Python<'_>,
    dyad: Argument<Bound<'_, Dyad>>,
    stiffness: Number,
    delay: DelayChoice,
    count: Count,
    axis: AxisChoice,
) -> Outcome<Spectrum> {
    let (axis, stiffness, delay) = check(dyad, stiffness, &delay, &axis)?;
    let count = count.check()?;
    let roots = apart(py, move || spectrum::characteristic_roots(&axis, stiffness, &delay, count))??;
    Ok(Spectrum::of(py, roots))
}

/// Rightmost roots of P1(s) P2(s) - (k + c s)² exp(-T s), without the rigid-body root s = 0.
///
/// T is the sum of both delays and P_i(s) = m_i s² + (b_i + c) s + k + kh_i: the denominator of Eq. 2 of [1]_,
/// with operators and a coupling damper.
///
/// Parameters
/// ----------
/// dyad : Dyad
///     Robots and operators.
/// stiffness : float
///     Stiffness of the virtual spring, N/m.
/// delay : float or (float, float)
///     One-way delay, s, or the pair (forward, backward).
/// count : int
///     How many roots to return, 1 to 1000.
/// axis : int or str
///     The axis by its index or its name.
///
/// Returns
/// -------
/// ndarray of complex
///     The roots, 1/s, rightmost first; fewer than `count` only if there is no delay.
///
/// Raises
/// ------
/// InvalidInput
///     If a value is out of its range.
///
/// Warns
/// -----
/// CertificateWarning
///     If the argument principle does not confirm that no root was missed; `certified_roots` reports the
///     same without a warning.
///
/// References
/// ----------
/// .. [1] M. Du, S. R. Kulkarni, S. Kager, D. Campolo, "Stability Criteria and Motor Performance in
///    Delayed Haptic Dyadic Interactions Mediated by Robots".
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> roots = ts.characteristic_roots(ts.hman(), 71.2, 0.175, count=4, axis="x")
/// >>> bool(roots[0].real > 0), bool(roots[1] == roots[0].conj())
/// (True, True)
#[pyfunction]
#[pyo3(signature = (dyad, stiffness, delay, count=Count::Given(8), axis=AxisChoice::FIRST),
       text_signature = "(dyad, stiffness, delay, count=8, axis=0)")]
pub fn characteristic_roots<'py>(
    py: Python<'py>,
    dyad: Argument<Bound<'py, Dyad>>,
    stiffness: Number,
    delay: DelayChoice,
    count: Count,
    axis: AxisChoice,
) -> Outcome<Bound<'py, PyArray1<Complex64>>> {
    let (axis, stiffness, delay) = check(dyad, stiffness, &delay, &axis)?;
    let count = count.check()?;
    let roots = apart(py, move || spectrum::characteristic_roots(&axis, stiffness, &delay, count))??;
    warn(py, "roots'", &roots.certificate)?;
    Ok(roots.roots.into_pyarray(py))
}

/// Largest real part of the characteristic roots, the rigid-body root excluded.
///
/// Parameters
/// ----------
/// dyad : Dyad
///     Robots and operators.
/// stiffness : float
///     Stiffness of the virtual spring, N/m.
/// delay : float or (float, float)
///     One-way delay, s, or the pair (forward, backward).
/// axis : int or str
///     The axis by its index or its name.
///
/// Returns
/// -------
/// float
///     The spectral abscissa, 1/s; below zero every motion but the common drift decays.
///
/// Raises
/// ------
/// InvalidInput
///     If a value is out of its range.
///
/// Warns
/// -----
/// CertificateWarning
///     If the argument principle does not confirm that no root was missed.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> ts.spectral_abscissa(ts.hman(), 71.2, 0.160) < 0 < ts.spectral_abscissa(ts.hman(), 71.2, 0.175)
/// True
#[pyfunction]
#[pyo3(signature = (dyad, stiffness, delay, axis=AxisChoice::FIRST),
       text_signature = "(dyad, stiffness, delay, axis=0)")]
pub fn spectral_abscissa(
    py: Python<'_>,
    dyad: Argument<Bound<'_, Dyad>>,
    stiffness: Number,
    delay: DelayChoice,
    axis: AxisChoice,
) -> Outcome<f64> {
    let (axis, stiffness, delay) = check(dyad, stiffness, &delay, &axis)?;
    let abscissa = apart(py, move || spectrum::spectral_abscissa(&axis, stiffness, &delay))??;
    warn(py, "abscissa's", &abscissa.certificate)?;
    Ok(abscissa.value)
}
