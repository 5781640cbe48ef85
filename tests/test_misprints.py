"""Every number that the report gives as evidence, against an expression of its own.

The paper is Du, Kulkarni, Kager and Campolo; where it prints a number or a formula, that stands here as
printed. Roots are those of `oracle_collocation`, delays come from the roots of F by numpy.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from oracle_collocation import Axes, spectral_abscissa
from telespring.paper.misprints import misprints

Robots = tuple[float, float, float, float]
Expected = float | Any | None

# Table III: m1, b1, m2, b2
X: Robots = (0.8334, 7.7257, 0.7776, 7.4208)
Y: Robots = (1.0649, 10.1168, 1.3407, 9.3496)
M, B = 0.8334, 7.7257
K = B**2 / (2 * M)
K_XY = (7.7257**2 + 7.4208**2) / (2 * (0.8334 + 0.7776))


def positive_roots(robots: Robots, k: float) -> list[float]:
    """Return the frequencies where |P1 P2| = k², from the polynomial itself, without its root at 0."""
    m1, b1, m2, b2 = robots
    one = np.polynomial.Polynomial([k**2, b1**2 - 2 * k * m1, m1**2])
    two = np.polynomial.Polynomial([k**2, b2**2 - 2 * k * m2, m2**2])
    cubic = np.polynomial.Polynomial((one * two).coef[1:])
    roots = [complex(root) for root in np.asarray(cubic.roots(), dtype=complex)]
    return sorted(math.sqrt(z.real) for z in roots if z.real > 0 and abs(z.imag) < 1e-9 * abs(z))


def loop_delays(robots: Robots, k: float, turns: int = 3) -> list[float]:
    """Return the one-way delays at which a pair of roots meets the imaginary axis."""
    m1, b1, m2, b2 = robots
    found = []
    for w in positive_roots(robots, k):
        p1, p2 = k - m1 * w**2 + 1j * b1 * w, k - m2 * w**2 + 1j * b2 * w
        first = (-cmath.phase(p1 * p2 / k**2)) % (2 * math.pi) / (2 * w)
        found += [first + n * math.pi / w for n in range(turns)]
    return sorted(found)


def rightmost(robots: Robots, k: float, delay: float) -> float:
    m1, b1, m2, b2 = (np.array([value]) for value in robots)
    zero = np.zeros(1)
    found = spectral_abscissa(Axes(m1, b1, m2, b2, zero, zero, zero), np.array([k]), np.array([delay]))
    assert found.resolved.all()
    return float(found.abscissa[0])


def close(value: float, tolerance: float = 1e-9) -> Any:
    """Say what the number must be; 1e-9 is what roots of a cubic by numpy are good for here."""
    return pytest.approx(value, rel=tolerance, abs=0.0)


def zero_up_to(size: float) -> Any:
    return pytest.approx(0.0, abs=size)


def diagonal() -> list[Expected]:
    m1, b1, m2, b2 = Y
    k, w, delay = 2 * K_XY, 10.0, 0.1
    p1, p2 = k - m1 * w**2 + 1j * b1 * w, k - m2 * w**2 + 1j * b2 * w
    # Cramer's rule on Eq. 1
    determinant = p1 * p2 - k**2 * cmath.exp(-2j * delay * w)
    true, printed = abs(p2 / determinant), abs(p1 / determinant)
    assert abs(true / printed - 1) > 1e-2
    return [close(true), close(true), close(printed), w, close(k), delay]


def rigid_body() -> list[Expected]:
    k = 2 * K_XY
    delay = loop_delays(X, k)[0] / 2
    slope = k * (7.7257 + 7.4208) + 2 * k**2 * delay
    # a difference quotient over 1e-6 s⁻¹ is as good as that times the next coefficient
    root = close(rightmost(X, k, delay), 1e-8)
    return [0.0, close(slope), close(slope, 1e-6), root, close(k), close(delay)]


def equation_5() -> list[Expected]:
    robots = (1.0, 1.0, 1.0, 10.0)
    printed = 101 / 4
    k = 0.99 * printed
    lost = loop_delays(robots, k)[0]
    # the exact critical stiffness: F touches zero there, its discriminant vanishes
    edge = 9.461095289921483
    assert len(positive_roots(robots, edge * (1 + 1e-6))) == 2
    assert len(positive_roots(robots, edge * (1 - 1e-6))) == 0
    # masses 1 and Eq. 5 make F = x (x² + 2k² - a²), a = (b2² - b1²)/2, k = (b1² + b2²)/4: a root above 0
    # where a² > 2k², that is (b2/b1)² > (√2 + 1)/(√2 - 1)
    return [
        1.0,
        1.0,
        10.0,
        printed,
        close(edge),
        close(k),
        float(len(positive_roots(robots, k))),
        close(lost, 1e-8),
        0.175,
        close(rightmost(robots, k, 0.175), 1e-6),
        close(math.sqrt((math.sqrt(2) + 1) / (math.sqrt(2) - 1))),
    ]


def equation_4() -> list[Expected]:
    robots, k = (0.97670822, 2.15372614, 0.30379312, 4.59594729), 9.174736188
    lost, back, again = loop_delays(robots, k)[:3]
    return [
        close(lost, 1e-7),
        close(back, 1e-7),
        close(again, 1e-7),
        close(rightmost(robots, k, (lost + back) / 2), 1e-4),
        close(rightmost(robots, k, (back + again) / 2), 1e-4),
        k,
        close((robots[1] ** 2 + robots[3] ** 2) / (2 * (robots[0] + robots[2]))),
    ]


def equation_9() -> list[Expected]:
    # ω² = 4 and k (b1 + b2)/(m1 b2 + m2 b1) = 4: the sign of their difference is 0; π/(2ω) = π/4
    return [0.0, 0.0, close(math.pi / 4), zero_up_to(1e-14), close(math.pi * M / (2 * B))]


def conjecture_2() -> list[Expected]:
    k = 2 * K_XY
    frequency = positive_roots(X, k)[-1]
    # the pair's real part, to the rounding of the delay times the root's speed
    return [close(loop_delays(X, k)[0]), zero_up_to(1e-9), close(frequency), close(k)]


def figure_3() -> list[Expected]:
    k = 2 * K
    # two robots alike: |P|² = (k - m w²)² + b² w² is least at w² = k/m - b²/(2m²) = k/(2m) = B²/(2M²)
    w2 = B**2 / (2 * M**2)
    least = (k - M * w2) ** 2 + B**2 * w2
    # the grid of 0.01 rad/s misses the peak by less than 1e-5
    return [close(k / least, 1e-5), close(-1 / k), close(k**2 / least, 1e-5), close(-1.0), close(k)]


def letters() -> list[Expected]:
    # S(K, B, K, B) = 2 B²/(4 K) = M
    return [close(K), close(M), M, B]


def robot_numbers() -> list[Expected]:
    delay = loop_delays(X, 2 * K_XY)[0]
    return [close(K_XY), close(K_XY), close(delay), close(delay)]


def reference_delay() -> list[Expected]:
    delay = loop_delays(X, 2 * K_XY)[0]
    return [0.165, close(delay), close(loop_delays(X, 72.0)[0]), close(delay / 2), 0.0825, close(K_XY)]


def figure_5h() -> list[Expected]:
    return [close(loop_delays(axis, 2 * K_XY)[0]) for axis in (X, Y)]


def figure_5j() -> list[Expected]:
    half, k = loop_delays(X, 2 * K_XY)[0] / 2, 4 * K_XY
    roots = [rightmost(axis, k, half) for axis in (X, Y)]
    assert roots[0] > 0 > roots[1]
    return [
        close(half),
        *(close(loop_delays(axis, k)[0]) for axis in (X, Y)),
        *(close(r, 1e-7) for r in roots),
    ]


def constant_delay_only() -> list[Expected]:
    def swing(k: float) -> tuple[float, float]:
        # the held robot's own root gives the swing: half a period, and the overshoot of 1 + |z|
        root = np.roots([M, B, k])[0]
        hold = math.pi / abs(root.imag)
        return hold, 1 + 2 * abs(cmath.exp(root * hold))

    (hold, growth), (near_hold, near_growth) = swing(K), swing(0.6 * K)
    rate = math.log(growth) / hold
    values = [K, K / 2, hold, growth, rate, near_hold, near_growth]
    assert not positive_roots((M, B, M, B), 0.6 * K)
    return [*(close(value) for value in values), None]


def conjugate_polynomial() -> list[Expected]:
    m1, b1, m2, b2 = X
    k, w, angle = 2 * K_XY, 5.0, 1.0
    product = (k - m1 * w**2 - 1j * b1 * w) * (k - m2 * w**2 - 1j * b2 * w)
    turned = product * cmath.exp(-2j * angle)
    # s² = -25 at s = 5j
    true, printed = abs(turned - k**2), abs(-25.0 * turned - k**2)
    return [close(true), close(true), close(printed), w, close(k)]


def equation_16() -> list[Expected]:
    # F of two robots alike is (m² x + b² - 2km)(m⁴ x² + m² (b² - 2km) x + 2 k² m²) over m⁰: the pair's
    # product is 2 k²/m², and its size the root of that
    size = math.sqrt(2) * (2 * K) / M
    return [close(size), close(size), close(size * (2 * M**2) / (4 * M**4))]


def table_2() -> list[Expected]:
    # η₂ = b⁴ - 4m²k² - 4mb²k vanishes where (2mk/b²)² + 2 (2mk/b²) = 1: 2mk/b² = √2 - 1 = tan(π/8)
    def eta2_over_b4(k: float) -> float:
        return 2 - (2 * M * k / B**2 + 1) ** 2

    true = math.tan(math.pi / 8) * K
    printed = B / (2 * M)
    return [close(true), zero_up_to(1e-14), close(printed), close(eta2_over_b4(printed))]


def free_handles() -> list[Expected]:
    hand = 120.0

    def crossings(robots: Robots, k: float) -> list[tuple[float, int]]:
        # one-way delays up to 1 s at which a pair leaves (+1) or returns (-1)
        m1, b1, m2, b2 = robots
        x = np.polynomial.Polynomial([0.0, 1.0])
        sizes = [(k + hand - m * x) ** 2 + b**2 * x for m, b in ((m1, b1), (m2, b2))]
        difference = sizes[0] * sizes[1] - k**4
        found = []
        for root in np.asarray(difference.roots(), dtype=complex):
            if root.real > 0 and abs(root.imag) < 1e-9 * abs(root):
                w = math.sqrt(root.real)
                p1, p2 = (k + hand - m * w**2 + 1j * b * w for m, b in ((m1, b1), (m2, b2)))
                first = (-cmath.phase(p1 * p2)) % (2 * math.pi) / (2 * w)
                way = 1 if difference.deriv()(root.real) > 0 else -1
                found += [(first + n * math.pi / w, way) for n in range(40)]
        return sorted(found)

    windows = []
    for robots in (X, Y):
        assert not crossings(robots, 71.0)
        (lost, leaves), (back, returns) = crossings(robots, 142.0)[:2]
        assert (leaves, returns) == (1, -1)
        windows += [close(lost, 1e-8), close(back, 1e-8)]
    free = [close(loop_delays(robots, 71.0)[0]) for robots in (X, Y)]
    return [hand, 71.0, *free, None, None, 142.0, *windows]


def weights() -> list[Expected]:
    # log r² falls without end at each sample, so that one of them is met; 1.05 N has the nearest neighbours
    forces = [0.9, 1.0, 1.05, 1.2, 3.0]
    estimate = sum(forces) / 5
    for _ in range(100):
        weight = [1 / ((force - estimate) ** 2 + np.finfo(float).eps) for force in forces]
        estimate = sum(w * force for w, force in zip(weight, forces, strict=True)) / sum(weight)
    assert min(abs(force - estimate) for force in forces) < 1e-12
    return [5.0, 1.05, close(estimate, 1e-9), zero_up_to(1e-12), close(1.0)]


def spot_velocity() -> list[Expected]:
    error = math.sqrt(0.3**2 / 10)
    return [0.2, 0.3, close(error), close(1.96 * error), close(0.588), close(0.03)]


EXPECTED: dict[str, Callable[[], list[Expected]]] = {
    "equation-2": diagonal,
    "rigid-body-root": rigid_body,
    "equation-5": equation_5,
    "equation-4": equation_4,
    "equation-9": equation_9,
    "conjecture-2": conjecture_2,
    "figure-3": figure_3,
    "section-3-letters": letters,
    "robot-numbers": robot_numbers,
    "reference-delay": reference_delay,
    "figure-5h": figure_5h,
    "figure-5j": figure_5j,
    "constant-delay-only": constant_delay_only,
    "conjugate-polynomial": conjugate_polynomial,
    "equation-16": equation_16,
    "table-2": table_2,
    "free-handles": free_handles,
    "weights": weights,
    "spot-velocity": spot_velocity,
}


@pytest.fixture(scope="module")
def evidence() -> dict[str, list[float | None]]:
    return {each.key: [item.value for item in each.evidence] for each in misprints()}


def test_law_every_misprint_is_listed_with_its_place_and_proven_here(du2025: dict[str, Any]) -> None:
    keys = [each.key for each in misprints()]
    assert len(keys) == len(set(keys))
    assert sorted(each["report"] for each in du2025["misprint"]) == sorted(keys) == sorted(EXPECTED)


@pytest.mark.parametrize("key", EXPECTED)
def test_cross_every_number_of_the_evidence(evidence: dict[str, list[float | None]], key: str) -> None:
    found, expected = evidence[key], EXPECTED[key]()
    assert len(found) == len(expected)
    for number, (value, truth) in enumerate(zip(found, expected, strict=True)):
        assert value == truth, f"{key}, number {number}"
