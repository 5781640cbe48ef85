"""Robots, operators and dyads as Python sees them."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

import telespring as ts


def test_ref_hman_is_table_3(hman: ts.Dyad, du2025: dict[str, Any]) -> None:
    for robot, printed in zip(hman.robots, ("hman1", "hman2"), strict=True):
        table = du2025["table3"][printed]
        assert robot.axes == ["x", "y"]
        np.testing.assert_array_equal(robot.mass, [table["mass"]["x"], table["mass"]["y"]])
        np.testing.assert_array_equal(robot.damping, [table["damping"]["x"], table["damping"]["y"]])


@pytest.mark.parametrize(
    "value",
    [
        ts.Robot(1.0, 4.0),
        ts.Robot([1.0, 2.0], [4.0, 5.0], axes=["a'b", "c"]),
        ts.Operator(),
        ts.Operator(mass=0.5, stiffness=[1.0, 2.0]),
        ts.hman(),
        ts.Dyad(ts.Robot(1.0, 4.0), ts.Robot(2.0, 3.0), (None, ts.Operator(stiffness=9.0)), 1.5),
    ],
    ids=repr,
)
def test_law_copies_are_equal_and_the_text_builds_the_same_value(value: object) -> None:
    assert pickle.loads(pickle.dumps(value)) == value
    assert copy.deepcopy(value) == value
    assert eval(repr(value), {"Robot": ts.Robot, "Operator": ts.Operator, "Dyad": ts.Dyad}) == value


def test_law_different_values_are_unequal() -> None:
    assert ts.Robot(1.0, 4.0) != ts.Robot(1.0, 4.5)
    assert ts.Robot(1.0, 4.0) != ts.Robot(1.0, 4.0, axes=["y"])
    assert ts.Operator(stiffness=1.0) != ts.Operator(stiffness=2.0)
    assert ts.hman() != ts.Dyad(ts.hman().robots[1], ts.hman().robots[0])
    assert ts.hman() != "hman"


def test_law_values_cannot_be_changed(hman: ts.Dyad) -> None:
    robot = hman.robots[0]
    with pytest.raises(AttributeError):
        robot.mass = np.zeros(2)  # type: ignore[misc]
    robot.mass[0] = 99.0  # a copy
    assert hman.robots[0].mass[0] == 0.8334


def test_law_a_number_holds_for_every_axis_of_the_dyad(hman: ts.Dyad) -> None:
    grip = ts.Operator(mass=0.5, stiffness=[10.0, 20.0])
    dyad = ts.Dyad(*hman.robots, operators=(grip, None))
    np.testing.assert_array_equal(dyad.operators[0].mass, [0.5, 0.5])
    np.testing.assert_array_equal(dyad.operators[0].stiffness, [10.0, 20.0])
    np.testing.assert_array_equal(dyad.operators[1].stiffness, [0.0, 0.0])


def test_law_operators_are_added_to_the_robots(hman: ts.Dyad) -> None:
    dyad = ts.Dyad(*hman.robots, (ts.Operator(0.5, 1.0, 10.0), ts.Operator(stiffness=[0.0, 30.0])), 0.25)
    assert dyad._parameters("y") == (1.0649 + 0.5, 10.1168 + 1.0, 1.3407, 9.3496, 10.0, 30.0, 0.25)
    assert dyad._parameters(1) == dyad._parameters("y")


@pytest.mark.parametrize(
    ("build", "field", "said"),
    [
        (lambda: ts.Robot(0.0, 4.0), "mass[0]", "0.0001 to 10000 kg"),
        (lambda: ts.Robot(833.4, -1.0), "damping[0]", "0 to 1000000"),
        (lambda: ts.Robot(12345.0, 1.0), "mass[0]", "if 12345 was meant in g, write 12.345"),
        (lambda: ts.Robot([1.0, float("nan")], [1.0, 1.0]), "mass[1]", "missing value"),
        (lambda: ts.Robot([1.0, 1.0], [1.0]), "damping", "one value per axis"),
        (lambda: ts.Robot([], []), "mass", "at least one axis"),
        (lambda: ts.Robot(1.0, 1.0, axes=["x", "y"]), "axes", "one value per axis"),
        (lambda: ts.Operator(stiffness=-1.0), "stiffness[0]", "operator stiffness"),
        (lambda: ts.Operator(stiffness=float("inf")), "stiffness[0]", "inf"),
        (lambda: ts.Dyad(ts.Robot(1.0, 1.0), ts.Robot([1.0, 1.0], [1.0, 1.0])), "robot2.axes", "same axes"),
        (
            lambda: ts.Dyad(*ts.hman().robots, operators=(None, ts.Operator(stiffness=[1.0, 2.0, 3.0]))),
            "operators[1].stiffness",
            "one value per axis",
        ),
        (lambda: ts.Dyad(*ts.hman().robots, coupling_damping=-1.0), "coupling_damping", "damping"),
        (lambda: ts.hman()._parameters(2), "axis", "counted from 0"),
        (lambda: ts.hman()._parameters("z"), "axis", '"x", "y"'),
    ],
)
def test_ref_bad_values_are_refused_at_the_door(build: Any, field: str, said: str) -> None:
    with pytest.raises(ts.InvalidInput) as refused:
        build()
    assert refused.value.field == field
    assert said in str(refused.value)
    assert all((refused.value.value, refused.value.allowed, refused.value.remedy))


def test_ref_a_wrong_type_is_a_type_error() -> None:
    with pytest.raises(TypeError, match="one number per axis, got 'heavy'"):
        ts.Robot("heavy", 1.0)  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        ts.Dyad(ts.Robot(1.0, 1.0), None)  # type: ignore[arg-type]


def test_law_refusals_are_value_errors_and_survive_a_process_border() -> None:
    refused = ts.InvalidInput("mass[0]", "-1", "a mass is positive", "Check the sign.")
    assert isinstance(refused, ValueError)
    again = pickle.loads(pickle.dumps(refused))
    assert str(again) == str(refused) == "mass[0] = -1: a mass is positive. Check the sign."
    assert (again.field, again.value, again.allowed, again.remedy) == refused.args
