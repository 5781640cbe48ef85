//! The experiment of a study as Python sees it: its trials, who takes part, and the laboratory.

use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use telespring::rig::Protocol;

use crate::errors::Outcome;
use crate::participants::{Agent, Arm, Task};
use crate::rig::Laboratory;

/// A condition of an experiment: a spring and a delay, or no spring.
///
/// It unpacks and compares as the pair (stiffness, delay).
///
/// Parameters
/// ----------
/// stiffness : float or None
///     Stiffness of the virtual spring, N/m; None is the unconnected mode.
/// delay : float
///     One-way delay, each way, s.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> unconnected, first, *_ = ts.Study.paper().experiment.conditions
/// >>> unconnected
/// Condition(stiffness=None, delay=0.0)
/// >>> stiffness, delay = first
/// >>> round(stiffness, 1), delay
/// (17.8, 0.0)
#[pyclass(frozen, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Condition {
    stiffness: Option<f64>,
    delay: f64,
}

type ConditionPair = (Option<f64>, f64);

#[pymethods]
impl Condition {
    #[new]
    #[pyo3(signature = (stiffness, delay=0.0))]
    fn new(stiffness: Option<f64>, delay: f64) -> Self {
        Self { stiffness, delay }
    }

    /// Stiffness of the virtual spring, N/m; None in the unconnected mode.
    #[getter]
    fn stiffness(&self) -> Option<f64> {
        self.stiffness
    }

    /// One-way delay, each way, s.
    #[getter]
    fn delay(&self) -> f64 {
        self.delay
    }

    /// Both attributes by their names.
    ///
    /// Returns
    /// -------
    /// dict
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("stiffness", self.stiffness)?;
        dict.set_item("delay", self.delay)?;
        Ok(dict)
    }

    fn pair(&self) -> ConditionPair {
        (self.stiffness, self.delay)
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.pair().into_pyobject(py)?.call_method0("__iter__")
    }

    fn __len__(&self) -> usize {
        2
    }

    fn __getitem__<'py>(&self, py: Python<'py>, index: isize) -> PyResult<Bound<'py, PyAny>> {
        match index {
            0 | -2 => Ok(self.stiffness.into_pyobject(py)?),
            1 | -1 => Ok(self.delay.into_pyobject(py)?.into_any()),
            _ => Err(PyIndexError::new_err("a condition is a pair")),
        }
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        match other.cast::<Self>() {
            Ok(other) => self == other.get(),
            Err(_) => {
                other.is_instance_of::<PyTuple>() && other.extract().is_ok_and(|other| self.pair() == other)
            }
        }
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        self.pair().into_pyobject(py)?.hash()
    }

    fn __repr__(&self) -> String {
        let stiffness = self.stiffness.map_or_else(|| "None".to_owned(), |value| format!("{value:?}"));
        format!("Condition(stiffness={stiffness}, delay={:?})", self.delay)
    }

    fn __getnewargs__(&self) -> ConditionPair {
        self.pair()
    }
}

/// Imperfections of the controllers and the network of a virtual laboratory; the defaults have none.
///
/// Parameters
/// ----------
/// computing_tick : bool
///     Whether a force acts one sample period after the sample it was computed from.
/// actuator_lag : float
///     Time constant of the robots' actuators, s.
/// encoder_resolution : float
///     Step to which measured positions are rounded, m; 0 is none.
/// jitter : float
///     Largest delay of a packet beyond that of the condition, s.
/// loss : float
///     Probability that a packet is lost.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> ts.Study.paper().experiment.settings == ts.LaboratorySettings()
/// True
#[pyclass(frozen, eq, get_all, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct LaboratorySettings {
    /// Whether a force acts one sample period after the sample it was computed from.
    computing_tick: bool,
    /// Time constant of the robots' actuators, s.
    actuator_lag: f64,
    /// Step to which measured positions are rounded, m; 0 is none.
    encoder_resolution: f64,
    /// Largest delay of a packet beyond that of the condition, s.
    jitter: f64,
    /// Probability that a packet is lost.
    loss: f64,
}

#[pymethods]
impl LaboratorySettings {
    #[new]
    #[pyo3(signature = (computing_tick=false, actuator_lag=0.0, encoder_resolution=0.0, jitter=0.0, loss=0.0))]
    fn new(computing_tick: bool, actuator_lag: f64, encoder_resolution: f64, jitter: f64, loss: f64) -> Self {
        Self { computing_tick, actuator_lag, encoder_resolution, jitter, loss }
    }

