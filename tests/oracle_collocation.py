"""Stability of a delayed dyad by a method that shares nothing with telespring, in NumPy alone.

Chebyshev collocation of the infinitesimal generator of the delay equation (D. Breda, S. Maset,
R. Vermiglio, "Pseudospectral differencing methods for characteristic roots of delay differential
equations", SIAM J. Sci. Comput. 27 (2005) 482-495). Only what is delayed is discretised: robot 2's
coupling signal k x2 + c v2 on its way of T = 2 δ seconds round the loop to robot 1, which is where
both ways' delays act once robot 1's clock is set δ seconds late. Eigenvalues near the imaginary axis
are then refined by Newton's method on the characteristic function in extended precision.

Nothing here imports telespring, and nothing here finds a crossing of the imaginary axis.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Counts = NDArray[np.int64]


class Axes(NamedTuple):
    """One column per parameter: SI units, as telespring's criteria take them."""

    m1: Floats
    b1: Floats
    m2: Floats
    b2: Floats
    kh1: Floats
    kh2: Floats
    c: Floats

    def at(self, chosen: Counts) -> Axes:
        """Return these columns' elements, in this order."""
        return Axes(*(column[chosen] for column in self))


class Verdict(NamedTuple):
    """Spectral abscissa (rigid-body root left out), 1/s, and whether its digits are confirmed."""

    abscissa: Floats
    resolved: NDArray[np.bool_]


def characteristic(
    axes: Axes, k: Floats, delay: Floats, s: NDArray[np.clongdouble]
) -> tuple[NDArray[np.clongdouble], NDArray[np.clongdouble]]:
    """Return χ(s) = P1 P2 - (k + c s)² exp(-2 δ s) and χ'(s); s has one trailing index more."""
    m1, b1, m2, b2, kh1, kh2, c = (np.asarray(one, np.longdouble)[..., None] for one in axes)
    stiffness, total = (np.asarray(one, np.longdouble)[..., None] for one in (k, 2 * delay))
    p1, d1 = (m1 * s + b1 + c) * s + stiffness + kh1, 2 * m1 * s + b1 + c
    p2, d2 = (m2 * s + b2 + c) * s + stiffness + kh2, 2 * m2 * s + b2 + c
    coupling, turn = stiffness + c * s, np.exp(-total * s)
    return p1 * p2 - coupling**2 * turn, d1 * p2 + p1 * d2 - coupling * (2 * c - total * coupling) * turn


def reach(axes: Axes, k: Floats) -> Floats:
    """Bound |s| of every root with Re s >= 0, whatever the delay.

    There |m s + b| >= hypot(m |s|, b), so |P_i| >= |s| hypot(m_i |s|, b_i + c) - k - kh_i, and
    |k + c s|² |exp(-T s)| <= (k + c |s|)². Beyond the largest |s| where the product of the two does
    not exceed this there is no root; it is looked for from far outside inwards.
    """
    m1, b1, m2, b2, kh1, kh2, c = axes
    scale = np.sqrt((k + np.maximum(kh1, kh2)) / np.minimum(m1, m2)) + c / np.minimum(m1, m2)
    radii = scale[:, None] * np.geomspace(30.0, 1e-4, 700)
    one = radii * np.hypot(m1[:, None] * radii, (b1 + c)[:, None]) - (k + kh1)[:, None]
    two = radii * np.hypot(m2[:, None] * radii, (b2 + c)[:, None]) - (k + kh2)[:, None]
    free = (one > 0) & (two > 0) & (one * two > (k[:, None] + c[:, None] * radii) ** 2)
    inside = np.argmin(free, axis=1)  # the first radius, from outside, that may hold a root
    assert free[:, 0].all()
    outer: Floats = radii[np.arange(len(k)), np.maximum(inside - 1, 0)]
    return outer


def nodes_needed(phase: Floats) -> Counts:
    """Nodes that resolve exp(iωθ) over the delay to rounding; `phase` is ω T / 2, rounded up to 8."""
    # the Chebyshev coefficients of that wave are Bessel functions J_n(phase), which fall off
    # faster than exponentially from n = phase + a few phase^(1/3)
    needed = phase + 5.0 * np.cbrt(phase) + 16.0
    return (8 * np.ceil(needed / 8)).astype(np.int64)


