"""Age in a range: the verdict from Python, compared with the gain of the loop on a grid of frequencies."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from typer.testing import CliRunner

import telespring as ts
from telespring.cli import app
from telespring.decision.question import Question
from telespring.decision.varying_delay import varying_delay

ARM = ts.Robot(0.8334, 7.7257)


def gain(
    k: float, ages: tuple[tuple[float, float], tuple[float, float]], one: ts.Robot, two: ts.Robot
) -> float:
    """Return the largest singular value over all frequencies, with the best constant scale."""
    (low1, high1), (low2, high2) = ages
    half1, half2 = 0.5 * (high1 - low1), 0.5 * (high2 - low2)
    s = 1j * np.logspace(-2, 3, 20_000)
    p1, p2 = ((float(r.mass[0]) * s + float(r.damping[0])) * s + k for r in (one, two))
    e1, e2 = np.exp(-s * 0.5 * (low1 + high1)), np.exp(-s * 0.5 * (low2 + high2))
    common = s * k / (p1 * p2 - k * k * e1 * e2)

    def largest(log: float) -> float:
        scale = math.exp(log)
        matrix = np.empty((s.size, 2, 2), complex)
        matrix[:, 0, 0], matrix[:, 0, 1] = half1 * k * e2, half1 * p1 / scale
        matrix[:, 1, 0], matrix[:, 1, 1] = half2 * p2 * scale, half2 * k * e1
        return float(np.linalg.norm(common[:, None, None] * matrix, 2, axis=(1, 2)).max())

    return float(minimize_scalar(largest, bounds=(-4.0, 4.0), method="bounded").fun)


@pytest.mark.parametrize("ages", [((0.03, 0.07), (0.03, 0.07)), ((0.09, 0.12), (0.02, 0.1))])
def test_cross_the_bound_is_where_the_gain_on_a_grid_reaches_one(
    ages: tuple[tuple[float, float], tuple[float, float]],
) -> None:
    other = ts.Robot(1.9, 5.2)
    bound = ts.Dyad(ARM, other).axis(0).age_range_stiffness(ages[1], ages[0])
    assert gain(0.99 * bound, ages, ARM, other) < 1.0 < gain(1.01 * bound, ages, ARM, other)


def test_ref_a_little_jitter_no_longer_costs_a_tier() -> None:
    # DESIGN: 95 to 105 ms, 94.6 N/m, between 73.6 of a bounded delay and 98.9 of the longest constant one.
    found = ts.verdicts(ts.Dyad(ARM, ARM), 80.0, 0.095, jitter=0.01)
    tier = found.tier("age in a range")
    assert tier.stiffness_bound == pytest.approx(94.61, abs=0.01)
    assert tier.satisfied
    assert tier.ages is not None
    assert tier.ages[0] == pytest.approx((0.095, 0.105))
    assert found.stiffness_allowed is not None
    assert found.stiffness_allowed.tier == "age in a range"
    assert tier.attack is None
    attacked = ts.verdicts(ts.Dyad(ARM, ARM), 80.0, 0.095, jitter=0.01, attack_seed=3).tier("age in a range")
    assert attacked.attack == pytest.approx(97.0, rel=0.02)


def test_law_a_sampled_coupling_damper_has_no_bound() -> None:
    damped = ts.Dyad(ARM, ARM, coupling_damping=0.5)
    found = ts.verdicts(damped, 30.0, 0.1, jitter=0.01, sample_period=0.001).tier("age in a range")
    assert found.stiffness_bound is None
    assert found.unavailable == "coupling damping with sampled controllers"
    assert ts.verdicts(damped, 30.0, 0.1, jitter=0.01).tier("age in a range").satisfied


def test_law_without_jitter_it_is_the_constant_delay() -> None:
    found = ts.verdicts(ts.hman(), 30.0, 0.1)
    assert found.tier("age in a range").stiffness_bound == found.tier("constant delay").stiffness_bound
    assert found.stiffness_allowed is not None
    assert found.stiffness_allowed.tier == "constant delay"


def test_law_over_a_range_of_operators_no_single_pair_has_less() -> None:
    low, high = ts.Operator(0.1, 1.0, 20.0), ts.Operator(0.6, 3.0, 120.0)
    held = ts.verdicts(ts.Dyad(ARM, ARM), 30.0, 0.08, jitter=0.02, operator_range=ts.OperatorRange(low, high))
    tier = held.tier("age in a range")
    assert tier.stiffness_bound is not None
    random = np.random.default_rng(5)
    for _ in range(60):
        pair = [ts.Operator(*random.uniform((0.1, 1.0, 20.0), (0.6, 3.0, 120.0)).tolist()) for _ in range(2)]
        own = ts.verdicts(ts.Dyad(ARM, ARM, (pair[0], pair[1])), 30.0, 0.08, jitter=0.02)
        bound = own.tier("age in a range").stiffness_bound
        assert bound is not None
        assert bound >= tier.stiffness_bound


def test_law_decide_answers_by_it_while_the_delay_varies() -> None:
    question = Question(ts.hman(), ts.Network(0.08, jitter=0.02, sample_period=0.001))
    found = varying_delay(question, question.judge(80.0))
    assert found is not None
    assert (found.status, found.tier) == ("stable", "age in a range")
    assert varying_delay(question, question.judge(found.usable_stiffness)).status == "stable"  # type: ignore[union-attr]
    robots = ["--robot", "0.8334,7.7257"] * 2
    options = [*robots, "--stiffness", "80", "--delay", "80ms", "--jitter", "20ms"]
    answer = json.loads(CliRunner().invoke(app, ["decide", "--json", *options]).stdout)
    assert answer["varying_delay"]["verdict"] == "age in a range"
    assert answer["verdicts"]["age_in_a_range"]["ages"][0] == pytest.approx([0.08, 0.101])
