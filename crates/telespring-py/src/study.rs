//! The study of a study file.

use std::ffi::CString;

use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyFutureWarning;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};
use telespring::InvalidInput;

use crate::adversary::Adversary;
use crate::architecture::{Architecture, ComparisonPlan, GuardOverdraft};
use crate::arguments::{Argument, DelayChoice, Number, hash, holds_truth_value, written};
use crate::coupling::Coupling;
use crate::errors::Outcome;
use crate::experiment::Experiment;
use crate::judged_network::JudgedNetwork;
use crate::model::Dyad;
use crate::network::Network;
use crate::operator_range::OperatorRange;
use crate::records::html_table;
use crate::robot_file::{Uncertainty, read_robot_file, read_text};
use crate::study_values::replacements;

/// The contents of a study file: two robots, what holds them, their coupling and network, and the experiment
/// to rehearse on them.
///
/// Create one by `Study.read`, `Study.from_toml` or `Study.paper`, and change it by `Study.replace`.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> study = ts.Study.from_toml('''
/// ... robot1 = {mass = 1, damping = 5}
/// ... robot2 = {mass = 1, damping = 5}
/// ... coupling.stiffness = 20
/// ... network.delay = 0.05
/// ... ''')
/// >>> study.coupling, study.delay
/// (Coupling(stiffness=20.0, damping=0.0), (0.05, 0.05))
/// >>> ts.Study.from_toml(study.to_toml()) == study
/// True
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Study(pub telespring::study::Study);

/// Robot files, by path or text, that replace the study's robots.
type RobotFiles<'py> = (Option<Bound<'py, PyAny>>, Option<Bound<'py, PyAny>>);

#[pymethods]
impl Study {
    /// The two H-MANs of Du, Kulkarni, Kager and Campolo at their condition 2K (71 N/m) and Δ (167 ms).
    ///
    /// Returns
    /// -------
    /// Study
    ///     With free handles and continuous controllers, as in Fig. 5(h) of the paper.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> ts.Study.paper().dyad == ts.hman()
    /// True
    #[staticmethod]
    fn paper() -> Self {
        Self(telespring::study::Study::paper())
    }

