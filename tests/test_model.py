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
    axis = dyad.axis("y")
    assert axis.parameters == (1.0649 + 0.5, 10.1168 + 1.0, 1.3407, 9.3496)
    assert axis.keywords == {"kh1": 10.0, "kh2": 30.0, "c": 0.25}
    assert dyad.axis(1) == dyad["y"] == axis


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
        (
            lambda: ts.Dyad(ts.Robot(1.0, 1.0), ts.Robot([1.0, 1.0], [1.0, 1.0])),
            "robot2.axes",
            "the same number of axes",
        ),
        (
            lambda: ts.Dyad(*ts.hman().robots, operators=(None, ts.Operator(stiffness=[1.0, 2.0, 3.0]))),
            "operators[1].stiffness",
            "one value per axis",
        ),
        (lambda: ts.Dyad(*ts.hman().robots, coupling_damping=-1.0), "coupling_damping", "damping"),
        (lambda: ts.hman().axis(2), "axis", "counted from 0"),
        (lambda: ts.hman()["z"], "axis", '"x", "y"'),
    ],
)
def test_ref_bad_values_are_refused_at_the_door(build: Any, field: str, said: str) -> None:
    with pytest.raises(ts.InvalidInput) as refused:
        build()
    assert refused.value.field == field
    assert said in str(refused.value)
    assert all((refused.value.value, refused.value.allowed, refused.value.remedy))


@pytest.mark.parametrize(
    ("build", "bad", "field", "value", "allowed"),
    [
        (lambda bad: ts.Robot(bad, 1), "a", "mass", "'a'", "one number per axis"),
        (lambda bad: ts.Robot(1.0, bad), ["a"], "damping", "['a']", "one number per axis"),
        (lambda bad: ts.Operator(stiffness=bad), "soft", "stiffness", "'soft'", "one number per axis"),
        (
            lambda bad: ts.Dyad(*ts.hman().robots, coupling_damping=bad),
            "b",
            "coupling_damping",
            "'b'",
            "real",
        ),
        (lambda bad: ts.hman().delay_system(bad, 0.1), "k", "stiffness", "'k'", "a real number"),
        (lambda bad: ts.spectral_abscissa(ts.hman(), bad, 0.1), 1j, "stiffness", "1j", "a real number"),
        (lambda bad: ts.open_loop(ts.hman(), bad, 0.1, [1.0]), None, "stiffness", "None", "a real number"),
        (lambda bad: ts.verdicts(ts.hman(), bad, 0.1), "k", "stiffness", "'k'", "a real number"),
        (lambda bad: ts.Network(0.1, jitter=bad), "j", "jitter", "'j'", "one number for both ways"),
        (lambda bad: ts.Network(0.1, sample_period=bad), [1.0], "sample_period", "[1.0]", "a real number"),
        (lambda bad: ts.Coupling(bad), "k", "stiffness", "'k'", "a real number"),
    ],
)
def test_ref_a_value_that_is_no_number_is_refused_by_its_name(
    build: Any, bad: Any, field: str, value: str, allowed: str
) -> None:
    refused = refusal(lambda: build(bad))
    assert (refused.field, refused.value) == (field, value)
    assert allowed in refused.allowed
    assert refused.remedy.startswith("Give")


@pytest.mark.parametrize(
    ("axis", "value"),
    [
        (-1, "-1"),
        (2, "2"),
        (10**30, "1" + 30 * "0"),
        ("z", '"z"'),
        (1.5, "1.5"),
        (None, "None"),
        (["x"], "['x']"),
    ],
)
def test_ref_an_axis_that_is_not_there_is_refused_with_those_that_are(axis: Any, value: str) -> None:
    hman = ts.hman()
    for ask in (
        lambda: ts.characteristic_roots(hman, 71.2, 0.1, axis=axis),
        lambda: ts.spectral_abscissa(hman, 71.2, 0.1, axis=axis),
        lambda: ts.nyquist(hman, 71.2, 0.1, axis=axis),
        lambda: hman.delay_system(71.2, 0.1, axis=axis),
    ):
        refused = refusal(ask)
        assert (refused.field, refused.value) == ("axis", value)
        assert refused.allowed == 'this dyad has the axes ["x", "y"], counted from 0'
        assert refused.remedy.startswith("Choose one")


def test_law_an_axis_is_the_same_by_name_and_by_any_integer() -> None:
    axes: list[Any] = ["y", 1, np.int64(1), np.uint8(1)]
    found = [ts.spectral_abscissa(ts.hman(), 71.2, 0.1, axis=axis) for axis in axes]
    assert found == found[:1] * 4


