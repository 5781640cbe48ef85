"""Poses of jointed arms: diagonal arms against the exact criteria, frozen poses against the plant itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import telespring as ts
from jointed_arms import ARM, OTHER
from telespring import _core
from telespring._types import FloatArray
from telespring.theory.poses import pose_stability, pose_system


def path(count: int) -> FloatArray:
    """One period of the figure of eight, Eq. 12."""
    angle = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    return np.column_stack([0.05 * np.sin(2 * angle), 0.1 * np.sin(angle)])


@pytest.mark.parametrize("stiffness", [20.0, 71.2, 142.0])
@pytest.mark.parametrize("grounds", [(0.0, 0.0), (120.0, 90.0)])
def test_law_arms_without_coupling_are_operators_on_each_axis(
    hman: ts.Dyad, stiffness: float, grounds: tuple[float, float]
) -> None:
    arms: Any = (
        {"kind": "lumped", "mass": [0.3, 0.5], "damping": [1.0, 0.2]},
        {"kind": "lumped", "mass": 0.4, "damping": 0.5},
    )
    operators = (
        ts.Operator([0.3, 0.5], [1.0, 0.2], grounds[0]),
        ts.Operator(0.4, 0.5, grounds[1]),
    )
    dyad = ts.Dyad(*hman.robots, operators)
    delay = (0.12, 0.18)
    expected = max(ts.spectral_abscissa(dyad, stiffness, delay, axis) for axis in dyad.axes)
    found = pose_stability(hman, arms, stiffness, delay, path(3), grounds)
    # 1e-9: eight states by collocation and Newton, beside the exact roots of one axis
    np.testing.assert_allclose(found.spectral_abscissa, expected, atol=1e-9)
    np.testing.assert_array_equal(found.spectral_abscissa, found.uncoupled_abscissa)
    assert found.complete
    assert found.axes_are_independent
    assert not found.cross_inertia.any()


def test_law_operators_and_coupling_dampers_of_the_dyad_count(hman: ts.Dyad) -> None:
    dyad = ts.Dyad(*hman.robots, (ts.Operator(0.2, 0.4, 30.0), ts.Operator(0.1)), coupling_damping=1.5)
    expected = max(ts.spectral_abscissa(dyad, 100.0, 0.1, axis) for axis in dyad.axes)
    found = pose_stability(dyad, (None, {"kind": "massless"}), 100.0, 0.1, [[0.0, 0.0]])
    assert found.worst_abscissa == pytest.approx(expected, abs=1e-9)


def test_cross_the_frozen_pose_moves_as_the_plant_does_nearby(hman: ts.Dyad) -> None:
    # Both plants, each driven by its agent and by its partner's position one delay ago, a small way from
    # a pose; beside them the linear system in steps of the classical Runge-Kutta method.
    position, k, ticks, period, grounds = np.array([0.03, -0.06]), 71.2, 600, 2.5e-4, (120.0, 90.0)
    late = 120  # ticks: 30 ms
    system = pose_system(hman, (ARM, OTHER), k, late * period, position, grounds)
    (_, a1), *rest = system.delayed
    assert not rest
    a0 = system.a0

    def deviation(size: float) -> float:
        arms = (ARM, OTHER)
        state = np.array([1.0, -0.5, 0.0, 0.0, -0.7, 0.3, 0.0, 0.0]) * size
        linear = [state]
        for tick in range(ticks):
            x = linear[-1]
            past = linear[max(tick - late, 0)]
            later = linear[max(tick + 1 - late, 0)]

            def slope(x: FloatArray, past: FloatArray) -> FloatArray:
                return a0 @ x + a1 @ past

            middle = 0.5 * (past + later)
            s1 = slope(x, past)
            s2 = slope(x + 0.5 * period * s1, middle)
            s3 = slope(x + 0.5 * period * s2, middle)
            s4 = slope(x + period * s3, later)
            linear.append(x + period / 6 * (s1 + 2 * s2 + 2 * s3 + s4))
        real = [state]
        for tick in range(ticks):
            x, past = real[-1], real[max(tick - late, 0)]
            following = np.empty(8)
            for side in range(2):
                mine, theirs = slice(4 * side, 4 * side + 4), slice(4 - 4 * side, 8 - 4 * side)
                place, speed = x[mine][:2], x[mine][2:]
                handle = {
                    "mass": hman.robots[side].mass.tolist(),
                    "damping": hman.robots[side].damping.tolist(),
                }
                moved = _core.simulate_handle(
                    handle,
                    arms[side],
                    [-grounds[side] * place],
                    [k * (past[theirs][:2] - place)],
                    period,
                    (position + place).tolist(),
                    speed.tolist(),
                )
                following[mine] = np.concatenate([moved.position[-1] - position, moved.velocity[-1]])
            real.append(following)
        difference = np.array(real)[:, [0, 1, 4, 5]] - np.array(linear)[:, [0, 1, 4, 5]]
        return float(np.abs(difference).max() / size)

    small, smaller = deviation(1e-3), deviation(1e-5)
    # What stays is the hold of the forces over a tick, half a tick's delay of both springs: 0.06 % here.
    assert smaller < 0.002
    # the rest falls with the size of the motion: the plant is the frozen pose, to first order
    assert abs(small - smaller) < 5e-4


def test_law_cross_inertia_is_found_and_matters(hman: ts.Dyad) -> None:
    found = pose_stability(hman, (ARM, OTHER), 71.2, 0.1, path(24), (120.0, 120.0))
    assert found.complete
    assert not found.axes_are_independent
    assert found.cross_inertia.shape == (24, 2)
    assert found.worst_abscissa == found.spectral_abscissa.max()
    np.testing.assert_array_equal(found.worst_position, found.position[found.worst])
    assert np.abs(found.spectral_abscissa - found.uncoupled_abscissa).max() > 0.05
    # a second count: the rightmost root of each pose is a root of its characteristic matrix
    system = pose_system(hman, (ARM, OTHER), 71.2, 0.1, found.worst_position, (120.0, 120.0))
    root = system.characteristic_roots(1)[0]
    assert root.real == found.worst_abscissa
    matrix = root * np.eye(8) - system.a0
    matrix = matrix - sum(term * np.exp(-root * delay) for delay, term in system.delayed)
    # 1e-9 of its largest singular value: singular
    singular = np.linalg.svd(matrix, compute_uv=False)
    assert singular[-1] < 1e-9 * singular[0]


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"arms": ({"kind": "lumped", "mass": -1.0}, None)}, "arm1.mass"),
        ({"arms": (None, {**ARM, "link_mass": [0.9, -0.4]})}, "arm2.link_mass[1]"),
        ({"arms": (ARM, None), "positions": [[0.0, 0.0], [0.0, 0.5]]}, "positions[1]"),
        ({"positions": [0.0, 0.0]}, "positions"),
        ({"positions": np.empty((0, 2))}, "positions"),
        ({"agent_stiffness": (0.0, -1.0)}, "agent_stiffness[1]"),
        ({"stiffness": -1.0}, "stiffness"),
        ({"delay": -0.1}, "delay"),
    ],
)
def test_law_wrong_values_are_named(hman: ts.Dyad, change: dict[str, Any], field: str) -> None:
    given: dict[str, Any] = {"arms": (None, None), "stiffness": 71.2, "delay": 0.1, "positions": path(4)}
    with pytest.raises(ts.InvalidInput) as refused:
        pose_stability(hman, **{**given, **change})
    assert refused.value.field == field, str(refused.value)
