//! The stability criteria as Python functions, over numbers and arrays, a dyad or one of its axes.

use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use telespring::quantity::{DELAY, STIFFNESS};
use telespring::{InvalidInput, Result, criteria};

use crate::arrays::Numbers;
use crate::axis::{self, Crossing};
use crate::errors::Outcome;
use crate::interrupt::apart;
use crate::prediction::take_predictor;
use crate::subject::{bind, numbers, paper};

/// The first lines of every list of parameters here.
macro_rules! parameters {
    ($kind:literal) => {
        concat!(
            "\n\nParameters\n----------\nm1, b1, m2, b2 : ",
            $kind,
            "\n    Masses, kg, and viscous dampings, N·s/m, of robot and operator together. A `Dyad` or a\n    \
             `DyadAxis` as the first argument replaces these and kh1, kh2, c."
        )
    };
}

/// The last lines of every list of parameters here.
macro_rules! keywords {
    ($kind:literal) => {
        concat!(
            "\nkh1, kh2 : ",
            $kind,
            "\n    Stiffness of each operator to the ground, N/m.\nc : ",
            $kind,
            "\n    Damping in parallel with the virtual spring, N·s/m."
        )
    };
}

macro_rules! stiffness {
    ($kind:literal) => {
        concat!("\nk : ", $kind, "\n    Stiffness of the virtual spring, N/m.")
    };
}

macro_rules! delay {
    ($kind:literal) => {
        concat!("\ndelay : ", $kind, "\n    One-way delay, s; the mean if both ways differ.")
    };
}

/// The last parameter of criteria that cover predictors.
macro_rules! predictor {
    () => {
        "\npredictor : {\"hold\", \"linear\", \"kalman\", \"shared-target\"} or mapping\n    What stands between the \
         partner's delayed motion and the spring, with the same delay each way and continuous\n    controllers. \
         Settings of a Kalman filter: {\"kind\": \"kalman\", \"model\": \"constant-velocity\" or\n    \
         \"constant-acceleration\", \"process\": …, \"position\": …, \"sample_period\": 0.001}. A shared target \
         changes\n    no root. docs/prediction.md has the theory."
    };
}

macro_rules! raises {
    () => {
        "\n\nRaises\n------\nInvalidInput\n    Where a value is out of its range (the element is named) or \
         shapes do not broadcast.\n"
    };
}

macro_rules! raises_search {
    () => {
        "\n\nRaises\n------\nInvalidInput\n    Where a value is out of its range (the element is named), shapes do \
         not broadcast, or the values span so\n    many decades that the search for all crossings does not end.\n"
    };
}

macro_rules! reference {
    () => {
        "\nReferences\n----------\n.. [1] M. Du, S. R. Kulkarni, S. Kager, D. Campolo, \"Stability Criteria and \
         Motor Performance in\n   Delayed Haptic Dyadic Interactions Mediated by Robots\".\n"
    };
}

#[doc = concat!(
    "Stiffness below which no constant delay destabilises.",
    parameters!("array_like"),
    "\nmethod : {\"exact\", \"paper\"}\n    The exact value, or Eq. 5 of [1]_, which is necessary but not sufficient \
     and covers neither operators\n    nor a coupling damper.",
    keywords!("array_like"),
    "\n\nReturns\n-------\nfloat or ndarray\n    Critical stiffness k_m, N/m: the infimum of all stiffnesses that \
     some delay destabilises; inf if there\n    is none. For a dyad the smallest over its axes.",
    raises!(),
    reference!(),
)]
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> round(ts.critical_stiffness(0.8334, 7.7257, 0.7776, 7.4208), 6)
/// 35.615988
/// >>> round(ts.critical_stiffness(ts.hman()), 6)
/// 35.615988
/// >>> ts.critical_stiffness(1.0, 1.0, 1.0, 10.0, method="paper")
/// 25.25
/// >>> round(ts.critical_stiffness(1.0, 1.0, 1.0, 10.0), 6)
/// 9.461095
#[pyfunction]
#[pyo3(signature = (*args, **kwargs),
       text_signature = "(m1, b1, m2, b2, method='exact', *, kh1=0.0, kh2=0.0, c=0.0)")]
