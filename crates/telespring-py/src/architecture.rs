//! The control architecture of a session as Python sees it, and what a comparison runs.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use telespring::session::architecture::{GuardDesign, PlayoutDesign, StrategyDesign};
use telespring::session::{self, Overdraft as CoreOverdraft};
use telespring::study::{Study, Table, Value, keys};

use crate::arguments::{Number, hash};
use crate::errors::Outcome;
use crate::participants::{keywords, written_out};
use crate::records::record;

/// What both sides of a session do with the partner's motion: strategy, predictor and play-out. `Study.session` returns
/// it.
///
/// Parameters
/// ----------
/// **keys
///     The keys of the section `[session]` of a study file; keys that are left out have their defaults, which are the
///     paper's bare spring.
///
/// Raises
/// ------
/// InvalidInput
///     If a key or a value is refused.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> guarded = ts.Architecture(strategy={"kind": "guard", "share": 0.5}, predictor="shared-target")
/// >>> guarded.label, guarded.playout
/// ('guard + shared-target', 'fixed')
/// >>> ts.Study.paper().replace(session=guarded).session == guarded
/// True
/// >>> ts.Study.paper().session
/// Architecture(strategy='spring', predictor='hold', playout='fixed')
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Architecture(pub session::Architecture);

#[pymethods]
impl Architecture {
    #[new]
    #[pyo3(signature = (**keys))]
    fn new(keys: Option<&Bound<'_, PyDict>>) -> Outcome<Self> {
        Ok(Self(session::Architecture::from_table(&keywords("session", keys)?)?))
    }

    /// The strategy's word, such as "guard".
    #[getter]
    fn strategy(&self) -> &'static str {
        self.0.strategy.kind()
    }

    /// The predictor's word, such as "shared-target".
    #[getter]
    fn predictor(&self) -> &'static str {
        self.0.predictor.kind()
    }

    /// The play-out's word: "fixed" or "adaptive".
    #[getter]
    fn playout(&self) -> &'static str {
        self.0.playout.kind()
    }

    /// The delay of a fixed play-out of its own, s; None where it follows the condition or the network.
    #[getter]
    fn playout_delay(&self) -> Option<f64> {
        match self.0.playout {
            PlayoutDesign::Fixed { delay } => delay,
            PlayoutDesign::Adaptive(_) => None,
        }
    }

    /// The architecture in a few words: its strategy, its predictor unless it holds, its play-out unless it is fixed.
    #[getter]
    fn label(&self) -> String {
        self.0.label()
    }

    /// Whether the strategy keeps an account of energy, which a recording has as `account`.
    #[getter]
    fn has_account(&self) -> bool {
        self.0.strategy.has_account()
    }

    /// Of the guard: the share of the robot's loss that it may give out again, what its account holds at the start (J),
    /// and the largest power at which it takes the partner's energy in (W). None for another strategy.
    #[getter]
    fn guard_settings(&self) -> Option<(f64, f64, f64)> {
        match self.0.strategy {
            StrategyDesign::Guard(GuardDesign { share, capacity, intake }) => Some((share, capacity, intake)),
            _ => None,
        }
    }

    /// The keys of the section `[session]` with their values: a word, or a dict where a setting is not the usual one.
    ///
    /// Returns
    /// -------
    /// dict
    ///     What `Study.replace(session=…)` takes.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> ts.Architecture(strategy="guard").settings()
    /// {'strategy': 'guard', 'predictor': 'hold', 'playout': 'fixed'}
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let table = self.0.to_table();
        let dict = PyDict::new(py);
        for key in ["strategy", "predictor", "playout"] {
            dict.set_item(key, from_value(py, &table[key])?)?;
        }
        Ok(dict)
    }

    /// As `settings`.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.settings(py)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        written_out("Architecture", &self.settings(py)?)
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.0.label().into_pyobject(py)?.as_any())
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((), Bound<'py, PyDict>)> {
        Ok(((), self.settings(py)?))
    }
}

record! {
    /// How far the guard's account can be overdrawn: energy that a robot gives out without having it.
    ///
    /// `Study.guard_overdraft` returns it; `docs/guard.md` has the proof.
    GuardOverdraft(CoreOverdraft) {
        /// The largest overdraft as a share of the robot's kinetic energy at the same speed.
        ratio,
        /// What the steps of the encoder alone can overdraw, J; it does not add up.
        hidden,
        /// The largest stiffness for which the guard is proven with these robots and controllers, N/m.
        proven_stiffness,
    }
    computed {
        /// Whether the guard is proven: no robot gets more than 1/(1 − 0.1) times the energy that is there, and what `hidden`
        /// adds.
        is_proven = |overdraft| overdraft.0.is_proven(),
    }
    methods {
        /// Above this ratio the guard counts as not proven.
        #[classattr]
        const LARGEST_PROVEN_RATIO: f64 = CoreOverdraft::LARGEST_PROVEN_RATIO;

        /// The most energy that a robot can have where at most `available` was there, J; infinite from a ratio of 1 on.
        ///
        /// Parameters
        /// ----------
        /// available : float
        ///     What the robot had at the start, its account held, and its hand and the partner gave less what was lost, J.
        ///
        /// Returns
        /// -------
        /// float
        ///
        /// Examples
        /// --------
        /// >>> import telespring as ts
        /// >>> overdraft = ts.Study.paper().guard_overdraft(142.5)
        /// >>> overdraft.is_proven, round(overdraft.largest_energy(1.0), 4)
        /// (True, 1.0002)
        fn largest_energy(&self, available: Number) -> Outcome<f64> {
            Ok(self.0.largest_energy(available.named("available")?))
        }
    }
}

