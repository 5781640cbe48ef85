"""numpy: the crossing polynomial's roots as eigenvalues of companion matrices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def maximum_delay(m1: float, b1: float, m2: float, b2: float, k: float) -> float:
    """numpy.roots on the cubic in ω², then the phase."""
    e1, e2 = b1 * b1 - 2 * m1 * k, b2 * b2 - 2 * m2 * k
    s1, s2 = m1 * m1, m2 * m2
    y = np.roots([s1 * s2, s1 * e2 + s2 * e1, (s1 + s2) * k * k + e1 * e2, (e1 + e2) * k * k])
    y = y.real[(np.abs(y.imag) < 1e-9 * np.abs(y)) & (y.real > 0)]
    if not y.size:
        return float("inf")
    w = np.sqrt(y)
    p = (k - m1 * y + 1j * b1 * w) * (k - m2 * y + 1j * b2 * w)
    return float(np.min(np.mod(-np.angle(p), 2 * np.pi) / (2 * w)))


def paper_critical_stiffness(m1: float, b1: float, m2: float, b2: float) -> float:
    return (b1 * b1 + b2 * b2) / (2 * (m1 + m2))


def maximum_delays(
    m1: NDArray[np.float64],
    b1: NDArray[np.float64],
    m2: NDArray[np.float64],
    b2: NDArray[np.float64],
    k: NDArray[np.float64],
) -> NDArray[np.float64]:
    """The same for arrays, with one batch of eigenvalues."""
    e1, e2 = b1 * b1 - 2 * m1 * k, b2 * b2 - 2 * m2 * k
    s1, s2 = m1 * m1, m2 * m2
    companion = np.zeros((len(k), 3, 3))
    companion[:, 0, 0] = -(s1 * e2 + s2 * e1) / (s1 * s2)
    companion[:, 0, 1] = -((s1 + s2) * k * k + e1 * e2) / (s1 * s2)
    companion[:, 0, 2] = -(e1 + e2) * k * k / (s1 * s2)
    companion[:, 1, 0] = companion[:, 2, 1] = 1
    y = np.linalg.eigvals(companion)
    real = (np.abs(y.imag) < 1e-9 * np.abs(y)) & (y.real > 0)
    y = np.where(real, y.real, np.nan)
    w = np.sqrt(y)
    m1, b1, m2, b2, k = (x[:, None] for x in (m1, b1, m2, b2, k))
    p = (k - m1 * y + 1j * b1 * w) * (k - m2 * y + 1j * b2 * w)
    delays = np.mod(-np.angle(p), 2 * np.pi) / (2 * w)
    result: NDArray[np.float64] = np.min(np.where(real, delays, np.inf), axis=1)
    return result
