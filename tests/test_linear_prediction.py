"""Where a linear prediction destabilises the bare spring by itself: the numbers of docs/guard.md."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import telespring as ts

#: axis x of the first H-MAN, Table III
MASS, DAMPING = 0.8334, 7.7257
PAGE = Path(__file__).parents[1] / "docs" / "guard.md"


def printed_limits() -> list[tuple[float, float, float]]:
    """Return the delay (s) and both limits (N/m) of every row of the table."""
    rows = re.findall(
        r"^\| (\d+) ms \| ([\d.]+) N/m \| ([\d.]+) N/m \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE
    )
    return [(float(delay) / 1e3, float(hold), float(linear)) for delay, hold, linear in rows]


def growth(stiffness: float, delay: float, *, is_linear: bool) -> float:
    """Return the largest real part of the roots of two identical robots that move against each other, 1/s."""
    own = [[0.0, 1.0], [-stiffness / MASS, -DAMPING / MASS]]
    partner = [[0.0, 0.0], [-stiffness / MASS, -stiffness * delay / MASS if is_linear else 0.0]]
    return ts.DelaySystem(own, [(delay, partner)]).spectral_abscissa()


def closed_form(delay: float, *, is_linear: bool) -> float:
    """Return the smallest positive k of a root on the imaginary axis.

    There k = -(m s² + b s) / (1 ± (1 + δ s) e^(-δ s)), without δ s if nothing is predicted.
    """
    s = 1j * np.linspace(1e-3, 100.0, 200_001)
    gain = (1 + delay * s if is_linear else 1) * np.exp(-delay * s)
    limits = []
    for sign in (1, -1):
        k = -(MASS * s**2 + DAMPING * s) / (1 + sign * gain)
        crossing = np.nonzero((k.imag[:-1] * k.imag[1:] < 0) & (np.abs(np.diff(k.imag)) < 1e3))[0]
        limits += [value for value in k.real[crossing] if value > 0]
    return float(min(limits))


def test_the_page_has_the_table() -> None:
    assert [delay for delay, _, _ in printed_limits()] == [0.02, 0.05, 0.084, 0.12, 0.167, 0.25, 0.334]


@pytest.mark.parametrize(("delay", "hold", "linear"), printed_limits())
def test_cross_linear_prediction_destabilises_where_the_page_says(
    delay: float, hold: float, linear: float
) -> None:
    for limit, is_linear in ((hold, False), (linear, True)):
        assert closed_form(delay, is_linear=is_linear) == pytest.approx(limit, rel=2e-3)
        assert growth(0.99 * limit, delay, is_linear=is_linear) < 0
        assert growth(1.01 * limit, delay, is_linear=is_linear) > 0
