//! The verdicts on a dyad over a network.

use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use telespring::verdicts as core;
use telespring::verdicts::{Assumption, SampledCertificate, Tier, Unavailable};

use crate::arguments::{Argument, Number};
use crate::errors::Outcome;
use crate::interrupt::apart;
use crate::model::Dyad;
use crate::network::Network;
use crate::operator_range::OperatorRange;
use crate::records::{Value, record, words};

words!(Tier {
    AnyNetwork = "any network",
    BoundedVaryingDelay = "bounded varying delay",
    AgeInRange = "age in a range",
    AnyConstantDelay = "any constant delay",
    ConstantDelay = "constant delay",
});

words!(Unavailable {
    CouplingDampingWithGroundedOperator = "coupling damping with grounded operator",
    CouplingDampingWithComputingTime = "coupling damping with computing time",
    CouplingDamping = "coupling damping",
    CouplingDampingWithSampledControllers = "coupling damping with sampled controllers",
    UnprovenOverRange = "not proven over the range",
});

words!(SampledCertificate {
    Complete = "complete",
    UpperBound = "upper bound",
    Incomplete = "incomplete",
});

impl Value for Assumption {
    fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let word = match self {
            Self::Met => "met",
            Self::MetBehindPlayoutBuffer { .. } => "met behind playout buffer",
            _ => "not met",
        };
        word.into_bound_py_any(py)
    }

    fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        match value.extract::<[f64; 2]>() {
            Ok(delay) => Ok(Self::MetBehindPlayoutBuffer { delay }),
            Err(_) => Ok(Self::Met),
        }
    }

    // the delay of the buffer, which the word does not hold
    fn to_argument<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        buffer_delay(self).map_or_else(|| self.to_python(py), |delay| delay.to_python(py))
    }
}

/// The playout buffer's delays if a verdict's assumption is met only behind one.
fn buffer_delay(assumption: &Assumption) -> Option<[f64; 2]> {
    match assumption {
        Assumption::MetBehindPlayoutBuffer { delay } => Some(*delay),
        _ => None,
    }
}

impl Value for core::Network {
    fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Network(*self).into_bound_py_any(py)
    }

    fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(value.cast::<Network>()?.get().0)
    }

    fn to_json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(Network(*self).to_dict(py)?.into_any())
    }
}

record! {
    /// One operator on one axis.
    OperatorPoint(core::OperatorPoint) {
        /// Mass, kg.
        mass,
        /// Damping, N·s/m.
        damping,
        /// Stiffness to the ground, N/m.
        stiffness,
    }
}

record! {
    /// How far a stiffness is from a bound.
    StiffnessMargin(core::StiffnessMargin) {
        /// Bound over stiffness: above 1 the stiffness is inside.
        ratio,
        /// Bound minus stiffness, N/m.
        difference,
    }
}

record! {
    /// The verdict of one tier on the whole dyad.
    Verdict(core::Verdict) {
        /// "any network", "bounded varying delay", "age in a range", "any constant delay" or "constant delay".
        tier,
        /// The largest stiffness, N/m, such that every smaller one is allowed; inf if there is no limit,
        /// None if the tier has no rule for this dyad.
        stiffness_bound,
        /// Whether that stiffness is itself allowed.
        attained,
        /// Whether the requested stiffness is proven to satisfy the rule on every axis, for every operator of the
        /// range. A constant delay may be stable above the bound, in a later stable interval.
        satisfied,
        /// Whether the search over a range of operators decided, and the bound is at most 5 % below the truth. A
        /// bound that is given holds either way.
        proven,
        /// The smallest bound found for a single pair of operators, N/m; None where none was computed.
        least_found,
        /// How far the stiffness is from the bound; None without a bound.
        margin,
        /// The axis with the smallest bound, counted from 0.
        worst_axis,
        /// The operators on that axis whose own bound is `least_found`.
        worst_operators,
        /// "met", "met behind playout buffer" or "not met": whether the network fulfils the assumption of the
        /// tier, as it is or only behind a buffer that delays every packet equally.
        assumption,
        /// Why the tier has no bound, where it has none.
        unavailable,
        /// The smallest and largest age of the partner samples in use, s, forward and backward; None but for the age in
        /// a range.
        ages,
        /// The lowest stiffness, N/m, at which an attack was seen to make the motion grow; None if none was searched or
        /// found.
        attack,
    }
    computed {
        /// The delay of that buffer, s, forward and backward: delay plus jitter plus longest gap.
        buffer_delay = |verdict| buffer_delay(&verdict.assumption),
    }
    methods {
        /// Whether the network fulfils the assumption of the verdict's tier without a buffer.
        #[getter]
        fn assumption_met(&self) -> bool {
            self.0.assumption == Assumption::Met
        }
    }
}

