//! What a study file describes: coupling, network, ranges of operators, uncertainty, and the study itself.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyType};
use telespring::study::RobotFile;
use telespring::verdicts;
use telespring::{InvalidInput, quantity};

use crate::arguments::{Argument, DelayChoice, Number, hash, written};
use crate::errors::Outcome;
use crate::experiment::Experiment;
use crate::model::{Dyad, Operator};
use crate::records::{html_table, record};
use crate::study_values::replacements;

/// The coupling of the robots: a virtual spring and a damper in parallel with it.
///
/// Parameters
/// ----------
/// stiffness : float
///     Stiffness, N/m.
/// damping : float
///     Damping, N·s/m, through the same delay.
///
/// Raises
/// ------
/// InvalidInput
///     If a value is out of range.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> ts.Coupling(stiffness=71.2)
/// Coupling(stiffness=71.2, damping=0.0)
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling(pub telespring::study::Coupling);

#[pymethods]
impl Coupling {
    #[new]
    #[pyo3(signature = (stiffness, damping=Number::Given(0.0)), text_signature = "(stiffness, damping=0.0)")]
    fn new(stiffness: Number, damping: Number) -> Outcome<Self> {
        let (stiffness, damping) = (stiffness.named("stiffness")?, damping.named("damping")?);
        Ok(Self(telespring::study::Coupling {
            stiffness: quantity::STIFFNESS.check("stiffness", stiffness)?,
            damping: quantity::DAMPING.check("damping", damping)?,
        }))
    }

    /// Stiffness of the study's coupling, N/m.
    #[getter]
    fn stiffness(&self) -> f64 {
        self.0.stiffness
    }

    /// Damping of the study's coupling, N·s/m.
    #[getter]
    fn damping(&self) -> f64 {
        self.0.damping
    }

    fn __repr__(&self) -> String {
        format!("Coupling(stiffness={:?}, damping={:?})", self.0.stiffness, self.0.damping)
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.__getnewargs__().into_pyobject(py)?.as_any())
    }

    fn __getnewargs__(&self) -> (f64, f64) {
        (self.0.stiffness, self.0.damping)
    }
}

/// A network between two controllers, by the quantities that determine stability.
///
/// Parameters
/// ----------
/// delay : float or (float, float)
///     The constant part of the one-way delay, s, or the pair (forward, backward).
/// jitter : float
///     Largest delay of a packet beyond that, s.
/// max_gap : float
///     Longest wait for a newer partner sample, s, losses included; 0 is a stream without gaps.
/// sample_period : float
///     Sample period of both controllers, s, over which they hold the force; 0 is a continuous controller.
/// computing_time : float
///     Time from reading the samples to applying the force, s, within the same period.
///
/// Raises
/// ------
/// InvalidInput
///     If a time is not in 0 to 100 s, delay, jitter and gap together exceed that, or the computing time
///     exceeds the sample period.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> network = ts.Network(0.05, jitter=0.01, max_gap=0.004, sample_period=0.001)
/// >>> round(network.oldest_partner_sample[0], 12)
/// 0.065
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Network(pub verdicts::Network);

