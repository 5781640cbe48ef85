//! The spring and the damper between the robots.

use pyo3::prelude::*;
use telespring::quantity;

use crate::arguments::{Number, hash};
use crate::errors::Outcome;

/// The coupling of the robots: a virtual spring and a damper in parallel with it.
///
/// Parameters
/// ----------
/// stiffness : float
///     Stiffness, N/m.
/// damping : float
///     Damping, N·s/m, through the same delay.
///
/// Raises
/// ------
/// InvalidInput
///     If a value is out of range.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> ts.Coupling(stiffness=71.2)
/// Coupling(stiffness=71.2, damping=0.0)
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling(pub telespring::study::Coupling);

#[pymethods]
impl Coupling {
    #[new]
    #[pyo3(signature = (stiffness, damping=Number::Given(0.0)), text_signature = "(stiffness, damping=0.0)")]
    fn new(stiffness: Number, damping: Number) -> Outcome<Self> {
        let (stiffness, damping) = (stiffness.named("stiffness")?, damping.named("damping")?);
        Ok(Self(telespring::study::Coupling {
            stiffness: quantity::STIFFNESS.check("stiffness", stiffness)?,
            damping: quantity::DAMPING.check("damping", damping)?,
        }))
    }

    /// Stiffness of the study's coupling, N/m.
    #[getter]
    fn stiffness(&self) -> f64 {
        self.0.stiffness
    }

    /// Damping of the study's coupling, N·s/m.
    #[getter]
    fn damping(&self) -> f64 {
        self.0.damping
    }

    fn __repr__(&self) -> String {
        format!("Coupling(stiffness={:?}, damping={:?})", self.0.stiffness, self.0.damping)
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.__getnewargs__().into_pyobject(py)?.as_any())
    }

    fn __getnewargs__(&self) -> (f64, f64) {
        (self.0.stiffness, self.0.damping)
    }
}
