"""Questions to `decide`, its command and `limits`, for tests of many of them."""

from __future__ import annotations

import json
from typing import Any

from typer.testing import CliRunner, Result

import telespring as ts
from telespring import cli
from telespring.decision import decide as decisions
from telespring.decision.decide import Decision
from telespring.decision.limits import COMMON_DELAYS, Limits
from telespring.decision.limits import limits as find_limits
from telespring.decision.question import Question

Delay = float | tuple[float, float]

#: The options of the robots of `one_axis`.
MINE = ("--robot", "1.2,6", "--robot", "2,9")


def one_axis() -> ts.Dyad:
    return ts.Dyad(ts.Robot(1.2, 6.0), ts.Robot(2.0, 9.0))


def run(*arguments: str, columns: int = 80, **environment: str) -> Result:
    return CliRunner(env={"COLUMNS": str(columns), "NO_COLOR": "1", **environment}).invoke(
        cli.app, list(arguments)
    )


def answered(*arguments: str) -> dict[str, Any]:
    found = run("decide", "--json", *arguments)
    assert found.exit_code == 0, found.output
    answer: dict[str, Any] = json.loads(found.stdout)
    return answer


def flat(text: str) -> str:
    return " ".join(text.split())


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
