"""The limits of `telespring decide --json` without a stiffness or a delay, in SI units."""

from __future__ import annotations

import math
from typing import Any

from telespring._core import LEAST_PROBABILITY, RESERVE
from telespring._json import finite_or_none
from telespring.decision.limits import DelayLimits, Limits
from telespring.show.decision_json import network_json, sampled_bound_json, varying_json
from telespring.show.screens.ages import ages_notes
from telespring.show.screens.robots import robot_notes
from telespring.show.tiers import TIERS

__all__ = ["limits_json"]


def limits_json(found: Limits) -> dict[str, Any]:
    """Return what `docs/study-json.md` lists for limits."""
    given, first = found.stiffness, found.delays[0].question
    return {
        "question": "limits",
        "reserve": RESERVE,
        "is_delay_given": found.is_delay_given,
        "sample_period": first.network.sample_period,
        "over_operator_ranges": found.over_operator_ranges,
        "least_probability": LEAST_PROBABILITY if found.robots_have_errors else None,
        "axes_independent": found.axes_independent,
        "warnings": [
            *ages_notes(first.ages, first.stated, is_delay_given=found.is_delay_given),
            *robot_notes(found),
        ],
        "playout_buffer": found.has_playout_buffer,
        "delays": [_delay_json(row, found.axes) for row in found.delays],
        "stiffness": None
        if given is None
        else {
            "stiffness": given.stiffness,
            "delay_limit": finite_or_none(given.delay_limit),
            "delay_limit_proven": given.delay_limit_proven,
            "usable_delay": finite_or_none(given.usable_delay),
            "recommended_delay": given.recommended_delay,
            "unbounded": math.isinf(given.delay_limit),
            "usable_delay_unbounded": math.isinf(given.usable_delay),
            "usable_varying_delay": None
            if given.usable_delay_while_varying is None
            else finite_or_none(given.usable_delay_while_varying),
            "recommended_varying_delay": given.recommended_delay_while_varying,
            "usable_varying_delay_unbounded": given.usable_delay_while_varying == math.inf,
        },
        "free": None if found.free is None else limits_json(found.free),
    }


def _delay_json(row: DelayLimits, axes: tuple[str, ...]) -> dict[str, Any]:
    (forward, backward), (constant_forward, constant_backward) = row.delay, row.constant_delay
    return {
        "delay": {"forward": forward, "backward": backward},
        "constant_delay": {
            "forward": constant_forward,
            "backward": constant_backward,
            "buffered": row.buffered,
        },
        "network": network_json(row),
        "stiffness_limit": finite_or_none(row.stiffness_limit),
        "usable_stiffness": finite_or_none(row.usable_stiffness),
        "recommended_stiffness": row.recommended_stiffness,
        "unbounded": math.isinf(row.stiffness_limit),
        "usable_stiffness_unbounded": math.isinf(row.usable_stiffness),
        "sampled_proven": row.is_sampled_proven if row.verdicts.network.sample_period > 0.0 else None,
        "soft_springs_fail_by_sampling": row.soft_springs_fail_by_sampling,
        "varying_delay": _varying_json(row),
        "verdicts": {
            TIERS[tier.tier].key: {
                "stiffness_allowed": finite_or_none(
                    math.nan if tier.stiffness_bound is None else tier.stiffness_bound
                ),
                "stiffness_unbounded": tier.stiffness_bound is not None and math.isinf(tier.stiffness_bound),
                "attained": tier.attained,
                "proven": tier.proven,
                **sampled_bound_json(tier, row.verdicts),
                "axis": None if tier.worst_axis is None else axes[tier.worst_axis],
                "assumption_met": row.question.core.assumption(tier) == "met",
                "available": tier.stiffness_bound is not None,
                "unavailable": tier.unavailable,
            }
            for tier in row.verdicts.tiers
        },
    }


def _varying_json(row: DelayLimits) -> dict[str, Any] | None:
    """Return what holds without a playout buffer; there is no stiffness to have a status."""
    found = varying_json(row.varying)
    return None if found is None else {key: value for key, value in found.items() if key != "status"}
