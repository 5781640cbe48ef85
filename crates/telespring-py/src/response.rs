//! Transfer matrix, Nyquist locus, magnitude and phase of one axis.

use num_complex::Complex64;
use numpy::{IntoPyArray, PyArray1, PyArray3, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use telespring::response::{self, Convention, GridStatus, Margin, NyquistStatus, ResponseCurve};
use telespring::{Delay, DyadAxis, InvalidInput};

use crate::arguments::{AxisChoice, DelayChoice, Number};
use crate::errors::Outcome;
use crate::model::Dyad;

type Numbers<'py> = Bound<'py, PyArray1<f64>>;
type Matrices<'py> = Bound<'py, PyArray3<Complex64>>;

/// The diagonal by its name.
#[derive(FromPyObject)]
pub struct ConventionName(String);

impl ConventionName {
    fn check(&self) -> telespring::Result<Convention> {
        match self.0.as_str() {
            "exact" => Ok(Convention::Exact),
            "paper" => Ok(Convention::Paper),
            other => Err(InvalidInput::new(
                "convention",
                format!("{other:?}"),
                "the conventions are \"exact\" and \"paper\"",
                "Leave it away for \"exact\".",
            )),
        }
    }
}

/// What every function here starts from: one axis, its spring (N/m) and its delays.
#[derive(FromPyObject)]
pub struct Loop<'py> {
    #[pyo3(item(0))]
    dyad: Bound<'py, Dyad>,
    #[pyo3(item(1))]
    stiffness: Number,
    #[pyo3(item(2))]
    delay: DelayChoice,
    #[pyo3(item(3))]
    axis: AxisChoice,
}

impl Loop<'_> {
    fn check(self) -> Outcome<(DyadAxis, f64, Delay)> {
        let axis = self.axis.of(&self.dyad.get().0)?;
        Ok((axis, self.stiffness.named("stiffness")?, self.delay.check()?))
    }
}

fn blocks<'py, T: numpy::Element + Copy>(
    py: Python<'py>,
    values: Vec<[[T; 2]; 2]>,
) -> PyResult<Bound<'py, PyArray3<T>>> {
    let shape = [values.len(), 2, 2];
    values.into_iter().flatten().flatten().collect::<Vec<T>>().into_pyarray(py).reshape(shape)
}

/// Matrices at each complex s (1/s): of positions, m/N, or where `mobility`, of velocities.
fn matrices<'py>(
    py: Python<'py>,
    of: Loop<'py>,
    s: &PyReadonlyArray1<'py, Complex64>,
    compute: impl Fn(&DyadAxis, f64, &Delay, Complex64) -> telespring::Result<[[Complex64; 2]; 2]> + Sync,
) -> Outcome<Matrices<'py>> {
    let (axis, stiffness, delay) = of.check()?;
    let points = s.as_array().to_vec();
    let found = py.detach(|| -> telespring::Result<Vec<_>> {
        let one = |(i, &s): (usize, &Complex64)| {
            compute(&axis, stiffness, &delay, s).map_err(|mut refusal| {
                if refusal.field == "s" && points.len() > 1 {
                    refusal.field = format!("s[{i}]");
                }
                refusal
            })
        };
        points.iter().enumerate().map(one).collect()
    })?;
    Ok(blocks(py, found)?)
}

/// The transfer matrix at each s, m/N.
#[pyfunction]
pub fn transfer_matrix<'py>(
    py: Python<'py>,
    of: Loop<'py>,
    s: PyReadonlyArray1<'py, Complex64>,
    convention: ConventionName,
) -> Outcome<Matrices<'py>> {
    let convention = convention.check()?;
    matrices(py, of, &s, |axis, stiffness, delay, s| {
        response::transfer_matrix(axis, stiffness, delay, s, convention)
    })
}

/// The mobility matrix at each s, (m/s)/N.
#[pyfunction]
pub fn mobility_matrix<'py>(
    py: Python<'py>,
    of: Loop<'py>,
    s: PyReadonlyArray1<'py, Complex64>,
) -> Outcome<Matrices<'py>> {
    matrices(py, of, &s, response::mobility_matrix)
}

type Response<'py> =
    (Numbers<'py>, Matrices<'py>, Bound<'py, PyArray3<f64>>, Bound<'py, PyArray3<f64>>, Vec<f64>);

/// Frequency, matrix, magnitude, phase and the poles on the axis.
#[pyfunction]
pub fn frequency_response<'py>(
    py: Python<'py>,
    of: Loop<'py>,
    frequency: PyReadonlyArray1<'py, f64>,
    convention: ConventionName,
) -> Outcome<Response<'py>> {
    let ((axis, stiffness, delay), convention) = (of.check()?, convention.check()?);
    let frequency = frequency.as_array().to_vec();
    let found =
        py.detach(|| response::frequency_response(&axis, stiffness, &delay, &frequency, convention))?;
    Ok((
        found.frequency.into_pyarray(py),
        blocks(py, found.value)?,
        blocks(py, found.magnitude)?,
        blocks(py, found.phase)?,
        found.poles_on_axis,
    ))
}

