//! Recorded traces of a network.

use numpy::{IntoPyArray, Ix1, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use telespring::InvalidInput;
use telespring::rig::trace::{
    BurstFit as CoreBurstFit, JitterFit as CoreJitterFit, PlayedTrace as CorePlayed, TraceFormat,
};
use telespring::rig::trace::{TraceFit as CoreTraceFit, TraceStatistics as CoreStatistics};
use telespring::rig::{GilbertElliott, JitterDistribution, TraceRow};
use telespring::study::TraceFile;

use crate::arguments::{Argument, Number, Truth};
use crate::arrays::Numbers;
use crate::errors::Outcome;
use crate::interrupt::apart;
use crate::records::{Array, Value, record};

record! {
    /// What a recorded trace of a network shows; delays are those of the packets that came.
    TraceStatistics(CoreStatistics) {
        /// Packets sent.
        sent,
        /// The median time between two packets sent, s.
        interval,
        /// The longest time between two packets sent, s.
        longest_interval,
        /// The share of packets lost.
        loss,
        /// The mean number of packets lost in a row; 0 without losses.
        burst_length,
        /// The share of packets that came after one sent later (reordered in the sense of RFC 4737).
        reordered,
        /// The smallest delay, s.
        minimum,
        /// The mean delay, s.
        mean,
        /// The standard deviation of the delays, s.
        sd,
        /// The median delay, s.
        median,
        /// The delay that 99 % of the packets do not exceed, s.
        quantile_99,
        /// The largest delay, s.
        maximum,
        /// The correlation of the delays of successive packets; the emulator's jitter has 0. NaN if all are equal.
        autocorrelation,
    }
}

/// The name of a jitter's distribution in a study file.
fn kind(distribution: &JitterDistribution) -> &'static str {
    match distribution {
        JitterDistribution::Uniform => "uniform",
        JitterDistribution::Normal { .. } => "normal",
        JitterDistribution::Gamma { .. } => "gamma",
        JitterDistribution::LogNormal { .. } => "lognormal",
    }
}

/// The distribution of a jitter with this name in a study file.
fn distribution_of(kind: &str, mean: f64, sd: f64) -> Outcome<JitterDistribution> {
    Ok(match kind {
        "uniform" => JitterDistribution::Uniform,
        "normal" => JitterDistribution::Normal { mean, sd },
        "gamma" => JitterDistribution::Gamma { mean, sd },
        "lognormal" => JitterDistribution::LogNormal { mean, sd },
        other => {
            let allowed = "the distributions are uniform, normal, gamma and lognormal";
            return Err(InvalidInput::new("distribution", other, allowed, "Choose one of them.").into());
        }
    })
}

record! {
    /// A distribution of the jitter, fitted to a recorded trace of a network by maximum likelihood.
    JitterFit {
        /// The constant delay to which the jitter is added, s.
        delay: f64,
        /// The bound of the jitter, s.
        jitter: f64,
        /// "uniform", "normal", "gamma" or "lognormal".
        kind: String,
        /// The mean of the distribution before it is cut at 0 and the bound, s; None if it is uniform.
        mean: Option<f64>,
        /// Its standard deviation, s; None if it is uniform.
        sd: Option<f64>,
        /// The logarithm of the likelihood of the recorded delays.
        log_likelihood: f64,
        /// How well it fits: the largest difference between the shares of packets up to a delay, recorded and fitted.
        distance: f64,
    }
    methods {
        /// The share of packets whose delay is at most `delay`, s, an array of one dimension.
        fn cumulative<'py>(&self, py: Python<'py>, delay: &Bound<'py, PyAny>) -> Outcome<Bound<'py, PyArray1<f64>>> {
            let (mean, sd) = (self.mean.unwrap_or(f64::NAN), self.sd.unwrap_or(f64::NAN));
            let distribution = distribution_of(&self.kind, mean, sd)?;
            let delays = Numbers::read("delay", delay)?.row()?;
            let share = |delay: &f64| distribution.cumulative(delay - self.delay, self.jitter);
            Ok(delays.iter().map(share).collect::<Vec<_>>().into_pyarray(py))
        }
    }
}

