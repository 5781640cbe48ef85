//! Transfer matrix, Nyquist locus, magnitude and phase of one axis.

use num_complex::Complex64;
use numpy::{IntoPyArray, Ix1, Ix3, PyArray3, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use std::convert::Infallible;
use telespring::response::{self, Convention, GridStatus, Margin, NyquistStatus};
use telespring::{Delay, DyadAxis, InvalidInput};

use crate::arguments::{Argument, AxisChoice, DelayChoice, Number, written};
use crate::errors::Outcome;
use crate::interrupt::apart;
use crate::model::Dyad;
use crate::records::{Array, record};

type Matrices<'py> = Bound<'py, PyArray3<Complex64>>;

/// The convention for the diagonal, by its name.
pub struct ConventionName(Argument<String>);

impl FromPyObject<'_, '_> for ConventionName {
    type Error = Infallible;

    fn extract(value: Borrowed<'_, '_, PyAny>) -> Result<Self, Infallible> {
        Argument::extract(value).map(Self)
    }
}

impl ConventionName {
    /// The convention of a frequency response by its Python name, checked.
    fn check(&self) -> telespring::Result<Convention> {
        match &self.0 {
            Argument::Given(name) if name == "exact" => Ok(Convention::Exact),
            Argument::Given(name) if name == "paper" => Ok(Convention::Paper),
            Argument::Given(text) | Argument::Other(text) => Err(InvalidInput::new(
                "convention",
                text,
                "the conventions are \"exact\" and \"paper\"",
                "Omit it for \"exact\".",
            )),
        }
    }
}

/// One axis of a dyad with its spring (N/m) and its delays: the arguments common to all functions here.
#[derive(FromPyObject)]
pub struct Loop<'py> {
    #[pyo3(item(0))]
    dyad: Bound<'py, PyAny>,
    #[pyo3(item(1))]
    stiffness: Number,
    #[pyo3(item(2))]
    delay: DelayChoice,
    #[pyo3(item(3))]
    axis: AxisChoice,
}

impl Loop<'_> {
    /// The loop of a frequency response, checked: axis, stiffness and delay.
    fn check(self) -> Outcome<(DyadAxis, f64, Delay)> {
        // one of its axes would be a natural mistake: the criteria take it
        let Ok(dyad) = self.dyad.cast::<Dyad>() else {
            let remedy = "Pass the dyad, and the name of the axis as `axis`.";
            return Err(InvalidInput::new("dyad", written(&self.dyad), "a Dyad is required", remedy).into());
        };
        let axis = self.axis.of(&dyad.get().0)?;
        Ok((axis, self.stiffness.named("stiffness")?, self.delay.check()?))
    }
}

/// Matrices of a frequency response as one array.
fn blocks<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<[[T; 2]; 2]>,
) -> PyResult<Bound<'py, PyArray3<T>>> {
    let shape = [values.len(), 2, 2];
    values.into_flattened().into_flattened().into_pyarray(py).reshape(shape)
}