record! {
    /// A stiffness and the tier that allows it.
    StiffnessAllowed(core::Allowed) {
        /// Every smaller stiffness, N/m, is allowed; inf if there is no limit.
        stiffness,
        /// Whether this stiffness itself is allowed too.
        attained,
        /// The tier that allows it.
        tier,
    }
}

record! {
    /// The verdict of Du, Kulkarni, Kager and Campolo.
    PaperVerdict(core::PaperVerdict) {
        /// Critical stiffness over all axes, N/m (Eq. 11 with Eq. 5).
        critical_stiffness,
        /// The axis with that stiffness, counted from 0.
        critical_axis,
        /// Maximum delay over all axes, s (Eq. 11 with Eqs. 6 to 9); inf up to the critical stiffness.
        maximum_delay,
        /// The axis with that delay, counted from 0.
        delay_axis,
        /// Whether they call the dyad stable.
        stable,
        /// Whether the exact verdict on this constant delay is the same.
        agrees,
    }
}

record! {
    /// What the age of a partner sample consists of, one direction, s.
    DelayBudget(core::DelayBudget) {
        /// The constant part of the one-way delay.
        network,
        /// The largest additional delay of a packet.
        jitter,
        /// The longest wait for a newer sample.
        gap,
        /// One sample period, for which the force is held.
        sampling,
        /// From reading the samples to applying the force.
        computing,
    }
    computed {
        /// The sum: no partner sample in use is older.
        total = |budget| budget.0.total(),
    }
}

record! {
    /// The slowest multiplier of one axis under sampled controllers.
    SampledSpectrum(core::SampledSpectrum) {
        /// The largest abs(z), the rigid-body multiplier excluded.
        radius,
        /// ln(radius) over the sample period, 1/s: comparable with the spectral abscissa.
        abscissa_equivalent,
        /// abs(arg z) over the sample period, rad/s.
        frequency,
        /// "complete" where a count proves that no multiplier lies outside, "upper bound" where the radius only
        /// bounds them all, "incomplete" where the count ended before it could decide.
        certificate,
    }
    computed {
        /// Whether every multiplier decays: the rate decides, since the radius of a slow motion rounds to 1.
        stable = |spectrum| spectrum.0.is_stable(),
    }
}

record! {
    /// One tier on one axis.
    AxisTier(core::AxisTier) {
        /// Which tier.
        tier,
        /// The largest stiffness, N/m; None if the tier has no bound.
        stiffness_bound,
        /// Whether that stiffness is itself allowed.
        attained,
        /// Whether the requested stiffness is proven to satisfy the rule, for every operator of the range.
        satisfied,
        /// Whether the search over a range of operators decided, and the bound is at most 5 % below the truth.
        proven,
        /// The smallest bound found for a single pair of operators, N/m; None where none was computed.
        least_found,
        /// The operators with that bound.
        operators,
        /// Why the tier has no bound, where it has none.
        unavailable,
    }
}

record! {
    /// One axis in detail.
    AxisVerdict(core::AxisVerdict) {
        /// Its name.
        name,
        /// Whether an operator, or one in the range, ties a handle to the ground.
        grounded,
        /// The five tiers, the strongest guarantee first.
        tiers,
        /// Eq. 5 of the paper, N/m.
        paper_critical_stiffness,
        /// Eq. 6 of the paper, s; 0 if its Eq. 9 fails.
        paper_maximum_delay,
        /// Every shorter one-way delay, s, is stable for every operator.
        maximum_delay,
        /// Whether the search over a range of operators decided, and `maximum_delay` is at most 5 % low.
        maximum_delay_proven,
        /// The smallest end of the first stable interval found for a single pair of operators, s.
        least_maximum_delay,
        /// The slowest multiplier under sampled controllers, the worst of the operators examined; None without a
        /// sample period.
        sampled,
        /// The largest stiffness, N/m, at most the bound of tier 4, up to which the sampled dyad is stable for
        /// every operator; 0 if none is proven. With a coupling damper and a range of operators the softest springs,
        /// of at most 0.1 N/m, are not examined.
        sampled_stiffness_bound,
        /// Whether the requested stiffness is proven to be stable under sampled controllers for every operator.
        sampled_stable,
        /// Whether the search decided, over a range of operators or for one pair, and the bound is at most 5 % low.
        sampled_proven,
    }
}