impl Value for CoreJitterFit {
    fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let [mean, sd] = match self.distribution.moments() {
            None => [None, None],
            Some(moments) => moments.map(Some),
        };
        let Self { delay, jitter, log_likelihood, distance, .. } = *self;
        let kind = kind(&self.distribution).to_owned();
        Ok(Bound::new(py, JitterFit { delay, jitter, kind, mean, sd, log_likelihood, distance })?.into_any())
    }

    fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        let fit = value.cast::<JitterFit>()?.get();
        let JitterFit { delay, jitter, log_likelihood, distance, .. } = *fit;
        let (mean, sd) = (fit.mean.unwrap_or(f64::NAN), fit.sd.unwrap_or(f64::NAN));
        let distribution = distribution_of(&fit.kind, mean, sd)?;
        Ok(Self { delay, jitter, distribution, log_likelihood, distance })
    }

    fn to_json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.to_python(py)?.call_method0("to_dict")
    }
}

record! {
    /// Losses in bursts, fitted to a recorded trace of a network by maximum likelihood: a good network loses no packet,
    /// a bad one all.
    BurstFit {
        /// The probability that a good network turns bad before the next recorded packet.
        to_bad: f64,
        /// The probability that a bad network turns good before the next recorded packet.
        to_good: f64,
        /// The number of bursts.
        bursts: usize,
        /// How well it fits: the largest difference between the shares of bursts up to a length, recorded and fitted.
        distance: f64,
    }
}

impl Value for CoreBurstFit {
    fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let Self { model: GilbertElliott { to_bad, to_good, .. }, bursts, distance } = *self;
        Ok(Bound::new(py, BurstFit { to_bad, to_good, bursts, distance })?.into_any())
    }

    fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        let BurstFit { to_bad, to_good, bursts, distance } = *value.cast::<BurstFit>()?.get();
        let model = GilbertElliott { to_bad, to_good, loss_good: 0.0, loss_bad: 1.0 };
        Ok(Self { model, bursts, distance })
    }

    fn to_json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.to_python(py)?.call_method0("to_dict")
    }
}

record! {
    /// The emulator's models that fit a recorded trace of a network.
    TraceFit(CoreTraceFit) {
        /// The distributions of the jitter, the most likely first; empty if all delays are equal.
        jitter,
        /// The losses; None if there are none.
        burst,
        /// The smallest delay of the trace, s.
        minimum,
    }
}

record! {
    /// The ages of the motion that a fixed play-out uses over a recorded trace of a network.
    PlayedTrace {
        /// The delay of the play-out, s.
        delay: f64,
        /// The time between two packets, and between two ticks, s.
        sample_period: f64,
        /// The ticks at which a motion was used.
        ticks: usize,
        /// Of these, the ticks at which an old motion was held because no later sample had come.
        held_ticks: usize,
        /// The smallest age of any sample in use, s, wherever the ticks fall between the recorded packets.
        smallest_age: f64,
        /// The largest one, s.
        largest_age: f64,
        /// The age of the newest sample in use, s, at each of the n ticks that did not use a motion exactly as old as the
        /// delay, (n,).
        newest: Array<f64, Ix1>,
        /// The age of the oldest sample in use, s, at the same ticks, (n,).
        oldest: Array<f64, Ix1>,
    }
    computed {
        /// The share of the ticks at which the motion was exactly as old as the delay.
        in_time = |played| played.core().in_time(),
        /// The smallest and the largest age of any sample in use, s, wherever the ticks fall between the recorded packets.
        ages = |played| {
            let [low, high] = played.core().ages();
            Pair(low, high)
        },
    }
    methods {
        /// The share of the ticks at which all ages were from `low` to `high`, s.
        fn share_within(&self, low: Number, high: Number) -> Outcome<f64> {
            Ok(self.core().share_within(low.named("low")?, high.named("high")?))
        }
    }
}

impl PlayedTrace {
    /// What the core knows of a trace that was played.
    fn core(&self) -> CorePlayed {
        let late = Python::attach(|py| {
            use numpy::PyArrayMethods;
            let (newest, oldest) = (self.newest.0.bind(py).readonly(), self.oldest.0.bind(py).readonly());
            newest
                .as_array()
                .iter()
                .zip(oldest.as_array())
                .map(|(newest, oldest)| [*newest, *oldest])
                .collect()
        });
        let Self { delay, sample_period, ticks, held_ticks, smallest_age, largest_age, .. } = *self;
        CorePlayed { delay, sample_period, ticks, held_ticks, extremes: [smallest_age, largest_age], late }
    }
}

