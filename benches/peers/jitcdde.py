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
    equations = peer.jitcdde(rhs, verbose=False, max_delay=max(case.delay, 1e-12))
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
        equations.step_on_discontinuities()
        out = np.zeros((case.count, 4))
        for i, t in enumerate(case.times):
            # outputs inside the steps already taken for the discontinuities are interpolated
            out[i] = equations.integrate(t) if t > 0 else 0.0
        return out[:, ::2].T

    return run
