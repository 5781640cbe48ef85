//! Characteristic roots with their certificate.

use num_complex::Complex64;
use numpy::{IntoPyArray, Ix1};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use telespring::spectrum::Certificate;

use crate::records::{Array, record};

record! {
    /// The rightmost characteristic roots.
    Spectrum {
        /// The roots, 1/s, rightmost first, the upper one of a pair first; of an axis without its rigid-body root.
        roots: Array<Complex64, Ix1>,
        /// Whether s = 0 is a root besides: both handles are free and the robots can drift together.
        rigid_body: bool,
        /// Whether the argument principle counted exactly as many roots right of `depth` as were found.
        complete: bool,
        /// The same in words, with both numbers where they differ.
        certificate: String,
        /// The line Re s = depth, 1/s, right of which roots were counted; -inf without delay.
        depth: f64,
    }
}

impl Spectrum {
    /// The spectrum of the core as Python reads it.
    pub fn of(py: Python<'_>, spectrum: telespring::spectrum::Spectrum) -> Self {
        Self {
            roots: spectrum.roots.into_pyarray(py).into(),
            rigid_body: spectrum.rigid_body,
            complete: spectrum.certificate.is_complete(),
            certificate: spectrum.certificate.to_string(),
            depth: spectrum.depth,
        }
    }
}

/// Warns that a root of the spectrum may have been missed, where the certificate does not exclude it.
pub fn warn(py: Python<'_>, whose: &str, certificate: &Certificate) -> PyResult<()> {
    static WARNING: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    if certificate.is_complete() {
        return Ok(());
    }
    let category = WARNING.import(py, "telespring._errors", "CertificateWarning")?;
    let text = format!("the {whose} certificate is {certificate}");
    py.import("warnings")?.call_method1("warn", (text, category)).map(drop)
}
