//! The virtual laboratory: single trials, and many at once on all cores.

use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use rayon::prelude::*;
use telespring::rig::{
    self, Agent, ConnectedMode, CouplingEnergy, Observation, Record, Row, Schedule, Target, Trial,
    TrialOutcome,
};
use telespring::{Delay, InvalidInput, quantity};

use crate::agent_function::{AgentFunction, call_agent, refuse_superfluous, refuse_uncallable};
use crate::arguments::{Argument, DelayChoice, Number, hash, rows, written};
use crate::errors::{Failure, Outcome};
use crate::interrupt::in_parallel;
use crate::model::Dyad;
use crate::recording::{Recording, Recordings};
use crate::trial_outcome::{ended, times, told_by_sides};

/// A virtual laboratory: two robots in two arms, their agents, a target and a network, in virtual time.
///
/// Examples
/// --------
/// >>> from telespring import _core
/// >>> laboratory = _core.Laboratory.paper()
/// >>> trial = laboratory.run(71.2, 0.0836, seed=1, duration=2.0, record_rate=100.0)
/// >>> trial.position.shape, trial.status
/// ((201, 2, 2), 'completed')
#[pyclass(frozen, module = "telespring._core")]
#[derive(Debug, Clone)]
pub struct Laboratory {
    inner: rig::Laboratory,
    source: Source,
}

/// Where a laboratory comes from, so that it can be pickled.
#[derive(Debug, Clone)]
enum Source {
    /// `Laboratory.paper()`.
    Paper,
    /// The laboratory of the study with this text, and the content of its traces.
    Study(String, [Option<String>; 2]),
    /// Another laboratory with the robots of a dyad.
    Robots(Box<Laboratory>, Box<Dyad>),
}

impl Laboratory {
    /// The Python laboratory of a study, with the content of the traces that it names.
    pub fn of(study: &telespring::study::Study, traces: [Option<String>; 2]) -> telespring::Result<Self> {
        let inner = study.laboratory_on_texts(traces.each_ref().map(Option::as_deref))?;
        Ok(Self { inner, source: Source::Study(study.to_toml(), traces) })
    }
}

#[pymethods]
impl Laboratory {
    /// The paper's laboratory for Python: robots of Table III, massless arms, a skilled and a less-skilled agent.
    #[staticmethod]
    fn paper() -> Self {
        Self { inner: rig::Laboratory::paper(), source: Source::Paper }
    }

