//! The experiment of a study as Python sees it: its trials, who takes part, and the laboratory.

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use telespring::rig::{Network, Protocol, Schedule};

use crate::arguments::{Argument, DelayChoice, Number, hash};
use crate::errors::Outcome;
use crate::participants::{Agent, Arm, Task};
use crate::records::record;
use crate::rig::Laboratory;

record! {
    /// A condition of an experiment: a spring and a delay, or no spring.
    ///
    /// It unpacks and compares as the pair (stiffness, delay).
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> unconnected, first, *_ = ts.Study.paper().experiment.conditions
    /// >>> unconnected
    /// Condition(stiffness=None, delay=0.0)
    /// >>> stiffness, delay = first
    /// >>> round(stiffness, 1), delay
    /// (17.8, 0.0)
    Condition as tuple {
        /// Stiffness of the virtual spring, N/m; None in the unconnected mode.
        stiffness: Option<f64>,
        /// One-way delay, each way, s.
        delay: f64,
    }
}

record! {
    /// Imperfections of the controllers and the network of a virtual laboratory.
    ///
    /// The attributes are keys of the sections `[laboratory]` and `[network]` of a study file; where the two directions
    /// of the network differ, jitter and loss are the larger ones.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> ts.Study.paper().experiment.settings.loss
    /// 0.0
    LaboratorySettings {
        /// Whether a force acts one sample period after the sample it was computed from.
        computing_tick: bool,
        /// Time constant of the robots' actuators, s; 0 is none.
        actuator_lag: f64,
        /// Step to which measured positions are rounded, m; 0 is none.
        encoder_resolution: f64,
        /// Largest delay of a packet beyond the constant one, s.
        jitter: f64,
        /// Probability that a packet is lost, apart from bursts and blackouts.
        loss: f64,
    }
}

record! {
    /// What a strategy holds on the handles over a sample period, which its proof depends on (docs/strategies.md).
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> damped = ts.Study.paper().replace(session={"strategy": "injected-damping"})
    /// >>> held = damped.experiment.held_coupling(71.2, 0.334)
    /// >>> held.stiffness, [round(damping, 2) for damping in held.damping[0]]
    /// (71.2, [16.26, 14.23])
    HeldCoupling {
        /// Stiffness by which a held force F is worth energy, F²/(2 stiffness), N/m: that of the spring on the handle; of two
        /// layers, that of the saturation.
        stiffness: f64,
        /// The strongest damper that the strategy puts on each handle, by robot and axis, N·s/m.
        damping: [[f64; 2]; 2],
    }
}

/// The rehearsal that a study describes: conditions, trials and who takes part. `Study.experiment` returns
/// it.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> experiment = ts.Study.paper().experiment
/// >>> len(experiment.conditions), experiment.trials, experiment.duration
/// (17, 20, 29.111)
/// >>> experiment.conditions[0].stiffness is None  # the unconnected mode
/// True
/// >>> experiment.agents[1].spots
/// 10
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    study: telespring::study::Study,
    protocol: Protocol,
    sample_period: f64,
}

impl Experiment {
    /// The experiment of a study whose robots have the axes of a rehearsal.
    pub fn of(study: &telespring::study::Study) -> Outcome<Self> {
        Ok(Self { study: study.clone(), protocol: study.protocol()?, sample_period: study.sample_period()? })
    }

    /// The schedule of one trial in this experiment.
    fn schedule(&self) -> Outcome<Schedule> {
        Ok(Schedule::new(self.protocol.duration, self.protocol.record_rate, self.sample_period)?)
    }
}

#[pymethods]
impl Experiment {
    /// The experiment of a study's text.
    #[staticmethod]
    fn _from_toml(text: &str) -> Outcome<Self> {
        Self::of(&telespring::study::Study::from_toml(text)?)
    }

