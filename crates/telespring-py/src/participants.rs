//! Who takes part in a rehearsal as Python sees it: agents, their arms, and the task that they follow.

use std::ffi::CString;

use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyDeprecationWarning, PyKeyError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use telespring::InvalidInput;
use telespring::rig::{self, Elbow, Spots, TwoLinkArm, figure_eight_positions};
use telespring::study::{self, AgentChoice, PythonObject, Table};

use crate::arguments::{Argument, hash};
use crate::errors::Outcome;
use crate::study_values::{option, to_table};

/// Who moves an arm. `Experiment.agents` returns both.
///
/// Parameters
/// ----------
/// **keys
///     The keys of the section `[agent1]` of a study file; keys that are left out have their defaults.
///
/// Raises
/// ------
/// InvalidInput
///     If a key or a value is refused.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> skilled, less_skilled = ts.Study.paper().experiment.agents
/// >>> skilled
/// Agent(kind='skilled', stiffness=120.0, damping=0.0)
/// >>> less_skilled.spots, less_skilled.damping is None
/// (10, True)
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Agent(pub AgentChoice);

#[pymethods]
impl Agent {
    #[new]
    #[pyo3(signature = (**keys))]
    fn new(keys: Option<&Bound<'_, PyDict>>) -> Outcome<Self> {
        Ok(Self(AgentChoice::from_table(&keywords("agent", keys)?)?))
    }

    /// "skilled", "blurred" (less skilled) or "python".
    #[getter]
    fn kind(&self) -> &'static str {
        match self.0 {
            AgentChoice::Skilled { .. } => "skilled",
            AgentChoice::Blurred { .. } => "blurred",
            AgentChoice::Python(_) => "python",
        }
    }

    /// Stiffness of the spring to the target, or of the springs to all spots together, N/m.
    #[getter]
    fn stiffness(&self) -> Option<f64> {
        match self.0 {
            AgentChoice::Skilled { stiffness, .. } | AgentChoice::Blurred { stiffness, .. } => {
                Some(stiffness)
            }
            AgentChoice::Python(_) => None,
        }
    }

    /// Damping in parallel with the spring to the target, N·s/m.
    #[getter]
    fn damping(&self) -> Option<f64> {
        match self.0 {
            AgentChoice::Skilled { damping, .. } => Some(damping),
            _ => None,
        }
    }

    /// Number of spots around the target.
    #[getter]
    fn spots(&self) -> Option<usize> {
        self.cloud().map(|spots| spots.count)
    }

    /// Standard deviation of a spot's velocity relative to the target, per axis, m/s.
    #[getter]
    fn spot_velocity(&self) -> Option<f64> {
        self.cloud().map(|spots| spots.velocity)
    }

    /// Time from a spot's birth on the target to its renewal, s.
    #[getter]
    fn spot_lifetime(&self) -> Option<f64> {
        self.cloud().map(|spots| spots.lifetime)
    }

    /// The class of an agent written in Python, as "module:name"; the study file's key is `class`.
    #[getter]
    fn class_(&self) -> Option<&str> {
        self.program().map(|object| object.path.as_str())
    }

    /// The options of an agent written in Python.
    #[getter]
    fn options<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.program().map(|object| options(py, object)).transpose()
    }

    /// The keys of the study file's section with their values, defaults filled in.
    ///
    /// Returns
    /// -------
    /// dict
    pub fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = with_kind(py, self.kind())?;
        match &self.0 {
            AgentChoice::Skilled { stiffness, damping } => {
                dict.set_item("stiffness", stiffness)?;
                dict.set_item("damping", damping)?;
            }
            AgentChoice::Blurred { stiffness, spots } => {
                dict.set_item("stiffness", stiffness)?;
                dict.set_item("spots", spots.count)?;
                dict.set_item("spot_velocity", spots.velocity)?;
                dict.set_item("spot_lifetime", spots.lifetime)?;
            }
            AgentChoice::Python(object) => set_program(&dict, "class", object)?,
        }
        Ok(dict)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        deprecated_item("Agent", &self.to_dict(py)?, key)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        written_out("Agent", &self.to_dict(py)?)
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.to_dict(py)?.as_any())
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((), Bound<'py, PyDict>)> {
        Ok(((), self.to_dict(py)?))
    }
}

