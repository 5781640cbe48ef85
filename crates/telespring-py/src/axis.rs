//! One axis of a dyad, and where its characteristic roots cross the imaginary axis.

use numpy::{IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use rayon::prelude::*;
use telespring::prediction::Prediction;
use telespring::quantity::{DELAY, STIFFNESS};
use telespring::{InvalidInput, Result, Side, criteria, spectrum, verdicts};

use crate::arguments::{Argument, Count, DelayChoice, Number};
use crate::arrays::{Numbers, labelled_map, over_arrays};
use crate::errors::Outcome;
use crate::interrupt::{apart, in_parallel};
use crate::records::record;
use crate::spectrum::{Spectrum, warn};

record! {
    /// A pair of characteristic roots on the imaginary axis; unpacks as (delay, frequency, direction).
    Crossing(criteria::Crossing) as tuple {
        /// The smallest one-way delay at which the pair is there, s; it returns every π/frequency.
        delay,
        /// Where it meets the axis, rad/s.
        frequency,
        /// +1 if the pair leaves the stable half-plane as the delay grows, -1 if it returns, 0 if it
        /// only touches.
        direction,
    }
}

/// One axis of a dyad: masses, dampings and what ties the handles to the ground, operators added to the robots.
///
/// ``dyad.axis("x")`` or ``dyad["x"]`` returns it, and the criteria are its methods; stiffnesses are in N/m,
/// one-way delays in s (their mean if both ways differ).
///
/// Parameters
/// ----------
/// m1, b1, m2, b2 : float
///     Masses, kg, and viscous dampings, N·s/m, of robot and operator together.
/// kh1, kh2 : float
///     Stiffness of each operator to the ground, N/m; 0 is a free handle.
/// c : float
///     Damping in parallel with the virtual spring, N·s/m.
/// name : str
///     The name of the axis.
/// index : int
///     Its place in the dyad, counted from 0.
///
/// Raises
/// ------
/// InvalidInput
///     If a value is out of its range.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> axis = ts.hman()["x"]
/// >>> round(axis.critical_stiffness(), 3), round(axis.maximum_delay(71.232), 4)
/// (35.616, 0.1672)
/// >>> axis.maximum_delay([20.0, 30.0])
/// array([inf, inf])
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct DyadAxis {
    /// As the dyad names it.
    pub name: String,
    /// Counted from 0.
    pub index: usize,
    /// Both sides and the coupling damper.
    pub axis: telespring::DyadAxis,
}

/// Whether `method` asks for the paper's formula.
pub fn is_paper(method: &Argument<String>) -> Result<bool> {
    let text = match method {
        Argument::Given(name) if name == "exact" => return Ok(false),
        Argument::Given(name) if name == "paper" => return Ok(true),
        Argument::Given(name) => format!("{name:?}"),
        Argument::Other(text) => text.clone(),
    };
    let allowed = "the methods are \"exact\" and \"paper\"";
    Err(InvalidInput::new("method", text, allowed, "Omit it for \"exact\"."))
}

/// The critical stiffness of a Python axis, N/m, exact or by Eq. 5 of the paper.
pub fn critical_stiffness(axis: &telespring::DyadAxis, paper: bool) -> Result<f64> {
    if paper { criteria::paper_critical_stiffness(axis) } else { Ok(criteria::critical_stiffness(axis)) }
}

/// The maximum delay of a Python axis, s, exact or by Eqs. 5 to 9 of the paper.
pub fn maximum_delay(axis: &telespring::DyadAxis, k: f64, paper: bool) -> Result<f64> {
    let k = STIFFNESS.check("k", k)?;
    if paper { criteria::paper_maximum_delay(axis, k) } else { criteria::maximum_delay(axis, k) }
}

/// The maximum stiffness of a Python axis, N/m.
pub fn maximum_stiffness(axis: &telespring::DyadAxis, delay: f64) -> Result<f64> {
    criteria::maximum_stiffness(axis, DELAY.check("delay", delay)?)
}

/// The damping to add to a Python axis, N·s/m.
pub fn minimum_damping(axis: &telespring::DyadAxis, k: f64, delay: f64) -> Result<f64> {
    criteria::minimum_damping(axis, STIFFNESS.check("k", k)?, DELAY.check("delay", delay)?)
}

/// How many roots of a Python axis lie in the right half-plane.
pub fn unstable_root_count(axis: &telespring::DyadAxis, k: f64, delay: f64) -> Result<i64> {
    criteria::unstable_root_count(axis, STIFFNESS.check("k", k)?, DELAY.check("delay", delay)?).map(i64::from)
}

/// Elements of a stability map that one thread takes at a time, about.
const PIECE: usize = 1 << 14;

/// Whether each pair of stiffness and delay is stable on all these Python axes, a row per stiffness.
pub fn stability_map<'py>(
    py: Python<'py>,
    axes: &[telespring::DyadAxis],
    k: &Numbers<'py>,
    delay: &Numbers<'py>,
    prediction: Option<&Prediction>,
) -> Outcome<Bound<'py, PyAny>> {
    let named = (k, delay);
    let (k, delay) = (k.row()?, delay.row()?);
    let shape = [k.len(), delay.len()];
    for (i, &value) in k.iter().enumerate() {
        STIFFNESS.check(&format!("k[{i}]"), value)?;
    }
    for (i, &value) in delay.iter().enumerate() {
        DELAY.check(&format!("delay[{i}]"), value)?;
    }
    let rows = (PIECE / delay.len().max(1)).clamp(1, 16);
    let stable = in_parallel(py, |stop| -> Result<Vec<bool>> {
        let mut stable = vec![true; shape[0] * shape[1]];
        let block = |(k, stable): (&[f64], &mut [bool])| {
            for (start, delay) in delay.chunks(PIECE).enumerate().map(|(i, delay)| (i * PIECE, delay)) {
                for axis in axes {
                    if stop.is_set() {
                        return Ok(());
                    }
                    let here = match prediction {
                        None => criteria::stability_map(axis, k, delay)?,
                        Some(prediction) => criteria::predicted_stability_map(axis, prediction, k, delay)?,
                    };
                    for (row, here) in stable.chunks_exact_mut(shape[1]).zip(here.chunks_exact(delay.len())) {
                        row[start..].iter_mut().zip(here).for_each(|(all, here)| *all &= here);
                    }
                }
            }
            Ok(())
        };
        k.par_chunks(rows).zip(stable.par_chunks_mut((rows * shape[1]).max(1))).try_for_each(block)?;
        Ok(stable)
    })??;
    Ok(labelled_map(stable.into_pyarray(py).reshape(shape)?.into_any(), named.0, named.1)?)
}

