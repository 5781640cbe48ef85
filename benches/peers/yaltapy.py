"""yaltapy: crossing table and stability windows of a delay system."""

from __future__ import annotations

import numpy as np
import yaltapy as peer


def maximum_delay(m1: float, b1: float, m2: float, b2: float, k: float, horizon: float) -> float:
    """The end of the first stability window up to the horizon, of chi, whose root s = 0 stays."""
    polynomials = np.zeros((2, 5))
    polynomials[0] = np.polymul([m1, b1, k], [m2, b2, k])
    polynomials[1, -1] = -k * k
    result = peer.thread_stability_windows(
        polynomials, np.array([1]), 1.0, 2 * horizon, tmaxsw=2 * horizon, plot=0
    )
    # delays, and whether it is stable from each on
    starts, stable = result["StabilityWindows"]
    unstable = starts[stable == 0]
    return float(unstable[0] / 2) if unstable.size and unstable[0] < 2 * horizon else float("inf")
