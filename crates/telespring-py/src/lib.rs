//! Python binding of `telespring`: newtypes and conversions only.
use pyo3::prelude::*;

/// The compiled core of `telespring`.
#[pymodule]
fn _core(_m: &Bound<'_, PyModule>) -> PyResult<()> {
    Ok(())
}
