"""The exact simulation from Python: shapes, labels, forces; its accuracy is tested in Rust."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import telespring as ts

PUSH = [[1.0, 0.0], [-1.0, 0.0]]


def test_ref_free_robot_under_a_step() -> None:
    # uncoupled (k = 0): m x'' + b x' = f gives x = f/b (t - m/b (1 - exp(-b t/m)))
    m, b = 0.8334, 7.7257
    robot = ts.Robot(m, b)
    found = ts.simulate_array(ts.Dyad(robot, robot), 0.0, 0.1, [[2.0], [0.0]], 5.0)
    t = found.time
    expected = 2.0 / b * (t - m / b * -np.expm1(-b * t / m))
    # 1e-11 of the largest value: what the method promises
    np.testing.assert_allclose(found.position[:, 0, 0], expected, rtol=0, atol=1e-11 * expected[-1])
    assert not found.position[:, 1, 0].any()


def test_law_labels_and_units(hman: ts.Dyad) -> None:
    found = ts.simulate(hman, 71.2, (0.1, 0.2), PUSH, 1.0, rate=100.0)
    assert found.position.dims == found.velocity.dims == ("time", "robot", "axis")
    assert dict(found.sizes) == {"time": 101, "robot": 2, "axis": 2}
    assert found.axis.values.tolist() == ["x", "y"]
    assert found.robot.values.tolist() == [1, 2]
    units = {name: found[name].attrs["units"] for name in ("time", "position", "velocity", "force_error")}
    assert units == {"time": "s", "position": "m", "velocity": "m/s", "force_error": "N"}
    assert (found.attrs["delay_forward"], found.attrs["delay_backward"]) == (0.1, 0.2)
    assert found.attrs["status"] == "completed"


def test_law_the_labelled_and_the_bare_call_agree_and_the_rate_only_samples(hman: ts.Dyad) -> None:
    labelled = ts.simulate(hman, 71.2, 0.167, PUSH, 2.0, rate=1000.0)
    bare = ts.simulate_array(hman, 71.2, 0.167, PUSH, 2.0, rate=1000.0)
    coarse = ts.simulate_array(hman, 71.2, 0.167, PUSH, 2.0, rate=100.0, velocities=False)
    np.testing.assert_array_equal(labelled.position.values, bare.position)
    assert bare.velocity is not None
    np.testing.assert_array_equal(labelled.velocity.values, bare.velocity)
    # 1e-11: outputs at the same time from the same method
    np.testing.assert_allclose(bare.position[::10], coarse.position, atol=1e-11)
    assert coarse.velocity is None


def test_law_one_signal_in_every_form_moves_the_robots_alike(hman: ts.Dyad) -> None:
    omega = 2.59
    still = [0.0, 0.0]
    forms: list[Any] = [
        ts.Sine(1.5, omega, 0.3),
        [ts.Sine(1.0, omega, 0.3), ts.Sine(0.5, omega, 0.3)],
        lambda t: 1.5 * math.sin(omega * t + 0.3),
        ts.Signal(lambda t: 1.5 * math.sin(omega * t + 0.3), breakpoints=[1.0]),
    ]
    first, *others = (ts.simulate_array(hman, 71.2, 0.1, [[form, 0.0], still], 3.0) for form in forms)
    for other in others:
        # 1e-10: functions are approximated, to 1e-12 or better as the next line says
        np.testing.assert_allclose(other.position, first.position, atol=1e-10)
        assert other.force_error.max() < 1e-12
    sampled = ts.Sampled(1.5 * np.sin(omega * np.arange(3001) / 1000 + 0.3), 1000.0)
    lines = ts.simulate_array(hman, 71.2, 0.1, [[sampled, 0.0], still], 3.0)
    # chords of a sine miss it by (omega h)²/8 of its amplitude, 1e-6; the robot moves about 0.1 m/N
    np.testing.assert_allclose(lines.position, first.position, atol=1e-6)
    held = ts.Sampled([1.0, 2.0], 1.0, hold="zero")
    step = ts.Signal(lambda t: 1.0 if t < 1.0 else 2.0, breakpoints=[1.0])
    one, two = (
        ts.simulate_array(hman, 71.2, 0.1, [[form, 0.0], still], 3.0).position for form in (held, step)
    )
    np.testing.assert_allclose(one, two, atol=1e-11)


def test_law_where_the_robots_start(hman: ts.Dyad) -> None:
    still = [[0.0, 0.0]] * 2
    past: list[list[Any]] = [[0.1, (0.2, 1.0)], [0.1, lambda t: 0.2 + t]]
    found = ts.simulate_array(hman, 71.2, 0.1, still, 1.0, history=past)
    assert found.velocity is not None
    np.testing.assert_allclose(found.position[0], [[0.1, 0.2], [0.1, 0.2]], atol=1e-14)
    np.testing.assert_allclose(found.velocity[0], [[0.0, 1.0], [0.0, 1.0]], atol=1e-10)
    # both at rest at one place: nothing moves
    np.testing.assert_allclose(found.position[:, :, 0], 0.1, atol=1e-13)


def test_ref_a_divergence_is_a_result(hman: ts.Dyad) -> None:
    found = ts.simulate(hman, 1e5, 0.5, PUSH, 200.0, rate=100.0)
    assert found.attrs["status"] == "diverged"
    assert 0 < found.attrs["diverged_at"] < 200.0
    assert found.time.values[-1] < found.attrs["diverged_at"] <= found.time.values[-1] + 0.0101
    assert np.isfinite(found.position.values).all()


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"delay": 167}, "delay"),
        ({"delay": (0.1, -0.1)}, "delay.backward"),
        ({"stiffness": -1.0}, "stiffness"),
        ({"forces": [1.0, -1.0]}, "forces"),
        ({"forces": [[1.0], [-1.0]]}, "forces"),
        ({"forces": [[1.0, float("nan")], [0.0, 0.0]]}, "forces[0][1]"),
        ({"forces": [[0.0, 0.0], [ts.Sampled([1.0], 0.0), 0.0]]}, "forces[1][0].rate"),
        ({"forces": [[0.0, 0.0], [ts.Sampled([1.0], 1.0, hold="cubic"), 0.0]]}, "forces[1][0].hold"),  # type: ignore[arg-type]
        ({"duration": 0.0}, "duration"),
        ({"rate": 0.0}, "rate"),
        ({"history": [[0.0, 0.0]]}, "history"),
        ({"history": [[0.0, 0.0], [0.0, float("inf")]]}, "history[1][1].position"),
    ],
)
def test_ref_bad_arguments_are_refused_by_name(hman: ts.Dyad, change: dict[str, Any], field: str) -> None:
    arguments: dict[str, Any] = {
        "dyad": hman,
        "stiffness": 71.2,
        "delay": 0.1,
        "forces": PUSH,
        "duration": 1.0,
    }
    with pytest.raises(ts.InvalidInput) as refused:
        ts.simulate(**(arguments | change))
    assert refused.value.field == field


def test_law_what_a_force_raises_comes_out_unchanged(hman: ts.Dyad) -> None:
    def raises(_: float) -> float:
        raise LookupError("seven")

    with pytest.raises(LookupError, match="seven"):
        ts.simulate(hman, 71.2, 0.1, [[raises, 0.0], [0.0, 0.0]], 1.0)
