"""Every limit that `decide` prints follows from docs/limits.md, and says which controllers it is for."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve
from typer.testing import CliRunner

import telespring as ts
from one_period_map import gain, radius
from questions import decide, limits
from telespring._types import FloatArray
from telespring.cli import app

ASKED = ("decide", "--robot", "1.2,6", "--robot", "2,9", "--delay", "40ms")
PERIOD = 0.001


def printed(*arguments: str) -> str:
    found = CliRunner(env={"COLUMNS": "200", "NO_COLOR": "1"}).invoke(app, [*ASKED, *arguments])
    assert found.exit_code == 0, found.output
    return found.stdout


def answered(*arguments: str) -> dict[str, Any]:
    answer: dict[str, Any] = json.loads(printed("--json", *arguments))
    return answer


def continuous_constant_delay() -> float:
    """Return where a root first reaches the imaginary axis at 40 ms, N/m: P₁P₂ = k² e^(−2jωδ) in ω and k."""

    def residual(unknown: FloatArray) -> FloatArray:
        omega, k = unknown
        s = 1j * omega
        gap = (1.2 * s**2 + 6.0 * s + k) * (2.0 * s**2 + 9.0 * s + k) - k**2 * np.exp(-0.08 * s)
        return np.array([gap.real, gap.imag])

    found = fsolve(residual, np.array([17.0, 200.0]), xtol=1e-13)
    assert np.abs(residual(found)).max() < 1e-6
    assert found[0] > 1.0
    return float(found[1])


def closed_forms() -> dict[str, tuple[float, float]]:
    """Return the continuous closed form and the sampled limit of each rule, N/m, from docs/limits.md."""
    ages = 2 * (0.040 + PERIOD)
    x = 6.0 * PERIOD / 1.2
    varying = brentq(
        lambda k: 2.0 * math.sqrt((6.0 - k * PERIOD) * (9.0 - k * PERIOD)) / ages - k, 1.0, 500.0
    )
    sides = ((1.2, 6.0, 0.0), (2.0, 9.0, 0.0))
    constant = brentq(lambda k: radius(sides, k, 0.0, PERIOD, 0.0, (40, 40)) - 1.0, 150.0, 250.0)
    return {
        "any_network": (36.0 / 4.8, 6.0 / PERIOD / (x**-0.5 + (1.0 - math.exp(-x)) ** -0.5) ** 2),
        "bounded_varying_delay": (2.0 * math.sqrt(54.0) / ages, float(varying)),
        "any_constant_delay": ((36.0 + 81.0) / (2.0 * 3.2), (36.0 + 81.0) / (2.0 * 3.2)),
        "constant_delay": (continuous_constant_delay(), float(constant)),
    }


def test_ref_the_limits_follow_from_the_numbers_on_their_page(root: Path) -> None:
    page, screen = (root / "docs" / "limits.md").read_text(), printed()
    verdicts = answered()["delays"][0]["verdicts"]
    for key, (continuous, sampled) in closed_forms().items():
        bound = verdicts[key]["stiffness_limit"]
        if key == "any_constant_delay":
            assert bound is None
            bound = verdicts[key]["stiffness_allowed"]
        assert bound == pytest.approx(sampled, rel=2e-6), key
        # What is printed is rounded down, and stands on the page beside the closed form.
        shown = f"{math.floor(bound * 10 ** (2 if bound < 100 else 1)) / 10 ** (2 if bound < 100 else 1):.4g}"
        assert shown in screen, (key, shown)
        assert f"{shown} N/m" in page, (key, shown)
        assert f"{continuous:.4g} N/m" in page, (key, continuous)
    assert "T₁+T₂ = 82 ms" in screen
    assert "h = 1 ms" in screen
    plain = limits(ts.Dyad(ts.Robot(1.2, 6.0), ts.Robot(2.0, 9.0)), 0.04, sample_period=0.0).delays[0]
    assert plain.stiffness_limit == pytest.approx(closed_forms()["constant_delay"][0], rel=1e-9)


def test_law_json_says_which_controllers_a_bound_is_for() -> None:
    answer = answered("--stiffness", "150")
    constant = answer["verdicts"]["constant_delay"]
    assert constant["controllers"] == "continuous"
    assert constant["stiffness_limit"] == answer["remedies"]["stiffness"] < constant["stiffness_allowed"]
    assert answer["verdicts"]["any_network"]["controllers"] == "sampled"
    assert answer["verdicts"]["any_constant_delay"]["stiffness_limit"] is None
    assert "controllers" not in answer["verdicts"]["paper"]
    plain = answered("--stiffness", "150", "--continuous")["verdicts"]["constant_delay"]
    assert plain["stiffness_limit"] == plain["stiffness_allowed"]
    [axis] = answer["axes"]
    assert axis["sampled_stable_delays"][0][1] == answer["remedies"]["delay"]
    assert answer["remedies"]["delay_attained"]
    assert answer["remedies"]["delay_proven"]


@pytest.mark.parametrize(
    ("robots", "grounds", "delay", "period", "unstable", "stable"),
    [
        # an undamped robot in a hand without damping: the hold feeds in proportion to k
        (((1.0, 0.0), (1.0, 5.0)), (0.0, 50.0), 0.02, 0.001, None, 40.0),
        (((1.0, 0.0), (1.0, 5.0)), (50.0, 0.0), 0.02, 0.001, 0.1, 40.0),
        # free: m/b = 1.43 ms is below half of the period
        (((1.0, 0.0), (1.0, 700.0)), (0.0, 0.0), 0.02, 0.005, 1.0, None),
    ],
)
def test_cross_a_limit_of_zero_is_true_and_says_why(
    robots: tuple[tuple[float, float], tuple[float, float]],
    grounds: tuple[float, float],
    delay: float,
    period: float,
    unstable: float | None,
    stable: float | None,
) -> None:
    one, other = (ts.Robot([m], [b]) for m, b in robots)
    dyad = ts.Dyad(one, other, tuple(ts.Operator(stiffness=[ground]) for ground in grounds))
    [row] = limits(dyad, delay, sample_period=period).delays
    assert row.stiffness_limit == row.usable_stiffness == 0.0
    assert row.soft_springs_fail_by_sampling
    sides = tuple((m, b, ground) for (m, b), ground in zip(robots, grounds, strict=True))
    ticks = round(delay / period)
    for k, is_stable in ((unstable, False), (stable, True)):
        if k is not None:
            size = radius((sides[0], sides[1]), k, 0.0, period, 0.0, (ticks, ticks))
            assert (size < 1.0) == is_stable
            assert decide(dyad, k, delay, sample_period=period).stable == is_stable
    # Half of the period is below m/b for a moderate damping: then the limit is not 0.
    calm = ts.Dyad(ts.Robot([1.0], [0.0]), ts.Robot([1.0], [5.0]))
    assert limits(calm, delay).delays[0].stiffness_limit > 0.0


def test_law_a_gain_of_one_is_proven_or_said_not_to_be() -> None:
    """The product of both gains, summed sample by sample, is below 1 at 15 stiffnesses up to the bound."""
    random = np.random.default_rng(3)
    proven = 0
    for _ in range(16):
        mass, damping = random.uniform(0.3, 3.0, 2), random.uniform(0.5, 12.0, 2)
        ground = 10.0 ** random.uniform(-6.0, 2.5, 2)
        ground[random.integers(2)] *= random.integers(2)
        if not ground.any():
            continue
        one, other = (ts.Robot([m], [b]) for m, b in zip(mass, damping, strict=True))
        dyad = ts.Dyad(one, other, tuple(ts.Operator(stiffness=[g]) for g in ground))
        tier = ts.verdicts(dyad, 1.0, 0.1, sample_period=0.005).tier("any network")
        assert tier.stiffness_bound is not None
        assert tier.least_found is not None
        assert 0.0 < tier.stiffness_bound <= tier.least_found
        assert tier.proven == (1.05 * tier.stiffness_bound >= tier.least_found)
        proven += tier.proven
        sides = list(zip(mass.tolist(), damping.tolist(), ground.tolist(), strict=True))
        for k in np.linspace(0.05, 0.999, 15) * tier.stiffness_bound:
            assert gain(sides[0], k, 0.005) * gain(sides[1], k, 0.005) < 1.0 + 1e-9
        above = 1.001 * tier.least_found
        assert gain(sides[0], above, 0.005) * gain(sides[1], above, 0.005) > 1.0
    assert proven >= 8
