//! How a refusal reaches Python: one exception class, defined in Python so that it can carry fields
//! and be pickled under the stable ABI.

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use telespring::InvalidInput;

/// Why a call into the core has no result.
#[derive(Debug)]
pub enum Failure {
    /// A value was refused.
    Refused(InvalidInput),
    /// Python itself raised, for instance in the user's function.
    Python(PyErr),
}

impl Failure {
    /// The same refusal with `place` put before its field.
    pub fn within(self, place: &str) -> Self {
        match self {
            Self::Refused(refusal) => Self::Refused(refusal.within(place)),
            raised @ Self::Python(_) => raised,
        }
    }
}

/// The result of every function of the binding.
pub type Outcome<T> = Result<T, Failure>;

impl From<InvalidInput> for Failure {
    /// The failure for a refusal by the core.
    fn from(refusal: InvalidInput) -> Self {
        Self::Refused(refusal)
    }
}

impl From<PyErr> for Failure {
    /// The failure for an exception from Python.
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

impl From<Failure> for PyErr {
    /// The Python exception for a failure.
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Python(error) => error,
            Failure::Refused(refusal) => {
                Python::attach(|py| exception(py, &refusal)).unwrap_or_else(|error| error)
            }
        }
    }
}

/// The Python exception `InvalidInput` for a refusal.
fn exception(py: Python<'_>, refusal: &InvalidInput) -> PyResult<PyErr> {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    let class = CLASS.import(py, "telespring._errors", "InvalidInput")?;
    let raised = class.call1((&refusal.field, &refusal.value, &refusal.allowed, &refusal.remedy))?;
    Ok(PyErr::from_value(raised))
}
