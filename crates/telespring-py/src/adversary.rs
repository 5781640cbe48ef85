//! Adversaries on a network as Python sees them.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use telespring::rig;

use crate::arguments::hash;
use crate::errors::Outcome;
use crate::participants::{keywords, with_kind, written_out};

/// What stands behind the network of a rehearsal and does the worst it can. `Study.adversaries` returns those of both
/// ways.
///
/// Parameters
/// ----------
/// **keys
///     The keys of `network.adversary` in a study file; all of a kind are required.
///
/// Raises
/// ------
/// InvalidInput
///     If a key or a value is refused.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> oldest = ts.Adversary(kind="oldest-sample", memory=1.0)
/// >>> study = ts.Study.paper().replace(network={"adversary": {"forward": oldest}})
/// >>> study.adversaries
/// (Adversary(kind='oldest-sample', memory=1.0), None)
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Adversary(pub rig::Adversary);

#[pymethods]
impl Adversary {
    #[new]
    #[pyo3(signature = (**keys))]
    fn new(keys: Option<&Bound<'_, PyDict>>) -> Outcome<Self> {
        Ok(Self(rig::Adversary::from_table(&keywords("adversary", keys)?)?))
    }

    /// "oldest-sample", "most-harmful-sample", "stretch-timed" or "lying-peer".
    #[getter]
    fn kind(&self) -> &'static str {
        self.0.kind()
    }

    /// How far back the oldest or the most harmful sample is sought, s.
    #[getter]
    fn memory(&self) -> Option<f64> {
        self.setting("memory")
    }

    /// The longest time for which a stretch-timed network withholds a packet, s.
    #[getter]
    fn longest(&self) -> Option<f64> {
        self.setting("longest")
    }

    /// How far a lying peer moves its position along the receiver's velocity, m.
    #[getter]
    fn position(&self) -> Option<f64> {
        self.setting("position")
    }

    /// What a lying peer adds to its time stamps, s; negative makes its motion older.
    #[getter]
    fn stamp(&self) -> Option<f64> {
        self.setting("stamp")
    }

    /// The energy that a lying peer claims to have sent beyond the truth, per second, W.
    #[getter]
    fn power(&self) -> Option<f64> {
        self.setting("power")
    }

    /// The keys of `network.adversary` in a study file with their values.
    ///
    /// Returns
    /// -------
    /// dict
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = with_kind(py, self.kind())?;
        for (key, value) in self.0.settings() {
            dict.set_item(key, value)?;
        }
        Ok(dict)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        written_out("Adversary", &self.to_dict(py)?)
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.to_dict(py)?.as_any())
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((), Bound<'py, PyDict>)> {
        Ok(((), self.to_dict(py)?))
    }
}

impl Adversary {
    /// The value of a setting of the adversary; `None` if its kind has none of this name.
    fn setting(&self, key: &str) -> Option<f64> {
        self.0.settings().into_iter().find(|(name, _)| *name == key).map(|(_, value)| value)
    }
}