@pytest.mark.parametrize(
    "pair", [(0.1, 0.2), [0.1, 0.2], np.array([0.1, 0.2]), np.array([0.1, 0.2], dtype=np.float32)[:]]
)
def test_law_a_row_of_two_is_a_pair_of_delays(pair: Any) -> None:
    hman = ts.hman()
    rtol = 1e-6 if getattr(pair, "dtype", None) == np.float32 else 0.0
    wanted = ts.spectral_abscissa(hman, 71.2, (0.1, 0.2))
    assert ts.spectral_abscissa(hman, 71.2, pair) == pytest.approx(wanted, rel=rtol, abs=0.0)
    assert ts.Network(pair).delay == pytest.approx((0.1, 0.2), rel=rtol, abs=0.0)
    result = ts.simulate(hman, 71.2, pair, [[1.0, 0.0], [0.0, 0.0]], duration=0.1)
    backward = result.attrs["delay_backward"]
    assert isinstance(backward, float)
    assert backward == pytest.approx(0.2, rel=rtol, abs=0.0)
    assert ts.verdicts(hman, 71.2, pair) is not None


@pytest.mark.parametrize(
    ("delay", "value"),
    [
        ((0.1, 0.2, 0.3), "(0.1, 0.2, 0.3)"),
        ([0.1], "[0.1]"),
        ((), "()"),
        ("0.1", "'0.1'"),
        (None, "None"),
        ((0.1, "b"), "(0.1, 'b')"),
        (np.array([0.1]), "array([0.1])"),
        (np.array([[0.1, 0.2]]), "array([[0.1, 0.2]])"),
        (list(range(99)), str(list(range(99)))[:57] + "..."),
    ],
)
def test_ref_a_delay_that_is_no_number_nor_a_pair_is_refused(delay: Any, value: str) -> None:
    hman = ts.hman()
    for ask in (
        lambda: ts.characteristic_roots(hman, 71.2, delay),
        lambda: ts.spectral_abscissa(hman, 71.2, delay),
        lambda: ts.nyquist(hman, 71.2, delay),
        lambda: ts.simulate(hman, 71.2, delay, [[1.0, 0.0], [0.0, 0.0]], duration=0.1),
        lambda: hman.delay_system(71.2, delay),
        lambda: ts.Network(delay),
    ):
        refused = refusal(ask)
        assert (refused.field, refused.value) == ("delay", value)
        assert "(forward, backward)" in refused.allowed
        assert refused.remedy == "Give a float or a pair of floats."


@pytest.mark.parametrize(
    ("count", "value"), [(2.5, "2.5"), (0, "0"), (-1, "-1"), (1001, "1001"), ("8", "'8'"), (None, "None")]
)
def test_ref_a_number_of_roots_is_a_whole_number(count: Any, value: str) -> None:
    hman = ts.hman()
    for ask in (
        lambda: ts.characteristic_roots(hman, 71.2, 0.1, count),
        lambda: ts.certified_roots(hman, 71.2, 0.1, count),
        lambda: hman.delay_system(71.2, 0.1).characteristic_roots(count),
        lambda: hman.delay_system(71.2, 0.1).certified_roots(count),
    ):
        refused = refusal(ask)
        assert (refused.field, refused.value) == ("count", value)
        assert "1 to 1000" in refused.allowed
        assert refused.remedy


def refusal(ask: Any) -> ts.InvalidInput:
    with pytest.raises(ts.InvalidInput) as refused:
        ask()
    return refused.value


def test_ref_a_wrong_type_is_refused_with_a_remedy() -> None:
    with pytest.raises(ts.InvalidInput):
        ts.Dyad(ts.Robot(1.0, 1.0), None)  # type: ignore[arg-type]


def test_law_refusals_are_value_errors_and_survive_a_process_border() -> None:
    refused = ts.InvalidInput("mass[0]", "-1", "a mass is positive", "Check the sign.")
    assert isinstance(refused, ValueError)
    again = pickle.loads(pickle.dumps(refused))
    assert str(again) == str(refused) == "mass[0] = -1: a mass is positive. Check the sign."
    assert (again.field, again.value, again.allowed, again.remedy) == refused.args


def test_law_a_dyad_is_a_collection_of_its_axes(hman: ts.Dyad) -> None:
    assert len(hman) == 2
    assert [axis.name for axis in hman] == hman.axes
    assert list(hman) == [hman["x"], hman["y"]]
    assert "x" in hman
    assert "z" not in hman
