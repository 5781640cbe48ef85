"""Published numbers, and those of the paper's own robots, through the public functions.

Where the paper is wrong both values stand here: what it prints or its formula gives, and what is true.
"""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import telespring as ts
from telespring.references import read_reference

# Du, Kulkarni, Kager, Campolo, Table III: m1, b1, m2, b2 of the two H-MANs
HMAN = {"x": (0.8334, 7.7257, 0.7776, 7.4208), "y": (1.0649, 10.1168, 1.3407, 9.3496)}


def paper_by_hand(m1: float, b1: float, m2: float, b2: float) -> float:
    return (b1**2 + b2**2) / (2 * (m1 + m2))  # Eq. 5


def pair(m1: float, b1: float, m2: float, b2: float) -> ts.Dyad:
    return ts.Dyad(ts.Robot(m1, b1), ts.Robot(m2, b2))


def test_ref_hman_is_table_three(hman: ts.Dyad) -> None:
    for index, axis in enumerate("xy"):
        one, two = hman.robots
        assert (one.mass[index], one.damping[index], two.mass[index], two.damping[index]) == HMAN[axis]


@pytest.mark.parametrize(("axis", "printed"), [("x", 35.615988), ("y", 39.442273)])
def test_ref_hman_critical_stiffness(axis: str, printed: float) -> None:
    by_hand = paper_by_hand(*HMAN[axis])
    assert by_hand == pytest.approx(printed, abs=5e-7)  # half a unit of the last digit printed
    # similar robots: Eq. 5 is exact here; 1e-10: what every criterion is promised to
    assert ts.critical_stiffness(*HMAN[axis]) == pytest.approx(by_hand, rel=1e-10)
    assert ts.critical_stiffness(*HMAN[axis], method="paper") == pytest.approx(by_hand, rel=1e-14)


@pytest.mark.parametrize(
    ("axis", "times", "seconds"),
    [
        # Eqs. 6 to 9 at twice and four times K_xy, the x axis' K (Eq. 11); DESIGN's digits
        ("x", 2, 0.16718632424),
        ("y", 2, 0.23185110031),
        ("x", 4, 0.06434961099),
        ("y", 4, 0.08661465432),
    ],
)
def test_ref_hman_maximum_delay(axis: str, times: int, seconds: float) -> None:
    stiffness = times * paper_by_hand(*HMAN["x"])
    found = ts.maximum_delay(*HMAN[axis], stiffness)
    # 1e-10, and half a unit of the last digit given
    assert found == pytest.approx(seconds, rel=1e-10, abs=5e-12)
    # a pair of roots is on the axis there, and on either side of it beside
    for delay, sign in ((found * (1 - 1e-6), -1), (found * (1 + 1e-6), 1)):
        assert math.copysign(1, ts.spectral_abscissa(ts.hman(), stiffness, delay, axis)) == sign


def test_ref_the_marginal_axis_of_figure_5h_is_x_and_5j_is_half_stable(hman: ts.Dyad) -> None:
    critical = paper_by_hand(*HMAN["x"])
    limits = {axis: ts.maximum_delay(*HMAN[axis], 2 * critical) for axis in "xy"}
    assert limits["x"] < limits["y"]  # the caption is right, the text is not
    half = limits["x"] / 2
    assert ts.spectral_abscissa(hman, 4 * critical, half, "x") > 0
    assert ts.spectral_abscissa(hman, 4 * critical, half, "y") < 0


def test_ref_equation_5_is_necessary_and_not_sufficient() -> None:
    robots = (1.0, 1.0, 1.0, 10.0)
    assert ts.critical_stiffness(*robots, method="paper") == pytest.approx(25.25, rel=1e-15)
    exact = ts.critical_stiffness(*robots)
    assert exact == pytest.approx(9.4610953, rel=1e-8)  # DESIGN's digits
    # the discriminant of the cubic F vanishes there: a double root in ω², found from the outside
    # F(w) = (m² w² + (b1² - 2 k m) w + k²) (m² w² + (b2² - 2 k m) w + k²) - k⁴, over w

    def cubic(k: float) -> Any:
        one = np.polynomial.Polynomial([k**2, 1.0 - 2 * k, 1.0])
        two = np.polynomial.Polynomial([k**2, 100.0 - 2 * k, 1.0])
        return (one * two - k**4).coef[1:]

    def discriminant(k: float) -> float:
        d, c, b, a = cubic(k)
        return float(18 * a * b * c * d - 4 * b**3 * d + b**2 * c**2 - 4 * a * c**3 - 27 * a**2 * d**2)

    assert exact == pytest.approx(brentq(discriminant, 9.0, 10.0, xtol=1e-13), rel=1e-10)
    assert math.isinf(ts.maximum_delay(*robots, exact * (1 - 1e-9)))
    assert math.isfinite(ts.maximum_delay(*robots, exact * (1 + 1e-9)))


