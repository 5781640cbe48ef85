"""Properties that hold for every dyad, on generated ones."""

from __future__ import annotations

import math
from typing import NamedTuple, TypedDict

import numpy as np
import pytest
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st

import telespring as ts


class Held(TypedDict):
    kh1: float
    kh2: float
    c: float


class Case(NamedTuple):
    m1: float
    b1: float
    m2: float
    b2: float
    kh1: float
    kh2: float
    c: float

    @property
    def held(self) -> Held:
        return Held(kh1=self.kh1, kh2=self.kh2, c=self.c)

    def exchanged(self) -> Case:
        return Case(self.m2, self.b2, self.m1, self.b1, self.kh2, self.kh1, self.c)

    def dyad(self) -> ts.Dyad:
        hands = (ts.Operator(0.0, 0.0, self.kh1), ts.Operator(0.0, 0.0, self.kh2))
        return ts.Dyad(ts.Robot(self.m1, self.b1), ts.Robot(self.m2, self.b2), hands, self.c)


def between(low: float, high: float) -> st.SearchStrategy[float]:
    """Log-uniform."""
    return st.floats(math.log(low), math.log(high)).map(math.exp)


masses, dampings = between(0.1, 5.0), between(1.0, 50.0)
springs = st.one_of(st.just(0.0), between(1.0, 500.0))
dyads = st.builds(
    Case, masses, dampings, masses, dampings, springs, springs, st.one_of(st.just(0.0), between(0.1, 20.0))
)
stiffnesses = between(1.0, 1000.0)
delays = between(0.01, 1.0)


def criteria(case: Case, k: float, delay: float) -> list[float]:
    robots = case[:4]
    edges = ts.stable_delays(*robots, k, 3.0, **case.held)
    return [
        ts.critical_stiffness(*robots, **case.held),
        ts.maximum_delay(*robots, k, **case.held),
        ts.maximum_stiffness(*robots, delay, **case.held),
        *(edge for pair in edges for edge in pair),
    ]


@given(dyads, stiffnesses, delays)
def test_law_the_partners_can_be_exchanged(case: Case, k: float, delay: float) -> None:
    # 1e-7: near a tangency an edge moves like the square root of rounding
    np.testing.assert_allclose(
        criteria(case.exchanged(), k, delay), criteria(case, k, delay), rtol=1e-7, atol=0
    )
    ours, theirs = (ts.certified_roots(one.dyad(), k, delay).roots for one in (case, case.exchanged()))
    np.testing.assert_allclose(ours, theirs, rtol=1e-10)


@given(dyads, stiffnesses, delays, between(0.1, 10.0))
def test_law_time_scales(case: Case, k: float, delay: float, factor: float) -> None:
    # t → t·factor with masses kept: b / factor, k / factor²
    slow = Case(
        case.m1,
        case.b1 / factor,
        case.m2,
        case.b2 / factor,
        case.kh1 / factor**2,
        case.kh2 / factor**2,
        case.c / factor,
    )
    before = ts.certified_roots(case.dyad(), k, delay).roots
    after = ts.certified_roots(slow.dyad(), k / factor**2, delay * factor).roots
    # 1e-7: a near-double root moves like the square root of rounding; most agree to 1e-14
    np.testing.assert_allclose(after * factor, before, rtol=1e-7)
    once = ts.critical_stiffness(*case[:4], **case.held)
    assert math.isclose(ts.critical_stiffness(*slow[:4], **slow.held) * factor**2, once, rel_tol=1e-9)
    once = ts.maximum_delay(*case[:4], k, **case.held)
    assert math.isclose(ts.maximum_delay(*slow[:4], k / factor**2, **slow.held), once * factor, rel_tol=1e-7)


@given(dyads, stiffnesses)
def test_law_without_delay_the_roots_are_those_of_the_ode(case: Case, k: float) -> None:
    m1, b1, m2, b2, kh1, kh2, c = case
    one, two = (
        np.polynomial.Polynomial([k + kh1, b1 + c, m1]),
        np.polynomial.Polynomial([k + kh2, b2 + c, m2]),
    )
    polynomial = one * two - np.polynomial.Polynomial([k, c]) ** 2
    true = np.asarray(polynomial.roots(), dtype=np.complex128)
    apart = np.abs(true[:, None] - true) + np.eye(len(true))
    assume(apart.min() > 1e-3)  # a crowd of roots is known to the root of rounding, and its status says so
    ours = ts.certified_roots(case.dyad(), k, 0.0).roots
    # each is a zero of the polynomial, as near as its rounding tells; all four (three, free) are there
    size = np.polynomial.Polynomial(np.abs((one * two).coef))
    assert (np.abs(polynomial(ours)) <= 1e-10 * size(np.abs(ours))).all()
    rigid = kh1 == kh2 == 0
    assert len(ours) == (3 if rigid else 4)
    assert math.isclose(ours.sum().real, -(b1 + c) / m1 - (b2 + c) / m2, rel_tol=1e-9)
    assert (ours.real < 0).all()
    assert ts.stable_delays(*case[:4], k, 1.0, **case.held)[0][0] == 0.0


