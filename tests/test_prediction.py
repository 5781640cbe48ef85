"""Verdicts of prediction: closed forms, Riccati equations, the sampled loop, and the numbers of the docs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg

import telespring as ts

#: axis x of the first H-MAN, Table III of Du et al. 2025
MASS, DAMPING = 0.8334, 7.7257
PAGE = Path(__file__).parents[1] / "docs" / "prediction.md"
VELOCITY = {"kind": "kalman", "model": "constant-velocity", "process": 1.0, "position": 1e-4}
ACCELERATION = {"kind": "kalman", "model": "constant-acceleration", "process": 100.0, "position": 1e-4}
PREDICTORS: tuple[Any, ...] = ("linear", VELOCITY, ACCELERATION)


def filter_matrices(predictor: dict[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the transition of the motion model, the intensity of its noise, and what is measured."""
    order = 2 if predictor["model"] == "constant-velocity" else 3
    drift = np.diag(np.ones(order - 1), 1)
    noise = np.zeros((order, order))
    noise[-1, -1] = predictor["process"]
    return drift, noise, np.eye(1, order)


def response(predictor: Any, s: np.ndarray, delay: float) -> np.ndarray:
    """Return predicted over true position at s, by the Riccati equation of the filter."""
    if predictor == "linear":
        return (1 + delay * s) * np.exp(-delay * s)
    drift, noise, seen = filter_matrices(predictor)
    density = np.array([[predictor["position"] ** 2 * 1e-3]])
    covariance = scipy.linalg.solve_continuous_are(drift.T, seen.T, noise, density)
    gain = covariance @ seen.T / density
    ahead = seen @ scipy.linalg.expm(delay * drift)
    closed = drift - gain @ seen
    return np.array(
        [
            (ahead @ np.linalg.solve(point * np.eye(len(drift)) - closed, gain))[0, 0]
            * np.exp(-delay * point)
            for point in s
        ]
    )


def closed_form(predictor: Any, delay: float) -> float:
    """Return the smallest stiffness with a root on the imaginary axis, of two identical free robots.

    There k = -(m s² + b s) / (1 ± H e^(-δ s)).
    """
    s = 1j * np.linspace(1e-2, 80.0, 8001)
    h = response(predictor, s, delay)
    limits = []
    for sign in (1, -1):
        k = -(MASS * s**2 + DAMPING * s) / (1 + sign * h)
        crossing = np.nonzero((k.imag[:-1] * k.imag[1:] < 0) & (np.abs(np.diff(k.imag)) < 1e3))[0]
        share = k.imag[crossing] / (k.imag[crossing] - k.imag[crossing + 1])
        limits += [v for v in k.real[crossing] + share * np.diff(k.real)[crossing] if v > 0]
    return float(min(limits))


@pytest.mark.parametrize("predictor", PREDICTORS)
@pytest.mark.parametrize("delay", [0.03, 0.084, 0.2])
def test_cross_the_limit_is_that_of_the_closed_form(predictor: Any, delay: float) -> None:
    limit = ts.maximum_stiffness(MASS, DAMPING, MASS, DAMPING, delay, predictor=predictor)
    assert limit == pytest.approx(closed_form(predictor, delay), rel=1e-4)
    assert ts.maximum_delay(MASS, DAMPING, MASS, DAMPING, limit, predictor=predictor) == pytest.approx(delay)


def sampled_radius(k: float, lag: int, predictor: Any, period: float = 1e-3) -> float:
    """Return the spectral radius of one period of two robots: both sides sample, predict and hold a force."""
    rate = DAMPING / MASS
    fade = np.exp(-rate * period)
    plant = np.array([[1.0, (1 - fade) / rate], [0.0, fade]])
    push = np.array([(period - (1 - fade) / rate) / DAMPING, (1 - fade) / DAMPING])
    if predictor == "linear":
        order, gain, move, ahead = 0, None, None, None
    else:
        drift, noise, seen = filter_matrices(predictor)
        order = len(drift)
        # Van Loan: transition and noise over one period
        block = scipy.linalg.expm(period * np.block([[-drift, noise], [np.zeros_like(drift), drift.T]]))
        move = block[order:, order:].T
        covariance = scipy.linalg.solve_discrete_are(
            move.T, seen.T, move @ block[:order, order:], [[predictor["position"] ** 2]]
        )
        gain = (covariance @ seen.T / (seen @ covariance @ seen.T + predictor["position"] ** 2))[:, 0]
        ahead = (seen @ scipy.linalg.expm(lag * period * drift))[0]
    # per side: position, velocity, their past, estimate after the last sample
    side = 2 + 2 * lag + order
    matrix = np.zeros((2 * side, 2 * side))
    for own, other in ((0, side), (side, 0)):
        delayed = np.zeros((2, 2 * side))  # the partner's motion as played
        for i in range(2):
            delayed[i, other + (2 * lag + i if lag else i)] = 1.0
        if predictor == "linear":
            predicted = delayed[0] + lag * period * delayed[1]
        else:
            estimate = np.zeros((order, 2 * side))
            estimate[:, own + 2 + 2 * lag : own + side] = move
            assert gain is not None
            assert ahead is not None
            estimate += np.outer(gain, delayed[0] - estimate[0])
            matrix[own + 2 + 2 * lag : own + side] = estimate
            predicted = ahead @ estimate
        force = k * predicted
        force[own] -= k
        matrix[own : own + 2, own : own + 2] += plant
        matrix[own : own + 2] += np.outer(push, force)
        for i in range(2 * lag):
            matrix[own + 2 + i, own + i] = 1.0
    roots = np.linalg.eigvals(matrix)
    return float(np.max(np.abs(roots[np.abs(roots - 1.0) > 1e-7])))


