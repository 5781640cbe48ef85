"""Eqs. 5 to 9 as they are printed, evaluated here a second time by companion-matrix roots and scalars.

The core's `method="paper"` shares no code with this.
"""

from __future__ import annotations

import math

import numpy as np

from telespring.paper import as_printed


def maximum_delay(m1: float, b1: float, m2: float, b2: float, k: float) -> tuple[float, float]:
    """Give δ_m (s) and its frequency (rad/s): infinite up to Eq. 5, else the smallest over the roots of F.

    Where B = 0 the printed sign(B) is 0, so z is 0 and its argument, and with it the delay, is 0.
    """
    if k <= (b1**2 + b2**2) / (2 * (m1 + m2)):
        return math.inf, math.nan
    found = []
    for root in np.roots(as_printed.cubic_equation_8(m1, b1, m2, b2, k)):
        if abs(root.imag) < 1e-9 * max(1.0, abs(root)) and root.real > 0.0:
            frequency = math.sqrt(root.real)
            found.append((as_printed.delay_equation_9(m1, b1, m2, b2, k, frequency), frequency))
    return min(found, default=(math.inf, math.nan))