#[pymethods]
impl Network {
    #[new]
    #[pyo3(
        signature = (delay, jitter=Number::Given(0.0), max_gap=Number::Given(0.0),
                     sample_period=Number::Given(0.0), computing_time=Number::Given(0.0)),
        text_signature = "(delay, jitter=0.0, max_gap=0.0, sample_period=0.0, computing_time=0.0)"
    )]
    fn new(
        delay: DelayChoice,
        jitter: Number,
        max_gap: Number,
        sample_period: Number,
        computing_time: Number,
    ) -> Outcome<Self> {
        let delay = delay.check()?;
        let (jitter, max_gap) = (jitter.named("jitter")?, max_gap.named("max_gap")?);
        let sample_period = sample_period.named("sample_period")?;
        let computing_time = computing_time.named("computing_time")?;
        Ok(Self(verdicts::Network::new(delay, jitter, max_gap, sample_period, computing_time)?))
    }

    /// The constant part of the study network's one-way delays, s: forward and backward.
    #[getter]
    fn delay(&self) -> (f64, f64) {
        (self.0.delay().forward(), self.0.delay().backward())
    }

    /// Largest delay of a packet beyond the constant part, s.
    #[getter]
    fn jitter(&self) -> f64 {
        self.0.jitter()
    }

    /// Longest wait for a newer partner sample, s.
    #[getter]
    fn max_gap(&self) -> f64 {
        self.0.max_gap()
    }

    /// Sample period of both controllers, s; 0 if they are continuous.
    #[getter]
    fn sample_period(&self) -> f64 {
        self.0.sample_period()
    }

    /// Time from reading the samples to applying the force, s.
    #[getter]
    fn computing_time(&self) -> f64 {
        self.0.computing_time()
    }

    /// Whether the delay is constant: no jitter and no gaps.
    #[getter]
    fn is_constant(&self) -> bool {
        self.0.is_constant()
    }

    /// Largest age of a partner sample, s: T1 and T2.
    #[getter]
    fn oldest_partner_sample(&self) -> (f64, f64) {
        self.0.oldest_partner_sample().into()
    }

    /// Largest age of a robot's own position sample, s: one period plus computing time.
    #[getter]
    fn oldest_own_sample(&self) -> f64 {
        self.0.oldest_own_sample()
    }

    /// Constant delays behind a playout buffer that absorbs jitter and gaps, s.
    #[getter]
    fn buffered(&self) -> (f64, f64) {
        self.0.buffered().into()
    }

    /// The network's numbers as a dict that `json.dumps` takes.
    pub fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        out.set_item("delay", vec![self.0.delay().forward(), self.0.delay().backward()])?;
        out.set_item("jitter", self.jitter())?;
        out.set_item("max_gap", self.max_gap())?;
        out.set_item("sample_period", self.sample_period())?;
        out.set_item("computing_time", self.computing_time())?;
        Ok(out)
    }

    fn _repr_html_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        html_table("Network", self.to_dict(py)?.as_any())
    }

    fn __repr__(&self) -> String {
        format!(
            "Network({:?}, jitter={:?}, max_gap={:?}, sample_period={:?}, computing_time={:?})",
            self.delay(),
            self.jitter(),
            self.max_gap(),
            self.sample_period(),
            self.computing_time()
        )
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.__getnewargs__().into_pyobject(py)?.as_any())
    }

    fn __getnewargs__(&self) -> ((f64, f64), f64, f64, f64, f64) {
        (self.delay(), self.jitter(), self.max_gap(), self.sample_period(), self.computing_time())
    }
}

/// A range of operators: a grip varies, and a verdict must hold for all of them.
///
/// Parameters
/// ----------
/// low, high : Operator
///     Both ends, included. A single number applies to every axis of the dyad.
///
/// Raises
/// ------
/// InvalidInput
///     If both ends differ in their number of axes or a lower end exceeds the upper.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> ts.OperatorRange(ts.Operator(), ts.Operator(mass=1.5, stiffness=300.0)).high.stiffness
/// array([300.])
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct OperatorRange {
    low: Operator,
    high: Operator,
}

impl OperatorRange {
    /// The Python operator range on a dyad with that many axes.
    pub fn on(&self, axes: usize) -> telespring::Result<verdicts::OperatorRange> {
        let low = self.low.on(axes).map_err(|refusal| refusal.within("low"))?;
        let high = self.high.on(axes).map_err(|refusal| refusal.within("high"))?;
        verdicts::OperatorRange::new(low, high)
    }
}

impl From<&verdicts::OperatorRange> for OperatorRange {
    /// The Python operator range with the values of one of the core.
    fn from(range: &verdicts::OperatorRange) -> Self {
        Self { low: range.low().into(), high: range.high().into() }
    }
}

