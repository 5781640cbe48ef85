//! What is recorded of trials: one trial, or many of the same length.

use numpy::{PyArray1, PyArray2, PyArray3, PyArray4};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The signals of one trial at its recorded instants, and how it ended.
///
/// Row j is at tick j/record_rate; all arrays end where the trial ended. Signals of both robots have the
/// shape (n, 2 robots, 2 axes). `Laboratory.run` returns it.
#[pyclass(frozen, get_all, module = "telespring._core")]
#[derive(Debug)]
pub struct Recording {
    /// Time since the start of the trial, s, (n,).
    pub time: Py<PyArray1<f64>>,
    /// Position of the target, m, (n, 2).
    pub target: Py<PyArray2<f64>>,
    /// Positions of the handles, m.
    pub position: Py<PyArray3<f64>>,
    /// Velocities of the handles, m/s.
    pub velocity: Py<PyArray3<f64>>,
    /// Force of each robot on its handle, from this instant on, N.
    pub coupling_force: Py<PyArray3<f64>>,
    /// Force that each agent commands its arm, from this instant on, N.
    pub agent_force: Py<PyArray3<f64>>,
    /// Force of each arm on its handle, from this instant on, N.
    pub handle_force: Py<PyArray3<f64>>,
    /// Where each agent takes the target to be, m.
    pub aim: Py<PyArray3<f64>>,
    /// "completed", "diverged" (a handle went beyond 10 m), "out of reach" (of a two-link arm) or "too stiff"
    /// (time constants of a robot in a two-link arm too short to integrate).
    pub status: &'static str,
    /// Time of the first tick that is left out, s; None where the trial was completed.
    pub ended_at: Option<f64>,
}

#[pymethods]
impl Recording {
    /// The attributes by their names.
    ///
    /// Returns
    /// -------
    /// dict
    fn to_dict<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        attributes(
            slf.as_any(),
            &[
                "time",
                "target",
                "position",
                "velocity",
                "coupling_force",
                "agent_force",
                "handle_force",
                "aim",
                "status",
                "ended_at",
            ],
        )
    }

    fn __getitem__<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        attribute(slf.as_any(), name)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("<Recording of {} instants, {}>", self.time.bind(py).len()?, self.status))
    }
}

/// The signals of many trials of the same length.
///
/// As `Recording`, with the trial as the first dimension of all signals; NaN after an early end.
/// `Laboratory.run_many` returns it.
#[pyclass(frozen, get_all, module = "telespring._core")]
#[derive(Debug)]
pub struct Recordings {
    /// Time since the start of a trial, s, (n,).
    pub time: Py<PyArray1<f64>>,
    /// Position of the target, m, (trials, n, 2).
    pub target: Py<PyArray3<f64>>,
    /// Positions of the handles, m, (trials, n, 2, 2).
    pub position: Py<PyArray4<f64>>,
    /// Velocities of the handles, m/s.
    pub velocity: Py<PyArray4<f64>>,
    /// Force of each robot on its handle, from this instant on, N.
    pub coupling_force: Py<PyArray4<f64>>,
    /// Force that each agent commands its arm, from this instant on, N.
    pub agent_force: Py<PyArray4<f64>>,
    /// Force of each arm on its handle, from this instant on, N.
    pub handle_force: Py<PyArray4<f64>>,
    /// Where each agent takes the target to be, m.
    pub aim: Py<PyArray4<f64>>,
    /// How each trial ended, as in `Recording`.
    pub status: Vec<&'static str>,
    /// Time of the first tick that is left out, s, (trials,); NaN where a trial was completed.
    pub ended_at: Py<PyArray1<f64>>,
}

#[pymethods]
impl Recordings {
    /// The attributes by their names.
    ///
    /// Returns
    /// -------
    /// dict
    fn to_dict<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        attributes(
            slf.as_any(),
            &[
                "time",
                "target",
                "position",
                "velocity",
                "coupling_force",
                "agent_force",
                "handle_force",
                "aim",
                "status",
                "ended_at",
            ],
        )
    }

    fn __getitem__<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        attribute(slf.as_any(), name)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!(
            "<Recordings of {} trials, {} instants each>",
            self.status.len(),
            self.time.bind(py).len()?
        ))
    }
}

/// The motion of one handle in an arm under given forces. `simulate_handle` returns it.
///
/// Row j is at j sample periods; the arrays end where the motion ended.
#[pyclass(frozen, get_all, module = "telespring._core")]
#[derive(Debug)]
pub struct HandleMotion {
    /// Position, m, (n, 2).
    pub position: Py<PyArray2<f64>>,
    /// Velocity, m/s, (n, 2).
    pub velocity: Py<PyArray2<f64>>,
    /// Force of the arm on the handle, N, (n, 2).
    pub handle_force: Py<PyArray2<f64>>,
    /// Torques of the joints, N·m; None for an arm without joints.
    pub torque: Option<Py<PyArray2<f64>>>,
    /// "completed", "out of reach" or "too stiff", as in `Recording`.
    pub status: &'static str,
    /// Time of the last row, s, where the motion ended early; None where it was completed.
    pub ended_at: Option<f64>,
}

#[pymethods]
impl HandleMotion {
    /// The attributes by their names.
    ///
    /// Returns
    /// -------
    /// dict
    fn to_dict<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let names = ["position", "velocity", "handle_force", "torque", "status", "ended_at"];
        attributes(slf.as_any(), &names)
    }

    fn __getitem__<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        attribute(slf.as_any(), name)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("<HandleMotion of {} instants, {}>", self.position.bind(py).len()?, self.status))
    }
}

fn attributes<'py>(object: &Bound<'py, PyAny>, names: &[&str]) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(object.py());
    for name in names {
        dict.set_item(name, object.getattr(name)?)?;
    }
    Ok(dict)
}

/// An attribute by its name in brackets.
fn attribute<'py>(object: &Bound<'py, PyAny>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    object.getattr(name).map_err(|_| PyKeyError::new_err(name.to_owned()))
}