    /// The conditions of the experiment in order.
    #[getter]
    fn conditions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let conditions = self.protocol.conditions.iter();
        PyTuple::new(
            py,
            conditions.map(|&(stiffness, delay)| Condition { stiffness, delay }).collect::<Vec<_>>(),
        )
    }

    /// Trials of each condition.
    #[getter]
    fn trials(&self) -> usize {
        self.protocol.trials
    }

    /// Duration of a trial in the experiment, s.
    #[getter]
    fn duration(&self) -> f64 {
        self.protocol.duration
    }

    /// First part of a trial that the experiment's analysis leaves out, s.
    #[getter]
    fn discard(&self) -> f64 {
        self.protocol.discard
    }

    /// Recorded samples per second in the experiment, Hz.
    #[getter]
    fn record_rate(&self) -> f64 {
        self.protocol.record_rate
    }

    /// The seed from which the seed of every trial is drawn.
    #[getter]
    fn seed(&self) -> u64 {
        self.protocol.seed
    }

    /// "blocks", one condition after the other, or "shuffled", in an order drawn from the seed.
    #[getter]
    fn order(&self) -> &'static str {
        if self.protocol.shuffled { "shuffled" } else { "blocks" }
    }

    /// Sample period of the controllers in the experiment, s.
    #[getter]
    fn sample_period(&self) -> f64 {
        self.sample_period
    }

    /// Number of sample periods of the experiment's trials.
    #[getter]
    fn tick_count(&self) -> Outcome<usize> {
        Ok(self.schedule()?.ticks())
    }

    /// Number of sample periods between two recorded instants of the experiment.
    #[getter]
    fn tick_stride(&self) -> Outcome<usize> {
        Ok(self.schedule()?.stride())
    }

    /// The recorded instants of a completed trial, s, the first at 0.
    #[getter]
    fn sample_times<'py>(&self, py: Python<'py>) -> Outcome<Bound<'py, PyArray1<f64>>> {
        let schedule = self.schedule()?;
        let times = (0..schedule.rows()).map(|row| schedule.time(row, self.sample_period));
        Ok(times.collect::<Vec<_>>().into_pyarray(py))
    }

    /// Both agents in the experiment, defaults filled in.
    #[getter]
    fn agents(&self) -> (Agent, Agent) {
        self.study.setup().agents.clone().map(Agent).into()
    }

    /// The target that both agents in the experiment follow, defaults filled in.
    #[getter]
    fn task(&self) -> Task {
        Task(self.study.setup().task.clone())
    }

    /// Both arms in the experiment, defaults filled in.
    #[getter]
    fn arms(&self) -> (Arm, Arm) {
        self.study.setup().arms.map(Arm).into()
    }

    /// Imperfections of the controllers and the network in the experiment.
    #[getter]
    fn settings(&self) -> LaboratorySettings {
        let setup = self.study.setup();
        let network = self.study.emulated_network();
        let Network { forward, backward } = &network.model;
        LaboratorySettings {
            computing_tick: setup.computing_tick,
            actuator_lag: setup.actuator_lag,
            encoder_resolution: setup.encoder_resolution,
            jitter: network.jitter(),
            loss: forward.loss.max(backward.loss),
        }
    }

    /// Damping in parallel with the spring in the experiment, N·s/m.
    #[getter]
    fn coupling_damping(&self) -> f64 {
        self.study.dyad().coupling_damping()
    }

    /// What the strategy of the study holds on the handles over a sample period, in one condition of the experiment.
    ///
    /// Parameters
    /// ----------
    /// stiffness : float
    ///     Of the virtual spring, N/m.
    /// delay : float or (float, float)
    ///     One-way delay, s, or the pair (forward, backward).
    ///
    /// Returns
    /// -------
    /// HeldCoupling
    ///     The spring and the strongest damper on each handle.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If a value is out of range, or refused by the strategy.
    fn held_coupling(&self, stiffness: Number, delay: DelayChoice) -> Outcome<HeldCoupling> {
        let held = self.study.held_coupling(stiffness.named("stiffness")?, delay.check()?)?;
        Ok(HeldCoupling { stiffness: held.stiffness, damping: held.damping })
    }

    /// The experiment's virtual laboratory: robots, arms, agents, target, controllers and network.
    ///
    /// Its `run` needs the agents and the target that are written in Python as arguments. A study that names recorded
    /// traces of the network needs `laboratory_on`.
    #[getter]
    fn laboratory(&self) -> Outcome<Laboratory> {
        Ok(Laboratory::of(&self.study, [None, None])?)
    }

    /// Files of the recorded traces of the experiment's network, forward and backward; None without one.
    #[getter]
    fn trace_files(&self) -> (Option<&str>, Option<&str>) {
        let traces = &self.study.emulated_network().traces;
        traces.each_ref().map(|file| file.as_ref().map(|file| file.path.as_str())).into()
    }

    /// The experiment's virtual laboratory with the recorded traces that its study names.
    ///
    /// Parameters
    /// ----------
    /// traces : (str or None, str or None)
    ///     The content of the files, forward and backward: a table, or the JSON of IRTT.
    ///
    /// Returns
    /// -------
    /// Laboratory
    ///     As `laboratory`.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If a trace is missing, superfluous, or no trace.
    #[pyo3(text_signature = "(self, traces)")]
    fn laboratory_on(&self, traces: Argument<(Option<String>, Option<String>)>) -> Outcome<Laboratory> {
        let (forward, backward) = traces.or_refuse(
            "traces",
            "a pair of texts is required, None for a direction without a trace",
            "Give (text, None), or read the files of trace_files.",
        )?;
        Ok(Laboratory::of(&self.study, [forward, backward])?)
    }

    fn __repr__(&self) -> String {
        let Protocol { conditions, trials, duration, .. } = &self.protocol;
        format!("<Experiment of {} conditions, {trials} trials each, {duration:?} s long>", conditions.len())
    }

    // of what every experiment has: equal ones have it alike
    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        let Protocol { trials, duration, seed, .. } = self.protocol;
        hash((trials, duration, seed, self.sample_period).into_pyobject(py)?.as_any())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((py.get_type::<Self>().getattr("_from_toml")?, (self.study.to_toml(),)))
    }
}
