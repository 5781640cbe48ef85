"""Delays at which sampled controllers are stable: against an explicit matrix, over ranges, in `decide`."""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import telespring as ts
from one_period_map import radius
from questions import decide, limits
from telespring.cli import app

#: The seed of `make verify`.
DRAWN = int(os.environ.get("TELESPRING_VERIFY", "1"))

#: Stable on [0, 0.8508) and again on (1.7738, 2.1128) s with continuous controllers, at 9.174736188 N/m.
RESTABILISING = ts.Dyad(ts.Robot([0.97670822], [2.15372614]), ts.Robot([0.30379312], [4.59594729]))
ISLAND_STIFFNESS = 9.174736188


def random_case(random: np.random.Generator) -> dict[str, Any]:
    """Draw a dyad with any damping or none, hands or none, slow controllers and unequal delays."""
    mass = np.exp(random.uniform(np.log(0.2), np.log(4.0), 2))
    damping = np.exp(random.uniform(np.log(0.1), np.log(15.0), 2))
    ground = np.exp(random.uniform(0.0, 6.0, 2)) * (random.random() < 0.4)
    if random.random() < 0.1:
        damping[random.integers(2)] = 0.0
    if random.random() < 0.3:
        ground[random.integers(2)] = 0.0
    period = float(np.exp(random.uniform(np.log(0.002), np.log(0.1))))
    return {
        "sides": tuple(zip(mass.tolist(), damping.tolist(), ground.tolist(), strict=True)),
        "k": float(np.exp(random.uniform(0.0, np.log(min(4.0 * mass.min() / period**2, 2000.0))))),
        "c": float(random.uniform(0.0, 5.0)) if random.random() < 0.3 else 0.0,
        "period": period,
        "computing": period * float(random.random()) * float(random.choice([0.0, 0.5, 1.0])),
        "delay": (float(random.choice([1.0, 1.0, random.uniform(0.2, 5.0), 0.0])), 1.0),
    }


def disagreements(case: dict[str, Any], points: int, longest: float) -> list[Any]:
    """Compare all intervals of stable delays with the eigenvalues of the explicit matrix, on a grid."""
    (m1, b1, kh1), (m2, b2, kh2) = case["sides"]
    axis = ts.DyadAxis(m1, b1, m2, b2, kh1=kh1, kh2=kh2, c=case["c"])
    period = case["period"]
    intervals = axis.sampled_stable_delays(
        case["k"], period, case["computing"], case["delay"], (longest + 1.0) * period
    )
    shares = np.array(case["delay"]) / np.mean(case["delay"])
    found = []
    for periods in np.linspace(0.0, longest, points):
        mean = periods * period
        forward, backward = (math.ceil(share * periods - 1e-9) for share in shares)
        size = radius(case["sides"], case["k"], case["c"], period, case["computing"], (forward, backward))
        told = any((start < mean or start == 0.0) and mean <= end * (1.0 + 1e-12) for start, end in intervals)
        # Closer to the circle than this, the eigenvalues of the matrix do not decide.
        if told != (size < 1.0) and abs(size - 1.0) > 1e-8:
            found.append((case, periods, size, intervals))
    return found


def test_cross_stable_delays_against_the_one_period_matrix() -> None:
    random = np.random.default_rng(20260)
    assert [bad for _ in range(300) for bad in disagreements(random_case(random), 11, 8.0)] == []


@pytest.mark.verify
def test_cross_stable_delays_against_the_one_period_matrix_at_length() -> None:
    random = np.random.default_rng(DRAWN)
    assert [bad for _ in range(3000) for bad in disagreements(random_case(random), 97, 24.0)] == []


def random_range(random: np.random.Generator) -> tuple[ts.Dyad, tuple[ts.OperatorRange, ts.OperatorRange]]:
    mass, damping = random.uniform(0.4, 3.0, 2), random.uniform(0.5, 10.0, 2)
    ranges = []
    for _ in range(2):
        low, softest = random.uniform(0.0, 3.0) * random.integers(2), random.uniform(0.0, 150.0)
        ranges.append(
            ts.OperatorRange(
                ts.Operator(stiffness=[softest], damping=[low]),
                ts.Operator(
                    stiffness=[softest + random.uniform(0.0, 300.0)],
                    damping=[low + random.uniform(0.0, 5.0)],
                    mass=[random.uniform(0.0, 0.8)],
                ),
            )
        )
    one, other = (ts.Robot([m], [b]) for m, b in zip(mass, damping, strict=True))
    return ts.Dyad(one, other), (ranges[0], ranges[1])