pub fn critical_stiffness<'py>(
    py: Python<'py>,
    args: &Bound<'py, PyTuple>,
    kwargs: Option<&Bound<'py, PyDict>>,
) -> Outcome<Bound<'py, PyAny>> {
    let (subject, [method]) = bind("critical_stiffness", args, kwargs, ["method"], 0)?;
    let paper = paper(method.as_ref())?;
    subject.evaluate(py, [], f64::min, |axis, []| axis::critical_stiffness(axis, paper))
}

#[doc = concat!(
    "Smallest constant one-way delay at which stability is lost.",
    parameters!("array_like"),
    stiffness!("array_like"),
    "\nmethod : {\"exact\", \"paper\"}\n    The exact value, or Eqs. 5 to 9 of [1]_.",
    keywords!("array_like"),
    predictor!(),
    "\n\nReturns\n-------\nfloat or ndarray\n    Maximum delay δ_m, s: every shorter delay above 0 is stable. \
     inf if no constant delay\n    destabilises, 0 where every short delay is unstable. For a dyad the smallest \
     over its axes.",
    raises!(),
    "\nSee Also\n--------\nstable_delays : stability can return at a longer delay.\n",
    reference!(),
)]
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> hman_x = (0.8334, 7.7257, 0.7776, 7.4208)
/// >>> round(ts.maximum_delay(*hman_x, 71.231976), 4)
/// 0.1672
/// >>> ts.maximum_delay(ts.hman(), [20.0, 30.0])
/// array([inf, inf])
#[pyfunction]
#[pyo3(signature = (*args, **kwargs),
       text_signature = "(m1, b1, m2, b2, k, method='exact', *, kh1=0.0, kh2=0.0, c=0.0, predictor='hold')")]
pub fn maximum_delay<'py>(
    py: Python<'py>,
    args: &Bound<'py, PyTuple>,
    kwargs: Option<&Bound<'py, PyDict>>,
) -> Outcome<Bound<'py, PyAny>> {
    let (predictor, kwargs) = take_predictor(kwargs)?;
    let (subject, [k, method]) = bind("maximum_delay", args, kwargs.as_ref(), ["k", "method"], 1)?;
    let paper = paper(method.as_ref())?;
    if paper && predictor.is_some() {
        return Err(InvalidInput::new(
            "method",
            "\"paper\"",
            "the paper has no predictor",
            "Leave out the method or the predictor.",
        )
        .into());
    }
    subject.evaluate(py, [numbers("k", k)?], f64::min, |axis, [k]| match &predictor {
        None => axis::maximum_delay(axis, k, paper),
        Some(prediction) => criteria::predicted_maximum_delay(axis, prediction, STIFFNESS.check("k", k)?),
    })
}

#[doc = concat!(
    "Stiffness below which every stiffness is stable at this delay.",
    parameters!("array_like"),
    delay!("array_like"),
    keywords!("array_like"),
    predictor!(),
    "\n\nReturns\n-------\nfloat or ndarray\n    sup{K : every 0 < k < K is stable at this delay}, N/m; inf at zero \
     delay. Some dyads are stable again at a\n    larger stiffness; that is not counted. For a dyad the smallest \
     over its axes.",
    raises_search!(),
)]
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> k = ts.maximum_stiffness(ts.hman(), 0.1)
/// >>> round(ts.maximum_delay(ts.hman(), k), 9)
/// 0.1
#[pyfunction]
#[pyo3(signature = (*args, **kwargs),
       text_signature = "(m1, b1, m2, b2, delay, *, kh1=0.0, kh2=0.0, c=0.0, predictor='hold')")]