def test_ref_unstable_below_the_papers_critical_stiffness() -> None:
    robots, k = (1.0, 1.0, 1.0, 10.0), 24.9975  # 0.99 of the paper's
    assert math.isinf(ts.maximum_delay(*robots, k, method="paper"))
    limit = ts.maximum_delay(*robots, k)
    assert limit == pytest.approx(0.1718, abs=5e-5)
    assert ts.spectral_abscissa(pair(*robots), k, 0.175) > 0
    assert ts.spectral_abscissa(pair(*robots), k, limit * (1 - 1e-6)) < 0
    # and in time: what is left of a push grows
    push = ts.Sampled([1.0] * 100 + [0.0], 1000.0)
    moved = ts.simulate_array(pair(*robots), k, 0.175, [[push], [0.0]], 300.0, rate=100.0)
    apart = np.abs(moved.position[:, 0, 0] - moved.position[:, 1, 0])
    assert apart[-1000:].max() > 2 * apart[10_000:11_000].max()


def test_ref_stability_that_comes_back_at_a_longer_delay() -> None:
    robots, k = (0.97670822, 2.15372614, 0.30379312, 4.59594729), 9.174736188
    stable = ts.stable_delays(*robots, k, 10.0)
    # DESIGN's four digits
    assert np.array(stable) == pytest.approx(np.array([(0.0, 0.8508), (1.7738, 2.1128)]), abs=5.1e-5)
    assert ts.maximum_delay(*robots, k) == stable[0][1]
    dyad = pair(*robots)
    for start, end in stable:
        for edge, leaves in ((start, False), (end, True)):
            if edge > 0:
                before, after = (ts.spectral_abscissa(dyad, k, edge * (1 + x)) > 0 for x in (-1e-6, 1e-6))
                assert (before, after) == (not leaves, leaves)


def test_ref_grounded_operators_bring_a_delay_independent_band() -> None:
    # DESIGN: crossings at 20 to 25 N/m, none at 30 to 80, again at 100
    robots, one, two = (100.0, 10.0, 1.0, 0.2), 12000.0, 100.0
    for k, crosses in (
        (20.0, True),
        (25.0, True),
        (30.0, False),
        (55.0, False),
        (80.0, False),
        (100.0, True),
    ):
        assert bool(ts.crossings(*robots, k, kh1=one, kh2=two)) == crosses, k
    first = ts.critical_stiffness(*robots, kh1=one, kh2=two)
    assert first < 20.0
    assert not ts.crossings(*robots, first * (1 - 1e-9), kh1=one, kh2=two)
    assert ts.crossings(*robots, first * (1 + 1e-9), kh1=one, kh2=two)


def test_ref_two_crossings_part_from_a_tangency() -> None:
    # at the stiffness where two crossings merge, F has a double root: the pair touches and turns back
    robots = (1.0, 1.0, 1.0, 10.0)
    critical = ts.critical_stiffness(*robots)
    above = ts.crossings(*robots, critical * (1 + 1e-8))
    assert [one.direction for one in above] in ([1, -1], [-1, 1])
    one, two = above
    # they part like the square root of the distance, sqrt(1e-8)
    assert one.frequency == pytest.approx(two.frequency, rel=1e-3)
    assert one.delay == pytest.approx(two.delay, rel=1e-2)
    assert not ts.crossings(*robots, critical * (1 - 1e-8))


def test_ref_published_limits_of_delay_systems() -> None:
    systems = read_reference("gu2003")["system"]
    assert len(systems) == 3
    for system in systems:
        now, late = np.array(system["A0"]), np.array(system["A1"])

        def abscissa(delay: float, now: Any = now, late: Any = late) -> float:
            return float(ts.DelaySystem(now, [(delay, late)]).spectral_abscissa())

        printed = [float(digits) for digits in re.findall(r"\d+\.\d+", system["published"])]
        limits = [edge for pair in system["stable"] for edge in pair if edge > 0]
        for limit, short in zip(limits, printed, strict=True):
            found = brentq(abscissa, limit * 0.999, limit * 1.001, xtol=1e-13, rtol=1e-14)
            # the file's twelve digits; 1e-9 is what is promised
            assert found == pytest.approx(limit, rel=1e-9), system["name"]
            # the book's lower limit on p. 193 is off by 6e-6, a unit or more of its last digit
            assert found == pytest.approx(short, abs=1e-4), system["name"]
        for start, end in system["stable"]:
            assert abscissa(0.5 * (start + end)) < 0
            assert abscissa(1.001 * end) > 0
            if start > 0:
                assert abscissa(0.999 * start) > 0
        if "crossing_frequency" in system:
            # x' = -0.9 x - x(t - tau): w² = 1 - 0.81
            assert system["crossing_frequency"] == pytest.approx(math.sqrt(1 - 0.9**2), rel=1e-15)
            roots = ts.DelaySystem(now, [(limits[-1], late)]).characteristic_roots(2)
            assert abs(np.imag(np.asarray(roots))[0]) == pytest.approx(system["crossing_frequency"], rel=1e-9)


def test_ref_published_systems_are_copied_as_they_were_collected(root: Path) -> None:
    file = root.parent / "shared" / "data" / "dde" / "published.toml"
    if not file.is_file():
        pytest.skip(f"{file} IS MISSING: references/gu2003.toml is not compared with what it was copied from")
    collected = tomllib.loads(file.read_text(encoding="utf-8"))["system"]
    for ours, theirs in zip(read_reference("gu2003")["system"], collected, strict=True):
        for key in ("A0", "A1", "stable", "crossing_frequency"):
            assert ours.get(key) == theirs.get(key)
        assert theirs["published"].startswith(ours["published"])
