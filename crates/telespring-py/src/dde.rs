//! The adaptive solver with right-hand sides, delays and histories written in Python.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use telespring::InvalidInput;
use telespring::dde::adaptive::{DelayKind, Discontinuity, Options, Solution, Status, Tolerance, solve};

use crate::errors::{Failure, Outcome};
use crate::model::PerAxis;

/// A delay as Python gives it: a number, or a function with how many arguments it takes.
#[derive(FromPyObject)]
pub enum DelayValue {
    /// Constant, s.
    Constant(f64),
    /// τ(t), or τ(t, y) where the flag is set.
    Function(Py<PyAny>, bool),
}

/// Tolerances and limits as Python gives them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct OptionValues {
    rtol: PerAxis,
    atol: PerAxis,
    max_steps: usize,
    initial_step: Option<f64>,
    max_step: Option<f64>,
    breakpoints: Vec<(f64, u32)>,
}

impl From<PerAxis> for Tolerance {
    fn from(value: PerAxis) -> Self {
        match value {
            PerAxis::All(value) => Self::Uniform(value),
            PerAxis::Each(values) => Self::PerComponent(values),
        }
    }
}

impl From<OptionValues> for Options {
    fn from(values: OptionValues) -> Self {
        Self {
            rtol: values.rtol.into(),
            atol: values.atol.into(),
            max_steps: values.max_steps,
            initial_step: values.initial_step,
            max_step: values.max_step,
            breakpoints: values
                .breakpoints
                .into_iter()
                .map(|(time, order)| Discontinuity { time, order })
                .collect(),
        }
    }
}

/// Copies what the user's function returned into `out`.
fn read_into(returned: &Bound<'_, PyAny>, field: &str, out: &mut [f64]) -> PyResult<()> {
    if let Ok(array) = returned.extract::<PyReadonlyArray1<'_, f64>>()
        && let Ok(values) = array.as_slice()
        && values.len() == out.len()
    {
        out.copy_from_slice(values);
        return Ok(());
    }
    let values = match returned.extract::<f64>() {
        Ok(value) => vec![value],
        Err(_) => returned.extract::<Vec<f64>>()?,
    };
    if values.len() != out.len() {
        let refusal = InvalidInput::new(
            field,
            format!("{} value(s)", values.len()),
            format!("one number per component is needed, that is {}", out.len()),
            "Return a sequence or a one-dimensional array of that length.",
        );
        return Err(Failure::from(refusal).into());
    }
    out.copy_from_slice(&values);
    Ok(())
}

fn kind<'a>(delay: DelayValue) -> DelayKind<'a, PyErr> {
    match delay {
        DelayValue::Constant(delay) => DelayKind::Constant(delay),
        DelayValue::Function(function, true) => DelayKind::State(Box::new(move |t, y: &[f64]| {
            Python::attach(|py| function.call1(py, (t, PyArray1::from_slice(py, y)))?.extract(py))
        })),
        DelayValue::Function(function, false) => {
            DelayKind::Time(Box::new(move |t| Python::attach(|py| function.call1(py, (t,))?.extract(py))))
        }
    }
}

/// A solution that can be asked for its value at any time within its span.
#[pyclass(frozen, module = "telespring._core")]
pub struct DdeSolution(Solution<PyErr>);

/// Solves y' = rhs(t, y, delayed) over `span`; what the user's functions raise comes out as it is.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the Python function beside it names them")]
pub fn solve_dde(
    py: Python<'_>,
    rhs: Py<PyAny>,
    delays: Vec<DelayValue>,
    history: Py<PyAny>,
    dimension: usize,
    initial: Option<Vec<f64>>,
    span: (f64, f64),
    options: OptionValues,
) -> Outcome<DdeSolution> {
    let options = Options::from(options);
    let rows = delays.len();
    let mut solution = py.detach(|| {
        let slope = |t: f64, y: &[f64], delayed: telespring::dde::adaptive::Delayed<'_>, out: &mut [f64]| {
            Python::attach(|py| {
                let delayed = PyArray1::from_slice(py, delayed.as_slice()).reshape([rows, dimension])?;
                let returned = rhs.bind(py).call1((t, PyArray1::from_slice(py, y), delayed))?;
                read_into(&returned, "rhs(t, y, delayed)", out)
            })
        };
        let past = |t: f64, out: &mut [f64]| {
            Python::attach(|py| read_into(&history.bind(py).call1((t,))?, "history(t)", out))
        };
        let delays = delays.into_iter().map(kind).collect();
        solve(slope, delays, past, dimension, initial.as_deref(), span, &options)
    })?;
    match solution.failure.take() {
        Some(raised) => Err(raised.into()),
        None => Ok(DdeSolution(solution)),
    }
}

#[pymethods]
impl DdeSolution {
    /// How the computation ended, in one word and in a sentence.
    #[getter]
    fn status(&self) -> (&'static str, String) {
        let word = match self.0.status {
            Status::Completed => "completed",
            Status::StepTooSmall { .. } => "step too small",
            Status::TooManySteps { .. } => "too many steps",
            Status::NonFinite { .. } => "not finite",
            Status::InvalidDelay { .. } => "invalid delay",
            _ => "stopped",
        };
        (word, self.0.status.to_string())
    }

    /// Steps kept, steps thrown away, calls of the right-hand side.
    #[getter]
    fn work(&self) -> (usize, usize, usize) {
        (self.0.steps, self.0.rejected, self.0.evaluations)
    }

    /// Times at which steps start and end.
    #[getter]
    fn knots<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.0.knots())
    }

    /// Break points as (time, order).
    #[getter]
    fn discontinuities(&self) -> Vec<(f64, u32)> {
        self.0.discontinuities.iter().map(|found| (found.time, found.order)).collect()
    }

    /// Values at many times, a row each.
    fn sample<'py>(
        &self,
        py: Python<'py>,
        times: PyReadonlyArray1<'py, f64>,
    ) -> Outcome<Bound<'py, PyArray2<f64>>> {
        let times = times.as_array().to_vec();
        let values = py.detach(|| self.0.sample(&times))?;
        Ok(values.into_pyarray(py).reshape([times.len(), self.0.dimension()])?)
    }

    /// Derivatives at many times, a row each.
    fn derivative<'py>(
        &self,
        py: Python<'py>,
        times: PyReadonlyArray1<'py, f64>,
    ) -> Outcome<Bound<'py, PyArray2<f64>>> {
        let times = times.as_array().to_vec();
        let dimension = self.0.dimension();
        let values = py.detach(|| -> telespring::Result<_> {
            let mut values = vec![0.0; times.len() * dimension];
            for (&t, row) in times.iter().zip(values.chunks_exact_mut(dimension)) {
                self.0.derivative(t, row)?;
            }
            Ok(values)
        })?;
        Ok(values.into_pyarray(py).reshape([times.len(), dimension])?)
    }
}
