"""Largest stiffness of a study by one-way delay and by what the network promises."""

from __future__ import annotations

import math
from typing import Any

from telespring._json import finite_or_none
from telespring.model import Study
from telespring.show.tiers import TIERS
from telespring.theory.verdicts import verdicts

__all__ = ["SUMMARY_DELAYS", "summarise"]

#: One-way delays (s) of the summary: good and bad links, and those of the paper's experiment.
SUMMARY_DELAYS = (0.01, 0.02, 0.05, 0.1, 0.167, 0.2, 0.334)

#: Verdicts whose rule assumes a constant delay and a continuous controller.
_CONSTANT = ("any constant delay", "constant delay")


def summarise(study: Study) -> dict[str, Any]:
    """Compute what each verdict allows at each delay, the study's own among them: most of key `summary`.

    Apart from the delay the network is the study's own. The rules for a constant delay assume continuous
    controllers; with sampled ones, a row gives no more than keeps the sampled dyad stable at its delay.
    """
    own = 0.5 * sum(study.delay)
    delays = sorted({*SUMMARY_DELAYS, own})
    return {
        "rows": [_summary_row(study, delay) for delay in delays],
        "tiers": [
            {"key": tier.key, "name": name, "network": tier.network, "rule": tier.rule}
            for name, tier in TIERS.items()
            if name != "paper"
        ],
        "highlight": delays.index(own),
    }


def _summary_row(study: Study, delay: float) -> dict[str, Any]:
    network = study.network
    verdict = verdicts(
        study.dyad,
        study.stiffness,
        delay,
        jitter=network.jitter,
        max_gap=network.max_gap,
        sample_period=network.sample_period,
        computing_time=network.computing_time,
        operator_range=study.operator_ranges,
    )
    names = [axis.name for axis in verdict.axes]
    sampled = [
        (axis.sampled_stiffness_bound, axis.name)
        for axis in verdict.axes
        if axis.sampled_stiffness_bound is not None
    ]
    sampled_bound, sampled_axis = min(sampled, default=(math.inf, ""))
    row: dict[str, Any] = {
        "delay": delay,
        # Behind a playout buffer, which waits for the latest packet and the longest gap.
        "constant_delay_in_use": delay + network.jitter + network.max_gap,
        "oldest_sample": max(budget.total for budget in verdict.delay_budget),
    }
    for name, description in TIERS.items():
        if name == "paper":
            entry = _summary_entry(verdict.paper.critical_stiffness, names[verdict.paper.critical_axis])
        else:
            tier = next(tier for tier in verdict.tiers if tier.tier == name)
            axis = None if tier.worst_axis is None else names[tier.worst_axis]
            entry = _summary_entry(tier.stiffness_bound, axis)
            if (
                name in _CONSTANT
                and tier.stiffness_bound is not None
                and sampled_bound < tier.stiffness_bound
            ):
                entry = _summary_entry(sampled_bound, sampled_axis, limited_by="sampling")
        row[description.key] = entry
    return row


def _summary_entry(stiffness: float | None, axis: str | None, limited_by: str = "rule") -> dict[str, Any]:
    unbounded = stiffness is not None and math.isinf(stiffness)
    return {
        "stiffness": None if stiffness is None else finite_or_none(stiffness),
        "unbounded": unbounded,
        "axis": None if unbounded else axis,
        "limited_by": limited_by,
    }