#[pymethods]
impl OperatorRange {
    #[new]
    fn new(low: Argument<Bound<'_, Operator>>, high: Argument<Bound<'_, Operator>>) -> Outcome<Self> {
        let (low, high) = (low.named("low")?.get().clone(), high.named("high")?.get().clone());
        let range = Self { low, high };
        range.on(range.low.count().max(range.high.count()))?;
        Ok(range)
    }

    /// The lower `Operator` of the range.
    #[getter]
    fn low(&self) -> Operator {
        self.low.clone()
    }

    /// The upper `Operator` of the range.
    #[getter]
    fn high(&self) -> Operator {
        self.high.clone()
    }

    fn __repr__(&self) -> String {
        format!("OperatorRange({}, {})", self.low.__repr__(), self.high.__repr__())
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.__getnewargs__().into_pyobject(py)?.as_any())
    }

    fn __getnewargs__(&self) -> (Operator, Operator) {
        (self.low(), self.high())
    }
}

/// Uncertainty of a robot's identified parameters, per axis.
///
/// Mass and damping of an axis have a normal distribution with these standard deviations and this
/// correlation; axes and robots are independent. `Study.uncertainty` returns it.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> study = ts.Study.from_toml('''
/// ... robot1 = {mass = 1, damping = 5, mass_sd = 0.02, damping_sd = 0.1}
/// ... robot2 = {mass = 1, damping = 5}
/// ... coupling.stiffness = 20
/// ... network.delay = 0.05
/// ... ''')
/// >>> first, second = study.uncertainty
/// >>> first.mass_sd, second is None
/// (array([0.02]), True)
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty(pub telespring::study::Uncertainty);

#[pymethods]
impl Uncertainty {
    #[new]
    fn new(
        mass_sd: Argument<Vec<f64>>,
        damping_sd: Argument<Vec<f64>>,
        correlation: Argument<Vec<f64>>,
    ) -> Outcome<Self> {
        Ok(Self(telespring::study::Uncertainty {
            mass_sd: mass_sd.named("mass_sd")?,
            damping_sd: damping_sd.named("damping_sd")?,
            correlation: correlation.named("correlation")?,
        }))
    }

    /// Standard deviation of the mass per axis, kg.
    #[getter]
    fn mass_sd<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.mass_sd.to_pyarray(py)
    }

    /// Standard deviation of the damping per axis, N·s/m.
    #[getter]
    fn damping_sd<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.damping_sd.to_pyarray(py)
    }

    /// Correlation of mass and damping per axis, −1 to 1.
    #[getter]
    fn correlation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.correlation.to_pyarray(py)
    }

    fn __repr__(&self) -> String {
        let telespring::study::Uncertainty { mass_sd, damping_sd, correlation } = &self.0;
        format!("Uncertainty(mass_sd={mass_sd:?}, damping_sd={damping_sd:?}, correlation={correlation:?})")
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.__getnewargs__().into_pyobject(py)?.as_any())
    }

    fn __getnewargs__(&self) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        (self.0.mass_sd.clone(), self.0.damping_sd.clone(), self.0.correlation.clone())
    }
}

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
        py.detach(|| {
            let robots = [one.as_ref(), other.as_ref()];
            Ok(Self(telespring::study::Study::from_changed_toml(&text, robots, &sections)?))
        })
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
    ///     `delay`. An `Agent`, `Arm`, `Task`, `LaboratorySettings`, `Coupling`, `Operator` or `Robot` may
    ///     replace its section, a robot with all that was known of the old one, such as its friction; a
    ///     `Network` replaces network and controller; `name` is the study's name, and
    ///     `allow_unusual=True` accepts values that no laboratory has.
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
        py.detach(|| Ok(Self(self.0.replace(&sections)?)))
    }

    /// The study with one of its robots replaced by that of a robot file.
    ///
    /// A robot file, as `telespring identify` writes it, has the section `[robot]` with the keys that
    /// `[robot1]` and `[robot2]` have in a study. Its section `[identification]`, if any, is a record that
    /// `robot_record` reads. If the record has a spring between the robot and the ground, its stiffness is
    /// added to that of this side's operator.
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
            Ok(number @ 1..=2_usize) => number - 1,
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
        Ok(self.network()?.delay())
    }

    /// Whether the study gives the delay of its network.
    #[getter]
    fn has_delay(&self) -> bool {
        self.0.has_delay()
    }

    /// Whether the study promises a playout buffer, which makes its delay constant.
    #[getter]
    fn has_playout_buffer(&self) -> bool {
        self.0.has_playout_buffer()
    }

    /// The uncertainty of each robot's parameters; None if they are certain.
    #[getter]
    fn uncertainty(&self) -> (Option<Uncertainty>, Option<Uncertainty>) {
        self.0.uncertainty().map(|robot| robot.cloned().map(Uncertainty)).into()
    }

    /// Coulomb friction of both robots of the study per axis, N, as an array (2, axes).
    #[getter]
    fn coulomb<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let friction = self.0.coulomb();
        friction.concat().into_pyarray(py).reshape([2, friction[0].len()])
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

