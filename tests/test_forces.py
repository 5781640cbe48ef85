"""Forces given as functions of time, compared with other forms of the same force and with other solvers."""

import math
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import telespring as ts

STILL = [0.0, 0.0]
K, OMEGA, DURATION = 120.0, 1.885, 29.111


def positions(force: Any, duration: float = 10.0, delay: float = 0.167, stiffness: float = 30.0) -> Any:
    """Positions of both robots along x under a force on the first."""
    found = ts.simulate_array(ts.hman(), stiffness, delay, [[force, 0.0], STILL], duration, rate=100.0)
    assert found.status == "completed"
    return found.position[:, :, 0]


def test_law_the_papers_task_as_functions_is_the_task_as_sines() -> None:
    def forces(sine: Callable[[float, float, float], Any]) -> list[list[Any]]:
        return [
            [sine(0.05 * K, 2 * OMEGA, 0.0), sine(0.1 * K, OMEGA, 0.0)],
            [sine(-0.05 * K, 2 * OMEGA, 0.3), sine(0.1 * K, OMEGA, 0.1)],
        ]

    def function(amplitude: float, omega: float, phase: float) -> Callable[[float], float]:
        return lambda t: amplitude * math.sin(omega * t + phase)

    one, two = (
        ts.simulate_array(ts.hman(), 30.0, 0.167, forces(form), DURATION) for form in (ts.Sine, function)
    )
    # both positions are below 1 m
    np.testing.assert_allclose(two.position, one.position, atol=1e-11)
    assert two.status == "completed"
    assert two.force_error.max() < 1e-11


def test_ref_the_steady_state_is_the_transfer_matrix() -> None:
    force = lambda t: 2.0 * math.sin(12.0 * t)  # noqa: E731
    dyad = ts.Dyad(ts.Robot(1.0, 8.0), ts.Robot(1.5, 9.0), operators=(ts.Operator(stiffness=50.0),) * 2)
    found = ts.simulate_array(dyad, 20.0, (0.1, 0.05), [[force], [0.0]], 30.0, rate=100.0)
    matrix = ts.transfer_matrix(dyad, 20.0, (0.1, 0.05), 12j)
    expected = 2.0 * np.imag(matrix[:, 0] * np.exp(12j * found.time)[:, None])
    # after 20 s transients have decayed: the abscissa is below -2/s
    late = found.time > 20.0
    np.testing.assert_allclose(found.position[late, :, 0], expected[late], atol=1e-12)


def gauss(centre: float, width: float) -> Callable[[float], float]:
    return lambda t: math.exp(-(((t - centre) / width) ** 2))


# a function that does not say where it jumps or bends, and the same force in another form
ALIKE: dict[str, tuple[Callable[[float], float], Any]] = {
    "constant": (lambda _: 3.0, 3.0),
    "nothing": (lambda _: 0.0, 0.0),
    "sine of 1 kHz": (lambda t: math.sin(2e3 * math.pi * t), ts.Sine(1.0, 2e3 * math.pi)),
    "late start": (lambda t: math.sin(7.0 * (t + 1e4)), ts.Sine(1.0, 7.0, 7e4)),
    "step": (lambda t: float(t > 10 / 3), ts.Signal(lambda t: float(t > 10 / 3), [10 / 3])),
    "step on an edge of a piece": (lambda t: float(t >= 2.5), ts.Signal(lambda t: float(t >= 2.5), [2.5])),
    "bend on an edge of a piece": (
        lambda t: abs(t - 2.5) ** 3,
        ts.Signal(lambda t: abs(t - 2.5) ** 3, [2.5]),
    ),
    "many steps": (
        lambda t: float(int(t / 0.37) % 2),
        ts.Sampled([float(i % 2) for i in range(40)], 1 / 0.37, hold="zero"),
    ),
    "a touch of 1 ms": (
        lambda t: float(7.0 < t < 7.001),
        ts.Signal(lambda t: float(7.0 < t < 7.001), [7.0, 7.001]),
    ),
    "a smooth touch of 1 ms": (
        gauss(7.0, 1e-3),
        ts.Signal(gauss(7.0, 1e-3), [6.99, 6.995, 7.0, 7.005, 7.01]),
    ),
    "kinks": (
        lambda t: abs(math.sin(3.0 * t)),
        ts.Signal(lambda t: abs(math.sin(3.0 * t)), [i * math.pi / 3.0 for i in range(1, 10)]),
    ),
    "bends of the third derivative": (
        lambda t: abs(t - math.pi) ** 3 / 30.0,
        ts.Signal(lambda t: abs(t - math.pi) ** 3 / 30.0, [math.pi]),
    ),
    "lines between samples": (
        lambda t: float(np.interp(t, np.arange(21.0) / 2.0, np.cos(np.arange(21.0)))),
        ts.Sampled(np.cos(np.arange(21.0)), 2.0),
    ),
}


