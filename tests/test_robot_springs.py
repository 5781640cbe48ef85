"""A robot's own spring to the ground: part of the robot, not a hand."""

from __future__ import annotations

from pathlib import Path

import pytest

import telespring as ts
from questions import answered, flat, run
from telespring.decision.decide import decide
from telespring.decision.question import Question

TEXT = "[robot]\nmass = [0.8334, 1.0649]\ndamping = [7.7, 10.1]\n[identification]\nstiffness = [{}, 0.0]\n"
OTHER = ("--robot", "hman2", "--ping", "80ms")


@pytest.fixture
def spring(tmp_path: Path) -> str:
    file = tmp_path / "spring.toml"
    file.write_text(TEXT.format(2.99932))
    return str(file)


def test_law_a_robots_own_spring_is_no_hand(spring: str) -> None:
    screen = flat(run("decide", "--robot", spring, *OTHER).stdout)
    assert "own spring to the ground of 3 N/m on x" in screen
    assert "held" not in screen
    assert ", handles free" in screen
    assert "hand" not in screen.replace("handles free", "")
    assert answered("--robot", spring, *OTHER)["free"] is None


def test_law_a_grip_is_named_without_the_spring(spring: str) -> None:
    screen = flat(run("decide", "--robot", spring, *OTHER, "--grip", "50:300").stdout)
    assert "Handles held by 50 to 300 N/m:" in screen


def test_cross_free_handles_keep_the_spring_as_an_operator_of_its_stiffness_does(spring: str) -> None:
    free = answered("--robot", spring, *OTHER, "--grip", "50:300", "--stiffness", "40")["free"]
    robot = ts.Robot([0.8334, 1.0649], [7.7, 10.1])
    dyad = ts.Dyad(robot, ts.hman().robots[1], (ts.Operator(stiffness=[2.99932, 0.0]), None))
    alone = decide(Question(dyad, ts.Network(0.04, sample_period=0.001)), 40.0)
    assert free["remedies"]["delay"] == pytest.approx(alone.delay_limit, rel=1e-12)
    assert free["remedies"]["stiffness"] == pytest.approx(alone.stiffness_limit, rel=1e-12)
    # Without the spring the delay is limited to 715 ms, with it to 2.4 s.
    bare = decide(Question(ts.Dyad(*dyad.robots), alone.verdicts.network), 40.0)
    assert bare.delay_limit < 0.5 * alone.delay_limit


@pytest.mark.parametrize("stiffness", [1e-3, 0.5993])
def test_law_a_measured_spring_may_be_weak(stiffness: float, tmp_path: Path) -> None:
    file = tmp_path / "soft.toml"
    file.write_text(TEXT.format(stiffness))
    for more in ((), ("--grip", "50:300")):
        found = run("decide", "--robot", str(file), *OTHER, *more)
        assert found.exit_code == 0, found.output


def test_law_the_spring_survives_the_text_and_a_new_hand() -> None:
    study = ts.Study.paper().with_robot(1, TEXT.format(0.5))
    held = study.replace(operator1={"stiffness": {"min": 50.0, "max": 300.0}})
    assert ts.Study.from_toml(held.to_toml()) == held
    assert held.ground_stiffness.tolist() == [[0.5, 0.0], [0.0, 0.0]]
    ranges = held.operator_ranges
    assert ranges is not None
    assert ranges[0].low.stiffness.tolist() == [50.5, 50.0]
    assert not study.replace(robot1=ts.Robot([1.0, 1.0], 5.0)).ground_stiffness.any()


def test_cross_a_range_given_in_python_keeps_the_spring() -> None:
    study = ts.Study.paper().with_robot(1, TEXT.format(80.0))
    hand = ts.OperatorRange(ts.Operator(), ts.Operator(stiffness=100.0))
    given = ts.decide(study, 50.0, 0.04, operator_range=hand)
    hands = {"stiffness": {"min": 0.0, "max": 100.0}}
    written = ts.decide(study.replace(operator1=hands, operator2=hands), 50.0, 0.04)
    assert given.stiffness_limit == written.stiffness_limit
    assert given.holders == written.holders
