//! Questions about a dyad over a network, and their answers.

use pyo3::prelude::*;
use telespring::decision as core;
use telespring::decision::Status;
use telespring::verdicts::Tier;

use crate::arguments::{Argument, Truth};
use crate::errors::Outcome;
use crate::interrupt::apart;
use crate::judged_network::JudgedNetwork;
use crate::model::{Dyad, Operator};
use crate::network::Network;
use crate::records::{Value, record, words};
use crate::verdicts::{AxisVerdict, DelayLimit, Ranges, StiffnessAllowed, Verdict, Verdicts, ranges_on};

words!(Status {
    Stable = "stable",
    Marginal = "marginal",
    NotProven = "not proven",
    Unstable = "unstable",
});

record! {
    /// What is known beside the verdicts, and counts in the answer.
    Knowledge(core::Knowledge) {
        /// Whether the axes of a robot are coupled: what the verdicts call stable is then not proven.
        has_coupled_axes,
        /// How probable it is that the constant delay is stable; None where masses and dampings have no errors.
        stable_probability,
        /// The stiffness, N/m, that is proven while the delay varies for all robots but a few; None without errors.
        varying_stiffness_limit,
        /// Whether the verdicts were asked to search an attack.
        is_attack_searched,
    }
}

record! {
    /// The answer without a playout buffer: the age of a sample varies within the jitter and the gaps.
    VaryingDelay(core::VaryingDelay) {
        /// "stable" if a tier proves it for every variation, with the reserve of stiffness and, where the robots have
        /// errors, with the least probability; "marginal" without one of these; "unstable" if one of the constant
        /// delays that the network may keep is; else "not proven".
        status,
        /// Every smaller stiffness is proven to be stable, N/m; infinite if there is no limit, 0 if no tier has a rule.
        stiffness_limit,
        /// Whether this stiffness is itself proven.
        is_attained,
        /// The largest stiffness with the reserve and, where the robots have errors, with the least probability, N/m:
        /// it is called stable.
        usable_stiffness,
        /// The tier that proves it; None if none has a rule. That of an age in a range holds where no sample is played
        /// after a newer one, as telespring's play-out does.
        tier,
        /// At this stiffness, N/m, a network was found that varies the delay so and makes the motion grow; infinite if
        /// the search found none, None if none was searched. It is simulated with the operators that allow the least.
        /// At other stiffnesses above the limit nothing is known.
        attack,
    }
    computed {
        /// The usable stiffness, N/m, as far as laboratories use one: `decide` accepts it without question.
        recommended_stiffness = |varying| varying.0.recommended_stiffness(),
    }
}

record! {
    /// The answer to a question at one stiffness.
    Decision(core::Decision) {
        /// The verdicts at the stiffness in question.
        verdicts,
        /// What is known beside them.
        known,
        /// The answer: "stable", "marginal", "not proven" or "unstable".
        status,
        /// The answer at a constant delay, which with jitter or gaps needs a playout buffer.
        constant_delay_status,
        /// Whether it stays stable with 5 % more stiffness.
        keeps_stiffness_reserve,
        /// Whether it stays stable with 5 % more delay.
        keeps_delay_reserve,
        /// The first delay at which it is unstable, the mean of both ways.
        delay_limit,
        /// The answer without a playout buffer; None if the delay does not vary.
        varying,
    }
    computed {
        /// Whether nothing that was not examined may decide: coupled axes, roots that were not counted.
        is_proven = |decision| decision.0.is_proven(),
        /// Whether it has the reserve of stiffness and delay, and is probable enough if robots have errors.
        keeps_reserve = |decision| decision.0.keeps_reserve(),
    }
}

/// What is asked about a dyad and its network, judged at any stiffness: the core of
/// `telespring.decision.question.Question`.
#[pyclass(frozen, eq, module = "telespring._core")]
#[derive(Debug, Clone, PartialEq)]
pub struct Question(core::Question);

#[pymethods]
impl Question {
    #[new]
    fn new(
        dyad: Argument<Bound<'_, Dyad>>,
        network: Argument<Bound<'_, Network>>,
        operator_range: Argument<Option<Ranges<'_>>>,
        has_playout_buffer: Truth,
        robot_springs: Argument<Option<[Option<Bound<'_, Operator>>; 2]>>,
        ages: Option<Bound<'_, JudgedNetwork>>,
    ) -> Outcome<Self> {
        let (dyad, network) = (dyad.named("dyad")?.get().0.clone(), network.named("network")?.get().0);
        let axes = dyad.axis_names().len();
        let spring = |operator: Option<Bound<'_, Operator>>| match operator {
            Some(operator) => operator.get().on(axes),
            None => Ok(telespring::Operator::free(axes)),
        };
        let robot_springs = match robot_springs.named("robot_springs")? {
            Some([first, second]) => Some([spring(first)?, spring(second)?]),
            None => None,
        };
        Ok(Self(core::Question {
            operator_ranges: ranges_on(&dyad, operator_range)?,
            has_playout_buffer: has_playout_buffer.named("has_playout_buffer")?,
            robot_springs,
            ages: ages.map(|ages| ages.get().0.clone()),
            ..core::Question::of_network(dyad, network)
        }))
    }

