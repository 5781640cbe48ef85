//! The adaptive solver with right-hand sides, delays and histories written in Python.

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use telespring::InvalidInput;
use telespring::dde::adaptive::{DelayKind, Discontinuity, Options, Solution, Status, Tolerance, solve};

use crate::arguments::PerAxis;
use crate::arrays::as_numbers;
use crate::errors::{Failure, Outcome};
use crate::interrupt::Watch;

/// A delay as Python passes it: a number, or a function and whether it takes the state.
#[derive(FromPyObject)]
pub enum DelayValue {
    /// Constant, s.
    Constant(f64),
    /// τ(t), or τ(t, y) where the flag is set.
    Function(Py<PyAny>, bool),
}

/// Tolerances and limits as Python passes them.
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
    /// The tolerance for `solve_dde`, from Python's number or array.
    fn from(value: PerAxis) -> Self {
        match value {
            PerAxis::All(value) => Self::Uniform(value),
            PerAxis::Each(values) => Self::PerComponent(values),
        }
    }
}

impl From<OptionValues> for Options {
    /// The options for `solve_dde`, from its Python arguments.
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

/// Copies the return value of the user's function in `solve_dde` into `out`.
fn read_into(returned: &Bound<'_, PyAny>, field: &str, out: &mut [f64]) -> PyResult<()> {
    // a subclass may mask values, which its numbers alone do not show
    if returned.is_exact_instance_of::<PyUntypedArray>()
        && let Ok(array) = returned.extract::<PyReadonlyArray1<'_, f64>>()
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
            format!("one number per component is required, that is {}", out.len()),
            "Return a sequence or a one-dimensional array of that length.",
        );
        return Err(Failure::from(refusal).into());
    }
    out.copy_from_slice(&values);
    Ok(())
}

/// The kind of a delay in `solve_dde`: a number or a function.
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

/// The solution of a delay differential equation as a continuous function of time.
///
/// Call it with a time or an array of times within `start` to `end`: the result has one component per last
/// index, so that ``solution(times)[:, 0]`` is the first component.
#[pyclass(frozen, module = "telespring")]
pub struct DelaySolution {
    solution: Solution<PyErr>,
    t: Py<PyArray1<f64>>,
    y: Py<PyArray2<f64>>,
}

