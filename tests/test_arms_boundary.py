"""The boundary with arms: its windows of delay, checked by collocation on both sides of each end."""

import json

import numpy as np
import pytest

import oracle_collocation as oracle
import telespring as ts
from telespring.paper.published import EXPERIMENT_DELAYS, EXPERIMENT_STIFFNESSES
from telespring.paper.sections.arms.boundary import ArmsBoundary, boundary_in_arms

REFERENCE = ts.critical_stiffness(0.8334, 7.7257, 0.7776, 7.4208)  # K_xy, 35.616 N/m
CONDITIONS = [(k, delay) for k in EXPERIMENT_STIFFNESSES for delay in EXPERIMENT_DELAYS]


@pytest.fixture(scope="module")
def found() -> ArmsBoundary:
    return boundary_in_arms(ts.hman(), [2 * REFERENCE, 4 * REFERENCE], conditions=CONDITIONS)


def abscissa(found: ArmsBoundary, axis: int, stiffness: float, delays: list[float]) -> np.ndarray:
    (m1, b1, m2, b2) = found.axes[axis].held.parameters
    columns = np.full((7, len(delays)), np.array([m1, b1, m2, b2, 120.0, 120.0, 0.0])[:, None])
    verdict = oracle.spectral_abscissa(
        oracle.Axes(*columns), np.full(len(delays), stiffness), np.array(delays)
    )
    assert verdict.resolved.all()
    return verdict.abscissa


@pytest.mark.parametrize("axis", [0, 1])
def test_cross_collocation_finds_the_same_ends_of_every_window(found: ArmsBoundary, axis: int) -> None:
    k, each = 4 * REFERENCE, found.axes[axis]
    ends = [
        (end, side) for window in each.unstable_held[1] for end, side in zip(window, (1, -1), strict=True)
    ]
    ends = [(end, side) for end, side in ends if end < found.horizon]
    assert len(ends) >= 7
    step = 1e-7  # s; the abscissa moves by about 10 /s per second of delay there, far above its rounding
    inside = abscissa(found, axis, k, [end + side * step for end, side in ends])
    outside = abscissa(found, axis, k, [end - side * step for end, side in ends])
    assert (inside > 0).all()
    assert (outside < 0).all()


@pytest.mark.parametrize("axis", [0, 1])
def test_cross_twice_the_reference_is_stable_at_every_delay_tried(found: ArmsBoundary, axis: int) -> None:
    assert found.axes[axis].unstable_held[0] == ()
    assert found.axes[axis].held.critical_stiffness() > 2 * REFERENCE
    delays = list(np.linspace(0.004, 1.0, 250))
    assert (abscissa(found, axis, 2 * REFERENCE, delays) < 0).all()


def test_pin_first_windows_at_four_times_the_reference(found: ArmsBoundary) -> None:
    x, y = (axis.unstable_held[1][0] for axis in found.axes)
    # to half a millisecond
    assert 1e3 * np.array(x) == pytest.approx([77.8, 152.9], abs=0.5)
    assert 1e3 * np.array(y) == pytest.approx([117.6, 167.3], abs=0.5)


def test_pin_windows_at_the_printed_stiffness() -> None:
    found = boundary_in_arms(ts.hman(), [71.0, 142.0])
    x, y = found.axes
    assert (x.unstable_held[0], y.unstable_held[0]) == ((), ())
    # to half a millisecond
    assert 1e3 * np.array(x.unstable_held[1][:2]) == pytest.approx(
        np.array([[78.3, 152.3], [247.3, 366.1]]), abs=0.5
    )
    assert 1e3 * np.array(y.unstable_held[1][:2]) == pytest.approx(
        np.array([[119.0, 165.9], [339.8, 415.5]]), abs=0.5
    )


def test_law_agents_without_stiffness_leave_the_boundary_of_free_handles() -> None:
    found = boundary_in_arms(ts.hman(), [2 * REFERENCE], agent_stiffness=(0.0, 0.0))
    for axis in found.axes:
        assert axis.stable_held == axis.stable_free


def test_law_numbers_go_into_json_and_every_window_is_told(found: ArmsBoundary) -> None:
    numbers = json.loads(json.dumps(found.numbers(), allow_nan=False))
    assert [each["axis"] for each in numbers["axes"]] == ["x", "y"]
    verdicts = {(each["stiffness"], each["delay"]): each for each in numbers["conditions"]}
    assert len(verdicts) == 16
    lost = {key for key, each in verdicts.items() if each["in_arms"] == "unstable"}
    assert lost == {(142.0, 0.084), (142.0, 0.334)}
    assert verdicts[(142.0, 0.084)]["unstable_axes_in_arms"] == ["x"]
    assert any("71.23 N/m: stable at every constant delay." in each for each in numbers["statements"])
