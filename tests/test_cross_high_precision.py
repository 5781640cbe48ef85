"""Roots and simulations against other people's programs and against many more digits."""

from __future__ import annotations

import importlib
import math
import warnings
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import telespring as ts

Complexes = NDArray[np.complex128]
Axis = tuple[float, ...]  # m1, b1, m2, b2, kh1, kh2, c

CASES = range(36)


def random_case(seed: int) -> tuple[Axis, float, tuple[float, float]]:
    """Return an axis, a stiffness and two unequal delays; a third each free, half grounded, grounded."""
    random = np.random.default_rng([5, seed])
    m1, m2 = np.exp(random.uniform(np.log(0.1), np.log(5.0), 2))
    b1, b2 = np.exp(random.uniform(np.log(1.0), np.log(50.0), 2))
    k = random.uniform(0.2, 6.0) * (b1**2 + b2**2) / (2 * (m1 + m2))
    kh1, kh2 = k * np.exp(random.uniform(np.log(0.05), np.log(5.0), 2))
    kh1, kh2 = ((0.0, 0.0), (kh1, 0.0), (kh1, kh2))[seed % 3]
    c = random.uniform(0.05, 1.0) * np.sqrt(b1 * b2) if seed % 2 else 0.0
    forward, backward = random.uniform(0.05, 3.0, 2) * np.sqrt(max(m1, m2) / k)
    axis = tuple(float(one) for one in (m1, b1, m2, b2, kh1, kh2, c))
    return axis, float(k), (float(forward), float(backward))


def dyad_of(axis: Axis) -> ts.Dyad:
    m1, b1, m2, b2, kh1, kh2, c = axis
    operators = (ts.Operator(0.0, 0.0, kh1), ts.Operator(0.0, 0.0, kh2))
    return ts.Dyad(ts.Robot(m1, b1), ts.Robot(m2, b2), operators, c)


def characteristic(axis: Axis, k: float, total: float) -> Callable[[Complexes], Complexes]:
    m1, b1, m2, b2, kh1, kh2, c = axis

    def chi(s: Complexes) -> Complexes:
        one = (m1 * s + (b1 + c)) * s + (k + kh1)
        two = (m2 * s + (b2 + c)) * s + (k + kh2)
        return one * two - (k + c * s) ** 2 * np.exp(-total * s)

    return chi


def polished(axis: Axis, k: float, delay: tuple[float, float], start: complex) -> mpmath.mpc:
    """Return the zero that Newton's method reaches from `start`, to 50 digits."""
    with mpmath.workdps(60):
        m1, b1, m2, b2, kh1, kh2, c, k = (mpmath.mpf(one) for one in (*axis, k))
        total = mpmath.mpf(delay[0]) + mpmath.mpf(delay[1])
        s = mpmath.mpc(start)
        for _ in range(60):
            one, two = (m1 * s + b1 + c) * s + k + kh1, (m2 * s + b2 + c) * s + k + kh2
            coupling, turn = k + c * s, mpmath.exp(-total * s)
            slope = (2 * m1 * s + b1 + c) * two + one * (2 * m2 * s + b2 + c)
            slope -= coupling * (2 * c - total * coupling) * turn
            step = (one * two - coupling**2 * turn) / slope
            s -= step
            if abs(step) <= mpmath.mpf(10) ** -52 * (abs(s) + mpmath.mpf(10) ** -30):
                return s
    pytest.fail(f"Newton does not settle from {start}")


def crossing_polished(axis: Axis, delay: float, frequency: float, k: float) -> tuple[mpmath.mpf, mpmath.mpf]:
    """Return the frequency and the stiffness of a crossing near two given ones, to 50 digits."""
    with mpmath.workdps(60):
        m1, b1, m2, b2, kh1, kh2, c = (mpmath.mpf(one) for one in axis)
        total, w, k = 2 * mpmath.mpf(delay), mpmath.mpf(frequency), mpmath.mpf(k)
        for _ in range(60):
            s = mpmath.mpc(0, w)
            one, two = (m1 * s + b1 + c) * s + k + kh1, (m2 * s + b2 + c) * s + k + kh2
            coupling = k + c * s
            value = mpmath.log(one * two / coupling**2 * mpmath.exp(total * s))
            slope = (2 * m1 * s + b1 + c) / one + (2 * m2 * s + b2 + c) / two - 2 * c / coupling + total
            by_w, by_k = mpmath.mpc(0, 1) * slope, 1 / one + 1 / two - 2 / coupling
            determinant = by_w.real * by_k.imag - by_w.imag * by_k.real
            step_w = (by_k.real * value.imag - by_k.imag * value.real) / determinant
            step_k = (by_w.imag * value.real - by_w.real * value.imag) / determinant
            w, k = w + step_w, k + step_k
            if abs(step_w) <= mpmath.mpf(10) ** -45 * w and abs(step_k) <= mpmath.mpf(10) ** -45 * k:
                return w, k
    pytest.fail(f"Newton does not settle from {frequency} rad/s, {k} N/m")


