//! Ranges of operators.

use pyo3::prelude::*;
use telespring::verdicts;

use crate::arguments::{Argument, hash};
use crate::errors::Outcome;
use crate::model::Operator;

/// A range of operators: a grip varies, and a verdict must hold for all of them.
///
/// Parameters
/// ----------
/// low, high : Operator
///     Both ends, included. A single number applies to every axis of the dyad.
///
/// Raises
/// ------
/// InvalidInput
///     If both ends differ in their number of axes or a lower end exceeds the upper.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> ts.OperatorRange(ts.Operator(), ts.Operator(mass=1.5, stiffness=300.0)).high.stiffness
/// array([300.])
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct OperatorRange {
    low: Operator,
    high: Operator,
}

impl OperatorRange {
    /// The Python operator range on a dyad with that many axes.
    pub fn on(&self, axes: usize) -> telespring::Result<verdicts::OperatorRange> {
        let low = self.low.on(axes).map_err(|refusal| refusal.within("low"))?;
        let high = self.high.on(axes).map_err(|refusal| refusal.within("high"))?;
        verdicts::OperatorRange::new(low, high)
    }
}

impl From<&verdicts::OperatorRange> for OperatorRange {
    /// The Python operator range with the values of one of the core.
    fn from(range: &verdicts::OperatorRange) -> Self {
        Self { low: range.low().into(), high: range.high().into() }
    }
}

#[pymethods]
impl OperatorRange {
    #[new]
    fn new(low: Argument<Bound<'_, Operator>>, high: Argument<Bound<'_, Operator>>) -> Outcome<Self> {
        let (low, high) = (low.named("low")?.get().clone(), high.named("high")?.get().clone());
        let range = Self { low, high };
        range.on(range.low.count().max(range.high.count()))?;
        Ok(range)
    }

    /// The lower `Operator` of the range.
    #[getter]
    fn low(&self) -> Operator {
        self.low.clone()
    }

    /// The upper `Operator` of the range.
    #[getter]
    fn high(&self) -> Operator {
        self.high.clone()
    }

    fn __repr__(&self) -> String {
        format!("OperatorRange({}, {})", self.low.__repr__(), self.high.__repr__())
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.__getnewargs__().into_pyobject(py)?.as_any())
    }

    fn __getnewargs__(&self) -> (Operator, Operator) {
        (self.low(), self.high())
    }
}
