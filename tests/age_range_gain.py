"""The gain that decides for ages in a range, on a grid of frequencies: it shares no code with the core."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import minimize_scalar

import telespring as ts


def gain(
    k: float, ages: tuple[tuple[float, float], tuple[float, float]], one: ts.Robot, two: ts.Robot
) -> float:
    """Return the largest singular value over all frequencies, with the best constant scale."""
    (low1, high1), (low2, high2) = ages
    half1, half2 = 0.5 * (high1 - low1), 0.5 * (high2 - low2)
    s = 1j * np.logspace(-2, 3, 20_000)
    p1, p2 = ((float(r.mass[0]) * s + float(r.damping[0])) * s + k for r in (one, two))
    e1, e2 = np.exp(-s * 0.5 * (low1 + high1)), np.exp(-s * 0.5 * (low2 + high2))
    common = s * k / (p1 * p2 - k * k * e1 * e2)

    def largest(log: float) -> float:
        scale = math.exp(log)
        matrix = np.empty((s.size, 2, 2), complex)
        matrix[:, 0, 0], matrix[:, 0, 1] = half1 * k * e2, half1 * p1 / scale
        matrix[:, 1, 0], matrix[:, 1, 1] = half2 * p2 * scale, half2 * k * e1
        return float(np.linalg.norm(common[:, None, None] * matrix, 2, axis=(1, 2)).max())

    return float(minimize_scalar(largest, bounds=(-4.0, 4.0), method="bounded").fun)