    /// The attributes by their names, which are those of the section `[laboratory]` of a study file.
    ///
    /// Returns
    /// -------
    /// dict
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("computing_tick", self.computing_tick)?;
        dict.set_item("actuator_lag", self.actuator_lag)?;
        dict.set_item("encoder_resolution", self.encoder_resolution)?;
        dict.set_item("jitter", self.jitter)?;
        dict.set_item("loss", self.loss)?;
        Ok(dict)
    }

    fn __repr__(&self) -> String {
        let Self { computing_tick, actuator_lag, encoder_resolution, jitter, loss } = self;
        let tick = if *computing_tick { "True" } else { "False" };
        format!(
            "LaboratorySettings(computing_tick={tick}, actuator_lag={actuator_lag:?}, \
             encoder_resolution={encoder_resolution:?}, jitter={jitter:?}, loss={loss:?})"
        )
    }

    fn __getnewargs__(&self) -> (bool, f64, f64, f64, f64) {
        (self.computing_tick, self.actuator_lag, self.encoder_resolution, self.jitter, self.loss)
    }
}

/// The rehearsal that a study describes: conditions, trials and who takes part. `Study.experiment` returns
/// it.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> experiment = ts.Study.paper().experiment
/// >>> len(experiment.conditions), experiment.trials, experiment.duration
/// (17, 20, 29.111)
/// >>> experiment.conditions[0].stiffness is None  # the unconnected mode
/// True
/// >>> experiment.agents[1].spots
/// 10
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    study: telespring::study::Study,
    protocol: Protocol,
    sample_period: f64,
}

impl Experiment {
    /// The experiment of a study whose robots have the axes of a rehearsal.
    pub fn of(study: &telespring::study::Study) -> Outcome<Self> {
        Ok(Self { study: study.clone(), protocol: study.protocol()?, sample_period: study.sample_period()? })
    }
}

#[pymethods]
impl Experiment {
    /// The experiment of a study's text.
    #[staticmethod]
    fn _from_toml(text: &str) -> Outcome<Self> {
        Self::of(&telespring::study::Study::from_toml(text)?)
    }

    /// The conditions in order.
    #[getter]
    fn conditions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let conditions = self.protocol.conditions.iter();
        PyTuple::new(
            py,
            conditions.map(|&(stiffness, delay)| Condition { stiffness, delay }).collect::<Vec<_>>(),
        )
    }

    /// Trials of each condition.
    #[getter]
    fn trials(&self) -> usize {
        self.protocol.trials
    }

    /// Duration of a trial, s.
    #[getter]
    fn duration(&self) -> f64 {
        self.protocol.duration
    }

    /// First part of a trial that the analysis leaves out, s.
    #[getter]
    fn discard(&self) -> f64 {
        self.protocol.discard
    }

    /// Recorded samples per second, Hz.
    #[getter]
    fn record_rate(&self) -> f64 {
        self.protocol.record_rate
    }

    /// The seed from which the seed of every trial is drawn.
    #[getter]
    fn seed(&self) -> u64 {
        self.protocol.seed
    }

    /// "blocks", one condition after the other, or "shuffled", in an order drawn from the seed.
    #[getter]
    fn order(&self) -> &'static str {
        if self.protocol.shuffled { "shuffled" } else { "blocks" }
    }

    /// Sample period of the controllers, s.
    #[getter]
    fn sample_period(&self) -> f64 {
        self.sample_period
    }

    /// Both agents, defaults filled in.
    #[getter]
    fn agents(&self) -> (Agent, Agent) {
        self.study.setup().agents.clone().map(Agent).into()
    }

    /// The target that both agents follow, defaults filled in.
    #[getter]
    fn task(&self) -> Task {
        Task(self.study.setup().task.clone())
    }

    /// Both arms, defaults filled in.
    #[getter]
    fn arms(&self) -> (Arm, Arm) {
        self.study.setup().arms.map(Arm).into()
    }

    /// Imperfections of the controllers and the network.
    #[getter]
    fn settings(&self) -> LaboratorySettings {
        let setup = self.study.setup();
        LaboratorySettings {
            computing_tick: setup.computing_tick,
            actuator_lag: setup.actuator_lag,
            encoder_resolution: setup.encoder_resolution,
            jitter: setup.jitter,
            loss: setup.loss,
        }
    }

    /// Damping beside the spring, N·s/m.
    #[getter]
    fn coupling_damping(&self) -> f64 {
        self.study.coupling().damping
    }

    /// The virtual laboratory: robots, arms, agents, target, controllers and network.
    ///
    /// Its `run` needs the agents and the target that are written in Python as arguments.
    #[getter]
    fn laboratory(&self) -> Outcome<Laboratory> {
        Ok(Laboratory(self.study.laboratory()?))
    }

    fn __repr__(&self) -> String {
        let Protocol { conditions, trials, duration, .. } = &self.protocol;
        format!("<Experiment of {} conditions, {trials} trials each, {duration:?} s long>", conditions.len())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((py.get_type::<Self>().getattr("_from_toml")?, (self.study.to_toml(),)))
    }
}