TINY: list[tuple[Axis, float]] = [
    *(((0.8334, 7.7257, 0.7776, 7.4208, tiny, 0.0, 0.0), 0.1) for tiny in (1e-6, 1e-14, 1e-16, 1e-200)),
    *(((0.8334, 7.7257, 0.7776, tiny, 0.0, 0.0, 0.0), 0.1) for tiny in (1e-3, 1e-9, 1e-15)),
    *(((1.2, 3.0, 0.4, 6.0, tiny, 40.0, 0.0), 0.3) for tiny in (1e-3, 1e-12, 1e-18)),
    *(((1.2, 3.0, 0.4, 6.0, 0.0, 0.0, tiny), 0.3) for tiny in (1e-3, 1e-12)),
    ((0.8334, 7.7257, 0.7776, 7.4208, 0.0, 0.0, 0.0), 1e-6),
    ((0.8334, 7.7257, 0.7776, 7.4208, 0.0, 0.0, 0.0), 100.0),
    ((1e-4, 1e-3, 1e4, 10.0, 0.0, 0.0, 0.0), 0.1),
    ((0.11512, 0.046096, 0.29197, 3.751e-5, 0.21427, 353.622, 0.0), 0.012476),
    # two resonances within a factor of two, one of them without damping
    ((4.56344, 1.02086e-8, 8.31487, 0.0, 164.193, 389.556, 0.0), 0.338911),
    ((0.371955, 3.49265e-8, 2.1625, 0.0, 33.9318, 65.6838, 0.0), 0.0892231),
    # a crossing whose phase is a half turn but for 1e-8
    ((2.20193, 0.0, 2436.05, 1.3483e-5, 9.02726e-15, 116917.0, 0.0), 1.1519e-6),
    ((0.0357148, 0.0, 0.977665, 3.6231e-5, 0.0, 0.0, 0.0), 1.78206e-9),
    # no damping but that of the coupling, through a long delay
    ((2.36321e-4, 0.0, 6.90935, 0.0, 8.8067e-17, 2.50225e-16, 3614.68), 16.2091),
    ((8.36368e-4, 0.0, 5.59092e-3, 0.0, 2.21456e-8, 5.72707e-11, 723.657), 0.0399658),
]


@pytest.mark.parametrize(("axis", "delay"), TINY)
def test_cross_maximum_stiffness_against_fifty_digits(axis: Axis, delay: float) -> None:
    m1, b1, m2, b2, kh1, kh2, c = axis
    k = ts.maximum_stiffness(m1, b1, m2, b2, delay, kh1=kh1, kh2=kh2, c=c)
    crossings = [one for one in ts.crossings(m1, b1, m2, b2, k, kh1=kh1, kh2=kh2, c=c) if one.direction == 1]
    # the one whose delays recur at this delay
    turned = [(delay - one.delay) * one.frequency / math.pi for one in crossings]
    frequency = crossings[int(np.argmin([abs(one - round(one)) for one in turned]))].frequency
    _, exact = crossing_polished(axis, delay, frequency, k)
    # 1e-11: rounding of k + kh - m w² relative to what is left of it next to a sharp resonance
    assert abs(exact - k) <= 1e-11 * exact
    for part in np.linspace(0.02, 0.999, 50):
        if part * k >= 1e-6:
            assert ts.unstable_root_count(m1, b1, m2, b2, part * k, delay, kh1=kh1, kh2=kh2, c=c) == 0


@pytest.mark.parametrize("seed", range(40))
def test_ref_next_to_the_critical_stiffness_the_sign_is_exact(seed: int) -> None:
    random = np.random.default_rng([8, seed])
    m, b = np.exp(random.uniform(np.log(0.1), np.log(10.0), 2)).tolist()
    for k in (
        b * b / (2 * m),
        math.nextafter(b * b / (2 * m), 0.0),
        math.nextafter(b * b / (2 * m), math.inf),
    ):
        # two identical robots: delay-independent exactly for k <= b²/(2m)
        independent = Fraction(k) * 2 * Fraction(m) <= Fraction(b) ** 2
        assert math.isinf(ts.maximum_delay(m, b, m, b, k)) == independent