record! {
    /// Single changes that each make the constant delay stable, and the sampled dyad if there is a sample period, for
    /// every operator of the range.
    Remedies(core::Remedies) {
        /// Lower the stiffness below this, N/m.
        stiffness,
        /// Bring the mean one-way delay below this, s.
        delay,
        /// Add more than this damping to each robot, N·s/m.
        damping,
    }
}

record! {
    /// The five verdicts, the paper's verdict, and what follows from them.
    ///
    /// In `to_dict` a `stiffness_bound` of None is infinite if `unavailable` is None, and absent if
    /// `unavailable` gives a reason; `worst_axis` is None only if it is absent.
    Verdicts(core::Verdicts) {
        /// The requested stiffness, N/m.
        stiffness,
        /// The network.
        network,
        /// The tiers, the strongest guarantee first.
        tiers,
        /// The bound of tier 2 from the robots' own damping, N/m: it holds for every passive operator. None
        /// with a coupling damper.
        any_passive_operator,
        /// Whether the sampled dyad is proven to be stable at this constant delay on every axis, for every operator;
        /// None without a sample period.
        sampled_stable,
        /// Whether the search over a range of operators decided; None without a sample period.
        sampled_proven,
        /// The paper's verdict.
        paper,
        /// The largest stiffness over the tiers whose assumption the network fulfils without a buffer. Tiers 3
        /// and 4 count up to the stiffness at which the sampled dyad is stable at this delay.
        stiffness_allowed,
        /// The same behind the playout buffer that makes the delay constant.
        stiffness_allowed_behind_buffer,
        /// What the age of a partner sample consists of, forward and backward.
        delay_budget,
        /// Every axis.
        axes,
        /// What to change, where tier 4 is not satisfied or the sampled dyad is not stable.
        remedies,
    }
    methods {
        /// The verdict of one tier, by its name.
        fn tier<'py>(&self, py: Python<'py>, name: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
            self.0.tier(Tier::from_python(name)?).to_python(py)
        }
    }
    repr { |verdicts| answer_in_short(&verdicts.0) }
}

/// The answer of each tier with its bound, N/m, as `repr` shows the verdicts.
fn answer_in_short(verdicts: &core::Verdicts) -> String {
    let word = |value: bool| if value { "True" } else { "False" };
    let delay = verdicts.network.delay();
    let mut out = format!(
        "<Verdicts stiffness={:?} delay=({:?}, {:?}) sample_period={:?}",
        verdicts.stiffness,
        delay.forward(),
        delay.backward(),
        verdicts.network.sample_period()
    );
    for verdict in &verdicts.tiers {
        let bound = match verdict.stiffness_bound {
            None => "no rule".to_owned(),
            Some(bound) if bound.is_infinite() => "no limit".to_owned(),
            Some(bound) => format!("limit {} N/m", four_digits_down(bound)),
        };
        let name = verdict.tier.name().replace(' ', "_");
        out += &format!(" {name}={} ({bound})", word(verdict.satisfied));
    }
    if let Some(stable) = verdicts.sampled_stable {
        let bounds = verdicts.axes.iter().filter_map(|axis| axis.sampled_stiffness_bound);
        let limit = four_digits_down(bounds.fold(f64::INFINITY, f64::min));
        out += &format!(" sampled_stable={} (limit {limit} N/m)", word(stable));
    }
    out + ">"
}

/// A limit to four digits, rounded down.
fn four_digits_down(limit: f64) -> f64 {
    if limit == 0.0 || limit.is_infinite() {
        return limit;
    }
    let scale = 10_f64.powi(3 - limit.log10().floor() as i32);
    (limit * scale).floor() / scale
}

record! {
    /// The first delay at which a dyad becomes unstable.
    DelayLimit(core::DelayLimit) {
        /// Every shorter one-way delay, s, the mean of both, is stable for every operator; inf if none destabilises.
        delay,
        /// Whether this delay itself is stable.
        attained,
        /// Whether a search over a range of operators decided, and the limit is at most 5 % and a period low.
        proven,
        /// The smallest limit found for a single pair of operators, s.
        least_found,
        /// The axis with the limit, counted from 0.
        worst_axis,
    }
}

/// One range for both operators, or one for each.
#[derive(FromPyObject)]
pub enum Ranges<'py> {
    /// The same for both.
    Both(Bound<'py, OperatorRange>),
    /// The first's and the second's.
    Each(Bound<'py, OperatorRange>, Bound<'py, OperatorRange>),
}

