//! The virtual laboratory: single trials, and many at once on all cores.

use numpy::ndarray::ArrayView2;
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use telespring::rig::{
    self, Agent, Coupling, Ending, Record, Recording, Row, Schedule, Seen, Status, Target, Trial,
};
use telespring::{Delay, InvalidInput};

use crate::arguments::{Argument, DelayChoice, Number};
use crate::errors::{Failure, Outcome};

/// Two robots in two arms, their agents, a target and a network, in virtual time.
///
/// Examples
/// --------
/// >>> from telespring import _core
/// >>> laboratory = _core.Laboratory.paper()
/// >>> trial = laboratory.run(71.2, 0.0836, seed=1, duration=2.0, record_rate=100.0)
/// >>> trial["position"].shape, trial["status"]
/// ((201, 2, 2), 'completed')
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Laboratory(pub rig::Laboratory);

/// A program that moves an arm: force from time, position, velocity and target.
type Program = Py<PyAny>;

#[pymethods]
impl Laboratory {
    /// The paper's: the robots of Table III, massless arms, a skilled and a less-skilled agent.
    #[staticmethod]
    fn paper() -> Self {
        Self(rig::Laboratory::paper())
    }

    /// One trial.
    ///
    /// Parameters
    /// ----------
    /// stiffness : float or None
    ///     Of the virtual spring, N/m; None is the unconnected mode.
    /// delay : float or (float, float)
    ///     One-way haptic delay, s, or the pair (forward, backward).
    /// seed : int
    ///     From which everything random is drawn; see trial_seed.
    /// duration : float
    ///     Length of the trial, s.
    /// record_rate : float
    ///     Rows kept per second, Hz; divides the controllers' rate.
    /// agents : (callable or None, callable or None), optional
    ///     For each agent that is a program of the caller's: f(time, position, velocity, target) ->
    ///     force, called at every tick; s, m, m/s, m and N, each vector (2,).
    /// target : (ticks + 1, 2) array, optional
    ///     Positions at every tick of the controllers, m, in place of the laboratory's own target.
    /// coupling_damping : float
    ///     Of the damper beside the spring, N·s/m.
    ///
    /// Returns
    /// -------
    /// dict
    ///     Row j is at tick j/record_rate; the arrays end where the trial ended. ``time`` (n,), s;
    ///     ``target`` (n, 2), m; each (n, 2 robots, 2 axes): ``position``, m, ``velocity``, m/s,
    ///     ``coupling_force`` of the robot on its handle, ``agent_force`` of the agent on its arm and
    ///     ``handle_force`` of the arm on the handle, N, all from that tick on, ``aim``, where the agent
    ///     takes the target to be, m. ``status`` is "completed", "diverged" (a handle went beyond 10 m) or
    ///     "out of reach" (of a two-link arm), ``ended_at`` the first tick that is left out, s, NaN where
    ///     completed.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     Where a value is out of range, an arm cannot reach the start, an agent's program is missing,
    ///     not wanted, or gives no finite force.
    #[pyo3(signature = (stiffness, delay, seed, duration, record_rate, agents=None, target=None, coupling_damping=Number::Given(0.0)),
           text_signature = "(self, stiffness, delay, seed, duration, record_rate, agents=None, target=None, coupling_damping=0.0)")]
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    fn run<'py>(
        &self,
        py: Python<'py>,
        stiffness: Argument<Option<f64>>,
        delay: DelayChoice,
        seed: Argument<u64>,
        duration: Number,
        record_rate: Number,
        agents: Option<[Option<Program>; 2]>,
        target: Option<PyReadonlyArray2<'py, f64>>,
        coupling_damping: Number,
    ) -> Outcome<Bound<'py, PyDict>> {
        let stiffness = stiffness.named("stiffness")?;
        let coupling = coupling(stiffness, delay.check()?, coupling_damping.named("coupling_damping")?);
        let seed = seed.named("seed")?;
        let (duration, rate) = (duration.named("duration")?, record_rate.named("record_rate")?);
        let schedule = Schedule::new(duration, rate, self.0.controller.sample_period)?;
        let mut laboratory = self.0.clone();
        if let Some(target) = target {
            laboratory.target = sampled(target.as_array(), schedule.ticks() + 1)?;
        }
        let agents = agents.unwrap_or([None, None]);
        for (side, agent) in agents.iter().enumerate() {
            if agent.is_some() && !matches!(laboratory.sides[side].agent, Agent::External) {
                return Err(unwanted(side).into());
            }
        }
        let recording = py.detach(|| {
            laboratory.check()?;
            let mut programs = agents
                .each_ref()
                .map(|agent| agent.as_ref().map(|program| move |seen: &Seen| call(program, seen)));
            let callbacks = programs
                .each_mut()
                .map(|program| program.as_mut().map(|program| program as rig::Callback<'_, Failure>));
            Trial { laboratory: &laboratory, coupling, seed, schedule }.record::<Failure>(callbacks)
        })?;
        let Recording { ending, target, position, velocity, coupling_force, agent_force, handle_force, aim } =
            recording;
        let result = PyDict::new(py);
        result.set_item("time", times(py, ending.rows, rate))?;
        let rows = ending.rows;
        result.set_item("target", target.into_flattened().into_pyarray(py).reshape([rows, 2])?)?;
        for (name, values) in [
            ("position", position),
            ("velocity", velocity),
            ("coupling_force", coupling_force),
            ("agent_force", agent_force),
            ("handle_force", handle_force),
            ("aim", aim),
        ] {
            let flat = values.into_flattened().into_flattened();
            result.set_item(name, flat.into_pyarray(py).reshape([rows, 2, 2])?)?;
        }
        let (status, ended_at) = ended(&ending);
        result.set_item("status", status)?;
        result.set_item("ended_at", ended_at)?;
        Ok(result)
    }

    /// Many trials on all cores, each with the numbers that `run` gives it.
    ///
    /// Parameters
    /// ----------
    /// stiffness : (trials,) array_like of float
    ///     N/m; NaN is the unconnected mode.
    /// delay : (trials,) array_like of float
    ///     One-way haptic delay, s.
    /// seed : (trials,) array_like of int
    ///     One seed per trial.
    /// duration, record_rate, coupling_damping : float
    ///     As in `run`.
    ///
    /// Returns
    /// -------
    /// dict
    ///     As of `run`, with the trial as first dimension, NaN after an early end; ``time`` (n,);
    ///     ``status`` a list, ``ended_at`` (trials,).
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     As `run`, and where the numbers of values differ; no agent may be a program.
    #[pyo3(signature = (stiffness, delay, seed, duration, record_rate, coupling_damping=Number::Given(0.0)),
           text_signature = "(self, stiffness, delay, seed, duration, record_rate, coupling_damping=0.0)")]
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    fn run_many<'py>(
        &self,
        py: Python<'py>,
        stiffness: Argument<Vec<f64>>,
        delay: Argument<Vec<f64>>,
        seed: Argument<Vec<u64>>,
        duration: Number,
        record_rate: Number,
        coupling_damping: Number,
    ) -> Outcome<Bound<'py, PyDict>> {
        let (stiffness, delay) = (stiffness.named("stiffness")?, delay.named("delay")?);
        let (seed, trials) = (seed.named("seed")?, stiffness.len());
        for (name, length) in [("delay", delay.len()), ("seed", seed.len())] {
            if length != trials {
                return Err(InvalidInput::new(
                    name,
                    format!("{length} value(s)"),
                    format!("one value per trial is needed, that is {trials} as in stiffness"),
                    "Give one stiffness, delay and seed per trial.",
                )
                .into());
            }
        }
        let (duration, rate) = (duration.named("duration")?, record_rate.named("record_rate")?);
        let schedule = Schedule::new(duration, rate, self.0.controller.sample_period)?;
        let damping = coupling_damping.named("coupling_damping")?;
        let laboratory = &self.0;
        let jobs = stiffness
            .iter()
            .zip(&delay)
            .zip(&seed)
            .enumerate()
            .map(|(index, ((&stiffness, &delay), &seed))| {
                let at = |refusal| Failure::Refused { refusal, index: Some(index) };
                let stiffness = Some(stiffness).filter(|value| !value.is_nan());
                let coupling = coupling(stiffness, Delay::each_way(delay).map_err(at)?, damping);
                Ok(Trial { laboratory, coupling, seed, schedule })
            })
            .collect::<Outcome<Vec<_>>>()?;
        let rows = schedule.rows();
        let mut targets = vec![[f64::NAN; 2]; trials * rows];
        let mut blocks = [(); 6].map(|()| vec![[[f64::NAN; 2]; 2]; trials * rows]);
        let endings = py.detach(|| -> Outcome<Vec<Ending>> {
            laboratory.check()?;
            let [position, velocity, coupling_force, agent_force, handle_force, aim] = &mut blocks;
            let endings: Vec<_> = (
                jobs.par_iter(),
                targets.par_chunks_mut(rows),
                position.par_chunks_mut(rows),
                velocity.par_chunks_mut(rows),
                coupling_force.par_chunks_mut(rows),
                agent_force.par_chunks_mut(rows),
                handle_force.par_chunks_mut(rows),
                aim.par_chunks_mut(rows),
            )
                .into_par_iter()
                .map(|(job, target, position, velocity, coupling_force, agent_force, handle_force, aim)| {
                    let mut record =
                        Record { target, position, velocity, coupling_force, agent_force, handle_force, aim };
                    job.run::<InvalidInput>([None, None], &mut record)
                })
                .collect();
            endings
                .into_iter()
                .enumerate()
                .map(|(index, ending)| {
                    ending.map_err(|refusal| Failure::Refused { refusal, index: Some(index) })
                })
                .collect()
        })?;
        let result = PyDict::new(py);
        result.set_item("time", times(py, rows, rate))?;
        result.set_item("target", targets.into_flattened().into_pyarray(py).reshape([trials, rows, 2])?)?;
        let names = ["position", "velocity", "coupling_force", "agent_force", "handle_force", "aim"];
        for (name, block) in names.into_iter().zip(blocks) {
            let block: Vec<Row> = block;
            let flat = block.into_flattened().into_flattened();
            result.set_item(name, flat.into_pyarray(py).reshape([trials, rows, 2, 2])?)?;
        }
        let (status, ended_at): (Vec<_>, Vec<_>) = endings.iter().map(ended).unzip();
        result.set_item("status", status)?;
        result.set_item("ended_at", ended_at.into_pyarray(py))?;
        Ok(result)
    }
}