def turns(
    chi: Callable[[Complexes], Complexes], left: float, right: float, low: float, high: float
) -> int | None:
    """Count zeros in a rectangle by the argument principle; None where an edge comes too close to one."""
    corners = np.array([left + 1j * low, right + 1j * low, right + 1j * high, left + 1j * high])
    turned = 0.0
    for start, end in zip(corners, np.roll(corners, -1), strict=True):
        at = np.linspace(0.0, 1.0, 129)
        for _ in range(12):
            steps = np.angle((value := chi(start + (end - start) * at))[1:] / value[:-1])
            coarse = np.flatnonzero(np.abs(steps) > 0.7)
            if len(coarse) == 0:
                break
            at = np.insert(at, coarse + 1, (at[coarse] + at[coarse + 1]) / 2)
        else:
            return None
        turned += float(steps.sum())
    return round(turned / (2 * np.pi))


def zeros_by_subdivision(
    chi: Callable[[Complexes], Complexes], left: float, right: float, low: float, high: float
) -> list[complex]:
    """Isolate every zero in a rectangle: cells are split until each holds one and is small."""
    cells, centres = [(left, right, low, high)], []
    while cells:
        x0, x1, y0, y1 = cells.pop()
        count = turns(chi, x0, x1, y0, y1)
        assert count is not None
        if count == 0:
            continue
        if count == 1 and max(x1 - x0, y1 - y0) < 0.05:
            centres.append(complex((x0 + x1) / 2, (y0 + y1) / 2))
            continue
        for share in (0.5171, 0.4619, 0.5537, 0.4283):  # a cut through a zero is tried elsewhere
            if x1 - x0 > y1 - y0:
                cut = x0 + share * (x1 - x0)
                halves = [(x0, cut, y0, y1), (cut, x1, y0, y1)]
            else:
                cut = y0 + share * (y1 - y0)
                halves = [(x0, x1, y0, cut), (x0, x1, cut, y1)]
            counts = [turns(chi, *half) for half in halves]
            if None not in counts and sum(one or 0 for one in counts) == count:
                break
        else:
            pytest.fail("no cut found that stays clear of the zeros")
        cells += halves
    return centres


@pytest.mark.parametrize("seed", CASES)
def test_cross_each_root_against_fifty_digits(seed: int) -> None:
    axis, k, delay = random_case(seed)
    found = ts.certified_roots(dyad_of(axis), k, delay, count=12)
    assert found.complete, found.certificate
    for root in found.roots.tolist():
        exact = polished(axis, k, delay, root)
        # 1e-12: what the roots are promised to
        assert abs(exact - root) <= 1e-12 * abs(exact), f"{root} should be {exact}"


@pytest.mark.parametrize("seed", CASES)
def test_cross_no_root_is_missing_and_none_is_invented(seed: int) -> None:
    axis, k, delay = random_case(seed)
    total = sum(delay)
    unit = 1.0 / total  # the length of a cell is measured in roots' distances, some 2π/T
    ours = ts.characteristic_roots(dyad_of(axis), k, delay, count=12)
    # the left edge stands in the widest gap after the sixth root, clear of all of them
    real = np.sort(ours.real)[::-1]
    gaps = real[5:-1] - real[6:]
    at = 5 + int(np.argmax(gaps))
    left = (real[at] + real[at + 1]) / 2
    m1, b1, m2, b2, kh1, kh2, c = axis
    # no zero right of `left` lies beyond: |P1 P2| > |k + c s|² exp(-T left) from here on
    radii = np.geomspace(1e-2, 1e6, 20_000)
    one, two = m1 * radii**2 - (b1 + c) * radii - k - kh1, m2 * radii**2 - (b2 + c) * radii - k - kh2
    outside = (one > 0) & (two > 0) & (one * two > (k + c * radii) ** 2 * np.exp(max(-total * left, 0.0)))
    reach = radii[np.flatnonzero(~outside)[-1] + 1]
    chi = characteristic(axis, k, total)
    cells = zeros_by_subdivision(
        lambda z: chi(z * unit), left / unit, reach / unit, -reach / unit * 1.01, reach / unit
    )
    others = [complex(polished(axis, k, delay, centre * unit)) for centre in cells]
    free = kh1 == kh2 == 0
    origin = [one for one in others if abs(one) < 1e-9 * unit]
    assert len(origin) == int(free)
    expected = np.array([one for one in others if abs(one) >= 1e-9 * unit])
    mine = ours[ours.real > left]
    assert len(expected) == len(mine), f"{len(expected)} zeros right of {left}, ours are {len(mine)}"
    distance = np.abs(expected[:, None] - mine)
    # each is the other's nearest, to the promised digits
    assert (distance.min(axis=0) <= 1e-12 * np.abs(mine)).all()
    assert (distance.min(axis=1) <= 1e-12 * np.abs(expected)).all()


