"""The answer of `telespring decide --json`: SI units, and None for what is infinite or does not exist."""

from __future__ import annotations

import math
from typing import Any

from telespring._core import RESERVE, tier_stiffness_limit
from telespring._json import finite_or_none
from telespring.decision.arm_stability import ArmStability
from telespring.decision.changes import Changes
from telespring.decision.decide import AxisDecision, Decision
from telespring.decision.limits import DelayLimits
from telespring.decision.uncertainty import AxisUncertainty, MarginUncertainty
from telespring.decision.varying_delay import VaryingDelay
from telespring.show.screens.ages import ages_notes
from telespring.show.screens.arms import describe_unavailable_arms
from telespring.show.screens.robots import robot_notes
from telespring.show.tiers import TIERS
from telespring.theory.verdicts import DelayBudget, StiffnessAllowed, Verdict, Verdicts

__all__ = [
    "arm_stability_json",
    "decision_json",
    "network_json",
    "sampled_bound_json",
    "uncertainty_json",
    "varying_json",
]


def decision_json(decision: Decision) -> dict[str, Any]:
    """Return what `docs/study-json.md` lists for `telespring decide --json`."""
    verdicts, allowed = decision.verdicts, _stiffness_allowed(decision)
    forward, backward = decision.delay
    constant_forward, constant_backward = decision.constant_delay
    return {
        "stiffness": decision.stiffness,
        "delay": {"forward": forward, "backward": backward, "mean": 0.5 * (forward + backward)},
        "constant_delay": {
            "forward": constant_forward,
            "backward": constant_backward,
            "mean": decision.mean_delay,
            "buffered": decision.buffered,
            "status": decision.constant_delay_status,
        },
        "playout_buffer": decision.has_playout_buffer,
        "network": network_json(decision),
        "varying_delay": varying_json(decision.varying),
        "status": decision.status,
        "stable": decision.stable,
        "reserve": {
            "required": RESERVE,
            "stiffness_kept": decision.keeps_stiffness_reserve,
            "delay_kept": decision.keeps_delay_reserve,
        },
        "sample_period": verdicts.network.sample_period,
        "worst_axis": decision.worst_axis.name,
        "horizon": decision.horizon,
        "axes": [_decision_axis_json(axis) for axis in decision.axes],
        "verdicts": {text.key: _decision_verdict_json(decision, name) for name, text in TIERS.items()},
        "stiffness_allowed": None if allowed is None else finite_or_none(allowed.stiffness),
        "stiffness_allowed_unbounded": allowed is not None and math.isinf(allowed.stiffness),
        "stiffness_allowed_attained": allowed is not None and allowed.attained,
        "allowing_verdict": None if allowed is None else allowed.tier,
        "paper_agrees": verdicts.paper.agrees,
        "sampled_stable": verdicts.sampled_stable,
        "over_operator_ranges": decision.over_operator_ranges,
        "delay_budget": {
            direction: _delay_budget_json(budget)
            for direction, budget in zip(("forward", "backward"), verdicts.delay_budget, strict=True)
        },
        "remedies": {
            "stiffness": finite_or_none(decision.stiffness_limit),
            "stiffness_unbounded": math.isinf(decision.stiffness_limit),
            "delay": finite_or_none(decision.delay_limit),
            "delay_unbounded": math.isinf(decision.delay_limit),
            "delay_attained": decision.delay_limit_attained,
            "delay_proven": decision.delay_limit_proven,
            "added_damping": finite_or_none(decision.added_damping),
        },
        "changes": None if decision.changes is None else _changes_json(decision.changes),
        "guarantees": [
            {
                "verdict": each.tier,
                "stiffness": each.stiffness,
                "needs_buffer": each.needs_buffer,
                "is_proven_now": each.is_proven_now,
            }
            for each in decision.guarantees
        ],
        "decay": None
        if decision.decay_rate is None
        else {
            "rate": decision.decay_rate,
            "stiffness": [[low, finite_or_none(high)] for low, high in decision.decay_stiffness],
        },
        "uncertainty": None if decision.uncertainty is None else uncertainty_json(decision.uncertainty),
        "axes_independent": decision.axes_independent,
        "warnings": [*ages_notes(decision.question.ages, decision.question.stated), *robot_notes(decision)],
        "free": None if decision.free is None else decision_json(decision.free),
        "in_arms": None if decision.arms is None else arm_stability_json(decision.arms),
    }