pub fn maximum_stiffness<'py>(
    py: Python<'py>,
    args: &Bound<'py, PyTuple>,
    kwargs: Option<&Bound<'py, PyDict>>,
) -> Outcome<Bound<'py, PyAny>> {
    let (predictor, kwargs) = take_predictor(kwargs)?;
    let (subject, [delay]) = bind("maximum_stiffness", args, kwargs.as_ref(), ["delay"], 1)?;
    let others = [numbers("delay", delay)?];
    subject.evaluate(py, others, f64::min, |axis, [delay]| match &predictor {
        None => axis::maximum_stiffness(axis, delay),
        Some(prediction) => criteria::predicted_maximum_stiffness(axis, prediction, delay),
    })
}

#[doc = concat!(
    "Smallest damping, added equally to both robots, above which every larger one is stable.",
    parameters!("array_like"),
    stiffness!("array_like"),
    delay!("array_like"),
    keywords!("array_like"),
    "\n\nReturns\n-------\nfloat or ndarray\n    Damping to add to b1 and to b2, N·s/m; 0 if none needs to be \
     added. For a dyad the largest over its axes.",
    raises_search!(),
)]
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> added = ts.minimum_damping(0.8334, 7.7257, 0.7776, 7.4208, 142.0, 0.1)
/// >>> round(ts.maximum_delay(0.8334, 7.7257 + added, 0.7776, 7.4208 + added, 142.0), 9)
/// 0.1
#[pyfunction]
#[pyo3(signature = (*args, **kwargs),
       text_signature = "(m1, b1, m2, b2, k, delay, *, kh1=0.0, kh2=0.0, c=0.0)")]
pub fn minimum_damping<'py>(
    py: Python<'py>,
    args: &Bound<'py, PyTuple>,
    kwargs: Option<&Bound<'py, PyDict>>,
) -> Outcome<Bound<'py, PyAny>> {
    let (subject, [k, delay]) = bind("minimum_damping", args, kwargs, ["k", "delay"], 2)?;
    let others = [numbers("k", k)?, numbers("delay", delay)?];
    subject.evaluate(py, others, f64::max, |axis, [k, delay]| axis::minimum_damping(axis, k, delay))
}

#[doc = concat!(
    "Number of characteristic roots with positive real part, from the crossings.",
    parameters!("array_like"),
    stiffness!("array_like"),
    delay!("array_like"),
    keywords!("array_like"),
    predictor!(),
    "\n\nReturns\n-------\nint or ndarray of int\n    The number, without the rigid-body root s = 0 and without roots on \
     the imaginary axis. For a dyad the sum\n    over its axes.",
    raises!(),
)]
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> ts.unstable_root_count(0.8334, 7.7257, 0.7776, 7.4208, 71.231976, [0.167, 0.168])
/// array([0, 2])
#[pyfunction]
#[pyo3(signature = (*args, **kwargs),
       text_signature = "(m1, b1, m2, b2, k, delay, *, kh1=0.0, kh2=0.0, c=0.0, predictor='hold')")]
pub fn unstable_root_count<'py>(
    py: Python<'py>,
    args: &Bound<'py, PyTuple>,
    kwargs: Option<&Bound<'py, PyDict>>,
) -> Outcome<Bound<'py, PyAny>> {
    let (predictor, kwargs) = take_predictor(kwargs)?;
    let (subject, [k, delay]) = bind("unstable_root_count", args, kwargs.as_ref(), ["k", "delay"], 2)?;
    let others = [numbers("k", k)?, numbers("delay", delay)?];
    let sum = |one: i64, other: i64| one + other;
    subject.evaluate(py, others, sum, |axis, [k, delay]| match &predictor {
        None => axis::unstable_root_count(axis, k, delay),
        Some(prediction) => {
            let k = STIFFNESS.check("k", k)?;
            Ok(criteria::predicted_unstable_root_count(axis, prediction, k, delay)?.into())
        }
    })
}