def least_limit(
    dyad: ts.Dyad, ranges: tuple[ts.OperatorRange, ts.OperatorRange], k: float, period: float, count: int,
    random: np.random.Generator,
) -> float:  # fmt: skip
    """Return the smallest limit of single operators, drawn from the box and its corners."""
    least = math.inf
    for _ in range(count):
        values: list[float] = []
        grounds: list[float] = []
        for robot, held in zip(dyad.robots, ranges, strict=True):
            at = np.where(random.random(3) < 0.4, random.integers(0, 2, 3), random.random(3))
            mass, damping, ground = (
                getattr(held.low, name)[0] + part * (getattr(held.high, name)[0] - getattr(held.low, name)[0])
                for part, name in zip(at, ("mass", "damping", "stiffness"), strict=True)
            )
            values += [robot.mass[0] + mass, robot.damping[0] + damping]
            grounds.append(ground)
        axis = ts.DyadAxis(*values, kh1=grounds[0], kh2=grounds[1])
        first = axis.sampled_stable_delays(k, period)
        least = min(least, first[0][1] if first and first[0][0] == 0.0 else 0.0)
    return least


def check_ranges(seed: int, ranges: int, operators: int) -> None:
    random = np.random.default_rng(seed)
    for _ in range(ranges):
        dyad, held = random_range(random)
        k, period = float(random.uniform(10.0, 250.0)), float(random.choice([0.001, 0.002, 0.005]))
        limit = ts.delay_limit(dyad, k, ts.Network(0.05, sample_period=period), held)
        least = least_limit(dyad, held, k, period, operators, random)
        assert limit.delay <= least * (1.0 + 1e-9), (dyad, held, k, period, limit, least)
        if limit.proven:
            assert 1.05 * limit.delay + period >= limit.least_found * (1.0 - 1e-9)


def test_cross_no_operator_of_a_range_is_unstable_below_the_limit_of_the_delay() -> None:
    check_ranges(5, ranges=25, operators=100)


@pytest.mark.verify
def test_cross_no_operator_of_a_range_is_unstable_below_the_limit_at_length() -> None:
    check_ranges(DRAWN, ranges=500, operators=1000)


def test_ref_the_sampled_limit_tends_to_that_of_continuous_controllers() -> None:
    """Half a period of hold and k h/2 less damping, to first order in the period."""
    k = 71.2
    exact = ts.delay_limit(ts.hman(), k, ts.Network(0.1)).delay
    for period in (1e-3, 1e-4, 1e-5):
        lag = 0.5 * period
        one, other = (ts.Robot(robot.mass, robot.damping - k * lag) for robot in ts.hman().robots)
        first_order = ts.delay_limit(ts.Dyad(one, other), k, ts.Network(0.1)).delay - lag
        limit = ts.delay_limit(ts.hman(), k, ts.Network(0.1, sample_period=period))
        assert limit.attained
        assert limit.proven
        assert first_order - 1.1 * period < limit.delay < first_order + 0.1 * period
        assert limit.delay < exact


def test_law_only_the_round_trip_counts_but_for_whole_periods() -> None:
    equal = ts.delay_limit(ts.hman(), 71.2, ts.Network(0.1, sample_period=0.001)).delay
    for pair in ((0.05, 0.15), (0.0, 0.2), (0.2, 0.0), (0.0999, 0.1001)):
        unequal = ts.delay_limit(ts.hman(), 71.2, ts.Network(pair, sample_period=0.001)).delay
        assert abs(unequal - equal) <= 0.001 + 1e-12


def test_ref_two_undamped_robots_with_a_damper_are_stopped_by_any_delay() -> None:
    axis = ts.DyadAxis(1.0, 0.0, 2.0, 0.0, c=3.0)
    [(start, end)] = axis.sampled_stable_delays(5.0, 0.02)
    assert 0.0 < start < 1e-300
    last = round(end / 0.02)
    sides = ((1.0, 0.0, 0.0), (2.0, 0.0, 0.0))
    sizes = [radius(sides, 5.0, 3.0, 0.02, 0.0, (ticks, ticks)) for ticks in (1, last, last + 1)]
    assert sizes[0] < 1.0
    assert sizes[1] < 1.0 < sizes[2]


