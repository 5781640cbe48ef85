//! Characteristic roots of one axis.

use num_complex::Complex64;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use telespring::spectrum::{self, Spectrum};

use crate::arguments::{AxisChoice, Count, DelayChoice, Number};
use crate::errors::Outcome;
use crate::model::Dyad;

/// The rightmost roots as (roots, rigid body, complete, certificate in words, depth).
pub type Roots<'py> = (Bound<'py, PyArray1<Complex64>>, bool, bool, String, f64);

/// As Python's `Spectrum` takes them.
pub fn roots(py: Python<'_>, found: Spectrum) -> Roots<'_> {
    (
        found.roots.into_pyarray(py),
        found.rigid_body,
        found.certificate.is_complete(),
        found.certificate.to_string(),
        found.depth,
    )
}

/// The rightmost roots as (roots, rigid body, complete, certificate in words, depth).
#[pyfunction]
pub fn characteristic_roots<'py>(
    py: Python<'py>,
    dyad: &Bound<'py, Dyad>,
    stiffness: Number,
    delay: DelayChoice,
    count: Count,
    axis: AxisChoice,
) -> Outcome<Roots<'py>> {
    let (axis, stiffness) = (axis.of(&dyad.get().0)?, stiffness.named("stiffness")?);
    let (delay, count) = (delay.check()?, count.check()?);
    let found = py.detach(|| spectrum::characteristic_roots(&axis, stiffness, &delay, count))?;
    Ok(roots(py, found))
}

/// The abscissa as (value, complete, certificate in words).
#[pyfunction]
pub fn spectral_abscissa(
    py: Python<'_>,
    dyad: &Bound<'_, Dyad>,
    stiffness: Number,
    delay: DelayChoice,
    axis: AxisChoice,
) -> Outcome<(f64, bool, String)> {
    let (axis, stiffness) = (axis.of(&dyad.get().0)?, stiffness.named("stiffness")?);
    let found = py.detach(|| spectrum::spectral_abscissa(&axis, stiffness, &delay.check()?))?;
    Ok((found.value, found.certificate.is_complete(), found.certificate.to_string()))
}