/// Evaluates a transfer or mobility matrix at each complex s, 1/s.
fn matrices<'py>(
    py: Python<'py>,
    of: Loop<'py>,
    s: &PyReadonlyArray1<'py, Complex64>,
    compute: impl Fn(&DyadAxis, f64, &Delay, Complex64) -> telespring::Result<[[Complex64; 2]; 2]>
    + Send
    + 'static,
) -> Outcome<Matrices<'py>> {
    let (axis, stiffness, delay) = of.check()?;
    let points = s.as_array().to_vec();
    let found = apart(py, move || -> telespring::Result<Vec<_>> {
        let one = |(i, &s): (usize, &Complex64)| {
            compute(&axis, stiffness, &delay, s).map_err(|mut refusal| {
                if refusal.field == "s" && points.len() > 1 {
                    refusal.field = format!("s[{i}]");
                }
                refusal
            })
        };
        points.iter().enumerate().map(one).collect()
    })??;
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
    matrices(py, of, &s, move |axis, stiffness, delay, s| {
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

record! {
    /// The transfer matrix over frequency; index 0 is robot 1.
    FrequencyResponse {
        /// Angular frequencies as given, rad/s, (n,).
        frequency: Array<f64, Ix1>,
        /// value[i, output, input] is the position of a robot under the force on a robot, m/N, (n, 2, 2).
        value: Array<Complex64, Ix3>,
        /// Its magnitude, m/N, (n, 2, 2).
        magnitude: Array<f64, Ix3>,
        /// Its phase, rad, (n, 2, 2), continuous from ω → 0: from 0 there, or from -π/2 for free handles.
        phase: Array<f64, Ix3>,
        /// Frequencies, rad/s, up to the largest given one, at which a characteristic root lies on the
        /// imaginary axis within rounding; the phase falls by π there.
        poles_on_axis: Vec<f64>,
    }
}

record! {
    /// One response over frequency.
    ResponseCurve {
        /// Angular frequencies as given, rad/s, (n,).
        frequency: Array<f64, Ix1>,
        /// The response, without a unit, (n,).
        value: Array<Complex64, Ix1>,
        /// Its magnitude, (n,).
        magnitude: Array<f64, Ix1>,
        /// Its phase, rad, (n,), continuous from ω → 0.
        phase: Array<f64, Ix1>,
    }
}

record! {
    /// Frequencies so dense that no resonance falls between two of them.
    FrequencyGrid {
        /// Angular frequencies, rad/s, (n,), ascending, both ends included.
        frequency: Array<f64, Ix1>,
        /// "resolved", "poles on the axis" or "too many points": whether they meet the resolution everywhere,
        /// everywhere but at the poles, or only as far as the limit on their number allows.
        status: String,
        /// Frequencies, rad/s, of resonances without damping and of roots on the imaginary axis.
        poles_on_axis: Vec<f64>,
    }
}

record! {
    /// A margin or distance and where it is taken; unpacks as (value, frequency).
    FrequencyMargin(response::Margin) as tuple {
        /// Its value, in the unit of the attribute.
        value,
        /// The angular frequency, rad/s; inf for the limit ω → ∞.
        frequency,
    }
}

record! {
    /// The Nyquist locus of one axis, the number of unstable roots and the margins.
    ///
    /// A margin is None if no finite one exists or the dyad is not stable.
    Nyquist {
        /// Angular frequencies of the locus from 0 on, rad/s, (n,); fine enough that no turn is skipped.
        frequency: Array<f64, Ix1>,
        /// L(jω) at each; points where it is infinite (undamped sides) are omitted.
        locus: Array<Complex64, Ix1>,
        /// Net clockwise encirclements of -1 over -∞ < ω < ∞, the rigid-body root deflated.
        encirclements: i64,
        /// Characteristic roots in the open right half-plane.
        unstable_roots: usize,
        /// Whether both handles are free: L(0) = -1 for every stiffness and delay, the root s = 0.
        rigid_body: bool,
        /// Whether every root but the rigid-body one is proven to lie in the open left half-plane.
        stable: bool,
        /// Smallest local minimum of abs(L + 1) over ω > 0 and of its limit, 1 at ω = ∞.
        minimum_distance: Margin,
        /// Smallest factor above 1 on L that brings a root onto the imaginary axis.
        gain_margin: Option<Margin>,
        /// Largest factor below 1 on L that does.
        gain_reduction_margin: Option<Margin>,
        /// Smallest rotation of L, rad, either way, that does.
        phase_margin: Option<Margin>,
        /// Smallest addition to the mean one-way delay, s, that does.
        delay_margin: Option<Margin>,
        /// "counted", "on the axis" (the dyad is marginal within rounding) or "not counted".
        status: String,
        /// The lowest frequency, rad/s, of a root on the axis; it is not among the unstable ones.
        root_on_axis: Option<f64>,
        /// "resolved", "poles on the axis" or "too many points": whether the locus has its resolution; the
        /// count does not depend on it.
        locus_status: String,
        /// Frequencies, rad/s, at which it has not.
        locus_poles: Vec<f64>,
    }
}

/// The transfer matrix over angular frequencies.
#[pyfunction]
pub fn frequency_response<'py>(
    py: Python<'py>,
    of: Loop<'py>,
    frequency: PyReadonlyArray1<'py, f64>,
    convention: ConventionName,
) -> Outcome<FrequencyResponse> {
    let ((axis, stiffness, delay), convention) = (of.check()?, convention.check()?);
    let frequency = frequency.as_array().to_vec();
    let response =
        apart(py, move || response::frequency_response(&axis, stiffness, &delay, &frequency, convention))??;
    Ok(FrequencyResponse {
        frequency: response.frequency.into_pyarray(py).into(),
        value: blocks(py, response.value)?.into(),
        magnitude: blocks(py, response.magnitude)?.into(),
        phase: blocks(py, response.phase)?.into(),
        poles_on_axis: response.poles_on_axis,
    })
}

impl ResponseCurve {
    /// A response curve as Python reads it.
    fn of(py: Python<'_>, curve: response::ResponseCurve) -> Self {
        Self {
            frequency: curve.frequency.into_pyarray(py).into(),
            value: curve.value.into_pyarray(py).into(),
            magnitude: curve.magnitude.into_pyarray(py).into(),
            phase: curve.phase.into_pyarray(py).into(),
        }
    }
}

/// The open loop as a `ResponseCurve` over angular frequencies.
#[pyfunction]
pub fn open_loop<'py>(
    py: Python<'py>,
    of: Loop<'py>,
    frequency: PyReadonlyArray1<'py, f64>,
) -> Outcome<ResponseCurve> {
    let (axis, stiffness, delay) = of.check()?;
    let frequency = frequency.as_array().to_vec();
    let curve = apart(py, move || response::open_loop(&axis, stiffness, &delay, &frequency))??;
    Ok(ResponseCurve::of(py, curve))
}

