"""The first table of a study: the largest stiffness by delay and by what the network promises."""

from __future__ import annotations

import math
from typing import Any

from telespring._json import finite_or_none
from telespring.decision.decide import TIERS
from telespring.model import Study
from telespring.theory.verdicts import verdicts

__all__ = ["SUMMARY_DELAYS", "summarise"]

#: One-way delays (s) of the summary: good and bad links, and the delays of the paper's experiment.
SUMMARY_DELAYS = (0.01, 0.02, 0.05, 0.1, 0.167, 0.2, 0.334)

#: Verdicts whose rule is for a constant delay and a controller without sampling.
_CONSTANT = ("any constant delay", "constant delay")


def summarise(study: Study) -> dict[str, Any]:
    """Find what each verdict allows over each delay, the study's own network otherwise.

    A sampled controller bears less than the rules for a constant delay say, so these give no more than
    the sampled dyad keeps at the delay of the row.

    Parameters
    ----------
    study
        Robots, operators or their ranges, coupling and network.

    Returns
    -------
    dict
        `summary` of `study.json`.
    """
    return {
        "rows": [_row(study, delay) for delay in SUMMARY_DELAYS],
        "tiers": [
            {"key": each.key, "name": name, "network": each.network, "rule": each.rule}
            for name, each in TIERS.items()
            if name != "paper"
        ],
        "highlight": SUMMARY_DELAYS.index(0.1),
    }


def _row(study: Study, delay: float) -> dict[str, Any]:
    network = study.network
    judged = verdicts(
        study.dyad,
        study.stiffness,
        delay,
        jitter=network.jitter,
        max_gap=network.max_gap,
        sample_period=network.sample_period,
        computing_time=network.computing_time,
        operator_range=study.operator_ranges,
    )
    names = [axis.name for axis in judged.axes]
    sampled = [
        (axis.sampled_stiffness_bound, axis.name)
        for axis in judged.axes
        if axis.sampled_stiffness_bound is not None
    ]
    bears, bearing_axis = min(sampled, default=(math.inf, ""))
    row: dict[str, Any] = {
        "delay": delay,
        # What a playout buffer makes of it: it waits for the latest packet and the longest gap.
        "constant_delay_in_use": delay + network.jitter + network.max_gap,
        "oldest_sample": max(budget.total for budget in judged.delay_budget),
    }
    for name, description in TIERS.items():
        if name == "paper":
            entry = _entry(judged.paper.critical_stiffness, names[judged.paper.critical_axis])
        else:
            tier = next(each for each in judged.tiers if each.tier == name)
            axis = None if tier.worst_axis is None else names[tier.worst_axis]
            entry = _entry(tier.stiffness_bound, axis)
            if name in _CONSTANT and tier.stiffness_bound is not None and bears < tier.stiffness_bound:
                entry = _entry(bears, bearing_axis, limited_by="sampling")
        row[description.key] = entry
    return row


def _entry(stiffness: float | None, axis: str | None, limited_by: str = "rule") -> dict[str, Any]:
    unbounded = stiffness is not None and math.isinf(stiffness)
    return {
        "stiffness": None if stiffness is None else finite_or_none(stiffness),
        "unbounded": unbounded,
        "axis": None if unbounded else axis,
        "limited_by": limited_by,
    }