record! {
    /// What identification recorded in a robot file in addition to the robot's parameters.
    RobotRecord(telespring::study::RobotRecord) {
        /// Whether the axes are free of inertial coupling; None if that is unknown.
        independent,
        /// Reservations about the estimates, as sentences.
        warnings,
        /// How many logs the estimates are from; None if that is unknown. The scatter between logs is in the
        /// standard deviations only of two logs or more.
        logs,
        /// Stiffness of a spring between the robot and the ground, N/m per axis; None if none was found.
        stiffness,
    }
}

/// What identification recorded in a robot file, in its section `[identification]`.
///
/// Parameters
/// ----------
/// robot_file : path_like or str
///     The file's path, or its text if it is a `str`.
///
/// Returns
/// -------
/// RobotRecord
///     Nothing known and no warnings if the section is missing.
///
/// Raises
/// ------
/// InvalidInput
///     If the text is no robot file.
/// OSError
///     If the file cannot be read.
///
/// Examples
/// --------
/// >>> from telespring.study.robot_file import robot_record
/// >>> text = "[robot]\nmass = 0.84\ndamping = 7.7\n[identification]\naxes_independent = false"
/// >>> robot_record(text)
/// RobotRecord(independent=False, warnings=(), logs=None, stiffness=None)
#[pyfunction]
pub fn robot_record(robot_file: &Bound<'_, PyAny>) -> Outcome<RobotRecord> {
    Ok(RobotRecord(read_robot_file(robot_file)?.record()?))
}

/// A robot file by its path, or by its text.
fn read_robot_file(path_or_text: &Bound<'_, PyAny>) -> Outcome<RobotFile> {
    // a robot file's text assigns values, the name of a file does not
    let is_text = |text: &Bound<'_, PyString>| text.to_cow().is_ok_and(|text| text.contains(['=', '\n']));
    Ok(match path_or_text.cast::<PyString>() {
        Ok(text) if is_text(text) => RobotFile::from_toml(&text.to_cow()?, "the robot's text")?,
        _ => RobotFile::from_toml(&read_text(path_or_text, "a robot file")?, &path_or_text.to_string())?,
    })
}

/// The text of a study or robot file in UTF-8; `kind` names it in a refusal.
fn read_text(path: &Bound<'_, PyAny>, kind: &str) -> Outcome<String> {
    // Python's own reading raises OSError with the file's name
    let path_of = path.py().import("pathlib")?.getattr("Path")?;
    let Ok(file) = path_of.call1((path,)) else {
        let allowed = "the path of a file is required";
        return Err(InvalidInput::new("path", written(path), allowed, "Give a str or a pathlib.Path.").into());
    };
    let bytes = file.call_method0("read_bytes")?;
    let bytes: Vec<u8> = bytes.extract()?;
    String::from_utf8(bytes).map_err(|error| {
        let before = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
        InvalidInput::new(
            path.to_string(),
            format!("a byte on line {line}"),
            format!("{kind} is text in UTF-8"),
            "Save it in that encoding.",
        )
        .into()
    })
}