#[doc = concat!(
    "Whether an axis is stable, for every stiffness and every delay.",
    parameters!("float"),
    "\nk : array_like, (n,)\n    Stiffnesses of the virtual spring, N/m.",
    "\ndelay : array_like, (d,)\n    One-way delays, s.",
    keywords!("float"),
    predictor!(),
    "\n\nReturns\n-------\nndarray of bool, (n, d)\n    A row per stiffness, a column per delay. For a dyad whether all \
     its axes are stable.",
    "\n\nRaises\n------\nInvalidInput\n    Where a value is out of its range (the element is named) or `k` or `delay` \
     has two dimensions.\n",
)]
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> ts.stability_map(ts.hman(), [30.0, 71.2], [0.1, 0.2]).tolist()
/// [[True, True], [True, False]]
#[pyfunction]
#[pyo3(signature = (*args, **kwargs),
       text_signature = "(m1, b1, m2, b2, k, delay, *, kh1=0.0, kh2=0.0, c=0.0, predictor='hold')")]
pub fn stability_map<'py>(
    py: Python<'py>,
    args: &Bound<'py, PyTuple>,
    kwargs: Option<&Bound<'py, PyDict>>,
) -> Outcome<Bound<'py, PyAny>> {
    let (predictor, kwargs) = take_predictor(kwargs)?;
    let (subject, [k, delay]) = bind("stability_map", args, kwargs.as_ref(), ["k", "delay"], 2)?;
    let (k, delay) = (numbers("k", k)?, numbers("delay", delay)?);
    axis::stability_map(py, &subject.axes()?, &k, &delay, predictor.as_ref())
}

#[doc = concat!(
    "Every pair of roots that meets the imaginary axis at some delay.",
    parameters!("float"),
    stiffness!("float"),
    keywords!("float"),
    "\n\nReturns\n-------\nlist of Crossing\n    By frequency (rad/s), with delay (s) and direction; each recurs every \
     π/frequency seconds of one-way delay.\n    Empty if no constant delay destabilises.",
    "\n\nRaises\n------\nInvalidInput\n    Where a value is out of its range, or a dyad has several axes: choose one.\n",
)]
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> [first] = ts.crossings(ts.hman()["x"], 71.231976)
/// >>> round(first.delay, 4), first.direction
/// (0.1672, 1)
#[pyfunction]
#[pyo3(signature = (*args, **kwargs),
       text_signature = "(m1, b1, m2, b2, k, *, kh1=0.0, kh2=0.0, c=0.0)")]
pub fn crossings<'py>(
    py: Python<'py>,
    args: &Bound<'py, PyTuple>,
    kwargs: Option<&Bound<'py, PyDict>>,
) -> Outcome<Bound<'py, PyAny>> {
    let (subject, [k]) = bind("crossings", args, kwargs, ["k"], 1)?;
    let axes = subject.axes()?;
    let [axis] = axes[..] else {
        return Err(InvalidInput::new(
            "dyad",
            format!("a dyad of {} axes", axes.len()),
            "crossings belong to one axis",
            "Choose an axis: crossings(dyad.axis(0), k).",
        )
        .into());
    };
    let k = STIFFNESS.check("k", numbers("k", k)?.single()?)?;
    let crossings = apart(py, move || criteria::crossings(&axis, k))??;
    let crossings: Vec<_> = crossings.iter().copied().map(Crossing).collect();
    Ok(crossings.into_bound_py_any(py)?)
}