/// How a robot follows its partner, as a `ResponseCurve` over angular frequencies.
#[pyfunction]
pub fn partner_response<'py>(
    py: Python<'py>,
    of: Loop<'py>,
    robot: Argument<usize>,
    frequency: PyReadonlyArray1<'py, f64>,
) -> Outcome<ResponseCurve> {
    let (axis, stiffness, delay) = of.check()?;
    let robot = robot.named("robot")?;
    let frequency = frequency.as_array().to_vec();
    let curve = apart(py, move || response::partner_response(&axis, stiffness, &delay, robot, &frequency))??;
    Ok(ResponseCurve::of(py, curve))
}

/// The status of a frequency grid as a word, and the poles on the axis.
fn grid_status(status: GridStatus) -> (String, Vec<f64>) {
    match status {
        GridStatus::Resolved => ("resolved".to_owned(), Vec::new()),
        GridStatus::PolesOnAxis(poles) => ("poles on the axis".to_owned(), poles),
        _ => ("too many points".to_owned(), Vec::new()),
    }
}

/// A grid of angular frequencies for a frequency response.
#[pyfunction]
pub fn frequency_grid(
    py: Python<'_>,
    of: Loop<'_>,
    low: Number,
    high: Number,
    resolution: Number,
    limit: Argument<usize>,
) -> Outcome<FrequencyGrid> {
    let (axis, stiffness, delay) = of.check()?;
    let (low, high) = (low.named("low")?, high.named("high")?);
    let (resolution, limit) = (resolution.named("resolution")?, limit.named("limit")?);
    let grid =
        apart(py, move || response::frequency_grid(&axis, stiffness, &delay, low, high, resolution, limit))??;
    let (status, poles_on_axis) = grid_status(grid.status);
    Ok(FrequencyGrid { frequency: grid.frequency.into_pyarray(py).into(), status, poles_on_axis })
}

/// The Nyquist locus of one axis of a Python dyad.
#[pyfunction]
pub fn nyquist(py: Python<'_>, of: Loop<'_>) -> Outcome<Nyquist> {
    let (axis, stiffness, delay) = of.check()?;
    let nyquist = apart(py, move || response::nyquist(&axis, stiffness, &delay))??;
    let stable = nyquist.is_stable();
    let (status, root_on_axis) = match nyquist.status {
        NyquistStatus::Counted => ("counted", None),
        NyquistStatus::OnTheAxis { frequency } => ("on the axis", Some(frequency)),
        _ => ("not counted", None),
    };
    let (locus_status, locus_poles) = grid_status(nyquist.locus_status);
    Ok(Nyquist {
        frequency: nyquist.frequency.into_pyarray(py).into(),
        locus: nyquist.locus.into_pyarray(py).into(),
        encirclements: nyquist.encirclements,
        unstable_roots: nyquist.unstable_roots,
        rigid_body: nyquist.rigid_body,
        stable,
        minimum_distance: nyquist.minimum_distance,
        gain_margin: nyquist.gain_margin,
        gain_reduction_margin: nyquist.gain_reduction_margin,
        phase_margin: nyquist.phase_margin,
        delay_margin: nyquist.delay_margin,
        status: status.to_owned(),
        root_on_axis,
        locus_status,
        locus_poles,
    })
}