#[pymethods]
impl DyadAxis {
    #[new]
    #[pyo3(
        signature = (m1, b1, m2, b2, *, kh1=Number::Given(0.0), kh2=Number::Given(0.0), c=Number::Given(0.0),
                     name=Argument::Given("x".to_owned()), index=Argument::Given(0)),
        text_signature = "(m1, b1, m2, b2, *, kh1=0.0, kh2=0.0, c=0.0, name='x', index=0)"
    )]
    #[expect(clippy::too_many_arguments, reason = "seven numbers describe an axis")]
    fn new(
        m1: Number,
        b1: Number,
        m2: Number,
        b2: Number,
        kh1: Number,
        kh2: Number,
        c: Number,
        name: Argument<String>,
        index: Argument<usize>,
    ) -> Outcome<Self> {
        let (name, index) = (name.named("name")?, index.named("index")?);
        let side = |mass, damping, ground_stiffness| Side { mass, damping, ground_stiffness };
        let axis = telespring::DyadAxis {
            sides: [
                side(m1.named("m1")?, b1.named("b1")?, kh1.named("kh1")?),
                side(m2.named("m2")?, b2.named("b2")?, kh2.named("kh2")?),
            ],
            coupling_damping: c.named("c")?,
        };
        axis.check()?;
        Ok(Self { name, index, axis })
    }

    /// The name of the axis.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// Place of the axis in the dyad, counted from 0.
    #[getter]
    fn index(&self) -> usize {
        self.index
    }

    /// Mass of robot and operator on side 1 and 2, kg.
    #[getter]
    fn masses(&self) -> (f64, f64) {
        self.axis.sides.map(|side| side.mass).into()
    }

    /// Viscous damping of robot and operator on side 1 and 2, N·s/m.
    #[getter]
    fn dampings(&self) -> (f64, f64) {
        self.axis.sides.map(|side| side.damping).into()
    }

    /// Stiffness of each operator to the ground, N/m; 0 is a free handle.
    #[getter]
    fn ground_stiffness(&self) -> (f64, f64) {
        self.axis.sides.map(|side| side.ground_stiffness).into()
    }

    /// The damper in parallel with the virtual spring, N·s/m.
    #[getter]
    fn coupling_damping(&self) -> f64 {
        self.axis.coupling_damping
    }

    /// The axis' m1, b1, m2, b2 in kg and N·s/m.
    #[getter]
    fn parameters(&self) -> (f64, f64, f64, f64) {
        let [first, second] = self.axis.sides;
        (first.mass, first.damping, second.mass, second.damping)
    }

    /// The axis' other three numbers, kh1, kh2 (N/m) and c (N·s/m), as keyword arguments.
    #[getter]
    fn keywords<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let [first, second] = self.axis.sides;
        let out = PyDict::new(py);
        out.set_item("kh1", first.ground_stiffness)?;
        out.set_item("kh2", second.ground_stiffness)?;
        out.set_item("c", self.axis.coupling_damping)?;
        Ok(out)
    }

    /// Whether both handles are free and there is no coupling damper: all that the paper's formulas cover.
    #[getter]
    fn is_plain(&self) -> bool {
        self.axis.is_free() && self.axis.coupling_damping == 0.0
    }

    /// Stiffness below which no constant delay destabilises, N/m; see `telespring.critical_stiffness`.
    #[pyo3(signature = (method=Argument::Given("exact".to_owned())), text_signature = "($self, method='exact')")]
    fn critical_stiffness(&self, method: Argument<String>) -> Outcome<f64> {
        Ok(critical_stiffness(&self.axis, is_paper(&method)?)?)
    }

    /// Smallest one-way delay at which stability is lost, s; see `telespring.maximum_delay`.
    #[pyo3(signature = (k, method=Argument::Given("exact".to_owned())), text_signature = "($self, k, method='exact')")]
    fn maximum_delay<'py>(
        &self,
        k: &Bound<'py, PyAny>,
        method: Argument<String>,
    ) -> Outcome<Bound<'py, PyAny>> {
        let paper = is_paper(&method)?;
        over_arrays(k.py(), &[Numbers::read("k", k)?], |row| maximum_delay(&self.axis, row[0], paper))
    }

    /// Stiffness below which every stiffness is stable at this delay, N/m; see `telespring.maximum_stiffness`.
    fn maximum_stiffness<'py>(&self, delay: &Bound<'py, PyAny>) -> Outcome<Bound<'py, PyAny>> {
        over_arrays(delay.py(), &[Numbers::read("delay", delay)?], |row| {
            maximum_stiffness(&self.axis, row[0])
        })
    }

    /// Smallest damping, added to both robots, above which every larger one is stable, N·s/m; see
    /// `telespring.minimum_damping`.
    fn minimum_damping<'py>(
        &self,
        k: &Bound<'py, PyAny>,
        delay: &Bound<'py, PyAny>,
    ) -> Outcome<Bound<'py, PyAny>> {
        over_arrays(k.py(), &[Numbers::read("k", k)?, Numbers::read("delay", delay)?], |row| {
            minimum_damping(&self.axis, row[0], row[1])
        })
    }

    /// Number of characteristic roots in the right half-plane; see `telespring.unstable_root_count`.
    fn unstable_root_count<'py>(
        &self,
        k: &Bound<'py, PyAny>,
        delay: &Bound<'py, PyAny>,
    ) -> Outcome<Bound<'py, PyAny>> {
        over_arrays(k.py(), &[Numbers::read("k", k)?, Numbers::read("delay", delay)?], |row| {
            unstable_root_count(&self.axis, row[0], row[1])
        })
    }

    /// Whether a stiffness is stable at a delay.
    fn is_stable<'py>(&self, k: &Bound<'py, PyAny>, delay: &Bound<'py, PyAny>) -> Outcome<Bound<'py, PyAny>> {
        over_arrays(k.py(), &[Numbers::read("k", k)?, Numbers::read("delay", delay)?], |row| {
            let (k, delay) = (STIFFNESS.check("k", row[0])?, DELAY.check("delay", row[1])?);
            Ok(criteria::stability_map(&self.axis, &[k], &[delay])?[0])
        })
    }

    /// Whether every stiffness is stable at every delay, a row per stiffness; see `telespring.stability_map`.
    fn stability_map<'py>(
        &self,
        py: Python<'py>,
        k: &Bound<'py, PyAny>,
        delay: &Bound<'py, PyAny>,
    ) -> Outcome<Bound<'py, PyAny>> {
        stability_map(py, &[self.axis], &Numbers::read("k", k)?, &Numbers::read("delay", delay)?, None)
    }

    /// Every crossing of the imaginary axis; see `telespring.crossings`.
    fn crossings(&self, py: Python<'_>, k: Number) -> Outcome<Vec<Crossing>> {
        let k = STIFFNESS.check("k", k.named("k")?)?;
        let axis = self.axis;
        Ok(apart(py, move || criteria::crossings(&axis, k))??.iter().copied().map(Crossing).collect())
    }

    /// Intervals of stable one-way delays up to a horizon, s; see `telespring.stable_delays`.
    #[pyo3(signature = (k, horizon=Number::Given(DELAY.maximum())), text_signature = "($self, k, horizon=100.0)")]
    fn stable_delays(&self, py: Python<'_>, k: Number, horizon: Number) -> Outcome<Vec<(f64, f64)>> {
        let (k, horizon) = (STIFFNESS.check("k", k.named("k")?)?, horizon.named("horizon")?);
        let axis = self.axis;
        Ok(apart(py, move || criteria::stable_delays(&axis, k, horizon))??)
    }

    /// Intervals of stable one-way delays under sampled controllers, s, each open at its start and closed at its end.
    ///
    /// A delay is the mean of both ways, which keep the proportion of `delay`; each way counts in whole sample
    /// periods (s), rounded up, as the controllers use it.
    #[pyo3(
        signature = (k, sample_period, computing_time=Number::Given(0.0), delay=DelayChoice::EachWay(0.0),
                     horizon=Number::Given(DELAY.maximum())),
        text_signature = "($self, k, sample_period, computing_time=0.0, delay=0.0, horizon=100.0)"
    )]
    fn sampled_stable_delays(
        &self,
        py: Python<'_>,
        k: Number,
        sample_period: Number,
        computing_time: Number,
        delay: DelayChoice,
        horizon: Number,
    ) -> Outcome<Vec<(f64, f64)>> {
        let (k, horizon) = (STIFFNESS.check("k", k.named("k")?)?, horizon.named("horizon")?);
        let period = sample_period.named("sample_period")?;
        let computing = computing_time.named("computing_time")?;
        let network = verdicts::Network::new(delay.check()?, 0.0, 0.0, period, computing)?;
        let axis = self.axis;
        Ok(apart(py, move || verdicts::sampled_stable_delays(&axis, k, &network, horizon))??)
    }

    /// The largest stiffness, N/m, that is stable on every network that keeps the age of each partner sample in a range (s)
    /// and plays none after a newer one, under continuous controllers.
    ///
    /// `forward` is the smallest and largest age of the samples of robot 1 that act on robot 2, `backward` the other way;
    /// the same if it is left out. See `telespring.verdicts` for sampled controllers and ranges of operators.
    #[pyo3(signature = (forward, backward=Argument::Given(None)), text_signature = "($self, forward, backward=None)")]
    fn age_range_stiffness(
        &self,
        py: Python<'_>,
        forward: Argument<(f64, f64)>,
        backward: Argument<Option<(f64, f64)>>,
    ) -> Outcome<f64> {
        let allowed = "the smallest and the largest age, two numbers of seconds, are required";
        let forward = forward.or_refuse("forward", allowed, "Pass a pair, such as (0.08, 0.12).")?;
        let backward = backward.or_refuse("backward", allowed, "Pass a pair, or leave it out.")?;
        let backward = backward.unwrap_or(forward);
        let range = |(least, greatest): (f64, f64), field: &str| {
            verdicts::AgeRange::new(least, greatest).map_err(|refusal| refusal.within(field))
        };
        let ages = [range(backward, "backward")?, range(forward, "forward")?];
        let axis = self.axis;
        Ok(apart(py, move || verdicts::age_range_stiffness(&axis, &ages))??.stiffness)
    }

    /// Ranges of stiffness with at least this decay rate (1/s), N/m; see `telespring.decay_stiffness`.
    fn decay_stiffness(&self, py: Python<'_>, delay: Number, decay_rate: Number) -> Outcome<Vec<(f64, f64)>> {
        let (delay, rate) = (DELAY.check("delay", delay.named("delay")?)?, decay_rate.named("decay_rate")?);
        let axis = self.axis;
        Ok(apart(py, move || criteria::decay_stiffness(&axis, delay, rate))??)
    }

    /// Largest real part of the characteristic roots but s = 0, 1/s; see `telespring.spectral_abscissa`.
    fn spectral_abscissa(&self, py: Python<'_>, k: Number, delay: DelayChoice) -> Outcome<f64> {
        let (k, delay) = (k.named("k")?, delay.check()?);
        let axis = self.axis;
        let abscissa = apart(py, move || spectrum::spectral_abscissa(&axis, k, &delay))??;
        warn(py, "abscissa's", &abscissa.certificate)?;
        Ok(abscissa.value)
    }

    /// The rightmost characteristic roots, 1/s; see `telespring.characteristic_roots`.
    #[pyo3(signature = (k, delay, count=Count::Given(8)), text_signature = "($self, k, delay, count=8)")]
    fn characteristic_roots<'py>(
        &self,
        py: Python<'py>,
        k: Number,
        delay: DelayChoice,
        count: Count,
    ) -> Outcome<Bound<'py, PyArray1<num_complex::Complex64>>> {
        let (k, delay, count) = (k.named("k")?, delay.check()?, count.check()?);
        let axis = self.axis;
        let roots = apart(py, move || spectrum::characteristic_roots(&axis, k, &delay, count))??;
        warn(py, "roots'", &roots.certificate)?;
        Ok(roots.roots.into_pyarray(py))
    }

    /// The rightmost characteristic roots with their certificate; see `telespring.certified_roots`.
    #[pyo3(signature = (k, delay, count=Count::Given(8)), text_signature = "($self, k, delay, count=8)")]
    fn certified_roots(
        &self,
        py: Python<'_>,
        k: Number,
        delay: DelayChoice,
        count: Count,
    ) -> Outcome<Spectrum> {
        let (k, delay, count) = (k.named("k")?, delay.check()?, count.check()?);
        let axis = self.axis;
        let roots = apart(py, move || spectrum::characteristic_roots(&axis, k, &delay, count))??;
        Ok(Spectrum::of(py, roots))
    }

    /// The attributes as a dict that `json.dumps` takes.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        out.set_item("name", &self.name)?;
        out.set_item("index", self.index)?;
        out.set_item("masses", self.axis.sides.map(|side| side.mass).to_vec())?;
        out.set_item("dampings", self.axis.sides.map(|side| side.damping).to_vec())?;
        out.set_item("ground_stiffness", self.axis.sides.map(|side| side.ground_stiffness).to_vec())?;
        out.set_item("coupling_damping", self.axis.coupling_damping)?;
        Ok(out)
    }

    fn __repr__(&self) -> String {
        let [first, second] = self.axis.sides;
        format!(
            "DyadAxis({:?}, {:?}, {:?}, {:?}, kh1={:?}, kh2={:?}, c={:?}, name='{}', index={})",
            first.mass,
            first.damping,
            second.mass,
            second.damping,
            first.ground_stiffness,
            second.ground_stiffness,
            self.axis.coupling_damping,
            self.name,
            self.index
        )
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        (self.parameters(), &self.name, self.index).into_pyobject(py)?.hash()
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        let keywords = self.keywords(py)?;
        keywords.set_item("name", &self.name)?;
        keywords.set_item("index", self.index)?;
        Ok((self.parameters().into_pyobject(py)?, keywords))
    }
}