    fn __repr__(&self) -> String {
        let period = self.inner.controller.sample_period;
        format!("<Laboratory of two stations, controllers at {:?} Hz>", 1.0 / period)
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.inner == other.inner
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.inner.controller.sample_period.into_pyobject(py)?.as_any())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let class = py.get_type::<Self>();
        Ok(match &self.source {
            Source::Paper => (class.getattr("paper")?, PyTuple::empty(py)),
            Source::Study(text, [forward, backward]) => {
                (class.getattr("_from_toml")?, (text, forward, backward).into_pyobject(py)?)
            }
            Source::Robots(laboratory, dyad) => {
                (class.getattr("with_robots")?, (*laboratory.clone(), *dyad.clone()).into_pyobject(py)?)
            }
        })
    }

    #[staticmethod]
    fn _from_toml(text: &str, forward: Option<String>, backward: Option<String>) -> Outcome<Self> {
        Ok(Self::of(&telespring::study::Study::from_toml(text)?, [forward, backward])?)
    }

    /// The same laboratory with the masses and dampings of other robots, of which its controllers know nothing.
    ///
    /// Parameters
    /// ----------
    /// dyad : Dyad
    ///     The robots, with the axes x and y; the rest of it means nothing here.
    ///
    /// Returns
    /// -------
    /// Laboratory
    ///     Everything else, Coulomb friction included, is as in this one.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If the robots have other axes.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> from telespring import _core
    /// >>> free = ts.Robot([0.8, 1.0], [1.0, 1.0], axes=["x", "y"])
    /// >>> _core.Laboratory.paper().with_robots(ts.Dyad(free, free)).least_damping[0]  # counted on, as before
    /// (7.7257, 10.1168)
    fn with_robots(&self, dyad: Argument<Bound<'_, Dyad>>) -> Outcome<Self> {
        let dyad = dyad.named("dyad")?.get().clone();
        if dyad.0.axis_names() != ["x", "y"] {
            Err(InvalidInput::new(
                "dyad",
                format!("{:?}", dyad.0.axis_names()),
                "a laboratory needs robots with exactly the two axes \"x\" and \"y\"",
                "Give both robots these axes.",
            ))?;
        }
        let mut inner = self.inner.clone();
        for (station, robot) in inner.stations.iter_mut().zip(dyad.0.robots()) {
            station.handle.mass.copy_from_slice(robot.mass());
            station.handle.damping.copy_from_slice(robot.damping());
        }
        Ok(Self { inner, source: Source::Robots(Box::new(self.clone()), Box::new(dyad)) })
    }

    /// The damping on which the controllers count, by robot and axis, N·s/m: the lower end of its interval.
    #[getter]
    fn least_damping(&self) -> ((f64, f64), (f64, f64)) {
        self.inner.session.least_damping.map(Into::into).into()
    }

    /// Positions of the target at the recorded instants of a whole trial, m, (n, 2).
    ///
    /// Parameters
    /// ----------
    /// duration, record_rate : float
    ///     As in `run`.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If a value is out of range, or the target is a function of the caller.
    fn target<'py>(
        &self,
        py: Python<'py>,
        duration: Number,
        record_rate: Number,
    ) -> Outcome<Bound<'py, PyArray2<f64>>> {
        let (duration, rate) = (duration.named("duration")?, record_rate.named("record_rate")?);
        let schedule = Schedule::new(duration, rate, self.inner.controller.sample_period)?;
        check_rows(schedule.rows(), 1)?;
        self.inner.target.check()?;
        let positions = self.inner.target.positions(&schedule, self.inner.controller.sample_period);
        let shape = [positions.len(), 2];
        Ok(positions.into_flattened().into_pyarray(py).reshape(shape)?)
    }

    /// Simulates one trial.
    ///
    /// Parameters
    /// ----------
    /// stiffness : float or None
    ///     Stiffness of the virtual spring, N/m; None is the unconnected mode.
    /// delay : float or (float, float)
    ///     One-way haptic delay, s, or the pair (forward, backward).
    /// seed : int
    ///     Seed of all random numbers of the trial; see trial_seed.
    /// duration : float
    ///     Duration of the trial, s.
    /// record_rate : float
    ///     Recorded instants per second, Hz; divides the controllers' rate.
    /// agents : (callable or None, callable or None), optional
    ///     A function for each agent that is external: f(time, position, velocity, target) -> force, called at
    ///     every tick; s, m, m/s, m and N, each vector (2,).
    /// target : (ticks + 1, 2) array, optional
    ///     Positions at every tick of the controllers, m, instead of the laboratory's own target.
    /// coupling_damping : float
    ///     Damping in parallel with the spring, N·s/m.
    /// interrupt_check : callable, optional
    ///     Called without arguments at short intervals; an exception from it ends the trial.
    ///
    /// Returns
    /// -------
    /// Recording
    ///     Its signals at every recorded instant, up to an early end.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If a value is out of range, more than 5e7 instants are recorded, an arm cannot reach the start,
    ///     or an agent's function is missing, superfluous, or returns no finite force.
    #[pyo3(signature = (stiffness, delay, seed, duration, record_rate, agents=Argument::Given(None), target=None, coupling_damping=Number::Given(0.0), interrupt_check=None),
           text_signature = "(self, stiffness, delay, seed, duration, record_rate, agents=None, target=None, coupling_damping=0.0, interrupt_check=None)")]
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    fn run(
        &self,
        py: Python<'_>,
        stiffness: Argument<Option<f64>>,
        delay: DelayChoice,
        seed: Argument<u64>,
        duration: Number,
        record_rate: Number,
        agents: Argument<Option<[Option<AgentFunction>; 2]>>,
        target: Option<&Bound<'_, PyAny>>,
        coupling_damping: Number,
        interrupt_check: Option<Py<PyAny>>,
    ) -> Outcome<Recording> {
        let stiffness = stiffness.named("stiffness")?;
        let coupling = coupling(stiffness, delay.check()?, coupling_damping.named("coupling_damping")?);
        let seed = seed.named("seed")?;
        let (duration, rate) = (duration.named("duration")?, record_rate.named("record_rate")?);
        let schedule = Schedule::new(duration, rate, self.inner.controller.sample_period)?;
        check_rows(schedule.rows(), 1)?;
        let mut laboratory = self.inner.clone();
        if let Some(target) = target {
            laboratory.target = sampled(rows("target", target)?, schedule.ticks() + 1)?;
        }
        let agents = agents.named("agents")?.unwrap_or([None, None]);
        for (side, agent) in agents.iter().enumerate() {
            if let Some(agent) = agent
                && !agent.bind(py).is_callable()
            {
                return Err(refuse_uncallable(side, written(agent.bind(py))).into());
            }
            if agent.is_some() && !matches!(laboratory.stations[side].agent, Agent::External) {
                return Err(refuse_superfluous(side).into());
            }
        }
        let recording = py.detach(|| {
            laboratory.check()?;
            let mut programs = agents.each_ref().map(|agent| {
                agent.as_ref().map(|program| move |seen: &Observation| call_agent(program, seen))
            });
            let callbacks = programs
                .each_mut()
                .map(|program| program.as_mut().map(|program| program as rig::Callback<'_, Failure>));
            let mut looked = || {
                Python::attach(|py| {
                    py.check_signals()?;
                    interrupt_check.as_ref().map_or(Ok(()), |check| check.call0(py).map(drop))
                })
                .map_err(Failure::Python)
            };
            Trial { laboratory: &laboratory, coupling, seed, schedule }
                .record_interruptible::<Failure>(callbacks, &mut looked)
        })?;
        let rig::Recording {
            outcome,
            target,
            position,
            velocity,
            coupling_force,
            agent_force,
            handle_force,
            aim,
            mut account,
            age,
        } = recording;
        let rows = outcome.rows;
        let signal = |values: Vec<Row>| -> PyResult<_> {
            let flat = values.into_flattened().into_flattened();
            Ok(flat.into_pyarray(py).reshape([rows, 2, 2])?.into())
        };
        let (status, ended_at) = ended(&outcome);
        account.resize(rows, [f64::NAN; 2]);
        let per_side = |values: Vec<[f64; 2]>| -> PyResult<_> {
            Ok(values.into_flattened().into_pyarray(py).reshape([rows, 2])?.into())
        };
        let told = told_by_sides(&outcome).map(|values| values.to_vec().into_pyarray(py).into());
        let [
            limited_share,
            withheld_share,
            given_out,
            energy_sent,
            age_mean,
            age_low,
            age_high,
            held_share,
            lost,
        ] = told;
        Ok(Recording {
            time: times(py, &schedule, rows, laboratory.controller.sample_period).into(),
            target: target.into_flattened().into_pyarray(py).reshape([rows, 2])?.into(),
            position: signal(position)?,
            velocity: signal(velocity)?,
            coupling_force: signal(coupling_force)?,
            agent_force: signal(agent_force)?,
            handle_force: signal(handle_force)?,
            aim: signal(aim)?,
            account: per_side(account)?,
            age: per_side(age)?,
            limited_share,
            withheld_share,
            given_out,
            energy_sent,
            age_mean,
            age_low,
            age_high,
            held_share,
            lost,
            coupling_energy: outcome.coupling_energy.total,
            coupling_energy_minimum: outcome.coupling_energy.minimum,
            hand_energy: outcome.hand_energy.to_vec().into_pyarray(py).into(),
            status: status.to_owned(),
            ended_at,
        })
    }

    /// Simulates many trials on all cores; each has the numbers that `run` computes.
    ///
    /// Parameters
    /// ----------
    /// stiffness : (trials,) array_like of float
    ///     Stiffness of the virtual spring, N/m; NaN is the unconnected mode.
    /// delay : (trials,) array_like of float
    ///     One-way haptic delay, s.
    /// seed : (trials,) array_like of int
    ///     One seed per trial.
    /// duration, record_rate, coupling_damping : float
    ///     As in `run`.
    ///
    /// Returns
    /// -------
    /// Recordings
    ///     As of `run`, with the trial as first dimension, NaN after an early end.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     As `run`, and where the numbers of values differ or an agent is external.
    #[pyo3(signature = (stiffness, delay, seed, duration, record_rate, coupling_damping=Number::Given(0.0)),
           text_signature = "(self, stiffness, delay, seed, duration, record_rate, coupling_damping=0.0)")]
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    fn run_many(
        &self,
        py: Python<'_>,
        stiffness: Argument<Vec<f64>>,
        delay: Argument<Vec<f64>>,
        seed: Argument<Vec<u64>>,
        duration: Number,
        record_rate: Number,
        coupling_damping: Number,
    ) -> Outcome<Recordings> {
        let (stiffness, delay) = (stiffness.named("stiffness")?, delay.named("delay")?);
        let (seed, trials) = (seed.named("seed")?, stiffness.len());
        for (name, length) in [("delay", delay.len()), ("seed", seed.len())] {
            if length != trials {
                return Err(InvalidInput::new(
                    name,
                    format!("{length} value(s)"),
                    format!("one value per trial is required, that is {trials} as in stiffness"),
                    "Pass one stiffness, delay and seed per trial.",
                )
                .into());
            }
        }
        let (duration, rate) = (duration.named("duration")?, record_rate.named("record_rate")?);
        let schedule = Schedule::new(duration, rate, self.inner.controller.sample_period)?;
        let damping = coupling_damping.named("coupling_damping")?;
        let laboratory = &self.inner;
        let jobs = stiffness
            .iter()
            .zip(&delay)
            .zip(&seed)
            .enumerate()
            .map(|(index, ((&stiffness, &delay), &seed))| {
                let at = |mut refusal: InvalidInput| {
                    refusal.field = format!("{}[{index}]", refusal.field);
                    refusal
                };
                let stiffness = Some(stiffness).filter(|value| !value.is_nan());
                if let Some(stiffness) = stiffness {
                    quantity::STIFFNESS.check("stiffness", stiffness).map_err(at)?;
                }
                let coupling = coupling(stiffness, Delay::each_way(delay).map_err(at)?, damping);
                Ok(Trial { laboratory, coupling, seed, schedule })
            })
            .collect::<Outcome<Vec<_>>>()?;
        let rows = schedule.rows();
        check_rows(rows, trials)?;
        let (targets, blocks, sides, outcomes) = in_parallel(py, |stop| -> telespring::Result<_> {
            laboratory.check()?;
            let mut targets = vec![[f64::NAN; 2]; trials * rows];
            let mut blocks = [(); 6].map(|()| vec![[[f64::NAN; 2]; 2]; trials * rows]);
            let mut sides = [(); 2].map(|()| vec![[f64::NAN; 2]; trials * rows]);
            let looked = || match stop.is_set() {
                // never seen: the exception of the signal is raised instead
                true => Err(InvalidInput::new("run_many", "a signal", "it was interrupted", "Run it again.")),
                false => Ok(()),
            };
            let [position, velocity, coupling_force, agent_force, handle_force, aim] = &mut blocks;
            let [account, age] = &mut sides;
            let outcomes: Vec<_> = (
                jobs.par_iter(),
                targets.par_chunks_mut(rows),
                position.par_chunks_mut(rows),
                velocity.par_chunks_mut(rows),
                coupling_force.par_chunks_mut(rows),
                agent_force.par_chunks_mut(rows),
                handle_force.par_chunks_mut(rows),
                aim.par_chunks_mut(rows),
                account.par_chunks_mut(rows),
                age.par_chunks_mut(rows),
            )
                .into_par_iter()
                .map(
                    |(
                        job,
                        target,
                        position,
                        velocity,
                        coupling_force,
                        agent_force,
                        handle_force,
                        aim,
                        account,
                        age,
                    )| {
                        let mut record = Record {
                            target,
                            position,
                            velocity,
                            coupling_force,
                            agent_force,
                            handle_force,
                            aim,
                            account,
                            age,
                        };
                        job.run_interruptible::<InvalidInput>([None, None], &mut record, &mut { looked })
                    },
                )
                .collect();
            let outcomes = outcomes
                .into_iter()
                .enumerate()
                .map(|(index, outcome)| {
                    outcome.map_err(|mut refusal| {
                        refusal.allowed = format!("{} (trial {index})", refusal.allowed);
                        refusal
                    })
                })
                .collect::<telespring::Result<Vec<TrialOutcome>>>()?;
            Ok((targets, blocks, sides, outcomes))
        })??;
        let signal = |values: Vec<Row>| -> PyResult<_> {
            let flat = values.into_flattened().into_flattened();
            Ok(flat.into_pyarray(py).reshape([trials, rows, 2, 2])?.into())
        };
        let per_side = |values: Vec<[f64; 2]>| -> PyResult<_> {
            Ok(values.into_flattened().into_pyarray(py).reshape([trials, rows, 2])?.into())
        };
        let [position, velocity, coupling_force, agent_force, handle_force, aim] = blocks;
        let [account, age] = sides;
        let (status, ended_at): (Vec<_>, Vec<_>) = outcomes.iter().map(ended).unzip();
        let status = status.into_iter().map(str::to_owned).collect();
        let told: Vec<_> = outcomes.iter().map(told_by_sides).collect();
        let mut told = (0..9).map(|quantity| -> PyResult<_> {
            let values: Vec<_> = told.iter().flat_map(|trial| trial[quantity]).collect();
            Ok(values.into_pyarray(py).reshape([trials, 2])?.into())
        });
        let coupling_energy = |of: fn(&CouplingEnergy) -> f64| {
            let values: Vec<_> = outcomes.iter().map(|outcome| of(&outcome.coupling_energy)).collect();
            values.into_pyarray(py).into()
        };
        let hand_energy: Vec<_> = outcomes.iter().flat_map(|outcome| outcome.hand_energy).collect();
        let mut next = || told.next().expect("there are nine quantities");
        let ended_at: Vec<_> = ended_at.into_iter().map(|time| time.unwrap_or(f64::NAN)).collect();
        Ok(Recordings {
            time: times(py, &schedule, rows, laboratory.controller.sample_period).into(),
            target: targets.into_flattened().into_pyarray(py).reshape([trials, rows, 2])?.into(),
            position: signal(position)?,
            velocity: signal(velocity)?,
            coupling_force: signal(coupling_force)?,
            agent_force: signal(agent_force)?,
            handle_force: signal(handle_force)?,
            aim: signal(aim)?,
            account: per_side(account)?,
            age: per_side(age)?,
            limited_share: next()?,
            withheld_share: next()?,
            given_out: next()?,
            energy_sent: next()?,
            age_mean: next()?,
            age_low: next()?,
            age_high: next()?,
            held_share: next()?,
            lost: next()?,
            coupling_energy: coupling_energy(|of_trial| of_trial.total),
            coupling_energy_minimum: coupling_energy(|of_trial| of_trial.minimum),
            hand_energy: hand_energy.into_pyarray(py).reshape([trials, 2])?.into(),
            status,
            ended_at: ended_at.into_pyarray(py).into(),
        })
    }
}