/// Two numbers of a trace that Python reads as a tuple.
struct Pair(f64, f64);

impl Value for Pair {
    fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok((self.0, self.1).into_pyobject(py)?.into_any())
    }

    fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (one, other) = value.extract()?;
        Ok(Self(one, other))
    }
}

/// A recorded trace of a network: what happened to each packet that somebody sent, in the order of sending.
///
/// `read_trace` reads one from a file.
///
/// Parameters
/// ----------
/// time : array_like
///     When each packet was sent, s; the first counts as 0.
/// delay : array_like
///     How long it took, s; NaN if it was lost.
/// losses_recorded : bool, optional
///     Whether a lost packet has a row. The default is whether one was lost.
///
/// Raises
/// ------
/// InvalidInput
///     If a time decreases, a delay is negative or above 100 s, or the packets are fewer than two, were sent all at
///     once, or never came.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> trace = ts.Trace([0.0, 0.01, 0.02, 0.03], [0.024, 0.026, float("nan"), 0.025])
/// >>> trace.statistics().loss, trace.quantile(0.5)
/// (0.25, 0.025)
/// >>> len(trace.halved()), trace.halved().quantile(1.0)
/// (4, 0.013)
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Trace(telespring::rig::Trace);

#[pymethods]
impl Trace {
    #[new]
    #[pyo3(signature = (time, delay, losses_recorded=None))]
    #[pyo3(text_signature = "(time, delay, losses_recorded=None)")]
    fn new(
        time: &Bound<'_, PyAny>,
        delay: &Bound<'_, PyAny>,
        losses_recorded: Option<Truth>,
    ) -> Outcome<Self> {
        let (time, delay) = (Numbers::read("time", time)?.row()?, Numbers::read("delay", delay)?.row()?);
        if time.len() != delay.len() {
            let allowed = format!("there are {} times", time.len());
            let remedy = "Give one delay for each packet, NaN if it was lost.";
            return Err(
                InvalidInput::new("delay", format!("{} numbers", delay.len()), allowed, remedy).into()
            );
        }
        let losses = losses_recorded.map(|given| given.named("losses_recorded")).transpose()?;
        let row = |(&time, &delay): (&f64, &f64)| {
            if delay.is_nan() {
                TraceRow { time, delay: 0.0, lost: true }
            } else {
                TraceRow { time, delay, lost: false }
            }
        };
        let trace = telespring::rig::Trace::new(time.iter().zip(&delay).map(row).collect())?;
        Ok(Self(if losses == Some(true) { trace.with_losses_recorded() } else { trace }))
    }

    /// One way of the trace in the text of a file: of a round trip half of each delay.
    #[staticmethod]
    fn _read(
        text: Argument<String>,
        name: Argument<String>,
        round_trip: Truth,
        is_forward: Truth,
    ) -> Outcome<Self> {
        let text = text.or_refuse("text", "a text is required", "Give a str.")?;
        let path = name.or_refuse("name", "a text is required", "Give a str.")?;
        let file = TraceFile { path, is_round_trip: round_trip.named("round_trip")? };
        let trace = file.trace(&text, is_forward.named("is_forward")?)?;
        Ok(Self(if file.is_round_trip { trace.halved() } else { trace }))
    }

