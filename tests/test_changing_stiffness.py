"""What docs/theory/verdicts.md proves of "any network": stiffness that changes, a damper in the coupling."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.linalg import expm

import telespring as ts

_STEP = 0.02  # s
_STEPS = 400


def _advance(robot: ts.Robot, k: float, c: float, own: np.ndarray, partner: np.ndarray) -> np.ndarray:
    """Position and velocity one step on, exactly, while a partner's sample of both is held."""
    rates = np.zeros((4, 4))
    rates[0, 1] = 1.0
    rates[1] = np.array([-k, -(robot.damping[0] + c), k, c]) / robot.mass[0]
    return np.asarray(expm(_STEP * rates) @ np.concatenate([own, partner]))[:2]


def _robots(rng: np.random.Generator) -> tuple[ts.Robot, ts.Robot]:
    def robot() -> ts.Robot:
        return ts.Robot(mass=float(np.exp(rng.uniform(-1, 1))), damping=float(np.exp(rng.uniform(0, 3))))

    return robot(), robot()


def _growth(
    robots: tuple[ts.Robot, ts.Robot],
    rates: list[float],
    stiffness: Callable[[int], float],
    c: float,
    rng: np.random.Generator,
) -> float:
    """Return by how much the hull of x and x + v/λ grows from two robots at rest, as a share of its width.

    Each side holds, for times of its own, the sample of the partner's past that is farthest to one side.
    """
    course = np.zeros((_STEPS + 1, 2, 2))
    course[0, :, 0] = -1.0, 1.0
    held, until = course[0, ::-1].copy(), [0, 0]
    for step in range(_STEPS):
        for side in range(2):
            if step >= until[side]:
                past = course[: step + 1, 1 - side]
                wanted = rng.choice([-1, 1]) * (past[:, 0] + past[:, 1] / rates[1 - side])
                held[side] = past[np.argmax(wanted)]
                until[side] = step + int(rng.integers(1, 80))
            course[step + 1, side] = _advance(
                robots[side], stiffness(side), c, course[step, side], held[side]
            )
    ahead = course[..., 0] + course[..., 1] / np.array(rates)
    return (float(max(np.abs(course[..., 0]).max(), np.abs(ahead).max())) - 1) / 2


@pytest.mark.parametrize("seed", range(4))
def test_law_a_stiffness_that_each_side_changes_alone_keeps_the_hull(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robots = _robots(rng)
    bounds = [robot.damping[0] ** 2 / (4 * robot.mass[0]) for robot in robots]
    tier = ts.verdicts(ts.Dyad(*robots), 1.0, 0.1).tier("any network")
    assert tier.stiffness_bound == pytest.approx(min(bounds), rel=1e-12)
    rates = [robot.damping[0] / (2 * robot.mass[0]) for robot in robots]

    def changing(side: int) -> float:
        return float(rng.choice([0.0, rng.uniform(), 1.0, 1.0]) * bounds[side])

    assert _growth(robots, rates, changing, 0.0, rng) < 1e-12


@pytest.mark.parametrize("seed", range(4))
def test_law_a_damper_in_the_coupling_keeps_the_hull_up_to_its_bound(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robots = _robots(rng)
    c = (0.5, 1.0, 1.5, 3.0)[seed] * min(robot.damping[0] for robot in robots)
    dyad = ts.Dyad(*robots, coupling_damping=c)
    bound = ts.verdicts(dyad, 1.0, 0.1).tier("any network").stiffness_bound
    assert bound is not None
    k = bound * (1 - 1e-9)
    rates = [min(np.roots([robot.mass[0], -(robot.damping[0] + c), k]).real) for robot in robots]
    assert _growth(robots, rates, lambda _: k, c, rng) < 1e-9


def test_law_above_the_bound_a_stiffness_that_is_switched_makes_the_motion_grow() -> None:
    """Let go while the robots part, back when they turn: without any delay, at the 146 N/m of the page."""
    axis = ts.hman()["x"]
    mass, damping = axis.masses[0], axis.dampings[0]
    distance, speed, turns = 1.0, 0.0, []
    for _ in range(4000):
        parting = distance * speed > 0
        stiffness = 0.0 if parting else 146.0
        # of two equal robots the distance swings with 2 k
        rates = 0.001 * np.array([[0.0, 1.0], [-2 * stiffness / mass, -damping / mass]])
        distance, speed = expm(rates) @ [distance, speed]
        if parting and abs(speed) < 0.01 * abs(distance):
            speed = 0.0  # as good as at rest: the spring is there again
            turns.append(abs(distance))
    assert len(turns) >= 3
    assert np.all(np.diff([1.0, *turns]) > 0)