    /// Read a Python `Study` from TOML text.
    ///
    /// Parameters
    /// ----------
    /// text : str
    ///     The text of a study file.
    /// robots : (path_like or str or None, path_like or str or None)
    ///     Robot files, or their texts, that take the place of `[robot1]` and `[robot2]`, whole.
    /// **sections
    ///     Sections with values that take the place of those in the text, as in `Study.replace`, except that a
    ///     section keeps its `kind`. Only the whole is checked, not the text without them.
    ///
    /// Returns
    /// -------
    /// Study
    ///     The study, checked.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If the text is not TOML, a key is unknown or missing, or a value has the wrong type or range.
    ///     The exception has the dotted field, what is allowed, a remedy and the line.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> try:
    /// ...     ts.Study.from_toml("[robot1]\nmass = 1")
    /// ... except ts.InvalidInput as refused:
    /// ...     print(refused.field)
    /// robot1.damping
    #[staticmethod]
    #[pyo3(
        signature = (text, robots=Argument::Given((None, None)), **sections),
        text_signature = "(text, robots=(None, None), **sections)"
    )]
    fn from_toml(
        py: Python<'_>,
        text: Argument<String>,
        robots: Argument<RobotFiles<'_>>,
        sections: Option<&Bound<'_, PyDict>>,
    ) -> Outcome<Self> {
        let text = text.named("text")?;
        let (one, other) = robots.or_refuse(
            "robots",
            "a pair of robot files is required, None for a robot that is not replaced",
            "Give (path, None), or texts instead of paths.",
        )?;
        let [one, other] = [one, other].map(|file| file.as_ref().map(read_robot_file).transpose());
        let (one, other) = (one?, other?);
        let sections = sections.map_or_else(|| Ok(Default::default()), replacements)?;
        let study = py.detach(|| {
            let robots = [one.as_ref(), other.as_ref()];
            telespring::study::Study::from_changed_toml(&text, robots, &sections)
        })?;
        warn_of_moved_keys(py, &study)?;
        Ok(Self(study))
    }

    /// Read a study file.
    ///
    /// Parameters
    /// ----------
    /// path : path_like
    ///     A TOML file in UTF-8.
    /// robots, **sections
    ///     What is replaced before anything is checked, as for `Study.from_toml`.
    ///
    /// Returns
    /// -------
    /// Study
    ///     The study, checked.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     As for `Study.from_toml`, and where the file is not UTF-8.
    /// OSError
    ///     If the file cannot be read.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> ts.Study.read("missing.toml")
    /// Traceback (most recent call last):
    /// FileNotFoundError: [Errno 2] No such file or directory: 'missing.toml'
    #[staticmethod]
    #[pyo3(
        signature = (path, robots=Argument::Given((None, None)), **sections),
        text_signature = "(path, robots=(None, None), **sections)"
    )]
    fn read(
        path: &Bound<'_, PyAny>,
        robots: Argument<RobotFiles<'_>>,
        sections: Option<&Bound<'_, PyDict>>,
    ) -> Outcome<Self> {
        Self::from_toml(path.py(), Argument::Given(read_text(path, "a study file")?), robots, sections)
    }

    /// The study with some values replaced.
    ///
    /// Parameters
    /// ----------
    /// **sections
    ///     Sections of a study file, each a mapping from keys to new values: numbers, strings, booleans, lists,
    ///     mappings or numpy arrays. None removes a key, which restores its default; None instead of a section
    ///     removes the section. Keys that are not named keep their values, with two exceptions: a new `kind`
    ///     restarts its section, and the `conditions` of a protocol exclude its lists of `stiffness` and
    ///     `delay`. An `Agent`, `Arm`, `Task`, `LaboratorySettings`, `Architecture`, `Coupling`, `Operator` or `Robot` may
    ///     replace its section, a robot with all that was known of the old one, such as its friction; a
    ///     `Network` replaces network and controller, and `LaboratorySettings` also `jitter` and `loss` of the
    ///     network; `name` is the study's name, and `allow_unusual=True` accepts values that no laboratory has.
    ///
    /// Returns
    /// -------
    /// Study
    ///     The new study, checked as if it had been read from a file.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If a value is refused, by its dotted field.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> study = ts.Study.paper().replace(coupling={"stiffness": 140.0}, protocol={"trials": 5})
    /// >>> study.stiffness, study.experiment.trials
    /// (140.0, 5)
    /// >>> study.replace(coupling={"stiffness": -1.0})
    /// Traceback (most recent call last):
    /// telespring._errors.InvalidInput: coupling.stiffness = -1: a coupling stiffness must be ...
    #[pyo3(signature = (**sections))]
    fn replace(&self, py: Python<'_>, sections: Option<&Bound<'_, PyDict>>) -> Outcome<Self> {
        let Some(sections) = sections else { return Ok(self.clone()) };
        let sections = replacements(sections)?;
        let study = py.detach(|| self.0.replace(&sections))?;
        warn_of_moved_keys(py, &study)?;
        Ok(Self(study))
    }

    /// The study with one of its robots replaced by that of a robot file.
    ///
    /// A robot file, as `telespring identify` writes it, has the section `[robot]` with the keys that
    /// `[robot1]` and `[robot2]` have in a study. Its section `[identification]`, if any, is a record that
    /// `robot_record` reads. If the record has a spring between the robot and the ground, it becomes the
    /// robot's `ground_stiffness`.
    ///
    /// Parameters
    /// ----------
    /// side : int
    ///     1 or 2: the robot to replace, whole.
    /// robot_file : path_like or str
    ///     The file's path, or its text if it is a `str`.
    ///
    /// Returns
    /// -------
    /// Study
    ///     The new study, checked.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If the text is no robot file, or the study refuses the robot.
    /// OSError
    ///     If the file cannot be read.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> text = "[robot]\nmass = [0.84, 1.07]\ndamping = [7.7, 10.1]\nmass_sd = 0.01"
    /// >>> study = ts.Study.paper().with_robot(1, text)
    /// >>> study.dyad.robots[0].mass, study.uncertainty[0].mass_sd
    /// (array([0.84, 1.07]), array([0.01, 0.01]))
    fn with_robot(&self, side: &Bound<'_, PyAny>, robot_file: &Bound<'_, PyAny>) -> Outcome<Self> {
        let robot = match side.extract() {
            Ok(number @ 1..=2_usize) if !holds_truth_value(side) => number - 1,
            _ => {
                let allowed = "a dyad has the robots 1 and 2";
                return Err(InvalidInput::new("side", written(side), allowed, "Choose one of them.").into());
            }
        };
        let file = read_robot_file(robot_file)?;
        Ok(Self(self.0.with_robot(robot, &file)?))
    }

    /// Whether the study file has one of the sections `[arm1]`, `[arm2]`, `[agent1]` and `[agent2]`: whether
    /// it names itself what holds the handles in the rehearsal. Equality and text of a study ignore it.
    #[getter]
    fn names_arms_or_agents(&self) -> bool {
        self.0.names_arms_or_agents()
    }

    /// The study as TOML text, from which the same study can be read.
    ///
    /// Returns
    /// -------
    /// str
    ///     The text of a study file, units as comments.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> ts.Study.paper().to_toml().splitlines()[3]
    /// 'name = "H-MAN 1"'
    fn to_toml(&self) -> String {
        self.0.to_toml()
    }

    /// The study's name as a str.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// The names of both robots; None if one has no name.
    #[getter]
    fn robot_names(&self) -> (Option<&str>, Option<&str>) {
        self.0.robot_names().into()
    }

    /// The study's `Dyad`; where the operators are ranges, with the middle of each.
    #[getter]
    fn dyad(&self) -> Dyad {
        Dyad(self.0.dyad().clone())
    }

    /// The ranges of both operators; None if all their values are single numbers.
    #[getter]
    fn operator_ranges(&self) -> Option<(OperatorRange, OperatorRange)> {
        self.0.operator_ranges().map(|[first, second]| (first.into(), second.into()))
    }

    /// The study's `Coupling`: the virtual spring and the damper in parallel with it.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If the study gives no stiffness: see `has_stiffness`.
    #[getter]
    fn coupling(&self) -> Outcome<Coupling> {
        Ok(Coupling(self.0.coupling()?))
    }

    /// Stiffness of the virtual spring in the study, N/m.
    #[getter]
    fn stiffness(&self) -> Outcome<f64> {
        Ok(self.0.coupling()?.stiffness)
    }

    /// Whether the study gives a stiffness; one that asks for limits does not.
    #[getter]
    fn has_stiffness(&self) -> bool {
        self.0.has_stiffness()
    }

    /// The study's `Network`, and the timing of the controllers.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If the study gives no delay: see `has_delay`.
    #[getter]
    fn network(&self) -> Outcome<Network> {
        Ok(Network(*self.0.network()?))
    }

    /// The constant part of the study's one-way delays, s: forward and backward.
    #[getter]
    fn delay(&self) -> Outcome<(f64, f64)> {
        let delay = self.0.network()?.delay();
        Ok((delay.forward(), delay.backward()))
    }

    /// Whether the study gives the delay of its network.
    #[getter]
    fn has_delay(&self) -> bool {
        self.0.has_delay()
    }

    /// The adversaries on the study's network, forward and backward; None where there is none.
    #[getter]
    fn adversaries(&self) -> (Option<Adversary>, Option<Adversary>) {
        self.0.adversaries().map(|way| way.map(Adversary)).into()
    }

    /// Whether the study promises a playout buffer, which makes its delay constant.
    #[getter]
    fn has_playout_buffer(&self) -> bool {
        self.0.has_playout_buffer()
    }

    /// Files of the recorded traces of the study's network, forward and backward; None without one.
    #[getter]
    fn trace_files(&self) -> (Option<&str>, Option<&str>) {
        let traces = &self.0.emulated_network().traces;
        traces.each_ref().map(|file| file.as_ref().map(|file| file.path.as_str())).into()
    }

    /// Compose the network that the verdicts judge: the ages that both sides really use.
    ///
    /// Losses, bursts, blackouts, a link of limited rate, a recorded trace and an adversary of the study's network
    /// make a motion older than delay, jitter and gap say, and the play-out of its session may use it later, or
    /// earlier, than the network delivers it. `docs/networks.md` has the rules.
    ///
    /// Parameters
    /// ----------
    /// delay : float or (float, float), optional
    ///     One-way delay, s, or the pair (forward, backward), in place of the network's.
    /// traces : (str or None, str or None)
    ///     The content of the recorded traces that the study names (`trace_files`), forward and backward. Without it
    ///     `unjudged` has "unread trace": nothing is proven.
    ///
    /// Returns
    /// -------
    /// JudgedNetwork
    ///     The network, its ages, and where they come from.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If there is no delay, or a trace is superfluous or no trace.
    ///
    /// Examples
    /// --------
    /// A play-out that is later than the network makes the age:
    ///
    /// >>> import telespring as ts
    /// >>> later = {"playout": {"kind": "fixed", "delay": 0.3}}
    /// >>> study = ts.Study.paper().replace(network={"delay": 0.05}, session=later)
    /// >>> study.judged_network().network.delay
    /// (0.3, 0.3)
    #[pyo3(
        signature = (delay=None, traces=Argument::Given((None, None))),
        text_signature = "(self, delay=None, traces=(None, None))"
    )]
    fn judged_network(
        &self,
        delay: Option<DelayChoice>,
        traces: Argument<(Option<String>, Option<String>)>,
    ) -> Outcome<JudgedNetwork> {
        let (forward, backward) = traces.or_refuse(
            "traces",
            "a pair of texts is required, None for a direction without a trace",
            "Give (text, None), or read the files of trace_files.",
        )?;
        let traces = self.0.recorded_traces([forward.as_deref(), backward.as_deref()])?;
        let delay = delay.map(|delay| delay.check()).transpose()?;
        Ok(JudgedNetwork(self.0.judged_network(delay, traces)?))
    }

    /// The uncertainty of each robot's parameters; None if they are certain.
    #[getter]
    fn uncertainty(&self) -> (Option<Uncertainty>, Option<Uncertainty>) {
        self.0.uncertainty().map(|robot| robot.cloned().map(Uncertainty)).into()
    }

    /// The mass that both robots have at least per axis, kg, as an array (2, axes): the lower end of its 95 % interval.
    #[getter]
    fn least_mass<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        by_robot(py, self.0.least_mass())
    }

    /// The damping that both robots have at least per axis, N·s/m, as an array (2, axes): the lower end of its 95 %
    /// interval, or 0.
    #[getter]
    fn least_damping<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        by_robot(py, self.0.least_damping())
    }

    /// Coulomb friction of both robots of the study per axis, N, as an array (2, axes).
    #[getter]
    fn coulomb<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let friction = self.0.coulomb();
        friction.concat().into_pyarray(py).reshape([2, friction[0].len()])
    }

    /// Stiffness of a spring between each robot and the ground per axis, N/m, as an array (2, axes); 0 without
    /// one. The operators of `dyad` and `operator_ranges` include it.
    #[getter]
    fn ground_stiffness<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let springs = self.0.ground_stiffness();
        springs.concat().into_pyarray(py).reshape([2, springs[0].len()])
    }

    /// The experiment to rehearse, or None if the robots have other axes than x and y.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If the study names no conditions and its robots have no reference stiffness for the default
    ///     ones, as robots without damping.
    #[getter]
    fn experiment(&self) -> Outcome<Option<Experiment>> {
        if self.0.is_planar() { Experiment::of(&self.0).map(Some) } else { Ok(None) }
    }

    /// What both sides do with the partner's motion, in the rehearsal and live: strategy, predictor and play-out.
    ///
    /// The verdicts judge the bare spring, whatever the session does.
    #[getter]
    fn session(&self) -> Architecture {
        Architecture(*self.0.session())
    }

    /// What a comparison of the study runs: architectures and networks.
    #[getter]
    fn comparison(&self) -> ComparisonPlan {
        ComparisonPlan::of(&self.0)
    }

    /// Say how far the guard's account can be overdrawn at a stiffness, on the axis with the least mass of both robots.
    ///
    /// Sample period, computing tick, lag of the actuators and encoder are those of the laboratory's controllers (1 kHz if
    /// the study names no period); a computing time of `[controller]` counts as a computing tick, and a mass as the lower end
    /// of its 95 % interval.
    ///
    /// Parameters
    /// ----------
    /// stiffness : float
    ///     N/m.
    ///
    /// Returns
    /// -------
    /// GuardOverdraft
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If the stiffness is out of range, or two sections give different sample periods.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> slow = ts.Study.paper().replace(laboratory={"sample_period": 0.01, "computing_tick": True})
    /// >>> overdraft = slow.guard_overdraft(2000.0)
    /// >>> overdraft.is_proven, round(overdraft.ratio, 2), round(overdraft.proven_stiffness)
    /// (False, 1.03, 194)
    fn guard_overdraft(&self, stiffness: Number) -> Outcome<GuardOverdraft> {
        let stiffness = stiffness.named("stiffness")?;
        Ok(GuardOverdraft(self.0.guard_overdraft(stiffness)?))
    }

    fn __repr__(&self) -> String {
        let given = |name: &str, value: Option<String>| {
            value.map_or(String::new(), |value| format!(" {name}={value}"))
        };
        format!(
            "<Study {:?}{}{} axes={:?}>",
            self.0.name(),
            given("stiffness", self.stiffness().ok().map(|stiffness| format!("{stiffness:?}"))),
            given("delay", self.delay().ok().map(|delay| format!("{delay:?}"))),
            self.0.dyad().axis_names()
        )
    }

    // of what a study has in any case: equal studies have it alike
    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        let (coupling, network) = (self.coupling().ok(), self.network().ok());
        hash((self.name(), self.dyad(), coupling, network).into_pyobject(py)?.as_any())
    }

    fn _repr_html_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let out = PyDict::new(py);
        out.set_item("name", self.name())?;
        out.set_item("robots", self.robot_names())?;
        out.set_item("stiffness", self.stiffness().ok())?;
        out.set_item("coupling_damping", self.0.dyad().coupling_damping())?;
        out.set_item("network", self.network().ok().map(|network| network.to_dict(py)).transpose()?)?;
        out.set_item("axes", self.dyad().to_dict(py)?.get_item("axes")?)?;
        html_table("Study", out.as_any())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((PyType::new::<Self>(py).getattr("from_toml")?, (self.to_toml(),)))
    }
}

/// A number per axis of both robots as an array (2, axes).
fn by_robot<'py>(py: Python<'py>, values: [Vec<f64>; 2]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let axes = values[0].len();
    values.concat().into_pyarray(py).reshape([2, axes])
}

/// Warns of keys that a study's text has at their old place, one warning for each.
fn warn_of_moved_keys(py: Python<'_>, study: &telespring::study::Study) -> PyResult<()> {
    for (old, new) in study.moved_keys() {
        let message =
            format!("{old} is now {new}, for the verdicts and the rehearsal; the next release refuses it.");
        let message = CString::new(message)?;
        PyErr::warn(py, &py.get_type::<PyFutureWarning>(), &message, 1)?;
    }
    Ok(())
}
