//! The four verdicts, as dictionaries that Python turns into its records.

use pyo3::prelude::*;
use telespring::verdicts as core;
use telespring::verdicts::{Assumption, SampledCertificate, Tier, Unavailable};

use crate::arguments::Number;
use crate::errors::Outcome;
use crate::model::Dyad;
use crate::study::{Network, OperatorRange};

#[derive(IntoPyObject)]
struct OperatorPoint {
    mass: f64,
    damping: f64,
    stiffness: f64,
}

impl From<core::OperatorPoint> for OperatorPoint {
    fn from(point: core::OperatorPoint) -> Self {
        Self { mass: point.mass, damping: point.damping, stiffness: point.stiffness }
    }
}

#[derive(IntoPyObject)]
struct Margin {
    ratio: f64,
    difference: f64,
}

#[derive(IntoPyObject)]
struct Verdict {
    tier: &'static str,
    stiffness_bound: Option<f64>,
    attained: bool,
    satisfied: bool,
    margin: Option<Margin>,
    worst_axis: Option<usize>,
    worst_operators: Option<(OperatorPoint, OperatorPoint)>,
    assumption: &'static str,
    buffer_delay: Option<(f64, f64)>,
    unavailable: Option<&'static str>,
}

fn pair([first, second]: [core::OperatorPoint; 2]) -> (OperatorPoint, OperatorPoint) {
    (first.into(), second.into())
}

impl From<&core::Verdict> for Verdict {
    fn from(verdict: &core::Verdict) -> Self {
        let (assumption, buffer_delay) = match verdict.assumption {
            Assumption::MetBehindPlayoutBuffer { delay } => ("met behind playout buffer", Some(delay.into())),
            Assumption::Met => ("met", None),
            _ => ("not met", None),
        };
        Self {
            tier: verdict.tier.name(),
            stiffness_bound: verdict.stiffness_bound,
            attained: verdict.attained,
            satisfied: verdict.satisfied,
            margin: verdict
                .margin
                .map(|margin| Margin { ratio: margin.ratio, difference: margin.difference }),
            worst_axis: verdict.worst_axis,
            worst_operators: verdict.worst_operators.map(pair),
            assumption,
            buffer_delay,
            unavailable: verdict.unavailable.map(|reason| match reason {
                Unavailable::CouplingDampingWithGroundedOperator => "coupling damping with grounded operator",
                Unavailable::CouplingDampingWithComputingTime => "coupling damping with computing time",
                Unavailable::CouplingDamping => "coupling damping",
                _ => "no rule",
            }),
        }
    }
}

#[derive(IntoPyObject)]
struct Allowed {
    stiffness: f64,
    attained: bool,
    tier: &'static str,
}

impl From<core::Allowed> for Allowed {
    fn from(allowed: core::Allowed) -> Self {
        Self { stiffness: allowed.stiffness, attained: allowed.attained, tier: allowed.tier.name() }
    }
}

#[derive(IntoPyObject)]
struct PaperVerdict {
    critical_stiffness: f64,
    critical_axis: usize,
    maximum_delay: f64,
    delay_axis: usize,
    stable: bool,
    agrees: bool,
}

#[derive(IntoPyObject)]
struct DelayBudget {
    network: f64,
    jitter: f64,
    gap: f64,
    sampling: f64,
    computing: f64,
    total: f64,
}

impl From<core::DelayBudget> for DelayBudget {
    fn from(budget: core::DelayBudget) -> Self {
        Self {
            network: budget.network,
            jitter: budget.jitter,
            gap: budget.gap,
            sampling: budget.sampling,
            computing: budget.computing,
            total: budget.total(),
        }
    }
}

#[derive(IntoPyObject)]
struct SampledSpectrum {
    radius: f64,
    abscissa_equivalent: f64,
    frequency: f64,
    stable: bool,
    certificate: &'static str,
}

impl From<core::SampledSpectrum> for SampledSpectrum {
    fn from(spectrum: core::SampledSpectrum) -> Self {
        Self {
            radius: spectrum.radius,
            abscissa_equivalent: spectrum.abscissa_equivalent,
            frequency: spectrum.frequency,
            stable: spectrum.is_stable(),
            certificate: match spectrum.certificate {
                SampledCertificate::Complete => "complete",
                SampledCertificate::UpperBound => "upper bound",
                _ => "incomplete",
            },
        }
    }
}

#[derive(IntoPyObject)]
struct AxisTier {
    tier: &'static str,
    stiffness_bound: Option<f64>,
    attained: bool,
    satisfied: bool,
    operators: (OperatorPoint, OperatorPoint),
}