def peer(name: str) -> ModuleType:
    try:
        # a peer's own warnings are not ours to mend
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return importlib.import_module(name)
    except ImportError:
        pytest.skip(f"{name} IS NOT INSTALLED: nothing is compared with it (`make .venv/.stamps/oracles`)")


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.filterwarnings("ignore")
def test_cross_rightmost_roots_against_tdcpy(seed: int) -> None:
    tdcpy = peer("tdcpy")
    axis, k, (forward, backward) = random_case(seed)
    m1, b1, m2, b2, kh1, kh2, c = axis
    now = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-(k + kh1) / m1, -(b1 + c) / m1, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [0.0, 0.0, -(k + kh2) / m2, -(b2 + c) / m2],
        ]
    )
    to_1, to_2 = np.zeros((4, 4)), np.zeros((4, 4))
    to_1[1, 2:], to_2[3, :2] = (k / m1, c / m1), (k / m2, c / m2)
    system = tdcpy.RDDE(np.stack([now, to_1, to_2], axis=-1), np.array([0.0, backward, forward]))
    ours = ts.characteristic_roots(dyad_of(axis), k, (forward, backward), count=6)
    left = ours[-1].real - 1e-6 * abs(ours[-1])
    theirs = tdcpy.roots(system, r=left)[0]
    # 1e-8: it refines by Newton on matrices, to about half the digits at worst
    for root in ours:
        assert np.abs(theirs - root).min() <= 1e-8 * abs(root)
    for root in theirs[(theirs.real > left + 1e-3 * abs(ours[-1])) & (np.abs(theirs) > 1e-6 * abs(ours[0]))]:
        assert np.abs(ours - root).min() <= 1e-8 * abs(root), f"ours lack {root}"


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.filterwarnings("ignore")
def test_cross_rightmost_roots_against_qpmr(seed: int) -> None:
    qpmr = peer("qpmr")
    axis, k, delay = random_case(seed)
    m1, b1, m2, b2, kh1, kh2, c = axis
    total = sum(delay)
    undelayed = np.convolve([k + kh1, b1 + c, m1], [k + kh2, b2 + c, m2])
    # time in units of T, so that its grid suits every case
    powers = total ** -np.arange(5.0)
    table = np.array([undelayed * powers, [-(k**2), -2 * k * c, -(c**2), 0.0, 0.0] * powers])
    table /= np.abs(table).max()
    ours = ts.characteristic_roots(dyad_of(axis), k, delay, count=6) * total
    # its own choice of region and grid misses unstable roots: it is told where to look, and finely
    region = (ours[-1].real - 0.37, ours[0].real + 1.03, -0.51, np.abs(ours.imag).max() + 1.07)
    theirs = qpmr.qpmr(table, np.array([0.0, 1.0]), region=region, ds=0.02)[0]
    for root in ours[ours.imag >= 0]:
        # 1e-6: its stated accuracy
        assert np.abs(theirs - root).min() <= 1e-6 * max(abs(root), 1.0), f"{root} is not among theirs"
    inside = (theirs.real > ours[-1].real + 1e-3) & (theirs.imag >= -1e-6) & (np.abs(theirs) > 1e-4)
    for root in theirs[inside]:
        assert np.abs(ours - root).min() <= 1e-6 * max(abs(root), 1.0), f"ours lack {root}"