/// Computes the seed of one trial of a rehearsal from these three numbers alone.
///
/// Parameters
/// ----------
/// seed : int
///     The seed of the rehearsal.
/// condition, trial : int
///     Index of the condition and of the trial, from 0.
///
/// Returns
/// -------
/// int
///     A seed from 0 to 2⁶⁴ − 1.
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

/// The coupling in the trials of a laboratory; none if unconnected.
fn coupling(stiffness: Option<f64>, delay: Delay, damping: f64) -> Option<ConnectedMode> {
    stiffness.map(|stiffness| ConnectedMode { stiffness, damping, delay })
}

/// A laboratory's target sampled at every tick, refused in the wrong shape.
fn sampled(target: Vec<[f64; 2]>, expected: usize) -> telespring::Result<Target> {
    if target.len() != expected {
        return Err(InvalidInput::new(
            "target",
            format!("an array of shape ({}, 2)", target.len()),
            format!("one row (x, y) per tick is required, that is shape ({expected}, 2)"),
            "Sample the target at every tick from 0 to the end of the trial.",
        ));
    }
    Ok(Target::Sampled(target))
}

/// Refuses recordings of a laboratory that would fill the memory.
///
/// The largest has 10 GB, with six signals of four numbers.
fn check_rows(rows: usize, trials: usize) -> telespring::Result<()> {
    const MOST: usize = 50_000_000;
    let all = rows.saturating_mul(trials);
    if all <= MOST {
        return Ok(());
    }
    Err(InvalidInput::new(
        "record_rate",
        format!("{all} rows"),
        format!("all trials together keep at most {MOST} rows"),
        "Run shorter or fewer trials, or keep fewer rows per second.",
    ))
}