#[doc = concat!(
    "All constant one-way delays up to a horizon at which an axis is stable.",
    parameters!("float"),
    stiffness!("float"),
    "\nhorizon : float\n    The longest delay of interest, s; by default 100 s, the longest delay of any function here.",
    keywords!("float"),
    "\n\nReturns\n-------\nlist of (float, float)\n    Half-open intervals [start, end), s, ascending. For a dyad those in \
     which all its axes are stable.",
    "\n\nRaises\n------\nInvalidInput\n    Where a value is out of its range.\n",
)]
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> dyad = (0.97670822, 2.15372614, 0.30379312, 4.59594729)
/// >>> [(round(start, 4), round(end, 4)) for start, end in ts.stable_delays(*dyad, 9.174736188, 3.0)]
/// [(0.0, 0.8508), (1.7738, 2.1128)]
#[pyfunction]
#[pyo3(signature = (*args, **kwargs),
       text_signature = "(m1, b1, m2, b2, k, horizon=100.0, *, kh1=0.0, kh2=0.0, c=0.0)")]
pub fn stable_delays<'py>(
    py: Python<'py>,
    args: &Bound<'py, PyTuple>,
    kwargs: Option<&Bound<'py, PyDict>>,
) -> Outcome<Vec<(f64, f64)>> {
    let (subject, [k, horizon]) = bind("stable_delays", args, kwargs, ["k", "horizon"], 1)?;
    let axes = subject.axes()?;
    let (k, horizon) = (
        numbers("k", k)?.single()?,
        match horizon {
            Some(horizon) => Numbers::read("horizon", &horizon)?.single()?,
            None => DELAY.maximum(),
        },
    );
    STIFFNESS.check("k", k)?;
    in_all(py, axes, move |axis| criteria::stable_delays(axis, k, horizon))
}

#[doc = concat!(
    "Stiffnesses at which every motion but the common drift decays at a requested rate.",
    "\n\nBelow these ranges the motion decays too slowly, above them it oscillates too long.",
    parameters!("float"),
    delay!("float"),
    "\ndecay_rate : float\n    The rate σ, 1/s: all roots but s = 0 lie left of -σ.",
    keywords!("float"),
    "\n\nReturns\n-------\nlist of (float, float)\n    Ranges of stiffness, N/m, ascending; empty if no stiffness has this \
     decay rate. For a dyad those that\n    hold on all its axes.",
    "\n\nRaises\n------\nInvalidInput\n    Where a value is out of its range, delay times decay rate exceeds 5, a rate of 0 meets an undamped\n    \
     side, or the values span so many decades that the search does not end.\n",
)]
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> [(soft, stiff)] = ts.decay_stiffness(ts.hman(), 0.05, 1.0)
/// >>> 0.0 < soft < stiff
/// True
#[pyfunction]
#[pyo3(signature = (*args, **kwargs),
       text_signature = "(m1, b1, m2, b2, delay, decay_rate, *, kh1=0.0, kh2=0.0, c=0.0)")]
pub fn decay_stiffness<'py>(
    py: Python<'py>,
    args: &Bound<'py, PyTuple>,
    kwargs: Option<&Bound<'py, PyDict>>,
) -> Outcome<Vec<(f64, f64)>> {
    let (subject, [delay, rate]) = bind("decay_stiffness", args, kwargs, ["delay", "decay_rate"], 2)?;
    let axes = subject.axes()?;
    let (delay, rate) = (numbers("delay", delay)?.single()?, numbers("decay_rate", rate)?.single()?);
    DELAY.check("delay", delay)?;
    in_all(py, axes, move |axis| criteria::decay_stiffness(axis, delay, rate))
}

/// The intervals of a criterion that every axis has.
fn in_all(
    py: Python<'_>,
    axes: Vec<telespring::DyadAxis>,
    compute: impl Fn(&telespring::DyadAxis) -> Result<Vec<(f64, f64)>> + Send + 'static,
) -> Outcome<Vec<(f64, f64)>> {
    let common = apart(py, move || -> Result<_> {
        let mut common = vec![(0.0, f64::INFINITY)];
        for axis in &axes {
            common = criteria::intersection(&common, &compute(axis)?);
        }
        Ok(common)
    })??;
    Ok(common)
}