def by_steps(
    axis: Axis, k: float, delay: tuple[float, float], force: tuple[float, float], times: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Integrate delay by delay with DOP853, each step reading the dense output of those before it.

    From rest at t = 0 a kink travels there and back: it arrives at n T, n T + forward, n T + backward,
    two derivatives higher each time; integration starts afresh at each.
    """
    m1, b1, m2, b2, kh1, kh2, c = axis
    forward, backward = delay
    total, end = forward + backward, float(times[-1])
    kinks = {n * total + d for n in range(int(end / total) + 1) for d in (0.0, forward, backward)}
    kinks |= {n * min(delay) for n in range(int(end / min(delay)) + 1)}
    edges = [*sorted(one for one in kinks if one < end - 1e-12), end]
    pieces: list[tuple[float, Any]] = []

    def past(t: float) -> Any:
        if t <= 0:
            return np.zeros(4)
        for start, solution in reversed(pieces):
            if t >= start:
                return solution(t)
        raise AssertionError(t)

    def rhs(t: float, y: NDArray[np.float64]) -> list[float]:
        x1, v1, x2, v2 = y
        late_2, late_1 = past(t - backward), past(t - forward)
        pull_1 = k * (late_2[2] - x1) + c * (late_2[3] - v1) - b1 * v1 - kh1 * x1 + force[0]
        pull_2 = k * (late_1[0] - x2) + c * (late_1[1] - v2) - b2 * v2 - kh2 * x2 + force[1]
        return [v1, pull_1 / m1, v2, pull_2 / m2]

    state, out = np.zeros(4), np.zeros((len(times), 4))
    for start, stop in pairwise(edges):
        if stop - start < 1e-9 * total:
            continue
        step = (stop - start) / np.ceil((stop - start) / 0.01)
        found = solve_ivp(
            rhs, (start, stop), state, "DOP853", dense_output=True, rtol=1e-13, atol=1e-15, max_step=step
        )
        state = found.y[:, -1]
        assert found.sol is not None
        pieces.append((start, found.sol))
        chosen = (times >= start) & (times <= stop)
        out[chosen] = found.sol(times[chosen]).T
    return out


SIMULATED: list[tuple[Axis, float, tuple[float, float]]] = [
    ((0.8334, 7.7257, 0.7776, 7.4208, 0.0, 0.0, 0.0), 71.231976, (0.167, 0.167)),  # close to its limit
    ((0.8334, 7.7257, 0.7776, 7.4208, 0.0, 0.0, 0.0), 142.0, (0.11, 0.27)),  # unstable, unequal delays
    ((1.2, 3.0, 0.4, 6.0, 40.0, 0.0, 1.5), 60.0, (0.31, 0.17)),  # one hand and a damper
]


@pytest.mark.parametrize(("axis", "k", "delay"), SIMULATED)
def test_cross_simulation_against_dop853_by_steps(axis: Axis, k: float, delay: tuple[float, float]) -> None:
    found = ts.simulate_array(dyad_of(axis), k, delay, [[1.0], [-0.4]], 2.0, rate=100.0)
    assert found.velocity is not None
    expected = by_steps(axis, k, delay, (1.0, -0.4), found.time)
    # 1e-10 of the largest value: the reference's own tolerance, 1e-13 a step over some 400 steps
    for mine, column in ((found.position, 0), (found.velocity, 1)):
        scale = np.abs(expected[:, column::2]).max()
        np.testing.assert_allclose(mine[:, :, 0], expected[:, column::2], rtol=0, atol=1e-10 * scale)


@pytest.mark.parametrize(("axis", "k", "delay"), SIMULATED)
def test_cross_simulation_against_the_adaptive_solver(
    axis: Axis, k: float, delay: tuple[float, float]
) -> None:
    m1, b1, m2, b2, kh1, kh2, c = axis
    forward, backward = delay

    def rhs(_: float, y: NDArray[np.float64], delayed: NDArray[np.float64]) -> list[float]:
        x1, v1, x2, v2 = y
        to_2, to_1 = delayed
        pull_1 = k * (to_1[2] - x1) + c * (to_1[3] - v1) - b1 * v1 - kh1 * x1 + 1.0
        pull_2 = k * (to_2[0] - x2) + c * (to_2[1] - v2) - b2 * v2 - kh2 * x2 - 0.4
        return [v1, pull_1 / m1, v2, pull_2 / m2]

    exact = ts.simulate_array(dyad_of(axis), k, delay, [[1.0], [-0.4]], 3.0, rate=100.0)
    solved = ts.solve_dde(rhs, [forward, backward], np.zeros(4), (0.0, 3.0), 1e-10, 1e-13)
    assert solved.completed
    y = solved(exact.time)
    scale = np.abs(exact.position).max()
    # 1e-8: a hundred times the solver's local tolerance
    np.testing.assert_allclose(y[:, [0, 2]], exact.position[:, :, 0], rtol=0, atol=1e-8 * scale)