@given(dyads, between(1.01, 3.0), between(1.0, 3.0))
def test_law_more_damping_raises_the_critical_stiffness(case: Case, first: float, second: float) -> None:
    # |P_i(jω)| grows with b_i at every ω > 0 and |k + jωc| does not: crossings only disappear
    before = ts.critical_stiffness(*case[:4], **case.held)
    more = ts.critical_stiffness(case.m1, case.b1 * first, case.m2, case.b2 * second, **case.held)
    assert more >= before * (1 - 1e-10)  # rounding


@given(dyads, stiffnesses, delays, st.floats(0.0, 1.0))
def test_law_only_the_sum_of_the_delays_decides(case: Case, k: float, delay: float, share: float) -> None:
    split = (2 * delay * share, 2 * delay * (1 - share))
    equal, unequal = (ts.certified_roots(case.dyad(), k, one).roots for one in (delay, split))
    # 1e-7: a near-double root moves like the square root of rounding
    np.testing.assert_allclose(unequal, equal, rtol=1e-7)
    alpha = ts.spectral_abscissa(case.dyad(), k, split)
    assume(abs(alpha) > 1e-9)  # the sign is rounding's there
    stable = any(a <= delay < b for a, b in ts.stable_delays(*case[:4], k, delay * 1.01, **case.held))
    assert stable == (alpha < 0)


@settings(max_examples=30, phases=[Phase.generate])  # shrinking a simulation takes minutes
@given(dyads, stiffnesses, delays)
def test_law_the_abscissa_is_the_rate_of_decay_in_time(case: Case, k: float, delay: float) -> None:
    dyad = case.dyad()
    roots = ts.certified_roots(dyad, k, delay, count=4).roots
    first = roots[0]
    others = [one for one in roots if abs(one - first) > 1e-9 and abs(one - first.conjugate()) > 1e-9]
    # a double root moves as t exp(αt) too
    assume(len(roots) - len(others) == (1 if first.imag == 0 else 2))
    gap = first.real - others[0].real
    assume(gap > 0.2 * abs(first) and abs(first.imag) < 300)
    # the slowest mode alone is left once the next has fallen by exp(-12)
    settle = 12.0 / gap + 4 * delay
    span = max(4.0 / abs(first), 2 * delay)
    # decayed by more than exp(-18) nothing of it would be left above rounding; grown, it diverges
    assume(-18 < first.real * (settle + 2 * span) < 24)
    found = ts.simulate_array(
        dyad,
        k,
        delay,
        [[0.0], [0.0]],
        settle + 2 * span,
        rate=400.0 / span,
        history=[[(0.0, 1.0)], [(0.0, -0.6)]],
    )
    assert found.velocity is not None
    late = found.time >= settle
    t, v = found.time[late] - settle, found.velocity[late, 0, 0]
    # velocity of robot 1 (the drift of free handles leaves it): fit v = exp(αt)(p cos ωt + q sin ωt)
    mode = np.exp(first.real * t)
    base = mode[:, None] * np.stack([np.cos(first.imag * t), np.sin(first.imag * t)], axis=1)
    base = base if abs(first.imag) > 0 else base[:, :1]
    left = v - base @ np.linalg.lstsq(base / mode[:, None], v / mode, rcond=None)[0]
    # the mode may hardly reach robot 1: a hundredth of the motion, carried back to t = 0, must be it
    visible = np.abs(v / mode).max() * math.exp(-first.real * settle) / np.abs(found.velocity).max()
    assume(visible > 1e-2)
    # exp(-12) of the next mode over that hundredth, and its share may be ten times the first's
    assert np.abs(left / mode).max() <= 1e-2 * np.abs(v / mode).max()


@settings(max_examples=25)
@given(dyads, stiffnesses, st.tuples(delays, delays), st.floats(-3.0, 3.0))
def test_law_simulations_superpose(case: Case, k: float, delay: tuple[float, float], share: float) -> None:
    def move(
        first: list[ts.Sine], second: float, start: float
    ) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        found = ts.simulate_array(
            case.dyad(), k, delay, [[first], [second]], 1.0, rate=50.0, history=[[start], [0.5 * start]]
        )
        return found.position

    one, two = move([ts.Sine(1.0, 3.0)], -0.4, 0.1), move([ts.Sine(0.5, 7.0, 0.2)], 1.1, -0.3)
    both = move([ts.Sine(1.0, 3.0), ts.Sine(0.5 * share, 7.0, 0.2)], -0.4 + 1.1 * share, 0.1 - 0.3 * share)
    expected = one + share * two
    # 1e-10: ten times what each simulation is promised to
    scale = max(np.abs(one).max(), abs(share) * np.abs(two).max())
    np.testing.assert_allclose(both, expected, rtol=0, atol=1e-10 * scale)


def test_law_a_search_that_does_not_end_is_refused_with_a_remedy_that_helps() -> None:
    light, delay = (1.77e-4, 0.0, 10.0, 0.0), 1.36e-6
    with pytest.raises(ts.InvalidInput, match="the search for its crossings did not end") as refused:
        ts.maximum_stiffness(*light, delay, kh2=7e-14, c=0.0033)
    assert "Set values that are negligible to 0" in str(refused.value)
    assert ts.maximum_stiffness(*light, delay, c=0.0033) > 1e9