impl Agent {
    /// The spots of the agent if it is blurred.
    fn cloud(&self) -> Option<&Spots> {
        match &self.0 {
            AgentChoice::Blurred { spots, .. } => Some(spots),
            _ => None,
        }
    }

    /// The Python object of the agent if it has one.
    fn program(&self) -> Option<&PythonObject> {
        match &self.0 {
            AgentChoice::Python(object) => Some(object),
            _ => None,
        }
    }
}

/// What carries an agent's hand to the handle. `Experiment.arms` returns both.
///
/// Pairs are those of the axes x and y (`mass`, `damping`, `base`) or of the upper and the lower link and
/// their joints.
///
/// Parameters
/// ----------
/// **keys
///     The keys of the section `[arm1]` of a study file; keys that are left out have their defaults.
///
/// Raises
/// ------
/// InvalidInput
///     If a key or a value is refused.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> arm = ts.Arm(kind="lumped", mass=0.8)
/// >>> arm.mass, arm.damping, arm.link_length is None
/// ((0.8, 0.8), (0.0, 0.0), True)
/// >>> ts.Study.paper().replace(arm1=arm).experiment.arms[0] == arm
/// True
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Arm(pub rig::Arm);

type Pair = (f64, f64);

#[pymethods]
impl Arm {
    #[new]
    #[pyo3(signature = (**keys))]
    fn new(keys: Option<&Bound<'_, PyDict>>) -> Outcome<Self> {
        Ok(Self(rig::Arm::from_table(&keywords("arm", keys)?)?))
    }

    /// "massless", "lumped" or "two-link".
    #[getter]
    fn kind(&self) -> &'static str {
        match self.0 {
            rig::Arm::TwoLink(_) => "two-link",
            rig::Arm::Lumped { .. } if self.lumped().is_some() => "lumped",
            rig::Arm::Lumped { .. } => "massless",
        }
    }

    /// Mass of a lumped arm per axis, kg.
    #[getter]
    fn mass(&self) -> Option<Pair> {
        self.lumped().map(|(mass, _)| mass.into())
    }

    /// Viscous damping of a lumped arm per axis, N·s/m.
    #[getter]
    fn damping(&self) -> Option<Pair> {
        self.lumped().map(|(_, damping)| damping.into())
    }

    /// Place of the arm's shoulder, m, in the coordinates of the task.
    #[getter]
    fn base(&self) -> Option<Pair> {
        self.links().map(|arm| arm.base.into())
    }

    /// The side to which the elbow bends, seen from the shoulder: "left" or "right".
    #[getter]
    fn elbow(&self) -> Option<&'static str> {
        self.links().map(|arm| if arm.elbow == Elbow::Left { "left" } else { "right" })
    }

    /// Lengths of the arm's links, m.
    #[getter]
    fn link_length(&self) -> Option<Pair> {
        self.links().map(|arm| arm.link_length.into())
    }

    /// Masses of the arm's links, kg.
    #[getter]
    fn link_mass(&self) -> Option<Pair> {
        self.links().map(|arm| arm.link_mass.into())
    }

    /// Distance of each link's centre of mass from its joint, m.
    #[getter]
    fn link_centre(&self) -> Option<Pair> {
        self.links().map(|arm| arm.link_centre.into())
    }

    /// Moment of inertia of each link about its centre of mass, kg·m².
    #[getter]
    fn link_inertia(&self) -> Option<Pair> {
        self.links().map(|arm| arm.link_inertia.into())
    }

    /// Viscous damping of the arm's joints, N·m·s/rad.
    #[getter]
    fn joint_damping(&self) -> Option<Pair> {
        self.links().map(|arm| arm.joint_damping.into())
    }

    /// Inertia of each actuator, reflected to its joint, kg·m².
    #[getter]
    fn rotor_inertia(&self) -> Option<Pair> {
        self.links().map(|arm| arm.rotor_inertia.into())
    }

    /// Largest torque of each actuator, N·m; infinite without a limit.
    #[getter]
    fn torque_limit(&self) -> Option<Pair> {
        self.links().map(|arm| arm.torque_limit.into())
    }

    /// The keys of the study file's section with their values, defaults filled in; pairs as lists.
    ///
    /// Returns
    /// -------
    /// dict
    pub fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = with_kind(py, self.kind())?;
        if let Some((mass, damping)) = self.lumped() {
            dict.set_item("mass", mass.to_vec())?;
            dict.set_item("damping", damping.to_vec())?;
        }
        if let Some(arm) = self.links() {
            dict.set_item("elbow", self.elbow())?;
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
        }
        Ok(dict)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        deprecated_item("Arm", &self.to_dict(py)?, key)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        written_out("Arm", &self.to_dict(py)?)
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.to_dict(py)?.as_any())
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((), Bound<'py, PyDict>)> {
        Ok(((), self.to_dict(py)?))
    }
}