/// A network of a comparison: its name, what `Study.replace(network=…)` takes for it, and its delays, s; None for the
/// protocol's.
type ComparedNetwork<'py> = (String, Bound<'py, PyDict>, Option<Vec<f64>>);

/// What a comparison runs beside the stiffnesses and delays of the protocol. `Study.comparison` returns it.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> study = ts.Study.paper().replace(comparison={
/// ...     "architectures": ["spring", {"strategy": "guard", "predictor": "shared-target"}],
/// ...     "networks": [{"name": "Wi-Fi", "jitter": 0.02, "delay": [0.0, 0.05]}],
/// ... })
/// >>> study.comparison.labels
/// ['spring', 'guard + shared-target']
/// >>> [(name, keys["jitter"], delays) for name, keys, delays in study.comparison.networks]
/// [('Wi-Fi', 0.02, [0.0, 0.05])]
/// >>> ts.Study.paper().comparison.networks
/// [('study', {}, None)]
#[pyclass(frozen, eq, module = "telespring._core")]
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonPlan {
    study: Study,
}

impl ComparisonPlan {
    /// What a comparison of a study runs.
    pub fn of(study: &Study) -> Self {
        Self { study: study.clone() }
    }
}

#[pymethods]
impl ComparisonPlan {
    /// The architectures that are compared, in order.
    #[getter]
    fn architectures(&self) -> Vec<Architecture> {
        self.study.compared_architectures().into_iter().map(Architecture).collect()
    }

    /// The labels of the architectures that are compared; of equal ones the second and the following are numbered.
    #[getter]
    fn labels(&self) -> Vec<String> {
        session::Architecture::labels(&self.study.compared_architectures())
    }

    /// The networks that are compared: for each its name, a dict for `Study.replace(network=…)` that leaves nothing of the
    /// study's own network but its delay, and a list of delays instead of the protocol's, s, or None.
    #[getter]
    fn networks<'py>(&self, py: Python<'py>) -> PyResult<Vec<ComparedNetwork<'py>>> {
        let Some(networks) = self.study.compared_networks() else {
            return Ok(vec![("study".to_owned(), PyDict::new(py), None)]);
        };
        let mut all = Vec::new();
        for network in networks {
            let dict = PyDict::new(py);
            for key in keys().iter().filter_map(|key| key.strip_prefix("network.")) {
                match network.keys.get(key) {
                    Some(value) => dict.set_item(key, from_value(py, value)?)?,
                    None if key == "delay" => {}
                    None => dict.set_item(key, py.None())?,
                }
            }
            all.push((network.name.clone(), dict, network.delays.clone()));
        }
        Ok(all)
    }

    fn __repr__(&self) -> String {
        let networks = self.study.compared_networks().map_or(1, <[_]>::len);
        let architectures = self.study.compared_architectures().len();
        format!("<ComparisonPlan of {architectures} architectures on {networks} network(s)>")
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.labels().into_pyobject(py)?.get_item(0)?.as_any())
    }

    #[staticmethod]
    fn _from_toml(text: &str) -> Outcome<Self> {
        Ok(Self::of(&Study::from_toml(text)?))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((py.get_type::<Self>().getattr("_from_toml")?, (self.study.to_toml(),)))
    }
}

/// A value of a study file as Python holds it.
fn from_value<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::String(text) => text.into_pyobject(py)?.into_any(),
        Value::Integer(value) => value.into_pyobject(py)?.into_any(),
        Value::Float(value) => value.into_pyobject(py)?.into_any(),
        Value::Boolean(value) => value.into_pyobject(py)?.to_owned().into_any(),
        Value::Datetime(value) => value.to_string().into_pyobject(py)?.into_any(),
        Value::Array(items) => {
            let items = items.iter().map(|item| from_value(py, item)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, items)?.into_any()
        }
        Value::Table(table) => from_table(py, table)?.into_any(),
    })
}

/// A table of a study file as Python holds it.
fn from_table<'py>(py: Python<'py>, table: &Table) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (key, value) in table {
        dict.set_item(key, from_value(py, value)?)?;
    }
    Ok(dict)
}
