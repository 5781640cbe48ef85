"""Hand-written Runge-Kutta 4 under numba: what a careful user writes.

The step divides the delay, so that the breaks at its multiples are steps' ends and only the middle of
a past step is interpolated (cubic Hermite); it is as near to the output period as that allows.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numba
import numpy as np
from case import RATE, Case
from numpy.typing import NDArray


@numba.njit(fastmath=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _steps(m1, b1, m2, b2, k, h, lag, count, y):  # type: ignore[no-untyped-def]
    # y holds x1, v1, x2, v2 at every step
    x1 = v1 = x2 = v2 = 0.0
    i1, i2 = 1.0 / m1, 1.0 / m2
    half = 0.5 * h
    for n in range(count - 1):
        y[n, 0], y[n, 1], y[n, 2], y[n, 3] = x1, v1, x2, v2
        if lag == 0:
            # without delay the partner is where it is now
            u1a, u2a = x2, x1
            k1a, k1b = v1, (k * (u1a - x1) - b1 * v1 + 1.0) * i1
            k1c, k1d = v2, (k * (u2a - x2) - b2 * v2 - 1.0) * i2
            p1, q1, p2, q2 = x1 + half * k1a, v1 + half * k1b, x2 + half * k1c, v2 + half * k1d
            k2a, k2b = q1, (k * (p2 - p1) - b1 * q1 + 1.0) * i1
            k2c, k2d = q2, (k * (p1 - p2) - b2 * q2 - 1.0) * i2
            p1, q1, p2, q2 = x1 + half * k2a, v1 + half * k2b, x2 + half * k2c, v2 + half * k2d
            k3a, k3b = q1, (k * (p2 - p1) - b1 * q1 + 1.0) * i1
            k3c, k3d = q2, (k * (p1 - p2) - b2 * q2 - 1.0) * i2
            p1, q1, p2, q2 = x1 + h * k3a, v1 + h * k3b, x2 + h * k3c, v2 + h * k3d
            k4a, k4b = q1, (k * (p2 - p1) - b1 * q1 + 1.0) * i1
            k4c, k4d = q2, (k * (p1 - p2) - b2 * q2 - 1.0) * i2
        else:
            u1a = u1m = u1b = u2a = u2m = u2b = 0.0
            if n >= lag:
                past = n - lag
                u2a, u2b = y[past, 0], y[past + 1, 0]
                u1a, u1b = y[past, 2], y[past + 1, 2]
                u2m = 0.5 * (u2a + u2b) + 0.125 * h * (y[past, 1] - y[past + 1, 1])
                u1m = 0.5 * (u1a + u1b) + 0.125 * h * (y[past, 3] - y[past + 1, 3])
            k1a, k1b = v1, (k * (u1a - x1) - b1 * v1 + 1.0) * i1
            k1c, k1d = v2, (k * (u2a - x2) - b2 * v2 - 1.0) * i2
            p1, q1, p2, q2 = x1 + half * k1a, v1 + half * k1b, x2 + half * k1c, v2 + half * k1d
            k2a, k2b = q1, (k * (u1m - p1) - b1 * q1 + 1.0) * i1
            k2c, k2d = q2, (k * (u2m - p2) - b2 * q2 - 1.0) * i2
            p1, q1, p2, q2 = x1 + half * k2a, v1 + half * k2b, x2 + half * k2c, v2 + half * k2d
            k3a, k3b = q1, (k * (u1m - p1) - b1 * q1 + 1.0) * i1
            k3c, k3d = q2, (k * (u2m - p2) - b2 * q2 - 1.0) * i2
            p1, q1, p2, q2 = x1 + h * k3a, v1 + h * k3b, x2 + h * k3c, v2 + h * k3d
            k4a, k4b = q1, (k * (u1b - p1) - b1 * q1 + 1.0) * i1
            k4c, k4d = q2, (k * (u2b - p2) - b2 * q2 - 1.0) * i2
        x1 += h / 6.0 * (k1a + 2.0 * (k2a + k3a) + k4a)
        v1 += h / 6.0 * (k1b + 2.0 * (k2b + k3b) + k4b)
        x2 += h / 6.0 * (k1c + 2.0 * (k2c + k3c) + k4c)
        v2 += h / 6.0 * (k1d + 2.0 * (k2d + k3d) + k4d)
    y[count - 1, 0], y[count - 1, 1], y[count - 1, 2], y[count - 1, 3] = x1, v1, x2, v2


@numba.njit(fastmath=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _outputs(h, rate, y, out):  # type: ignore[no-untyped-def]
    for i in range(out.shape[1]):
        place = i / rate / h
        n = min(int(place + 1e-9), y.shape[0] - 2)
        u = place - n
        for robot in range(2):
            a, va, b, vb = y[n, 2 * robot], y[n, 2 * robot + 1], y[n + 1, 2 * robot], y[n + 1, 2 * robot + 1]
            w = 1.0 - u
            out[robot, i] = w * w * ((1.0 + 2.0 * u) * a + u * h * va) + u * u * (
                (1.0 + 2.0 * w) * b - w * h * vb
            )


def simulation(case: Case) -> Callable[[], NDArray[np.float64]]:
    """Return a call that simulates into arrays of its own, made once."""
    lag = math.ceil(case.delay * RATE - 1e-9)
    h = case.delay / lag if lag else 1.0 / RATE
    count = math.ceil(case.duration / h - 1e-9) + 1
    y, out = np.zeros((count, 4)), np.zeros((2, case.count))
    on_grid = count == case.count
    args = (case.m1, case.b1, case.m2, case.b2, case.k, h, lag, count, y)

    def run() -> NDArray[np.float64]:
        _steps(*args)
        if on_grid:
            # every output is a step
            return y[:, ::2].T
        _outputs(h, RATE, y, out)
        return out

    run()
    return run