@pytest.mark.parametrize(
    ("delay", "is_stable", "keeps_delay"),
    [(0.7, True, True), (1.2, False, False), (1.82, True, False), (1.95, True, True), (2.05, True, False)],
)
def test_ref_stable_again_beyond_the_first_limit(delay: float, is_stable: bool, keeps_delay: bool) -> None:
    """Published intervals; the reserve of 5 % reaches from 0.95 to 1.05 of the delay there."""
    for period in (0.0, 0.001):
        found = decide(RESTABILISING, ISLAND_STIFFNESS, delay, sample_period=period)
        assert found.stable == is_stable, period
        assert found.keeps_delay_reserve == keeps_delay, period
        # A period takes half of itself from the delay, and some damping.
        assert found.delay_limit == pytest.approx(0.8508, abs=1e-4 + 12.0 * period)
        [axis] = found.axes
        around = axis.worst_case.stable_around
        if delay > 1.8:
            assert around == pytest.approx((1.7738, 2.1128), abs=1e-4 + 45.0 * period)


def test_law_the_screen_says_that_it_is_stable_again() -> None:
    robots = ("--robot", "0.97670822,2.15372614", "--robot", "0.30379312,4.59594729")
    asked = ("decide", *robots, "--stiffness", str(ISLAND_STIFFNESS), "--delay", "1.95s")
    screen = CliRunner(env={"COLUMNS": "300", "NO_COLOR": "1"}).invoke(app, list(asked)).stdout
    assert "stable again beyond a first limit of 840 ms: the delay may grow by 144 ms, to 2.094 s" in screen
    assert "shrink by 135 ms, to 1.815 s" in screen
    assert "continuous controllers the delay" not in screen


def test_law_a_reserve_has_no_gap() -> None:
    """Both ends of the reserve are stable, and something between them is not."""
    network = ts.Network(1.3, sample_period=0.001)
    both = (0.6, 1.45)
    for factor in both:
        assert decide(RESTABILISING, ISLAND_STIFFNESS, factor * 1.3).stable
    assert not ts.is_stable_over_delays(RESTABILISING, ISLAND_STIFFNESS, network, both)
    assert ts.is_stable_over_delays(RESTABILISING, ISLAND_STIFFNESS, network, (1.4, 1.5))
    assert ts.is_stable_over_delays(RESTABILISING, ISLAND_STIFFNESS, network, (0.1, 0.6))
    # Unstable from 101.6 N/m to some 123 N/m, stable on both sides of it.
    window = ts.Dyad(
        ts.Robot([2.0], [0.2455]),
        ts.Robot([0.6], [0.2455]),
        (ts.Operator(stiffness=[900.0]), ts.Operator(stiffness=[370.0])),
    )
    slow = ts.Network(0.055, sample_period=0.005)
    assert ts.is_stable_over_stiffnesses(window, (50.0, 101.0), slow)
    assert ts.is_stable_over_stiffnesses(window, (125.0, 200.0), slow)
    assert not ts.is_stable_over_stiffnesses(window, (101.0, 125.0), slow)


def test_law_a_range_whose_ends_do_not_ascend_is_refused() -> None:
    network = ts.Network(0.1, sample_period=0.001)
    for ends in ((80.0, 60.0), (60.0, float("inf")), (float("nan"), 60.0)):
        with pytest.raises(ts.InvalidInput, match="stiffnesses"):
            ts.is_stable_over_stiffnesses(ts.hman(), ends, network)
    for ends in ((1.1, 0.9), (-0.1, 1.0), (0.0, float("inf"))):
        with pytest.raises(ts.InvalidInput, match="factors"):
            ts.is_stable_over_delays(ts.hman(), 60.0, network, ends)


def test_law_a_delay_at_the_limit_is_stable_and_the_next_period_is_not() -> None:
    for k in (40.0, 71.2, 120.0):
        limit = decide(ts.hman(), k, 0.05).delay_limit
        assert decide(ts.hman(), k, limit).stable
        assert not decide(ts.hman(), k, limit + 1e-6).stable


@pytest.mark.parametrize("delay", [(0.03, 0.09), (0.0, 0.12), 0.06])
def test_law_what_may_be_used_is_stable_with_unequal_delays(delay: float | tuple[float, float]) -> None:
    usable = limits(ts.hman(), delay).delays[0].usable_stiffness
    assert decide(ts.hman(), usable, delay).status == "stable"
    assert decide(ts.hman(), 1.03 * usable, delay).status == "marginal"


def test_law_a_limit_that_was_not_found_is_not_called_unstable() -> None:
    dyad = ts.Dyad(ts.Robot(0.23, 0.072), ts.Robot(0.32, 0.155), coupling_damping=4.33)
    hands = ts.OperatorRange(ts.Operator(), ts.Operator(stiffness=300.0))
    screen = " ".join(str(ts.decide(dyad, delay=0.056, operator_range=hands)).split())
    assert "No limit is proven at this constant delay" in screen
    assert "even a soft spring is unstable" not in screen
