//! The network between the controllers.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use telespring::verdicts;

use crate::arguments::{DelayChoice, Number, hash};
use crate::errors::Outcome;
use crate::records::html_table;

/// A network between two controllers, by the quantities that determine stability.
///
/// Parameters
/// ----------
/// delay : float or (float, float)
///     The constant part of the one-way delay, s, or the pair (forward, backward).
/// jitter : float or (float, float)
///     Largest delay of a packet beyond that, s, or the pair (forward, backward).
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
        signature = (delay, jitter=DelayChoice::EachWay(0.0), max_gap=Number::Given(0.0),
                     sample_period=Number::Given(0.0), computing_time=Number::Given(0.0)),
        text_signature = "(delay, jitter=0.0, max_gap=0.0, sample_period=0.0, computing_time=0.0)"
    )]
    fn new(
        delay: DelayChoice,
        jitter: DelayChoice,
        max_gap: Number,
        sample_period: Number,
        computing_time: Number,
    ) -> Outcome<Self> {
        let delay = delay.check()?;
        let (jitters, max_gap) = (jitter.both_ways("jitter")?, max_gap.named("max_gap")?);
        let sample_period = sample_period.named("sample_period")?;
        let computing_time = computing_time.named("computing_time")?;
        Ok(Self(verdicts::Network::with_jitters(delay, jitters, max_gap, sample_period, computing_time)?))
    }

    /// The constant part of the study network's one-way delays, s: forward and backward.
    #[getter]
    fn delay(&self) -> (f64, f64) {
        (self.0.delay().forward(), self.0.delay().backward())
    }

    /// Largest delay of a packet beyond the constant part, s: the larger of both ways.
    #[getter]
    fn jitter(&self) -> f64 {
        self.0.jitter()
    }

    /// Largest delay of a packet beyond the constant part, s: forward and backward.
    #[getter]
    fn jitters(&self) -> (f64, f64) {
        self.0.jitters().into()
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

    /// The network's numbers as a dict that `json.dumps` takes; the jitter is a list if the ways differ.
    pub fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        out.set_item("delay", vec![self.0.delay().forward(), self.0.delay().backward()])?;
        match self.jitters() {
            (forward, backward) if forward == backward => out.set_item("jitter", forward)?,
            (forward, backward) => out.set_item("jitter", vec![forward, backward])?,
        }
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
            "Network({:?}, jitter={}, max_gap={:?}, sample_period={:?}, computing_time={:?})",
            self.delay(),
            self.written_jitter(),
            self.max_gap(),
            self.sample_period(),
            self.computing_time()
        )
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.__getnewargs__().into_pyobject(py)?.as_any())
    }

    fn __getnewargs__(&self) -> ((f64, f64), (f64, f64), f64, f64, f64) {
        (self.delay(), self.jitters(), self.max_gap(), self.sample_period(), self.computing_time())
    }
}

impl Network {
    /// The jitter as Python writes it: one number, or the pair of both ways.
    fn written_jitter(&self) -> String {
        match self.jitters() {
            (forward, backward) if forward == backward => format!("{forward:?}"),
            both => format!("{both:?}"),
        }
    }
}