type Curve<'py> = (Numbers<'py>, Bound<'py, PyArray1<Complex64>>, Numbers<'py>, Numbers<'py>);

fn curve(py: Python<'_>, found: ResponseCurve) -> Curve<'_> {
    (
        found.frequency.into_pyarray(py),
        found.value.into_pyarray(py),
        found.magnitude.into_pyarray(py),
        found.phase.into_pyarray(py),
    )
}

/// The open loop as (frequency, value, magnitude, phase).
#[pyfunction]
pub fn open_loop<'py>(
    py: Python<'py>,
    of: Loop<'py>,
    frequency: PyReadonlyArray1<'py, f64>,
) -> Outcome<Curve<'py>> {
    let (axis, stiffness, delay) = of.check()?;
    let frequency = frequency.as_array().to_vec();
    Ok(curve(py, py.detach(|| response::open_loop(&axis, stiffness, &delay, &frequency))?))
}

/// How a robot follows its partner, as (frequency, value, magnitude, phase).
#[pyfunction]
pub fn partner_response<'py>(
    py: Python<'py>,
    of: Loop<'py>,
    robot: usize,
    frequency: PyReadonlyArray1<'py, f64>,
) -> Outcome<Curve<'py>> {
    let (axis, stiffness, delay) = of.check()?;
    let frequency = frequency.as_array().to_vec();
    Ok(curve(py, py.detach(|| response::partner_response(&axis, stiffness, &delay, robot, &frequency))?))
}

/// How a grid ended, in words and with the poles it met.
fn words(status: GridStatus) -> (&'static str, Vec<f64>) {
    match status {
        GridStatus::Resolved => ("resolved", Vec::new()),
        GridStatus::PolesOnAxis(poles) => ("poles on the axis", poles),
        _ => ("too many points", Vec::new()),
    }
}

/// The grid as (frequency, status, poles on the axis).
#[pyfunction]
pub fn frequency_grid<'py>(
    py: Python<'py>,
    of: Loop<'py>,
    low: f64,
    high: f64,
    resolution: f64,
    limit: usize,
) -> Outcome<(Numbers<'py>, &'static str, Vec<f64>)> {
    let (axis, stiffness, delay) = of.check()?;
    let found =
        py.detach(|| response::frequency_grid(&axis, stiffness, &delay, low, high, resolution, limit))?;
    let (status, poles) = words(found.status);
    Ok((found.frequency.into_pyarray(py), status, poles))
}

/// Value and frequency of a margin.
type Pair = (f64, f64);

/// The Nyquist locus, what it counts and the margins.
#[derive(IntoPyObject)]
pub struct Nyquist<'py> {
    frequency: Numbers<'py>,
    locus: Bound<'py, PyArray1<Complex64>>,
    encirclements: i64,
    unstable_roots: usize,
    rigid_body: bool,
    stable: bool,
    minimum_distance: Pair,
    gain_margin: Option<Pair>,
    gain_reduction_margin: Option<Pair>,
    phase_margin: Option<Pair>,
    delay_margin: Option<Pair>,
    status: &'static str,
    root_on_axis: Option<f64>,
    locus_status: &'static str,
    locus_poles: Vec<f64>,
}

/// The Nyquist locus of one axis.
#[pyfunction]
pub fn nyquist<'py>(py: Python<'py>, of: Loop<'py>) -> Outcome<Nyquist<'py>> {
    let (axis, stiffness, delay) = of.check()?;
    let found = py.detach(|| response::nyquist(&axis, stiffness, &delay))?;
    let pair = |margin: Margin| (margin.value, margin.frequency);
    let stable = found.is_stable();
    let (status, root_on_axis) = match found.status {
        NyquistStatus::Counted => ("counted", None),
        NyquistStatus::OnTheAxis { frequency } => ("on the axis", Some(frequency)),
        _ => ("not counted", None),
    };
    let (locus_status, locus_poles) = words(found.locus_status);
    Ok(Nyquist {
        frequency: found.frequency.into_pyarray(py),
        locus: found.locus.into_pyarray(py),
        encirclements: found.encirclements,
        unstable_roots: found.unstable_roots,
        rigid_body: found.rigid_body,
        stable,
        minimum_distance: pair(found.minimum_distance),
        gain_margin: found.gain_margin.map(pair),
        gain_reduction_margin: found.gain_reduction_margin.map(pair),
        phase_margin: found.phase_margin.map(pair),
        delay_margin: found.delay_margin.map(pair),
        status,
        root_on_axis,
        locus_status,
        locus_poles,
    })
}
