"""jitcdde: adaptive Bogacki-Shampine 2(3) with Hermite interpolation, compiled to C."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Callable
from typing import Any

import jitcdde as peer
import numpy as np
from case import Case
from numpy.typing import NDArray


def build(case: Case) -> Any:
    """Generate and compile the equations; they can be integrated once."""
    y, t = peer.y, peer.t
    rhs = [
        y(1),
        (case.k * (y(2, t - case.delay) - y(0)) - case.b1 * y(1) + 1) / case.m1,
        y(3),
        (case.k * (y(0, t - case.delay) - y(2)) - case.b2 * y(3) - 1) / case.m2,
    ]
    # told its delays, it needs no sympy to find them
    equations = peer.jitcdde(rhs, verbose=False, delays=[0, case.delay], max_delay=case.delay)
    # it compiles as a package of the current folder, which must therefore hold no other
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        # simplification alone would need sympy, which it does not ask for
        equations.compile_C(simplify=False)
    return equations


def integrate(equations: Any, case: Case, **tolerances: float) -> Callable[[], NDArray[np.float64]]:
    """Return a call that integrates from rest, at the given or else the default tolerances."""

    def run() -> NDArray[np.float64]:
        equations.purge_past()
        equations.constant_past(np.zeros(4), time=0.0)
        equations.set_integration_parameters(**tolerances)
        # the jump at t = 0 is smoothed over, so that every output can be had from the start on
        equations.adjust_diff()
        first = equations.t
        out = np.zeros((case.count, 4))
        for i, t in enumerate(case.times):
            out[i] = equations.integrate(t) if t > first else 0.0
        return out[:, ::2].T

    return run