def generator(axes: Axes, k: Floats, delay: Floats, nodes: int) -> Floats:
    """Return the matrices whose eigenvalues approximate the roots, one per dyad."""
    m1, b1, m2, b2, kh1, kh2, c = axes
    grid = np.arange(nodes + 1)
    points = np.cos(np.pi * grid / nodes)
    weights = np.where((grid == 0) | (grid == nodes), 2.0, 1.0) * (-1.0) ** grid
    difference = points[:, None] - points + np.eye(nodes + 1)
    derivative = weights[:, None] / weights / difference
    derivative -= np.diag(derivative.sum(axis=1))

    out = np.zeros((len(k), 4 + nodes, 4 + nodes))
    x1, v1, x2, v2, sent = 0, 1, 2, 3, slice(4, None)  # the signal's present value is k x2 + c v2
    out[:, x1, v1] = out[:, x2, v2] = 1.0
    out[:, v1, x1], out[:, v1, v1] = -(k + kh1) / m1, -(b1 + c) / m1
    out[:, v2, x2], out[:, v2, v2] = -(k + kh2) / m2, -(b2 + c) / m2
    out[:, v2, x1], out[:, v2, v1] = k / m2, c / m2
    out[:, v1, -1] = 1.0 / m1  # the last node is T seconds old
    rate = 1.0 / delay[:, None]  # d/dθ over an interval of length T = 2 δ is D / δ
    out[:, sent, sent] = derivative[1:, 1:] * rate[..., None]
    out[:, sent, x2] = derivative[1:, 0] * rate * k[:, None]
    out[:, sent, v2] = derivative[1:, 0] * rate * c[:, None]
    return out


def newton(axes: Axes, k: Floats, delay: Floats, start: Complexes) -> NDArray[np.clongdouble]:
    """Refine approximate roots; one trailing index of `start` counts roots of one dyad."""
    s = start.astype(np.clongdouble)
    for _ in range(30):
        value, slope = characteristic(axes, k, delay, s)
        step = np.where(slope == 0, 0, value / np.where(slope == 0, 1, slope))
        s = s - step
        if np.all(np.abs(step) <= 4 * np.finfo(np.longdouble).eps * np.abs(s)):
            break
    return s


def _abscissa_with(axes: Axes, k: Floats, delay: Floats, nodes: int, scale: Floats) -> Verdict:
    found = np.linalg.eigvals(generator(axes, k, delay, nodes))
    free = (axes.kh1 == 0) & (axes.kh2 == 0)
    nearest_zero = np.argmin(np.abs(found), axis=1)
    rigid = np.abs(found[np.arange(len(k)), nearest_zero])
    # the rigid-body root is simple, so that rounding moves it by a tiny part of the matrix' size
    resolved = ~free | (rigid < 1e-7 * scale)
    found[free, nearest_zero[free]] = -np.inf
    order = np.argsort(-found.real, axis=1)[:, :6]
    rough = np.take_along_axis(found, order, axis=1)
    sharp = newton(axes, k, delay, np.where(np.isfinite(rough), rough, scale[:, None]))
    moved = np.abs(sharp - rough).astype(np.float64)
    # far left of the first a root may be rough: only those that could be rightmost must stand still
    deciding = rough.real >= rough.real[:, :1] - 1e-4 * scale[:, None]
    resolved &= np.all(~deciding | (moved < 1e-6 * scale[:, None]), axis=1)
    real = np.where(deciding, sharp.real, -np.inf).max(axis=1)
    return Verdict(real.astype(np.float64), resolved)


def spectral_abscissa(axes: Axes, k: Floats, delay: Floats, *, batch: int = 128) -> Verdict:
    """Largest real part of the roots, 1/s, without the rigid-body root of free handles.

    Where Newton moves a deciding eigenvalue the nodes are doubled, twice at most; where the
    abscissa is within a thousandth of the root's possible size from the axis, a finer grid must
    confirm it.
    """
    size = reach(axes, k)
    needed = nodes_needed(size * delay)
    abscissa, resolved = np.full(len(k), np.nan), np.zeros(len(k), bool)

    def compute(which: Counts, factor: int) -> None:
        for nodes in np.unique(needed[which]):
            same = which[needed[which] == nodes]
            for start in range(0, len(same), batch):
                part = same[start : start + batch]
                abscissa[part], resolved[part] = _abscissa_with(
                    axes.at(part), k[part], delay[part], int(nodes) * factor, size[part]
                )

    compute(np.arange(len(k)), 1)
    near = np.flatnonzero(np.abs(abscissa) < 1e-3 * size)
    before = abscissa[near]
    compute(near, 2)
    # both grids end in Newton's method: they must find the same root to its last digits
    resolved[near] &= np.abs(abscissa[near] - before) < 1e-12 * size[near]
    for factor in (2, 4):
        compute(np.flatnonzero(~resolved), factor)
    return Verdict(abscissa, resolved)