/// The seed of one trial of a rehearsal; it depends on nothing but the three numbers.
///
/// Parameters
/// ----------
/// seed : int
///     Of the rehearsal.
/// condition, trial : int
///     Counted from 0.
///
/// Returns
/// -------
/// int
///     From 0 to 2⁶⁴ − 1.
///
/// Examples
/// --------
/// >>> from telespring import _core
/// >>> _core.trial_seed(1, 0, 0)
/// 7424550030962593201
#[pyfunction]
pub fn trial_seed(seed: Argument<u64>, condition: Argument<u64>, trial: Argument<u64>) -> Outcome<u64> {
    Ok(rig::trial_seed(seed.named("seed")?, condition.named("condition")?, trial.named("trial")?))
}

fn coupling(stiffness: Option<f64>, delay: Delay, damping: f64) -> Option<Coupling> {
    stiffness.map(|stiffness| Coupling { stiffness, damping, delay })
}

fn sampled(target: ArrayView2<'_, f64>, expected: usize) -> telespring::Result<Target> {
    if target.shape() != [expected, 2] {
        return Err(InvalidInput::new(
            "target",
            format!("an array of shape {:?}", target.shape()),
            format!("one row (x, y) per tick is needed, that is shape ({expected}, 2)"),
            "Sample the target at every tick from 0 to the end of the trial.",
        ));
    }
    Ok(Target::Sampled(target.rows().into_iter().map(|row| [row[0], row[1]]).collect()))
}