/// Solves y' = rhs(t, y, delayed) over `span`; exceptions of the user's functions pass through unchanged.
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
) -> Outcome<DelaySolution> {
    let options = Options::from(options);
    let rows = delays.len();
    let mut solution = py.detach(|| {
        let mut watch = Watch::start();
        let slope = |t: f64, y: &[f64], delayed: telespring::dde::adaptive::Delayed<'_>, out: &mut [f64]| {
            Python::attach(|py| {
                watch.look_and_yield(py)?;
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
    if let Some(raised) = solution.failure.take() {
        return Err(raised.into());
    }
    DelaySolution::of(py, solution)
}

/// What a solution is pickled as: status, counts, break points, knots, coefficients and initial state.
type State<'py> = (
    (String, f64, usize, f64),
    [usize; 3],
    Vec<(f64, u32)>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
);

#[pymethods]
impl DelaySolution {
    /// "completed", "step too small", "too many steps", "not finite", "invalid delay" or "stopped". In every case
    /// the solution up to `end` can be read.
    #[getter]
    fn status(&self) -> &'static str {
        match self.solution.status {
            Status::Completed => "completed",
            Status::StepTooSmall { .. } => "step too small",
            Status::TooManySteps { .. } => "too many steps",
            Status::NonFinite { .. } => "not finite",
            Status::InvalidDelay { .. } => "invalid delay",
            _ => "stopped",
        }
    }

    /// The same as a sentence, with the time reached and what to try.
    #[getter]
    fn message(&self) -> String {
        self.solution.status.to_string()
    }

    /// The times between the steps of `solve_dde`.
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.t.bind(py).clone()
    }

    /// The solution at these times, a row each.
    #[getter]
    fn y<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.y.bind(py).clone()
    }

    /// Break points met: time, and the lowest derivative that may jump there.
    #[getter]
    fn discontinuities(&self) -> Vec<(f64, u32)> {
        self.solution.discontinuities.iter().map(|point| (point.time, point.order)).collect()
    }

    /// Steps that `solve_dde` kept.
    #[getter]
    fn steps(&self) -> usize {
        self.solution.steps
    }

    /// Steps that `solve_dde` rejected.
    #[getter]
    fn rejected(&self) -> usize {
        self.solution.rejected
    }

    /// Calls of the right-hand side by `solve_dde`.
    #[getter]
    fn evaluations(&self) -> usize {
        self.solution.evaluations
    }

    /// Whether `solve_dde` reached the end of the span.
    #[getter]
    fn completed(&self) -> bool {
        matches!(self.solution.status, Status::Completed)
    }

    /// The first time.
    #[getter]
    fn start(&self) -> f64 {
        self.solution.knots().first().copied().unwrap_or(f64::NAN)
    }

    /// The last time; that of the span where `completed`.
    #[getter]
    fn end(&self) -> f64 {
        self.solution.knots().last().copied().unwrap_or(f64::NAN)
    }

    /// y at one or many times, one component per last index.
    fn __call__<'py>(&self, times: &Bound<'py, PyAny>) -> Outcome<Bound<'py, PyAny>> {
        self.at(times, |times, values| {
            values.copy_from_slice(&self.solution.sample(times)?);
            Ok(())
        })
    }

    /// y' at one or many times, one order less accurate than y.
    fn derivative<'py>(&self, times: &Bound<'py, PyAny>) -> Outcome<Bound<'py, PyAny>> {
        self.at(times, |times, values| {
            times
                .iter()
                .zip(values.chunks_exact_mut(self.solution.dimension()))
                .try_for_each(|(&t, row)| self.solution.derivative(t, row))
        })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, State<'py>)> {
        let (at, delay, value) = match self.solution.status {
            Status::StepTooSmall { at } | Status::TooManySteps { at } | Status::NonFinite { at } => {
                (at, 0, 0.0)
            }
            Status::InvalidDelay { at, delay, value } => (at, delay, value),
            _ => (0.0, 0, 0.0),
        };
        let Solution { steps, rejected, evaluations, .. } = self.solution;
        let state = (
            (self.status().to_owned(), at, delay, value),
            [steps, rejected, evaluations],
            self.discontinuities(),
            self.t(py),
            PyArray1::from_slice(py, self.solution.coefficients()),
            PyArray1::from_slice(py, self.solution.initial()),
        );
        Ok((py.get_type::<Self>().getattr("_restore")?, state))
    }

    /// The solution that `__reduce__` took apart.
    #[staticmethod]
    fn _restore(
        py: Python<'_>,
        ended: (String, f64, usize, f64),
        counts: [usize; 3],
        discontinuities: Vec<(f64, u32)>,
        knots: PyReadonlyArray1<'_, f64>,
        coefficients: PyReadonlyArray1<'_, f64>,
        initial: PyReadonlyArray1<'_, f64>,
    ) -> Outcome<Self> {
        let (word, at, delay, value) = ended;
        let status = match word.as_str() {
            "completed" => Status::Completed,
            "step too small" => Status::StepTooSmall { at },
            "too many steps" => Status::TooManySteps { at },
            "not finite" => Status::NonFinite { at },
            _ => Status::InvalidDelay { at, delay, value },
        };
        let points = discontinuities.into_iter().map(|(time, order)| Discontinuity { time, order });
        let values = |array: PyReadonlyArray1<'_, f64>| array.as_array().to_vec();
        let (knots, coefficients, initial) = (values(knots), values(coefficients), values(initial));
        let solution = Solution::restore(status, counts, points.collect(), knots, coefficients, initial)?;
        Self::of(py, solution)
    }

    fn __repr__(&self) -> String {
        format!(
            "DelaySolution(status='{}', start={:?}, end={:?}, steps={})",
            self.status(),
            self.start(),
            self.end(),
            self.solution.steps
        )
    }
}

impl DelaySolution {
    /// The solution of the core as Python reads it.
    fn of(py: Python<'_>, solution: Solution<PyErr>) -> Outcome<Self> {
        let (t, dimension) = (solution.knots(), solution.dimension());
        let y = solution.sample(t)?.into_pyarray(py).reshape([t.len(), dimension])?.unbind();
        Ok(Self { t: PyArray1::from_slice(py, t).unbind(), y, solution })
    }

    /// One row of values per time, in the shape of the times.
    fn at<'py>(
        &self,
        times: &Bound<'py, PyAny>,
        evaluate: impl Fn(&[f64], &mut [f64]) -> telespring::Result<()> + Sync,
    ) -> Outcome<Bound<'py, PyAny>> {
        // evaluated between two looks for signals
        const CHUNK: usize = 1 << 14;
        let py = times.py();
        let times: PyReadonlyArrayDyn<'py, f64> = as_numbers("times", times)?.extract()?;
        let mut shape = times.shape().to_vec();
        let times: Vec<f64> = times.as_array().iter().copied().collect();
        let (dimension, known) = (self.solution.dimension(), self.solution.start()..=self.solution.end());
        shape.push(dimension);
        let values = py.detach(|| -> Outcome<_> {
            let mut values = vec![0.0; times.len() * dimension];
            let mut watch = Watch::start();
            for (part, (times, values)) in
                times.chunks(CHUNK).zip(values.chunks_mut(CHUNK * dimension)).enumerate()
            {
                watch.look()?;
                evaluate(times, values).map_err(|mut refusal| {
                    let first = times.iter().position(|time| !known.contains(time)).unwrap_or(0);
                    refusal.field = format!("times[{}]", part * CHUNK + first);
                    refusal
                })?;
            }
            Ok(values)
        })?;
        Ok(values.into_pyarray(py).reshape(shape)?.into_any())
    }
}