def _stiffness_allowed(decision: Decision) -> StiffnessAllowed | None:
    """Return the largest stiffness of the tiers whose assumption the ages in use meet."""
    question = decision.question
    return None if question.unjudged else question.core.allowed(decision.verdicts)


def network_json(found: Decision | DelayLimits) -> dict[str, Any]:
    """Return `network` of `telespring decide --json`: as stated, and what of it was judged."""
    ages = found.question.ages
    is_all_stated = ages is None or (
        ages.is_as_stated
        and not (ages.sources or ages.unjudged or ages.has_computing_tick or ages.is_guard_predicted)
    )
    judged = None if ages is None or is_all_stated else ages.to_dict()
    return {"stated": found.question.network_as_stated.to_dict(), "judged": judged}


def _changes_json(changes: Changes) -> dict[str, Any]:
    delay = changes.delay
    return {
        "varying_stiffness": changes.varying_stiffness,
        "is_buffer_enough": changes.is_buffer_enough,
        "stiffness": changes.stiffness,
        "delay": None if delay is None else {"forward": delay[0], "backward": delay[1]},
        "added_damping": changes.added_damping,
        "sample_period": changes.sample_period,
    }


def varying_json(varying: VaryingDelay | None) -> dict[str, Any] | None:
    """Return `varying_delay` of `telespring decide --json`."""
    if varying is None:
        return None
    return {
        "status": varying.status,
        "stiffness_limit": finite_or_none(varying.stiffness_limit),
        "stiffness_unbounded": math.isinf(varying.stiffness_limit),
        "attained": varying.is_attained,
        "usable_stiffness": finite_or_none(varying.usable_stiffness),
        "recommended_stiffness": varying.recommended_stiffness,
        "verdict": varying.tier,
        "attack": None if varying.attack is None else {"stiffness": finite_or_none(varying.attack)},
    }


def _decision_axis_json(axis: AxisDecision) -> dict[str, Any]:
    own = axis.worst_case
    return {
        "axis": axis.name,
        "operators": [
            {"mass": each.mass, "damping": each.damping, "stiffness": each.stiffness}
            for each in own.operators
        ],
        "critical_stiffness": finite_or_none(axis.critical_stiffness),
        "critical_stiffness_unbounded": math.isinf(axis.critical_stiffness),
        "critical_stiffness_paper": finite_or_none(own.critical_stiffness_paper),
        "maximum_delay": finite_or_none(axis.maximum_delay),
        "maximum_delay_unbounded": math.isinf(axis.maximum_delay),
        "maximum_delay_proven": axis.verdict.maximum_delay_proven,
        "least_maximum_delay": finite_or_none(axis.verdict.least_maximum_delay),
        "maximum_delay_paper": finite_or_none(own.maximum_delay_paper),
        "maximum_delay_paper_unbounded": math.isinf(own.maximum_delay_paper),
        "maximum_stiffness": finite_or_none(axis.maximum_stiffness),
        "maximum_stiffness_unbounded": math.isinf(axis.maximum_stiffness),
        "stable_delays": [list(interval) for interval in own.stable_delays],
        "sampled_proven": axis.verdict.sampled_proven,
        "sampled_stable_delays": None
        if own.sampled_stable_delays is None
        else [[start, finite_or_none(end)] for start, end in own.sampled_stable_delays],
        "spectral_abscissa": finite_or_none(own.spectral_abscissa),
        "sampled_abscissa": None if axis.sampled_abscissa is None else finite_or_none(axis.sampled_abscissa),
        "crossings": [
            {"delay": crossing.delay, "frequency": crossing.frequency, "direction": crossing.direction}
            for crossing in own.crossings
        ],
        "stable": axis.stable,
    }


