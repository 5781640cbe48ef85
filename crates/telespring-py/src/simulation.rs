//! Exact linear simulation of all axes of a dyad, into one block of memory.

use numpy::{IntoPyArray, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use telespring::dde::linear::{
    Force, History, Hold, SampledForce, Simulation, Sine, Status, Workspace, output_count,
};
use telespring::{Delay, InvalidInput};

use crate::arguments::{Argument, DelayChoice, Number, Truth};
use crate::errors::Outcome;
use crate::interrupt::{Watch, apart};
use crate::model::Dyad;

/// One sine as Python passes it.
#[derive(FromPyObject)]
pub struct SineValue {
    amplitude: f64,
    angular_frequency: f64,
    phase: f64,
}

impl From<&SineValue> for Sine {
    /// A sine of a simulated force from Python's three numbers.
    fn from(value: &SineValue) -> Self {
        Self { amplitude: value.amplitude, angular_frequency: value.angular_frequency, phase: value.phase }
    }
}

/// A force as Python passes it; its fields tell which kind it is.
#[derive(FromPyObject)]
pub enum ForceValue {
    /// A constant, N.
    Step(f64),
    /// A sine.
    Sine(SineValue),
    /// The sum of several.
    Sines(Vec<SineValue>),
    /// A sampled signal.
    Sampled {
        /// Samples, N.
        values: Vec<f64>,
        /// Samples per second, Hz.
        rate: f64,
        /// "linear" or "zero".
        hold: String,
    },
    /// A function of time that jumps or bends at the breakpoints.
    Signal {
        /// f(t).
        function: Py<PyAny>,
        /// Times, s.
        breakpoints: Vec<f64>,
    },
    /// A smooth function of time.
    Function(Py<PyAny>),
}

/// A position before t = 0 as Python passes it.
#[derive(FromPyObject)]
pub enum HistoryValue {
    /// At rest there, m.
    Rest(f64),
    /// At rest there until it starts with a velocity, m and m/s.
    Launched(f64, f64),
    /// A function of time that jumps or bends at the breakpoints.
    Signal {
        /// x(t), t ≤ 0.
        function: Py<PyAny>,
        /// Times, s.
        breakpoints: Vec<f64>,
    },
    /// A smooth function of time.
    Function(Py<PyAny>),
}

/// Converts a Python function for a simulation; its exceptions pass through unchanged.
fn sampled_function<T>(
    py: Python<'_>,
    function: &Py<PyAny>,
    lower: impl FnOnce(&mut dyn FnMut(f64) -> f64) -> telespring::Result<T>,
) -> Outcome<T> {
    let (mut raised, mut watch) = (None, Watch::start());
    let lowered = lower(&mut |t| {
        if raised.is_some() {
            return f64::NAN;
        }
        let value = watch.look_and_yield(py).and_then(|()| function.call1(py, (t,))?.extract::<f64>(py));
        value.unwrap_or_else(|error| {
            raised = Some(error);
            f64::NAN
        })
    });
    match raised {
        Some(error) => Err(error.into()),
        None => Ok(lowered?),
    }
}

impl ForceValue {
    /// The force of the core for what Python passed to `simulate`.
    fn lower(&self, py: Python<'_>, duration: f64) -> Outcome<Force> {
        Ok(match self {
            Self::Step(value) => Force::Step(*value),
            Self::Sine(sine) => Force::Sines { constant: 0.0, sines: vec![sine.into()] },
            Self::Sines(sines) => {
                Force::Sines { constant: 0.0, sines: sines.iter().map(Sine::from).collect() }
            }
            Self::Sampled { values, rate, hold } => {
                Force::Sampled(SampledForce::new(values.clone(), *rate, hold_of(hold)?)?)
            }
            Self::Signal { function, breakpoints } => {
                sampled_function(py, function, |f| Force::from_function(f, breakpoints, duration))?
            }
            Self::Function(function) => {
                sampled_function(py, function, |f| Force::from_function(f, &[], duration))?
            }
        })
    }
}

/// The interpolation of a simulated force by its Python name.
fn hold_of(name: &str) -> telespring::Result<Hold> {
    match name {
        "linear" => Ok(Hold::Linear),
        "zero" => Ok(Hold::Zero),
        _ => Err(InvalidInput::new(
            "hold",
            format!("{name:?}"),
            "between samples a signal is \"linear\" or holds its value (\"zero\")",
            "Choose one of them.",
        )),
    }
}

impl HistoryValue {
    /// The history of the core for what Python passed to `simulate`.
    fn lower(&self, py: Python<'_>, delay: &Delay) -> Outcome<History> {
        // the partner needs one delay of history; without delay only value and slope at 0
        let span = delay.round_trip().max(1e-3);
        Ok(match self {
            Self::Rest(position) => History::rest(*position)?,
            Self::Launched(position, velocity) => History::rest(*position)?.with_velocity(*velocity)?,
            Self::Signal { function, breakpoints } => {
                sampled_function(py, function, |f| History::from_function(f, breakpoints, span))?
            }
            Self::Function(function) => {
                sampled_function(py, function, |f| History::from_function(f, &[], span))?
            }
        })
    }
}

/// The forms of a force and of a history in `simulate`.
const FORCES: &str = "a number, a Sine or a list of them, a Sampled, a Signal, or a function of time";
const PASTS: &str = "a number, a pair (position, velocity), a Signal, or a function of time";

/// Converts the values of both robots in `simulate`, axis by axis; a refusal names robot and axis.
fn lowered<V, T>(
    name: &str,
    axes: usize,
    values: Vec<Vec<Argument<V>>>,
    form: &str,
    lower: impl Fn(&V) -> Outcome<T>,
) -> Outcome<Vec<[T; 2]>> {
    let shape_is_right = values.len() == 2 && values.iter().all(|robot| robot.len() == axes);
    if !shape_is_right {
        let got: Vec<_> = values.iter().map(Vec::len).collect();
        return Err(InvalidInput::new(
            name,
            format!("lists of lengths {got:?}"),
            format!("two lists are required, one per robot, each with one entry per axis, that is {axes}"),
            "Write them as [[robot 1's axes], [robot 2's axes]].",
        )
        .into());
    }
    let one = |robot: usize, axis: usize| {
        let field = format!("{name}[{robot}][{axis}]");
        match &values[robot][axis] {
            Argument::Given(value) => lower(value).map_err(|failure| failure.within(&field)),
            Argument::Other(text) => {
                let remedy = "Write it in one of these forms.";
                Err(InvalidInput::new(field, text, format!("{form} is required"), remedy).into())
            }
        }
    };
    (0..axes).map(|axis| Ok([one(0, axis)?, one(1, axis)?])).collect()
}

type Block<'py> = Bound<'py, PyArray3<f64>>;
/// Per axis the approximation error for each robot, and whether all are small.
type Fits = (Vec<[f64; 2]>, bool);
type Simulated<'py> = (Block<'py>, Option<Block<'py>>, Vec<Option<f64>>, Fits, Fits);

/// Simulates a dyad: positions and velocities as blocks (robot, axis, time), and per axis the time of divergence
/// and how well functions are approximated.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the Python function beside it names them")]
pub fn simulate<'py>(
    py: Python<'py>,
    dyad: Argument<Bound<'py, Dyad>>,
    stiffness: Number,
    delay: DelayChoice,
    forces: Vec<Vec<Argument<ForceValue>>>,
    duration: Number,
    rate: Number,
    history: Option<Vec<Vec<Argument<HistoryValue>>>>,
    velocities: Truth,
) -> Outcome<Simulated<'py>> {
    let axes: Vec<_> = dyad.named("dyad")?.get().0.axes().collect();
    let (stiffness, delay) = (stiffness.named("stiffness")?, delay.check()?);
    let (duration, rate) = (duration.named("duration")?, rate.named("rate")?);
    let velocities = velocities.named("velocities")?;
    let count = output_count(duration, rate)?;
    let forces =
        lowered("forces", axes.len(), forces, FORCES, |force: &ForceValue| force.lower(py, duration))?;
    let histories = match history {
        None => axes.iter().map(|_| Default::default()).collect(),
        Some(history) => {
            lowered("history", axes.len(), history, PASTS, |past: &HistoryValue| past.lower(py, &delay))?
        }
    };
    let block = 2 * axes.len() * count;
    let force_fits = (
        forces.iter().map(|pair| pair.each_ref().map(Force::error)).collect(),
        forces.iter().flatten().all(Force::is_resolved),
    );
    let history_fits = (
        histories.iter().map(|pair| pair.each_ref().map(History::error)).collect(),
        histories.iter().flatten().all(History::is_resolved),
    );
    let shape = [2, axes.len(), count];
    let (position, velocity, diverged) = apart(py, move || -> telespring::Result<_> {
        let mut position = vec![0.0; block];
        let mut velocity = vec![0.0; if velocities { block } else { 0 }];
        let mut diverged = Vec::with_capacity(axes.len());
        let mut workspace = Workspace::default();
        for (index, axis) in axes.iter().enumerate() {
            let simulation = Simulation {
                axis,
                stiffness,
                delay: &delay,
                forces: &forces[index],
                histories: &histories[index],
                duration,
                rate,
            };
            let velocity = velocities.then(|| rows(&mut velocity, index, count));
            let ending = simulation
                .run_into(rows(&mut position, index, count), velocity, &mut workspace)
                .map_err(|refusal| on_axis(refusal, index))?;
            diverged.push(match ending.status {
                Status::Diverged { at } => Some(at),
                _ => None,
            });
        }
        Ok((position, velocity, diverged))
    })??;
    let velocity = if velocities { Some(velocity.into_pyarray(py).reshape(shape)?) } else { None };
    Ok((position.into_pyarray(py).reshape(shape)?, velocity, diverged, force_fits, history_fits))
}

/// Adds the axis to a refusal of the core, which works on one axis: `forces[robot]` becomes `forces[robot][axis]`.
fn on_axis(mut refusal: InvalidInput, axis: usize) -> InvalidInput {
    if let Some(robot) = refusal.field.strip_prefix("forces[")
        && let Some((robot, rest)) = robot.split_once(']')
    {
        refusal.field = format!("forces[{robot}][{axis}]{rest}");
    }
    refusal
}

/// The rows of both robots on one axis in a simulated block (robot, axis, time).
fn rows(block: &mut [f64], axis: usize, count: usize) -> [&mut [f64]; 2] {
    let (first, second) = block.split_at_mut(block.len() / 2);
    let row = axis * count..(axis + 1) * count;
    [&mut first[row.clone()], &mut second[row]]
}
