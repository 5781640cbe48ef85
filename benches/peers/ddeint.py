"""ddeint: scipy's VODE with a linearly interpolated past, as its documentation shows it."""

from __future__ import annotations

from collections.abc import Callable

import ddeint as peer
import numpy as np
from case import Case
from numpy.typing import NDArray


def simulation(case: Case) -> Callable[[], NDArray[np.float64]]:
    m1, b1, m2, b2, k = case.m1, case.b1, case.m2, case.b2, case.k

    def rhs(past, t):  # type: ignore[no-untyped-def]
        y, delayed = past(t), past(t - case.delay)
        return np.array(
            [
                y[1],
                (k * (delayed[2] - y[0]) - b1 * y[1] + 1) / m1,
                y[3],
                (k * (delayed[0] - y[2]) - b2 * y[3] - 1) / m2,
            ]
        )

    def run() -> NDArray[np.float64]:
        out = peer.ddeint(rhs, lambda _: np.zeros(4), case.times)
        return np.asarray(out)[:, ::2].T

    return run
