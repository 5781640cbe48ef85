//! The experiment of a study as Python sees it: plain values, labels and lists.

use numpy::{PyArray1, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use telespring::rig::{Arm, Elbow, Protocol};
use telespring::study::{AgentChoice, OptionValue, PythonObject, Task};

use crate::errors::Outcome;
use crate::rig::Laboratory;
use crate::study::Study;

/// How far a robot's identified parameters may be off, per axis.
///
/// Mass and damping of one axis are normal with these standard deviations and this correlation; axes and
/// robots are independent. `Study.uncertainty` gives it.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> study = ts.Study.from_toml('''
/// ... robot1 = {mass = 1, damping = 5, mass_sd = 0.02, damping_sd = 0.1}
/// ... robot2 = {mass = 1, damping = 5}
/// ... coupling.stiffness = 20
/// ... network.delay = 0.05
/// ... ''')
/// >>> first, second = study.uncertainty
/// >>> first.mass_sd, second is None
/// (array([0.02]), True)
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty(pub telespring::study::Uncertainty);

#[pymethods]
impl Uncertainty {
    #[new]
    fn new(mass_sd: Vec<f64>, damping_sd: Vec<f64>, correlation: Vec<f64>) -> Self {
        Self(telespring::study::Uncertainty { mass_sd, damping_sd, correlation })
    }

    /// Standard deviation of the mass per axis, kg.
    #[getter]
    fn mass_sd<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.mass_sd.to_pyarray(py)
    }

    /// Standard deviation of the damping per axis, N·s/m.
    #[getter]
    fn damping_sd<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.damping_sd.to_pyarray(py)
    }

    /// Correlation of mass and damping per axis, −1 to 1.
    #[getter]
    fn correlation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.correlation.to_pyarray(py)
    }

    fn __repr__(&self) -> String {
        let each = &self.0;
        format!(
            "Uncertainty(mass_sd={:?}, damping_sd={:?}, correlation={:?})",
            each.mass_sd, each.damping_sd, each.correlation
        )
    }

    fn __getnewargs__(&self) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        (self.0.mass_sd.clone(), self.0.damping_sd.clone(), self.0.correlation.clone())
    }
}

/// What a study says of its rehearsal: conditions, trials, who takes part. `Study.experiment` gives it.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> experiment = ts.Study.paper().experiment
/// >>> len(experiment.conditions), experiment.trials, experiment.duration
/// (17, 20, 29.111)
/// >>> experiment.conditions[0]
/// (None, 0.0)
/// >>> experiment.agents[1]["spots"]
/// 10
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    study: Study,
    protocol: Protocol,
    sample_period: f64,
}

impl Experiment {
    /// That of a study whose robots have the axes of a rehearsal.
    pub fn of(study: &Study) -> Outcome<Self> {
        let inner = &study.0;
        Ok(Self { study: study.clone(), protocol: inner.protocol()?, sample_period: inner.sample_period()? })
    }
}

#[pymethods]
impl Experiment {
    /// Conditions in order: stiffness, N/m, None in the unconnected mode, and one-way delay, s.
    #[getter]
    fn conditions(&self) -> Vec<(Option<f64>, f64)> {
        self.protocol.conditions.clone()
    }

    /// Trials of each condition.
    #[getter]
    fn trials(&self) -> usize {
        self.protocol.trials
    }

    /// Length of a trial, s.
    #[getter]
    fn duration(&self) -> f64 {
        self.protocol.duration
    }

    /// First part of a trial that the analysis leaves out, s.
    #[getter]
    fn discard(&self) -> f64 {
        self.protocol.discard
    }

    /// Samples kept per second, Hz.
    #[getter]
    fn record_rate(&self) -> f64 {
        self.protocol.record_rate
    }

    /// From which every trial's own seed is drawn.
    #[getter]
    fn seed(&self) -> u64 {
        self.protocol.seed
    }