impl Arm {
    /// Mass and damping of a lumped arm; none of a massless one.
    fn lumped(&self) -> Option<([f64; 2], [f64; 2])> {
        match self.0 {
            rig::Arm::Lumped { mass, damping } if mass != [0.0; 2] || damping != [0.0; 2] => {
                Some((mass, damping))
            }
            _ => None,
        }
    }

    /// The links of a two-link arm; none of another.
    fn links(&self) -> Option<&TwoLinkArm> {
        match &self.0 {
            rig::Arm::TwoLink(arm) => Some(arm),
            rig::Arm::Lumped { .. } => None,
        }
    }
}

/// The task of a rehearsal: the target that both agents follow. `Experiment.task` returns it.
///
/// Parameters
/// ----------
/// **keys
///     The keys of the section `[task]` of a study file; keys that are left out have their defaults.
///
/// Raises
/// ------
/// InvalidInput
///     If a key or a value is refused.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> ts.Study.paper().experiment.task
/// Task(kind='figure-eight', amplitude=[0.05, 0.1], angular_frequency=2.59)
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Task(pub study::Task);

#[pymethods]
impl Task {
    #[new]
    #[pyo3(signature = (**keys))]
    fn new(keys: Option<&Bound<'_, PyDict>>) -> Outcome<Self> {
        Ok(Self(study::Task::from_table(&keywords("task", keys)?)?))
    }