@pytest.mark.parametrize("predictor", PREDICTORS)
def test_cross_the_sampled_loop_with_the_live_gain_loses_stability_there(predictor: Any) -> None:
    for lag in (30, 84):
        limit = ts.maximum_stiffness(MASS, DAMPING, MASS, DAMPING, lag * 1e-3, predictor=predictor)
        # a held force of 1 ms and the own sample cost up to a few per cent of the stiffness
        assert sampled_radius(0.93 * limit, lag, predictor) < 1.0
        assert sampled_radius(1.03 * limit, lag, predictor) > 1.0


def test_law_every_form_of_a_question_has_the_same_answer() -> None:
    dyad = ts.hman()
    delays = np.array([0.05, 0.167])
    for predictor in ("hold", *PREDICTORS, "shared-target"):
        both = np.asarray(ts.maximum_stiffness(dyad, delays, predictor=predictor))
        single = [
            min(float(ts.maximum_stiffness(axis, delay, predictor=predictor)) for axis in dyad)
            for delay in delays
        ]
        assert both == pytest.approx(single)
        k = np.outer([0.9, 1.1], both)
        assert (np.asarray(ts.unstable_root_count(dyad, k, delays, predictor=predictor)) > 0).tolist() == [
            [False, False],
            [True, True],
        ]
        stable = ts.stability_map(dyad, [0.9 * both[0], 1.1 * both[0]], [0.05], predictor=predictor)
        assert stable.tolist() == [[True], [False]]
        for share, is_stable in ((0.97, True), (1.03, False)):
            roots = [
                dyad.delay_system(share * both[1], 0.167, axis, predictor=predictor) for axis in range(2)
            ]
            assert (max(system.spectral_abscissa_without_zero() for system in roots) < 0) is is_stable
    assert ts.maximum_stiffness(dyad, 0.1, predictor="hold") == ts.maximum_stiffness(dyad, 0.1)
    assert ts.maximum_stiffness(dyad, 0.1, predictor="shared-target") == ts.maximum_stiffness(dyad, 0.1)


def test_law_with_linear_prediction_no_stiffness_bears_every_delay() -> None:
    k = np.array([2.0, 10.0, 30.0])
    assert np.isinf(ts.maximum_delay(ts.hman(), k)).all()
    longest = ts.maximum_delay(ts.hman(), k, predictor="linear")
    assert np.isfinite(longest).all()
    assert (np.diff(longest) < 0).all()


@pytest.mark.parametrize(
    ("predictor", "field"),
    [
        ("lineal", "predictor"),
        (3, "predictor"),
        ({}, "predictor.kind"),
        ({"kind": "cubic"}, "predictor.kind"),
        ({"kind": "linear", "process": 1.0}, "predictor.process"),
        ({"kind": "kalman", "model": "constant-jerk"}, "predictor.model"),
        ({"kind": "kalman", "process": -1.0}, "predictor.process"),
        ({"kind": "kalman", "position": "1"}, "predictor.position"),
        ({"kind": "kalman", "position": 1e-12}, "predictor.position"),
        ({"kind": "kalman", "sample_period": 0.0}, "predictor.sample_period"),
        ({"kind": "kalman", "window": 3}, "predictor.window"),
    ],
)
def test_law_what_is_no_predictor_is_refused(predictor: Any, field: str) -> None:
    for ask in (
        lambda: ts.maximum_stiffness(ts.hman(), 0.1, predictor=predictor),
        lambda: ts.hman().delay_system(71.0, 0.1, predictor=predictor),
    ):
        with pytest.raises(ts.InvalidInput) as refused:
            ask()
        assert refused.value.field == field
    with pytest.raises(ts.InvalidInput):
        ts.maximum_delay(ts.hman(), 71.0, "paper", predictor="linear")


def printed_limits() -> list[tuple[float, list[float]]]:
    """Return the delay (s) and the limits (N/m) of every row of the page's table."""
    text = PAGE.read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) ms \|((?: [\d.]+ \|){4})$", text, re.MULTILINE)
    return [(float(delay) / 1e3, [float(cell) for cell in cells.split("|")[:-1]]) for delay, cells in rows]


def test_law_the_page_prints_the_limits() -> None:
    rows = printed_limits()
    assert len(rows) >= 7
    for column, predictor in enumerate(("hold", *PREDICTORS)):
        limits = np.asarray(
            ts.maximum_stiffness(ts.hman(), [delay for delay, _ in rows], predictor=predictor)
        )
        # one digit after the point, rounded down
        assert [np.floor(10 * limit) / 10 for limit in limits] == [cells[column] for _, cells in rows]


def test_law_the_map_draws_the_limits() -> None:
    ax = ts.plot.prediction_map(ts.hman(), ["hold", "linear"], points=8)
    hold, linear = (np.asarray(line.get_xydata()) for line in ax.get_lines())
    assert hold[3] == pytest.approx([ts.maximum_stiffness(ts.hman(), 1e-3 * hold[3, 1]), 131.25])
    assert linear[3, 0] == pytest.approx(ts.maximum_stiffness(ts.hman(), 0.13125, predictor="linear"))
    [stable] = ax.collections
    assert stable.get_datalim(ax.transData).y0 == 0.0, "without a delay every stiffness is stable"
    with pytest.raises(ts.InvalidInput):
        ts.plot.prediction_map(ts.hman(), [])