    /// "blocks", one condition after the other, or "shuffled", in an order drawn from the seed.
    #[getter]
    fn order(&self) -> &'static str {
        if self.protocol.shuffled { "shuffled" } else { "blocks" }
    }

    /// Period of the controllers, s.
    #[getter]
    fn sample_period(&self) -> f64 {
        self.sample_period
    }

    /// Both agents as the study file names them, defaults filled in.
    #[getter]
    fn agents<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.study.0.setup().agents.iter().map(|each| agent(py, each)).collect()
    }

    /// What the agents follow as the study file names it, defaults filled in.
    #[getter]
    fn task<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        match &self.study.0.setup().task {
            Task::FigureEight { amplitude, angular_frequency } => {
                let dict = kind(py, "figure-eight")?;
                dict.set_item("amplitude", amplitude.to_vec())?;
                dict.set_item("angular_frequency", angular_frequency)?;
                Ok(dict)
            }
            Task::Python(object) => python(py, "function", object),
        }
    }

    /// Both arms as the study file names them, defaults filled in.
    #[getter]
    fn arms<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.study.0.setup().arms.iter().map(|each| arm(py, each)).collect()
    }

    /// The damper beside the spring, N·s/m.
    #[getter]
    fn coupling_damping(&self) -> f64 {
        self.study.0.coupling().damping
    }

    /// The virtual laboratory: robots, arms, agents, target, controllers and network.
    ///
    /// An agent of Python is to be given to its `run`, and so is a target of Python.
    #[getter]
    fn laboratory(&self) -> Outcome<Laboratory> {
        Ok(Laboratory(self.study.0.laboratory()?))
    }

    fn __repr__(&self) -> String {
        let Protocol { conditions, trials, duration, .. } = &self.protocol;
        format!("<Experiment of {} conditions, {trials} trials each, {duration:?} s long>", conditions.len())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Study, &'static str))> {
        Ok((py.import("builtins")?.getattr("getattr")?, (self.study.clone(), "experiment")))
    }
}

fn kind<'py>(py: Python<'py>, kind: &str) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("kind", kind)?;
    Ok(dict)
}

fn agent<'py>(py: Python<'py>, agent: &AgentChoice) -> PyResult<Bound<'py, PyDict>> {
    match agent {
        AgentChoice::Skilled { stiffness, damping } => {
            let dict = kind(py, "skilled")?;
            dict.set_item("stiffness", stiffness)?;
            dict.set_item("damping", damping)?;
            Ok(dict)
        }
        AgentChoice::Blurred { stiffness, spots } => {
            let dict = kind(py, "blurred")?;
            dict.set_item("stiffness", stiffness)?;
            dict.set_item("spots", spots.count)?;
            dict.set_item("spot_velocity", spots.velocity)?;
            dict.set_item("spot_lifetime", spots.lifetime)?;
            Ok(dict)
        }
        AgentChoice::Python(object) => python(py, "class", object),
    }
}

fn arm<'py>(py: Python<'py>, arm: &Arm) -> PyResult<Bound<'py, PyDict>> {
    match arm {
        Arm::Lumped { mass, damping } if mass.iter().chain(damping).all(|&each| each == 0.0) => {
            kind(py, "massless")
        }
        Arm::Lumped { mass, damping } => {
            let dict = kind(py, "lumped")?;
            dict.set_item("mass", mass.to_vec())?;
            dict.set_item("damping", damping.to_vec())?;
            Ok(dict)
        }
        Arm::TwoLink(arm) => {
            let dict = kind(py, "two-link")?;
            dict.set_item("elbow", if arm.elbow == Elbow::Left { "left" } else { "right" })?;
            for (key, pair) in [
                ("base", arm.base),
                ("link_length", arm.link_length),
                ("link_mass", arm.link_mass),
                ("link_centre", arm.link_centre),
                ("link_inertia", arm.link_inertia),
                ("joint_damping", arm.joint_damping),
                ("rotor_inertia", arm.rotor_inertia),
                ("torque_limit", arm.torque_limit),
            ] {
                dict.set_item(key, pair.to_vec())?;
            }
            Ok(dict)
        }
    }
}

fn python<'py>(py: Python<'py>, key: &str, object: &PythonObject) -> PyResult<Bound<'py, PyDict>> {
    let dict = kind(py, "python")?;
    dict.set_item(key, &object.path)?;
    let options = PyDict::new(py);
    for (name, value) in &object.options {
        options.set_item(name, option(py, value)?)?;
    }
    dict.set_item("options", options)?;
    Ok(dict)
}

fn option<'py>(py: Python<'py>, value: &OptionValue) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        OptionValue::Boolean(value) => value.into_pyobject(py)?.to_owned().into_any(),
        OptionValue::Whole(value) => value.into_pyobject(py)?.into_any(),
        OptionValue::Number(value) => value.into_pyobject(py)?.into_any(),
        OptionValue::Text(text) => text.into_pyobject(py)?.into_any(),
        OptionValue::List(items) => {
            let items = items.iter().map(|item| option(py, item)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, items)?.into_any()
        }
    })
}
