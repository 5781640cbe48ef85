"""Frequency response as Python sees it; the computation is proven in the core's own tests."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import telespring as ts

K, DELAY = 71.231976, 0.15
# forward, backward
UNEQUAL = (0.1, 0.2)


def chi(dyad: ts.Dyad, k: float, round_trip: float, s: complex) -> tuple[complex, complex, complex]:
    m1, b1, m2, b2 = dyad[0].parameters
    kh1, kh2 = dyad[0].ground_stiffness
    c = dyad.coupling_damping
    p1 = m1 * s**2 + (b1 + c) * s + k + kh1
    p2 = m2 * s**2 + (b2 + c) * s + k + kh2
    return p1, p2, p1 * p2 - (k + c * s) ** 2 * np.exp(-round_trip * s)


def test_ref_transfer_matrix_is_the_corrected_eq_2(hman: ts.Dyad) -> None:
    s = np.array([[0.5 + 3j, 2j], [1.0, -0.3 + 1j]])
    found = ts.transfer_matrix(hman, K, UNEQUAL, s)
    printed = ts.transfer_matrix(hman, K, UNEQUAL, s, convention="paper")
    assert found.shape == (2, 2, 2, 2)
    for place in np.ndindex(2, 2):
        p1, p2, full = chi(hman, K, 0.3, complex(s[place]))
        forward, backward = np.exp(-0.1 * s[place]), np.exp(-0.2 * s[place])
        expected = np.array([[p2, K * backward], [K * forward, p1]]) / full
        # the same few operations in another order
        np.testing.assert_allclose(found[place], expected, rtol=1e-12)
        np.testing.assert_allclose(
            printed[place], expected[::-1, ::-1] * [[1, 0], [0, 1]] + expected * [[0, 1], [1, 0]], rtol=1e-12
        )


def test_law_mobility_is_s_times_the_transfer_matrix(hman: ts.Dyad) -> None:
    s = 0.2 + 2.0j
    np.testing.assert_allclose(
        ts.mobility_matrix(hman, K, DELAY, s), s * ts.transfer_matrix(hman, K, DELAY, s), rtol=1e-13
    )
    assert ts.mobility_matrix(hman, K, DELAY, 0.0).shape == (2, 2)


def test_law_frequency_response_is_the_matrix_on_the_axis_and_its_phase_is_continuous(hman: ts.Dyad) -> None:
    grid = ts.frequency_grid(hman, K, DELAY, 0.01, 80.0)
    assert grid.status == "resolved"
    assert np.all(np.diff(grid.frequency) > 0)
    found = ts.frequency_response(hman, K, DELAY, grid.frequency)
    np.testing.assert_allclose(
        found.value, ts.transfer_matrix(hman, K, DELAY, 1j * grid.frequency), rtol=1e-9
    )
    np.testing.assert_allclose(found.magnitude, np.abs(found.value), rtol=1e-13)
    turned = found.value / np.abs(found.value) * np.exp(-1j * found.phase)
    np.testing.assert_allclose(turned, 1.0, atol=1e-9)
    assert np.abs(np.diff(found.phase, axis=0)).max() < 0.5
    assert found.poles_on_axis == ()
    # one frequency alone has the phase it has among others
    alone = ts.frequency_response(hman, K, DELAY, grid.frequency[-1])
    np.testing.assert_allclose(alone.phase[0], found.phase[-1], atol=1e-9)


def test_law_minus_the_open_loop_is_the_product_of_both_partners(hman: ts.Dyad) -> None:
    frequency = [0.0, 1.0, 8.0, 30.0]
    first = ts.partner_response(hman, K, UNEQUAL, frequency)
    second = ts.partner_response(hman, K, UNEQUAL, frequency, robot=1)
    loop = ts.open_loop(hman, K, UNEQUAL, frequency)
    np.testing.assert_allclose(-loop.value, first.value * second.value, rtol=1e-13)
    np.testing.assert_allclose(loop.phase, math.pi + first.phase + second.phase, atol=1e-12)
    np.testing.assert_array_equal(loop.frequency, frequency)
    # robot 1 waits for the backward delay, robot 2 for the forward one
    m1, b1, m2, b2 = hman[0].parameters
    for curve, m, b, delay in ((first, m1, b1, 0.2), (second, m2, b2, 0.1)):
        expected = K * np.exp(-8j * delay) / (m * (8j) ** 2 + b * 8j + K)
        np.testing.assert_allclose(curve.value[2], expected, rtol=1e-13)


# DESIGN: the H-MANs' x axis at twice its critical stiffness loses stability at 167.18632424 ms
def test_ref_nyquist_agrees_with_the_delay_criteria(hman: ts.Dyad) -> None:
    k = 2 * ts.critical_stiffness(hman["x"])
    found = ts.nyquist(hman, k, DELAY)
    assert found.stable
    assert found.rigid_body
    assert found.status == "counted"
    assert found.delay_margin is not None
    assert DELAY + found.delay_margin.value == pytest.approx(0.16718632424, rel=1e-9)
    [crossing] = ts.crossings(hman["x"], k)
    assert found.delay_margin.frequency == pytest.approx(crossing.frequency, rel=1e-9)
    assert found.locus[0] == -1.0
    assert found.locus_status == "resolved"
    np.testing.assert_allclose(ts.open_loop(hman, k, DELAY, found.frequency).value, found.locus, rtol=1e-12)
    unstable = ts.nyquist(hman, k, 0.18, axis="x")
    assert (unstable.encirclements, unstable.unstable_roots, unstable.stable) == (2, 2, False)
    assert unstable.delay_margin is None
    assert ts.nyquist(hman, k, 0.18, axis="y").stable  # y holds up to 231.85 ms


def test_ref_an_undamped_dyad_is_marginal_and_says_where() -> None:
    spring = ts.Dyad(ts.Robot(1.0, 0.0), ts.Robot(1.0, 0.0))
    found = ts.nyquist(spring, 10.0, 0.0)
    assert found.status == "on the axis"
    assert found.root_on_axis is not None
    assert not found.stable


def test_law_results_cannot_be_changed(hman: ts.Dyad) -> None:
    with pytest.raises(AttributeError):
        ts.nyquist(hman, K, DELAY).stable = False  # type: ignore[misc]


@pytest.mark.parametrize(
    ("call", "field", "said"),
    [
        (lambda d: ts.transfer_matrix(d, K, DELAY, 0.0), "s", "infinite there"),
        (lambda d: ts.transfer_matrix(d, K, DELAY, [1j, 0.0]), "s[1]", "infinite there"),
        (lambda d: ts.transfer_matrix(d, K, DELAY, "i"), "s", "complex number"),
        (lambda d: ts.transfer_matrix(d, K, DELAY, 1j, convention="old"), "convention", '"exact"'),  # type: ignore[arg-type]
        (lambda d: ts.frequency_response(d, K, DELAY, [1.0, 0.0]), "frequency[1]", "infinite there"),
        (lambda d: ts.frequency_response(d, K, 167.0, [1.0]), "delay", "0.167"),
        (lambda d: ts.open_loop(d, K, DELAY, [[1.0]]), "frequency", "one-dimensional"),
        (lambda d: ts.open_loop(d, -1.0, DELAY, 1.0), "stiffness", "coupling stiffness"),
        (lambda d: ts.partner_response(d, K, DELAY, 1.0, robot=2), "robot", "0"),
        (lambda d: ts.frequency_grid(d, K, DELAY, 2.0, 1.0), "high", "above low"),
        (lambda d: ts.nyquist(d, K, DELAY, axis="z"), "axis", '"x", "y"'),
    ],
)
def test_ref_bad_values_are_refused_at_the_door(hman: ts.Dyad, call: Any, field: str, said: str) -> None:
    with pytest.raises(ts.InvalidInput) as refused:
        call(hman)
    assert refused.value.field == field
    assert said in str(refused.value)
