"""Delay systems as Python sees them; their roots are proven in the core's own tests."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

import telespring as ts

# x′ = -x(t - 1): s = W(-1), Corless et al. 1996, doi:10.1007/BF02124750
LAMBERT = -0.3181315052047641 + 1.3372357014306895j


def test_ref_roots_of_the_scalar_equation_are_lambert_s() -> None:
    system = ts.DelaySystem([[0]], [(1.0, [[-1]])])
    roots = system.characteristic_roots(4)
    np.testing.assert_allclose(roots[:2], [LAMBERT, LAMBERT.conjugate()], rtol=1e-13)
    assert np.abs(roots + np.exp(-roots)).max() < 1e-12
    assert system.spectral_abscissa() == pytest.approx(LAMBERT.real, rel=1e-13)
    found = system.certified_roots(4)
    assert isinstance(found, ts.Spectrum)
    assert found.complete
    np.testing.assert_array_equal(found.roots, roots)


def test_ref_without_delay_the_roots_are_eigenvalues() -> None:
    a0 = np.array([[0.0, 1.0], [-2.0, -3.0]])
    np.testing.assert_allclose(
        sorted(ts.DelaySystem(a0).characteristic_roots().real), [-2.0, -1.0], rtol=1e-13
    )


def test_cross_a_dyad_s_system_has_its_roots_and_the_rigid_body_s(hman: ts.Dyad) -> None:
    delay = (0.1, 0.2)
    system = hman.delay_system(71.2, delay, axis="y")
    expected = ts.characteristic_roots(hman, 71.2, delay, 5, "y")
    found = system.characteristic_roots(6)
    rigid = np.abs(found).argmin()
    assert found[rigid] == 0.0
    np.testing.assert_allclose(np.delete(found, rigid), expected, rtol=1e-10)


@pytest.mark.parametrize("delay", [(6e-6, 1.4e-5), (6e-5, 1.4e-4), (0.1, 0.2), (43.0, 99.0)])
def test_cross_tiny_and_long_delays_are_certified_too(hman: ts.Dyad, delay: tuple[float, float]) -> None:
    system = hman.delay_system(71.2, delay)
    found = system.certified_roots(8)
    assert found.complete, found.certificate
    expected = ts.characteristic_roots(hman, 71.2, delay, 8)
    moving = found.roots[found.roots != 0.0]
    np.testing.assert_allclose(moving, expected[: len(moving)], rtol=1e-11)
    # the rightmost root has a modulus of up to 13 1/s
    assert system.spectral_abscissa_without_zero() == pytest.approx(expected[0].real, abs=1e-12)
    assert system.roots_at_zero == 1


def test_ref_a_root_at_zero_is_set_apart_exactly() -> None:
    free = ts.hman().delay_system(71.2, 0.1)
    assert free.spectral_abscissa() == 0.0 > free.spectral_abscissa_without_zero()
    held = ts.Dyad(*ts.hman().robots, operators=(ts.Operator(stiffness=1e-3), None)).delay_system(71.2, 0.1)
    assert held.roots_at_zero == 0
    assert held.spectral_abscissa() == held.spectral_abscissa_without_zero() < 0.0
    assert ts.DelaySystem(np.zeros((2, 2))).roots_at_zero == 2
    assert ts.DelaySystem(np.zeros((2, 2))).spectral_abscissa_without_zero() == -np.inf


def test_law_a_system_is_what_was_given() -> None:
    a0 = np.asfortranarray([[0.0, 1.0], [-2.0, -3.0]])
    late, early = np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([[0.0, 0.5], [0.0, 0.0]])
    system = ts.DelaySystem(a0, [(0.5, late), (0.25, early), (0.0, np.eye(2)), (0.5, late)])
    np.testing.assert_array_equal(system.a0, a0 + np.eye(2))
    assert [delay for delay, _ in system.delayed] == [0.25, 0.5]
    np.testing.assert_array_equal(system.delayed[0][1], early)
    np.testing.assert_array_equal(system.delayed[1][1], 2 * late)
    assert pickle.loads(pickle.dumps(system)) == copy.copy(system) == system
    assert eval(repr(system), {"DelaySystem": ts.DelaySystem}) == system
    assert system != ts.DelaySystem(a0)


def test_ref_a_dyad_s_robots_feel_each_other_late() -> None:
    dyad = ts.Dyad(ts.Robot(1.0, 4.0), ts.Robot(2.0, 4.0), coupling_damping=0.5)
    system = dyad.delay_system(10.0, (0.1, 0.2))
    np.testing.assert_array_equal(
        system.a0, [[0, 1, 0, 0], [-10, -4.5, 0, 0], [0, 0, 0, 1], [0, 0, -5, -2.25]]
    )
    (forward, on2), (backward, on1) = system.delayed
    assert (forward, backward) == (0.1, 0.2)
    np.testing.assert_array_equal(on2[3], [5.0, 0.25, 0.0, 0.0])
    np.testing.assert_array_equal(on1[1], [0.0, 0.0, 10.0, 0.5])


def test_ref_roots_that_cannot_be_certified_are_warned_of() -> None:
    # a delay 1000 times the time constants: far more roots than collocation resolves
    system = ts.DelaySystem([[-1000.0]], [(100.0, [[-990.0]])])
    assert not system.certified_roots(900).complete
    with pytest.warns(ts.CertificateWarning, match="certificate"):
        system.characteristic_roots(900)


@pytest.mark.parametrize(
    ("build", "field"),
    [
        (lambda: ts.DelaySystem([[0.0, 1.0]]), "a0"),
        (lambda: ts.DelaySystem([1.0, 2.0]), "a0"),
        (lambda: ts.DelaySystem([[1j]]), "a0"),
        (lambda: ts.DelaySystem([[float("nan")]]), "a0[0][0]"),
        (lambda: ts.DelaySystem([[0.0]], [(-1.0, [[1.0]])]), "delayed[0].delay"),
        (lambda: ts.DelaySystem([[0.0]], [(1.0, [[1.0]]), (2.0, "A")]), "delayed[1].matrix"),
        (lambda: ts.DelaySystem([[0.0]]).characteristic_roots(0), "count"),
        (lambda: ts.hman().delay_system(0.0, 0.1), "stiffness"),
        (lambda: ts.hman().delay_system(10.0, 0.1, axis=2), "axis"),
    ],
)
def test_ref_bad_values_are_refused_at_the_door(build: Any, field: str) -> None:
    with pytest.raises(ts.InvalidInput) as refused:
        build()
    assert refused.value.field == field