#[derive(IntoPyObject)]
struct AxisVerdict {
    name: String,
    grounded: bool,
    tiers: Vec<AxisTier>,
    paper_critical_stiffness: f64,
    paper_maximum_delay: f64,
    maximum_delay: f64,
    sampled: Option<SampledSpectrum>,
    sampled_stiffness_bound: Option<f64>,
}

impl From<core::AxisVerdict> for AxisVerdict {
    fn from(axis: core::AxisVerdict) -> Self {
        let named = |(tier, found): (Tier, core::AxisTier)| AxisTier {
            tier: tier.name(),
            stiffness_bound: found.stiffness_bound,
            attained: found.attained,
            satisfied: found.satisfied,
            operators: pair(found.operators),
        };
        Self {
            name: axis.name,
            grounded: axis.grounded,
            tiers: Tier::ALL.into_iter().zip(axis.tiers).map(named).collect(),
            paper_critical_stiffness: axis.paper_critical_stiffness,
            paper_maximum_delay: axis.paper_maximum_delay,
            maximum_delay: axis.maximum_delay,
            sampled: axis.sampled.map(Into::into),
            sampled_stiffness_bound: axis.sampled_stiffness_bound,
        }
    }
}

#[derive(IntoPyObject)]
struct Remedies {
    stiffness: Option<f64>,
    delay: Option<f64>,
    damping: Option<f64>,
}

/// All of it, each record as a dictionary.
#[derive(IntoPyObject)]
pub struct Verdicts {
    stiffness: f64,
    network: Network,
    tiers: Vec<Verdict>,
    any_passive_operator: Option<f64>,
    sampled_stable: Option<bool>,
    paper: PaperVerdict,
    stiffness_allowed: Option<Allowed>,
    stiffness_allowed_behind_buffer: Option<Allowed>,
    delay_budget: (DelayBudget, DelayBudget),
    axes: Vec<AxisVerdict>,
    operators_examined: usize,
    remedies: Remedies,
}

impl From<core::Verdicts> for Verdicts {
    fn from(found: core::Verdicts) -> Self {
        let [forward, backward] = found.delay_budget;
        Self {
            stiffness: found.stiffness,
            network: Network(found.network),
            tiers: found.tiers.iter().map(Into::into).collect(),
            any_passive_operator: found.any_passive_operator,
            sampled_stable: found.sampled_stable,
            paper: PaperVerdict {
                critical_stiffness: found.paper.critical_stiffness,
                critical_axis: found.paper.critical_axis,
                maximum_delay: found.paper.maximum_delay,
                delay_axis: found.paper.delay_axis,
                stable: found.paper.stable,
                agrees: found.paper.agrees,
            },
            stiffness_allowed: found.stiffness_allowed.map(Into::into),
            stiffness_allowed_behind_buffer: found.stiffness_allowed_behind_buffer.map(Into::into),
            delay_budget: (forward.into(), backward.into()),
            axes: found.axes.into_iter().map(Into::into).collect(),
            operators_examined: found.operators_examined,
            remedies: Remedies {
                stiffness: found.remedies.stiffness,
                delay: found.remedies.delay,
                damping: found.remedies.damping,
            },
        }
    }
}

/// One range for both operators, or one each.
#[derive(FromPyObject)]
pub enum Ranges<'py> {
    /// The same for both.
    Both(Bound<'py, OperatorRange>),
    /// The first's and the second's.
    Each(Bound<'py, OperatorRange>, Bound<'py, OperatorRange>),
}

/// The four verdicts on a dyad over a network.
#[pyfunction]
pub fn verdicts(
    py: Python<'_>,
    dyad: &Bound<'_, Dyad>,
    stiffness: Number,
    network: &Bound<'_, Network>,
    operator_range: Option<Ranges<'_>>,
) -> Outcome<Verdicts> {
    let stiffness = stiffness.named("stiffness")?;
    let (dyad, network) = (&dyad.get().0, &network.get().0);
    let axes = dyad.axis_names().len();
    let ranges = match &operator_range {
        None => None,
        Some(Ranges::Both(range)) => {
            let range = range.get().on(axes).map_err(|refusal| refusal.within("operator_range"))?;
            Some([range.clone(), range])
        }
        Some(Ranges::Each(first, second)) => Some([
            first.get().on(axes).map_err(|refusal| refusal.within("operator_range[0]"))?,
            second.get().on(axes).map_err(|refusal| refusal.within("operator_range[1]"))?,
        ]),
    };
    py.detach(|| Ok(core::verdicts(dyad, ranges.as_ref(), stiffness, network)?.into()))
}