    /// What the text of a file with a trace is: "table", "irtt" or "ping".
    #[staticmethod]
    fn _format(text: Argument<String>) -> Outcome<&'static str> {
        let text = text.or_refuse("text", "a text is required", "Give a str.")?;
        Ok(match TraceFormat::of(&text) {
            TraceFormat::Table => "table",
            TraceFormat::Irtt => "irtt",
            TraceFormat::Ping => "ping",
        })
    }

    /// When each packet was sent over the network, s, the first at 0, (n,).
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.rows().iter().map(|row| row.time).collect::<Vec<_>>().into_pyarray(py)
    }

    /// How long each packet took over the network, s, NaN if it was lost, (n,).
    #[getter]
    fn delay<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let delay = |row: &TraceRow| if row.lost { f64::NAN } else { row.delay };
        self.0.rows().iter().map(delay).collect::<Vec<_>>().into_pyarray(py)
    }

    /// Whether the network lost each packet, (n,).
    #[getter]
    fn lost<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.0.rows().iter().map(|row| row.lost).collect::<Vec<_>>().into_pyarray(py)
    }

    /// How long the network's trace is, s: to the last packet, and a median interval more.
    #[getter]
    fn duration(&self) -> f64 {
        self.0.duration()
    }

    /// Whether a packet that the network lost has a row; if not, lost packets may be missing rows.
    #[getter]
    fn losses_recorded(&self) -> bool {
        self.0.has_losses_recorded()
    }

    /// What the network's trace shows.
    fn statistics(&self) -> TraceStatistics {
        TraceStatistics(self.0.statistics())
    }

    /// The delay that this share of the packets that came over the network does not exceed, s.
    fn quantile(&self, share: Number) -> Outcome<f64> {
        let share = share.named("share")?;
        if !(0.0..=1.0).contains(&share) {
            let remedy = "Give 0.99 for 99 of 100 packets.";
            return Err(InvalidInput::new("share", share, "a share from 0 to 1", remedy).into());
        }
        Ok(self.0.quantile(share))
    }

    /// The emulator's models that fit the network's trace: constant delay, jitter and bursts of losses.
    ///
    /// The emulator draws every delay by itself: where `statistics().autocorrelation` is far from 0, the fit has the
    /// right delays, but not for as long in a row.
    fn fit(&self, py: Python<'_>) -> Outcome<TraceFit> {
        let trace = self.0.clone();
        Ok(TraceFit(apart(py, move || trace.fit())?))
    }

    /// The network's trace with half of each delay: one way of a round trip, if both ways take equally long.
    fn halved(&self) -> Self {
        Self(self.0.clone().halved())
    }

    /// The trace of a network to which a packet was sent every `period` s, where the rows of lost packets are missing.
    ///
    /// A step between two rows of more than 1.5 periods, up to `longest` s, gets a row for each packet that is missing; a
    /// longer one is a pause of the sender and is closed to one period.
    fn with_missing_rows(&self, period: Number, longest: Number) -> Outcome<Self> {
        Ok(Self(self.0.with_missing_rows(period.named("period")?, longest.named("longest")?)?))
    }

    /// Play a session once round the network's trace, which is repeated in a circle, behind a fixed play-out, as an
    /// endpoint does: a packet and a tick every `sample_period` s.
    fn play(&self, py: Python<'_>, delay: Number, sample_period: Number) -> Outcome<PlayedTrace> {
        let (delay, sample_period) = (delay.named("delay")?, sample_period.named("sample_period")?);
        let trace = self.0.clone();
        let played = apart(py, move || trace.play(delay, sample_period))??;
        let side = |at: usize| -> Array<f64, Ix1> {
            played.late.iter().map(|ages| ages[at]).collect::<Vec<_>>().into_pyarray(py).into()
        };
        let (newest, oldest) = (side(0), side(1));
        let CorePlayed { delay, sample_period, ticks, held_ticks, extremes, .. } = played;
        let [smallest_age, largest_age] = extremes;
        Ok(PlayedTrace { delay, sample_period, ticks, held_ticks, smallest_age, largest_age, newest, oldest })
    }

    /// The network's trace as a table in text, which `read_trace` and a study read.
    fn to_csv(&self) -> String {
        self.0.to_csv()
    }

    fn __len__(&self) -> usize {
        self.0.rows().len()
    }

    fn __repr__(&self) -> String {
        let shown = self.0.statistics();
        format!(
            "<Trace of {} packets in {:.4} s, {:.3} % lost, median {:.4} ms>",
            shown.sent,
            self.0.duration(),
            100.0 * shown.loss,
            1e3 * shown.median
        )
    }

    fn __getnewargs__<'py>(
        &self,
        py: Python<'py>,
    ) -> (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, bool) {
        (self.time(py), self.delay(py), self.losses_recorded())
    }

    fn _repr_html_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let shown: Bound<'py, PyDict> = self.statistics().to_dict(py)?;
        crate::records::html_table("Trace", shown.as_any())
    }
}
