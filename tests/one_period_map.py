"""The dyad under two sampled controllers as an explicit one-period matrix: shares no code with the core."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from telespring._types import FloatArray

__all__ = ["gain", "radius"]

#: Mass (kg), damping (N·s/m) and ground stiffness (N/m) of one side.
Side = tuple[float, float, float]


def _held(side: Side, span: float) -> tuple[FloatArray, FloatArray]:
    """Free motion and the effect of a constant force over a span, by the matrix exponential."""
    mass, damping, ground = side
    generator = np.zeros((3, 3))
    generator[0, 1] = span
    generator[1] = [-ground / mass * span, -damping / mass * span, span / mass]
    step = expm(generator)
    return step[:2, :2], step[:2, 2]


def _one_period(
    sides: tuple[Side, Side], k: float, c: float, period: float, computing: float, ticks: tuple[int, int]
) -> FloatArray:
    """Map position, velocity and last force of both sides, and their samples under way, over one period."""
    size = [3 + 2 * each for each in ticks]
    base = [0, size[0]]
    step = np.zeros((sum(size), sum(size)))
    for i in range(2):
        me, partner, late = base[i], base[1 - i], ticks[1 - i]
        whole, _ = _held(sides[i], period)
        rest, new = _held(sides[i], period - computing)
        _, early = _held(sides[i], computing)
        seen = partner if late == 0 else partner + 3 + 2 * (late - 1)
        force = ((seen, k), (seen + 1, c), (me, -k), (me + 1, -c))
        step[me : me + 2, me : me + 2] += whole
        step[me : me + 2, me + 2] += rest @ early
        for column, weight in force:
            step[me : me + 2, column] += new * weight
            step[me + 2, column] += weight
        for n in range(ticks[i]):
            for part in range(2):
                source = me + part if n == 0 else me + 3 + 2 * (n - 1) + part
                step[me + 3 + 2 * n + part, source] = 1.0
    return step


def radius(
    sides: tuple[Side, Side], k: float, c: float, period: float, computing: float, ticks: tuple[int, int]
) -> float:
    """Return the largest multiplier, the rigid-body multiplier of free handles left out."""
    multipliers = np.linalg.eigvals(_one_period(sides, k, c, period, computing, ticks))
    if sides[0][2] == 0.0 and sides[1][2] == 0.0:
        multipliers = np.delete(multipliers, np.argmin(np.abs(multipliers - 1.0)))
    return float(np.abs(multipliers).max())


def gain(side: Side, k: float, period: float) -> float:
    """Return the sum of the absolute response of one held loop to a unit pulse of its partner's position."""
    free, push = _held(side, period)
    loop = free - np.outer(k * push, [1.0, 0.0])
    multipliers, vectors = np.linalg.eig(loop)
    slowest = float(np.abs(multipliers).max())
    if slowest >= 1.0:
        return float("inf")
    weights = vectors[0] * np.linalg.solve(vectors, k * push.astype(complex))
    samples = np.arange(int(40.0 / -np.log(slowest)) + 3)
    return float(np.abs((multipliers[:, None] ** samples * weights[:, None]).sum(axis=0)).sum())
