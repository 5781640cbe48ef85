"""The method of steps over scipy.integrate.solve_ivp: one call per delay, the past its dense output."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from case import Case
from numpy.typing import NDArray
from scipy.integrate import solve_ivp


def simulation(case: Case, rtol: float, max_step: float = np.inf) -> Callable[[], NDArray[np.float64]]:
    """Return a call that simulates with DOP853."""
    m1, b1, m2, b2, k = case.m1, case.b1, case.m2, case.b2, case.k

    def run() -> NDArray[np.float64]:
        times = case.times
        out = np.zeros((2, case.count))
        start, state = 0.0, np.zeros(4)
        past = None
        while start < case.duration:
            end = min(start + case.delay, case.duration)

            def rhs(t: float, y: NDArray[np.float64], past=past) -> list[float]:  # type: ignore[no-untyped-def]
                x1, _, x2, _ = (0.0, 0.0, 0.0, 0.0) if past is None else past(t - case.delay)
                return [
                    y[1],
                    (k * (x2 - y[0]) - b1 * y[1] + 1) / m1,
                    y[3],
                    (k * (x1 - y[2]) - b2 * y[3] - 1) / m2,
                ]

            solved = solve_ivp(
                rhs,
                (start, end),
                state,
                "DOP853",
                rtol=rtol,
                atol=rtol * 1e-3,
                dense_output=True,
                max_step=max_step,
            )
            inside = (times >= start) & (times <= end)
            out[:, inside] = solved.sol(times[inside])[::2]
            start, state, past = end, solved.y[:, -1], solved.sol
        return out

    return run