    /// "figure-eight" or "python".
    #[getter]
    fn kind(&self) -> &'static str {
        match self.0 {
            study::Task::FigureEight { .. } => "figure-eight",
            study::Task::Python(_) => "python",
        }
    }

    /// Amplitudes A and B of the figure eight along x and y, m.
    #[getter]
    fn amplitude(&self) -> Option<Pair> {
        match self.0 {
            study::Task::FigureEight { amplitude, .. } => Some(amplitude.into()),
            study::Task::Python(_) => None,
        }
    }

    /// Angular frequency ω of the figure eight, rad/s.
    #[getter]
    fn angular_frequency(&self) -> Option<f64> {
        match self.0 {
            study::Task::FigureEight { angular_frequency, .. } => Some(angular_frequency),
            study::Task::Python(_) => None,
        }
    }

    /// The function of a task's target written in Python, as "module:name".
    #[getter]
    fn function(&self) -> Option<&str> {
        match &self.0 {
            study::Task::Python(object) => Some(&object.path),
            study::Task::FigureEight { .. } => None,
        }
    }

    /// The options of a task's target written in Python.
    #[getter]
    fn options<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        match &self.0 {
            study::Task::Python(object) => options(py, object).map(Some),
            study::Task::FigureEight { .. } => Ok(None),
        }
    }

    /// Positions of the target of a figure eight, Eq. 12: (A sin 2ωt, B sin ωt).
    ///
    /// Parameters
    /// ----------
    /// times : (n,) array_like of float
    ///     Times since the start of the trial, s.
    ///
    /// Returns
    /// -------
    /// ndarray, (n, 2)
    ///     Positions along x and y, m.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If the target is written in Python: only its function knows the positions.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np
    /// >>> import telespring as ts
    /// >>> ts.Task(angular_frequency=np.pi).positions([0.0, 0.25]).round(4).tolist()
    /// [[0.0, 0.0], [0.05, 0.0707]]
    fn positions<'py>(
        &self,
        py: Python<'py>,
        times: Argument<Vec<f64>>,
    ) -> Outcome<Bound<'py, PyArray2<f64>>> {
        let times = times.named("times")?;
        let study::Task::FigureEight { amplitude, angular_frequency } = self.0 else {
            return Err(InvalidInput::new(
                "task.kind",
                "python",
                "only a figure eight has positions without its Python function",
                "Use the positions that the function returns.",
            )
            .into());
        };
        let positions = figure_eight_positions(amplitude, angular_frequency, &times);
        Ok(positions.into_flattened().into_pyarray(py).reshape([times.len(), 2])?)
    }

    /// The keys of the study file's section with their values, defaults filled in; pairs as lists.
    ///
    /// Returns
    /// -------
    /// dict
    pub fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = with_kind(py, self.kind())?;
        match &self.0 {
            study::Task::FigureEight { amplitude, angular_frequency } => {
                dict.set_item("amplitude", amplitude.to_vec())?;
                dict.set_item("angular_frequency", angular_frequency)?;
            }
            study::Task::Python(object) => set_program(&dict, "function", object)?,
        }
        Ok(dict)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        deprecated_item("Task", &self.to_dict(py)?, key)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        written_out("Task", &self.to_dict(py)?)
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.to_dict(py)?.as_any())
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((), Bound<'py, PyDict>)> {
        Ok(((), self.to_dict(py)?))
    }
}

/// The keywords of an agent, arm, task or adversary as a table of a study file.
pub fn keywords(name: &str, keys: Option<&Bound<'_, PyDict>>) -> Outcome<Table> {
    keys.map_or_else(|| Ok(Table::new()), |keys| to_table(name, keys.as_mapping()))
}

/// A dict for an agent, arm, task or adversary that begins with its kind.
pub fn with_kind<'py>(py: Python<'py>, kind: &str) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("kind", kind)?;
    Ok(dict)
}

/// Sets the Python object of an agent or a task in its dict.
fn set_program(dict: &Bound<'_, PyDict>, key: &str, object: &PythonObject) -> PyResult<()> {
    dict.set_item(key, &object.path)?;
    dict.set_item("options", options(dict.py(), object)?)
}

/// The options of an agent or a task written in Python as a dict.
fn options<'py>(py: Python<'py>, object: &PythonObject) -> PyResult<Bound<'py, PyDict>> {
    let options = PyDict::new(py);
    for (name, value) in &object.options {
        options.set_item(name, option(py, value)?)?;
    }
    Ok(options)
}

/// The value of a key in brackets, as agents, arms and tasks had when they were dicts; it warns.
fn deprecated_item<'py>(class: &str, dict: &Bound<'py, PyDict>, key: &str) -> PyResult<Bound<'py, PyAny>> {
    let value = dict.get_item(key)?.ok_or_else(|| PyKeyError::new_err(key.to_owned()))?;
    let attribute = if key == "class" { "class_" } else { key };
    let message = format!(
        "{class}[{key:?}] is now {class}.{attribute}; access by key will be removed in the next release."
    );
    let category = dict.py().get_type::<PyDeprecationWarning>();
    PyErr::warn(dict.py(), &category, &CString::new(message)?, 1)?;
    Ok(value)
}

/// An agent, arm or task as its constructor's call is written.
pub fn written_out(class: &str, dict: &Bound<'_, PyDict>) -> PyResult<String> {
    let keys = dict.iter().map(|(key, value)| Ok(format!("{key}={}", value.repr()?)));
    Ok(format!("{class}({})", keys.collect::<PyResult<Vec<_>>>()?.join(", ")))
}
