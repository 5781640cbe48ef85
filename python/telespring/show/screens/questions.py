"""Phrases that the screens of a decision and of limits share."""

from __future__ import annotations

import math
from typing import NamedTuple

from telespring.decision.question import is_stable, stiffness_limit
from telespring.show.quantities import format_number, format_time
from telespring.theory.verdicts import Verdict, Verdicts

__all__ = [
    "CONTINUOUS_TIERS",
    "TierBound",
    "allowed_stiffness",
    "describe_grip",
    "given_delay",
    "hand_effect",
    "sampling_clause",
    "sampling_note",
    "tier_bounds",
]

#: What the tiers beyond one known delay leave out.
CONTINUOUS_TIERS = "The rule for any constant delay is that of continuous controllers."


class TierBound(NamedTuple):
    """What one tier allows, as a screen shows it: at one known constant delay sampled controllers count.

    Attributes
    ----------
    verdict
        The verdict of the tier.
    bound, attained
        The stiffness, N/m, and whether it is itself allowed.
    axis
        Name of the axis that sets it.
    is_satisfied
        Whether the stiffness in question is allowed.
    """

    verdict: Verdict
    bound: float | None
    attained: bool
    axis: str
    is_satisfied: bool


def tier_bounds(judged: Verdicts) -> list[TierBound]:
    """List the tiers, the one for one known constant delay first."""
    names = [axis.name for axis in judged.axes]
    rows = []
    for verdict in reversed(judged.tiers):
        axis = "–" if verdict.worst_axis is None else names[verdict.worst_axis]
        row = TierBound(verdict, verdict.stiffness_bound, verdict.attained, axis, verdict.satisfied)
        if verdict.tier == "constant delay" and judged.sampled_stable is not None:
            sampled = {each.name: each.sampled_stiffness_bound or 0.0 for each in judged.axes}
            limit = stiffness_limit(judged)
            worst = min(sampled, key=lambda name: sampled[name])
            row = row._replace(bound=limit, attained=False, axis=worst, is_satisfied=is_stable(judged))
        rows.append(row)
    return rows


def sampling_note(judged: Verdicts) -> str:
    """Say which numbers sampled controllers put into the rules, and how they change the closed forms.

    Examples
    --------
    >>> import telespring as ts
    >>> sampling_note(ts.verdicts(ts.hman(), 20.0, 0.04, sample_period=0.001))[:76]
    'A force is held: the own sample is up to h = 1 ms old, the partner samples T'
    """
    h = judged.network.sample_period + judged.network.computing_time
    age = sum(budget.total for budget in judged.delay_budget)
    note = (
        f"A force is held: the own sample is up to h = {format_time(h, 6)} old, the partner samples "
        f"T₁+T₂ = {format_time(age, 6)} in all."
    )
    if judged.tier("bounded varying delay").stiffness_bound is None:
        return note
    return (
        f"{note} The limit for a bounded varying delay is that of b₁ − kh and b₂ − kh, and the one for any "
        "network is below its continuous form."
    )


def given_delay(delay: tuple[float, float]) -> str:
    """Write a delay that was given, with as many digits as people write.

    Examples
    --------
    >>> given_delay((0.04, 0.04)), given_delay((0.04, 0.06))
    ('40 ms each way', '40 ms forward and 60 ms backward')
    """
    forward, backward = (format_time(value, 6) for value in delay)
    return f"{forward} each way" if delay[0] == delay[1] else f"{forward} forward and {backward} backward"


def sampling_clause(period: float) -> str:
    """Write how the controllers work.

    Examples
    --------
    >>> sampling_clause(0.001), sampling_clause(0.0)
    ('controllers sampled every 1 ms', 'continuous controllers')
    """
    if period == 0.0:
        return "continuous controllers"
    return f"controllers sampled every {format_time(period, 6)}"


def allowed_stiffness(bound: float | None, attained: bool) -> str:
    """Write the stiffnesses that a bound allows, without the unit.

    Examples
    --------
    >>> allowed_stiffness(35.616, True), allowed_stiffness(99.7, False), allowed_stiffness(0.0, False)
    ('up to 35.61', 'below 99.7', 'none')
    """
    if bound is None:
        return "no rule"
    if math.isinf(bound):
        return "no limit"
    if bound == 0.0:
        return "none"
    # A bound that is rounded down is itself allowed, but then so is everything below it.
    return f"{'up to' if attained else 'below'} {format_number(bound, rounding='down')}"


def hand_effect(free: float | None, held: float | None) -> str:
    """Say whether holding the handles raises a limit or lowers it.

    Examples
    --------
    >>> hand_effect(35.6, 120.0), hand_effect(35.6, 27.2), hand_effect(35.6, 35.6)
    ('helps', 'hurts', 'is no matter')
    """
    if free is None or held is None:
        return "is not known"
    if math.isclose(free, held, rel_tol=1e-3) or free == held:
        return "is no matter"
    return "helps" if held > free else "hurts"


def describe_grip(stiffness: tuple[float, float]) -> str:
    """Write how a grip holds a handle, from the ends of its range, N/m.

    Examples
    --------
    >>> describe_grip((50.0, 300.0)), describe_grip((120.0, 120.0))
    ('held by 50 to 300 N/m', 'held by 120 N/m')
    """
    low, high = (format_number(value, 6) for value in stiffness)
    return f"held by {low} N/m" if low == high else f"held by {low} to {high} N/m"