@pytest.mark.parametrize("name", ALIKE)
def test_law_a_function_acts_like_the_same_force_in_another_form(name: str) -> None:
    function, other = ALIKE[name]
    expected = positions(other)
    # 1e-9 of 3 N on 30 N/m would be 1e-10 m; the start of a late sine is rounded at 7e4 rad: 1e-11
    np.testing.assert_allclose(positions(function), expected, atol=1e-10 * max(1.0, np.abs(expected).max()))


@pytest.mark.parametrize("name", ["step", "kinks", "a smooth touch of 1 ms", "bends of the third derivative"])
def test_cross_a_function_without_delay_as_scipy_integrates_it(name: str) -> None:
    function, _ = ALIKE[name]
    (m1, b1, m2, b2), k = ts.hman()["x"].parameters, 30.0

    def slope(t: float, y: Any) -> list[float]:
        x1, v1, x2, v2 = y
        pull = k * (x2 - x1)
        return [v1, (function(t) + pull - b1 * v1) / m1, v2, (-pull - b2 * v2) / m2]

    times = np.arange(1001) / 100
    # short steps: scipy's own error control passes over the touch
    found = solve_ivp(slope, (0.0, 10.0), [0.0] * 4, "DOP853", times, rtol=1e-10, atol=1e-12, max_step=5e-4)
    # a step off its place by scipy's own step of 0.5 ms would be 1e-5 m; its error control cuts it down
    np.testing.assert_allclose(positions(function, delay=0.0), found.y[[0, 2]].T, atol=1e-9)


def test_cross_a_function_as_the_adaptive_solver_integrates_it() -> None:
    (m1, b1, m2, b2), k, delay = ts.hman()["x"].parameters, 30.0, 0.167
    function, _ = ALIKE["kinks"]

    def slope(t: float, y: Any, delayed: Any) -> list[float]:
        first, second = k * (delayed[0][2] - y[0]), k * (delayed[0][0] - y[2])
        return [y[1], (function(t) + first - b1 * y[1]) / m1, y[3], (second - b2 * y[3]) / m2]

    kinks = [i * math.pi / 3.0 for i in range(1, 10)]
    solution = ts.solve_dde(slope, delay, [0.0] * 4, (0.0, 10.0), 1e-11, 1e-13, breakpoints=kinks)
    expected = solution(np.arange(1001) / 100)[:, [0, 2]]
    np.testing.assert_allclose(positions(function), expected, atol=1e-9)


def hash_noise(t: float) -> float:
    """Return another value at every time, the same for the same time."""
    return math.sin(1e15 * math.sin(1e3 * t))


@pytest.mark.parametrize(
    "function", [hash_noise, pytest.param(lambda t: math.sin(1e6 * t), marks=pytest.mark.verify)]
)
def test_law_a_function_that_cannot_be_followed_is_a_status_and_a_warning(
    function: Callable[[float], float],
) -> None:
    with pytest.warns(ts.ApproximationWarning, match="force_error"):
        found = ts.simulate(ts.hman(), 30.0, 0.167, [[function, 0.0], STILL], 2.0, rate=10.0)
    assert found.attrs["status"] == "not resolved"
    # of the size of the force itself, or of what the longest fit leaves; the others are exact
    assert 1e-3 < found.force_error.values[0, 0] < 10.0
    assert found.force_error.values[0, 1] == 0.0


def test_law_single_precision_is_noise_of_its_size() -> None:
    with pytest.warns(ts.ApproximationWarning, match="e-08 N"):
        found = ts.simulate(
            ts.hman(), 30.0, 0.167, [[lambda t: float(np.float32(math.sin(t))), 0.0], STILL], 10.0, rate=10.0
        )
    exact = ts.simulate(ts.hman(), 30.0, 0.167, [[ts.Sine(1.0, 1.0), 0.0], STILL], 10.0, rate=10.0)
    np.testing.assert_allclose(found.position, exact.position, atol=1e-7)


def test_law_a_history_that_cannot_be_followed_is_a_status_and_a_warning() -> None:
    def swing(t: float) -> float:
        return float(np.float32(math.cos(3.0 * t)))

    with pytest.warns(ts.ApproximationWarning, match="history_error"):
        found = ts.simulate(
            ts.hman(), 30.0, 0.167, [STILL, STILL], 2.0, history=[[swing, 0.0], STILL], rate=10.0
        )
    assert found.attrs["status"] == "not resolved"


def test_law_a_random_function_is_refused_and_its_remedy_works() -> None:
    rng = np.random.default_rng(1)
    with pytest.raises(ts.InvalidInput, match="sampled signal") as refused:
        ts.simulate(ts.hman(), 30.0, 0.167, [[lambda _: rng.normal(), 0.0], STILL], 2.0)
    assert refused.value.field.startswith("forces[0][0].function(")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sampled = ts.Sampled(rng.normal(size=2001), 1000.0)
        found = ts.simulate(ts.hman(), 30.0, 0.167, [[sampled, 0.0], STILL], 2.0)
    assert found.attrs["status"] == "completed"
