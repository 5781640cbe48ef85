"""Decisions and limits of a dyad over a network that is written out, for tests of many of them."""

from __future__ import annotations

from typing import Any

import telespring as ts
from telespring.decision import decide as decisions
from telespring.decision.decide import Decision
from telespring.decision.limits import COMMON_DELAYS, Limits
from telespring.decision.limits import limits as find_limits
from telespring.decision.question import Question

Delay = float | tuple[float, float]


def question(
    dyad: ts.Dyad,
    delay: Delay,
    *,
    operator_ranges: tuple[ts.OperatorRange, ts.OperatorRange] | None = None,
    has_playout_buffer: bool = False,
    sample_period: float = 0.001,
    **timing: float,
) -> Question:
    network = ts.Network(delay, sample_period=sample_period, **timing)
    return Question(dyad, network, operator_ranges, has_playout_buffer)


def _split(keywords: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    own = {"horizon", "decay_rate", "uncertainty", "records", "compare_free"}
    return (
        {name: value for name, value in keywords.items() if name not in own},
        {name: value for name, value in keywords.items() if name in own},
    )


def decide(dyad: ts.Dyad, stiffness: float, delay: Delay, **keywords: Any) -> Decision:
    asked, rest = _split(keywords)
    return decisions.decide(question(dyad, delay, **asked), stiffness, **rest)


def limits(
    dyad: ts.Dyad, delay: Delay | None = None, stiffness: float | None = None, **keywords: Any
) -> Limits:
    asked, rest = _split(keywords)
    delays = COMMON_DELAYS if delay is None else None
    return find_limits(question(dyad, delay or 0.0, **asked), stiffness, delays=delays, **rest)