def _decision_verdict_json(decision: Decision, name: str) -> dict[str, Any]:
    axes = [axis.name for axis in decision.axes]
    constant, paper = decision.verdicts.tier("constant delay"), decision.verdicts.paper
    if name == "paper":
        bound: float | None = paper.critical_stiffness
        axis: int | None = paper.critical_axis
        attained, satisfied, tier = True, paper.stable, constant
    else:
        tier = _decision_tier_json(decision, name)
        bound, attained, axis, satisfied = (
            tier.stiffness_bound,
            tier.attained,
            tier.worst_axis,
            tier.satisfied,
        )
    assumption = decision.question.core.assumption(tier)
    return {
        "name": name,
        "network": TIERS[name].network,
        "rule": TIERS[name].rule,
        "stiffness_allowed": None if bound is None else finite_or_none(bound),
        "stiffness_unbounded": bound is not None and math.isinf(bound),
        "attained": attained,
        **({} if name == "paper" else sampled_bound_json(tier, decision.verdicts)),
        "axis": None if axis is None else axes[axis],
        "satisfied": satisfied,
        **({} if name == "paper" else {"proven": tier.proven}),
        "assumption_met": assumption == "met",
        "assumption": assumption,
        "available": bound is not None,
        **({} if name == "paper" else {"unavailable": tier.unavailable}),
        **({} if name == "paper" or tier.ages is None else {"ages": [list(ages) for ages in tier.ages]}),
    }


def sampled_bound_json(tier: Verdict, judged: Verdicts) -> dict[str, Any]:
    """Return which controllers the bound of a tier is for, and the bound with those in question.

    `stiffness_allowed` of one constant delay is that of continuous controllers, even where those in question
    sample.
    """
    is_continuous = tier.tier in ("any constant delay", "constant delay")
    is_sampled = judged.sampled_stable is not None
    bound = tier_stiffness_limit(judged, tier.tier)
    return {
        "controllers": "sampled" if is_sampled and not is_continuous else "continuous",
        "stiffness_limit": None if bound is None else finite_or_none(bound),
    }


def _decision_tier_json(decision: Decision, name: str) -> Verdict:
    return next(tier for tier in decision.verdicts.tiers if tier.tier == name)


def _delay_budget_json(budget: DelayBudget) -> dict[str, float]:
    names = ("network", "jitter", "gap", "sampling", "computing", "total")
    return {name: getattr(budget, name) for name in names}


def uncertainty_json(known: MarginUncertainty) -> dict[str, Any]:
    """Return `uncertainty` of `telespring decide --json`."""
    stable = known.stable
    return {
        "stable_probability": {
            "value": stable.value,
            "standard_error": stable.standard_error,
            "draws": stable.draws,
        },
        "axes": [_axis_uncertainty_json(axis) for axis in known.axes],
        "worst": _axis_uncertainty_json(known.worst),
    }


def _axis_uncertainty_json(axis: AxisUncertainty) -> dict[str, Any]:
    return {
        "axis": axis.axis,
        "critical_stiffness_interval": list(axis.critical_stiffness),
        "maximum_delay_interval": [finite_or_none(end) for end in axis.maximum_delay],
        "maximum_delay_unbounded_probability": axis.delay_unbounded,
    }


def arm_stability_json(arms: ArmStability) -> dict[str, Any]:
    """Return `in_arms` of `telespring decide --json`, the verdict on one condition."""
    reason = describe_unavailable_arms(arms)
    if arms.operators is None:
        return {"known": False, "reason": reason}
    (condition,) = arms.conditions
    operators, poses = arms.operators, arms.poses
    axes, position = condition.unstable_axes, condition.worst_position
    return {
        "known": True,
        "reason": reason,
        "agent_stiffness": list(operators.agent_stiffness),
        "agent_damping": list(operators.agent_damping),
        "arm_mass": [list(masses) for masses in operators.arm_mass],
        "arm_damping": [list(dampings) for dampings in operators.arm_damping],
        "depends_on_pose": poses is not None,
        "stable": condition.stable,
        "unstable_axes": None if axes is None else list(axes),
        "spectral_abscissa": condition.spectral_abscissa,
        "independent_abscissa": condition.independent_abscissa,
        "poses": None if poses is None else len(poses.positions),
        "unstable_poses": condition.unstable_poses,
        "worst_position": None if position is None else list(position),
        "axes_independent": poses is None or poses.axes_are_independent,
        "cross_inertia": [0.0, 0.0] if poses is None else poses.cross_inertia.max(axis=0).tolist(),
        "complete": condition.complete,
    }