impl<'py> Argument<Option<Ranges<'py>>> {
    /// The ranges of the verdicts or `None`, or a refusal with this field.
    fn named(self, field: &str) -> Outcome<Option<Ranges<'py>>> {
        let allowed = "an OperatorRange, a pair of them, or None is required";
        Ok(self.or_refuse(field, allowed, "Pass OperatorRange(low, high), two operators.")?)
    }
}

/// The ranges of both operators on all axes of a dyad.
pub fn ranges_on(
    dyad: &telespring::Dyad,
    operator_range: Argument<Option<Ranges<'_>>>,
) -> Outcome<Option<[core::OperatorRange; 2]>> {
    let axes = dyad.axis_names().len();
    Ok(match &operator_range.named("operator_range")? {
        None => None,
        Some(Ranges::Both(range)) => {
            let range = range.get().on(axes).map_err(|refusal| refusal.within("operator_range"))?;
            Some([range.clone(), range])
        }
        Some(Ranges::Each(first, second)) => Some([
            first.get().on(axes).map_err(|refusal| refusal.within("operator_range[0]"))?,
            second.get().on(axes).map_err(|refusal| refusal.within("operator_range[1]"))?,
        ]),
    })
}

/// The five `Verdicts` on a dyad over a network.
#[pyfunction]
pub fn verdicts(
    py: Python<'_>,
    dyad: Argument<Bound<'_, Dyad>>,
    stiffness: Number,
    network: Argument<Bound<'_, Network>>,
    operator_range: Argument<Option<Ranges<'_>>>,
    attack_seed: Argument<Option<u64>>,
) -> Outcome<Verdicts> {
    let (dyad, network) = (dyad.named("dyad")?.get().0.clone(), network.named("network")?.get().0);
    let ranges = ranges_on(&dyad, operator_range)?;
    let stiffness = stiffness.named("stiffness")?;
    let seed = attack_seed.or_refuse(
        "attack_seed",
        "an integer from 0 to 2^64 - 1, or None, is required",
        "Pass None to search no attack.",
    )?;
    let verdicts = apart(py, move || -> telespring::Result<core::Verdicts> {
        let verdicts = core::verdicts(&dyad, ranges.as_ref(), stiffness, &network)?;
        Ok(match seed {
            Some(seed) => verdicts.with_attack(&dyad, seed),
            None => verdicts,
        })
    })??;
    Ok(Verdicts(verdicts))
}

/// The first delay at which a dyad becomes unstable.
#[pyfunction]
pub fn delay_limit(
    py: Python<'_>,
    dyad: Argument<Bound<'_, Dyad>>,
    stiffness: Number,
    network: Argument<Bound<'_, Network>>,
    operator_range: Argument<Option<Ranges<'_>>>,
) -> Outcome<DelayLimit> {
    let (dyad, network) = (dyad.named("dyad")?.get().0.clone(), network.named("network")?.get().0);
    let ranges = ranges_on(&dyad, operator_range)?;
    let stiffness = stiffness.named("stiffness")?;
    Ok(DelayLimit(apart(py, move || core::delay_limit(&dyad, ranges.as_ref(), stiffness, &network))??))
}

/// Whether a dyad is stable at every delay between two multiples of the network's.
#[pyfunction]
pub fn is_stable_over_delays(
    py: Python<'_>,
    dyad: Argument<Bound<'_, Dyad>>,
    stiffness: Number,
    network: Argument<Bound<'_, Network>>,
    factors: Argument<(f64, f64)>,
    operator_range: Argument<Option<Ranges<'_>>>,
) -> Outcome<bool> {
    let (dyad, network) = (dyad.named("dyad")?.get().0.clone(), network.named("network")?.get().0);
    let ranges = ranges_on(&dyad, operator_range)?;
    let (k, factors) = (stiffness.named("stiffness")?, factors.named("factors")?);
    Ok(apart(py, move || core::is_stable_over_delays(&dyad, ranges.as_ref(), k, &network, factors))??)
}

/// Whether a dyad is stable at every stiffness of a range.
#[pyfunction]
pub fn is_stable_over_stiffnesses(
    py: Python<'_>,
    dyad: Argument<Bound<'_, Dyad>>,
    stiffnesses: Argument<(f64, f64)>,
    network: Argument<Bound<'_, Network>>,
    operator_range: Argument<Option<Ranges<'_>>>,
) -> Outcome<bool> {
    let (dyad, network) = (dyad.named("dyad")?.get().0.clone(), network.named("network")?.get().0);
    let ranges = ranges_on(&dyad, operator_range)?;
    let stiffnesses = stiffnesses.named("stiffnesses")?;
    Ok(apart(py, move || core::is_stable_over_stiffnesses(&dyad, ranges.as_ref(), stiffnesses, &network))??)
}
