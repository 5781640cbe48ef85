"""Answers at the ends of what is allowed, and values that `decide` refuses."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

import telespring as ts
from telespring._types import FloatArray
from telespring.decision.decide import decide
from telespring.decision.limits import limits
from telespring.decision.question import Question
from telespring.show.limits_json import limits_json


@dataclass(frozen=True)
class Errors:
    """Standard errors of a robot of one axis."""

    mass_sd: FloatArray
    damping_sd: FloatArray
    correlation: FloatArray = field(default_factory=lambda: np.zeros(1))


MINE = ts.Dyad(ts.Robot(1.2, 6.0), ts.Robot(2.0, 9.0))
STUDY = ts.Study.from_toml(
    "", robot1={"mass": 1.2, "damping": 6.0}, robot2={"mass": 2.0, "damping": 9.0}, network={"delay": 0.04}
)


@pytest.mark.parametrize(
    ("subject", "arguments"),
    [
        (STUDY, {"stiffness": 150.0, "delay": (0.1, 0.2, 0.3)}),
        (MINE, {"stiffness": 150.0, "delay": 0.04, "horizon": "a"}),
        (MINE, {"stiffness": 150.0, "delay": 0.04, "decay_rate": "a"}),
        (MINE, {"stiffness": True, "delay": 0.04}),
        (MINE, {"stiffness": 150.0, "delay": True}),
        (ts.Dyad(*MINE.robots, coupling_damping=1e5), {"stiffness": 150.0, "delay": 0.04}),
    ],
)
def test_law_what_is_no_value_is_refused(subject: Any, arguments: dict[str, Any]) -> None:
    with pytest.raises(ts.InvalidInput):
        ts.decide(subject, **arguments)


def test_law_the_stiffest_spring_is_judged() -> None:
    assert ts.decide(MINE, 9.6e6, 0.04, allow_unusual=True).status == "unstable"
    assert ts.decide(MINE, 9.6e6, allow_unusual=True).limits is not None


def test_law_a_limit_in_short_is_not_rounded_up() -> None:
    answer = ts.decide(MINE, delay=0.04)
    assert answer.limits is not None
    usable = answer.limits.delays[0].usable_stiffness
    shown = float(repr(answer).split("usable at ")[1].split(" ms ")[1].split(" ")[0])
    assert 0.9999 * usable < shown <= usable


def test_law_a_sampled_damper_with_errors_is_not_called_stable_while_the_delay_varies() -> None:
    robot = ts.Robot(0.125, 3.0)
    question = Question(
        ts.Dyad(robot, robot, coupling_damping=20.0), ts.Network(0.04, jitter=0.01, sample_period=0.005)
    )
    error = Errors(np.array([0.02]), np.array([0.0]))
    found = decide(question, 100.0, uncertainty=(error, error)).varying
    assert found is not None
    assert found.status != "stable"
    assert found.usable_stiffness == 0.0


def test_law_the_flag_of_a_usable_delay_is_its_own() -> None:
    errors = tuple(Errors(np.array([0.0]), np.array([0.1 * b])) for b in (6.0, 9.0))
    question = Question(MINE, ts.Network(0.0, sample_period=0.001))
    row = limits(question, 18.0, uncertainty=(errors[0], errors[1])).stiffness
    assert row is not None
    assert math.isfinite(row.usable_delay)
    assert math.isinf(row.delay_limit)
    stiffness = limits_json(limits(question, 18.0, uncertainty=(errors[0], errors[1])))["stiffness"]
    assert stiffness["unbounded"]
    assert not stiffness["usable_delay_unbounded"]


@pytest.mark.parametrize("subject", [MINE, STUDY])
@pytest.mark.parametrize("stiffness", [None, 100.0])
def test_law_a_network_without_a_sample_period_is_announced(subject: Any, stiffness: float | None) -> None:
    continuous = ts.decide(subject, stiffness, ts.Network(0.04, jitter=0.01))
    text = " ".join(str(continuous).split())
    assert "The network has no sample period: the controllers are taken as continuous." in text
    assert "sample_period=0.001" in text
    sampled = ts.Network(0.04, jitter=0.01, sample_period=0.001)
    for given in (sampled, 0.04, (0.04, 0.05)):
        assert ts.decide(subject, stiffness, given).notes == ()
    if stiffness is None:
        # the note matters: the command's answer is on the safe side
        usable = []
        for network in (ts.Network(0.04, jitter=0.01), sampled):
            found = ts.decide(subject, delay=network).limits
            assert found is not None
            assert found.delays[0].varying is not None
            usable.append(found.delays[0].varying.usable_stiffness)
        assert usable[1] < usable[0]