fn unwanted(side: usize) -> InvalidInput {
    let number = side + 1;
    InvalidInput::new(
        format!("agents[{side}]"),
        "a program",
        format!("agent {number} of this laboratory is not moved by a program of the caller's"),
        format!("Choose kind = \"python\" in [agent{number}], or give None."),
    )
}

/// What the program answers, or what it raised.
fn call(program: &Program, seen: &Seen) -> Outcome<[f64; 2]> {
    Python::attach(|py| {
        let vector = |values: [f64; 2]| PyArray1::from_slice(py, &values);
        let arguments = (seen.time, vector(seen.position), vector(seen.velocity), vector(seen.target));
        let answer = program.call1(py, arguments)?;
        match answer.extract::<Argument<[f64; 2]>>(py) {
            Ok(Argument::Given(force)) => Ok(force),
            Ok(Argument::Other(text)) => Err(InvalidInput::new(
                "agents",
                text,
                format!("at {} s the agent's force has to be two numbers, N along x and y", seen.time),
                "Return an array or a pair of two floats.",
            )
            .into()),
            Err(never) => match never {},
        }
    })
}

fn times(py: Python<'_>, rows: usize, rate: f64) -> Bound<'_, PyArray1<f64>> {
    (0..rows).map(|row| row as f64 / rate).collect::<Vec<_>>().into_pyarray(py)
}

/// The status by its name, and when the trial ended early, s.
fn ended(ending: &Ending) -> (&'static str, f64) {
    match ending.status {
        Status::Diverged { at } => ("diverged", at),
        Status::OutOfReach { at } => ("out of reach", at),
        _ => ("completed", f64::NAN),
    }
}