    /// Whether the ages of the motion in use have a bound.
    #[getter]
    fn is_bounded(&self) -> bool {
        self.0.is_bounded()
    }

    /// Whether delay, jitter and gap are all that makes the ages: a playout buffer takes them up.
    #[getter]
    fn is_as_stated(&self) -> bool {
        self.0.is_as_stated()
    }

    /// Whether the age of the motion in use varies, if nobody promises a playout buffer.
    #[getter]
    fn is_varying(&self) -> bool {
        self.0.is_varying()
    }

    /// Whether anything holds a handle besides the robot's own spring.
    #[getter]
    fn is_held(&self) -> bool {
        self.0.is_held()
    }

    /// Whether the ages in use meet the assumption of a tier, in a word.
    fn assumption<'py>(&self, py: Python<'py>, verdict: &Bound<'py, Verdict>) -> PyResult<Bound<'py, PyAny>> {
        match self.0.assumption(&verdict.get().0) {
            Some(assumption) => assumption.to_python(py),
            None => Ok(pyo3::types::PyString::intern(py, "not met").into_any()),
        }
    }

    /// The largest stiffness of the tiers whose assumption the ages in use meet; None if none of these has a rule.
    fn allowed(&self, judged: &Bound<'_, Verdicts>) -> Option<StiffnessAllowed> {
        self.0.allowed(&judged.get().0).map(StiffnessAllowed)
    }

    /// The answer that follows from the verdicts on the question and from what is known beside them.
    fn decision(
        &self,
        py: Python<'_>,
        judged: &Bound<'_, Verdicts>,
        known: &Bound<'_, Knowledge>,
    ) -> Outcome<Decision> {
        let (question, judged, known) = (self.0.clone(), judged.get().0.clone(), known.get().0);
        Ok(Decision(apart(py, move || question.decision(judged, known))??))
    }

    /// The answer without a playout buffer; None if the delay does not vary.
    fn varying(
        &self,
        py: Python<'_>,
        judged: &Bound<'_, Verdicts>,
        known: &Bound<'_, Knowledge>,
    ) -> Outcome<Option<VaryingDelay>> {
        let (question, judged, known) = (self.0.clone(), judged.get().0.clone(), known.get().0);
        Ok(apart(py, move || question.varying(&judged, &known))??.map(VaryingDelay))
    }

    /// Whether the constant delay is stable with the reserve, masses and dampings exactly known and axes independent.
    fn is_usable(&self, py: Python<'_>, judged: &Bound<'_, Verdicts>) -> Outcome<bool> {
        let (question, judged) = (self.0.clone(), judged.get().0.clone());
        Ok(apart(py, move || question.is_usable(&judged))??)
    }

    /// The first delay, the mean of both ways, that is unstable at the stiffness judged.
    fn delay_limit(&self, py: Python<'_>, judged: &Bound<'_, Verdicts>) -> Outcome<DelayLimit> {
        let (question, judged) = (self.0.clone(), judged.get().0.clone());
        Ok(DelayLimit(apart(py, move || question.delay_limit(&judged))??))
    }
}

/// Whether the constant delay is stable for every operator, sampled controllers included.
#[pyfunction]
pub fn is_stable(judged: &Bound<'_, Verdicts>) -> bool {
    core::is_stable(&judged.get().0)
}

/// The same of one axis.
#[pyfunction]
pub fn is_axis_stable(axis: &Bound<'_, AxisVerdict>) -> bool {
    core::is_axis_stable(&axis.get().0)
}

/// Whether some operator in question is unstable; if not, a search over ranges was cut off.
#[pyfunction]
pub fn is_instability_proven(judged: &Bound<'_, Verdicts>) -> bool {
    core::is_instability_proven(&judged.get().0)
}

/// The stiffness, N/m, below which every one is stable at the delay, sampled controllers included.
#[pyfunction]
pub fn stiffness_limit(judged: &Bound<'_, Verdicts>) -> f64 {
    core::stiffness_limit(&judged.get().0)
}

/// The stiffness bound, N/m, of a tier with the controllers in question; None if it has no rule for them.
#[pyfunction]
pub fn tier_stiffness_limit(judged: &Bound<'_, Verdicts>, tier: &Bound<'_, PyAny>) -> PyResult<Option<f64>> {
    Ok(core::tier_stiffness_limit(&judged.get().0, Tier::from_python(tier)?))
}

/// The delay that is judged, s: the network's, or that behind a playout buffer.
#[pyfunction]
pub fn constant_delay(judged: &Bound<'_, Verdicts>) -> (f64, f64) {
    core::constant_delay(&judged.get().0).into()
}

/// Whether a mean delay, s, is below a limit, or at one that is itself stable.
#[pyfunction]
pub fn is_within(delay: f64, limit: &Bound<'_, DelayLimit>) -> bool {
    core::is_within(delay, &limit.get().0)
}

/// The worst of some answers.
#[pyfunction]
pub fn worst_status<'py>(py: Python<'py>, statuses: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    Vec::<Status>::from_python(statuses)?.into_iter().max().to_python(py)
}
