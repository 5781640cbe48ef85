"""Design of the laboratory runs: first evenly over the unknowns, then where the likelihood is high."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from telespring._types import FloatArray
from telespring.paper.calibration.fit import optimum
from telespring.paper.calibration.likelihood import Likelihood, threshold
from telespring.paper.calibration.surrogate import Surrogate
from telespring.paper.calibration.unknowns import NAMES, VARIANTS, free_unknowns

__all__ = ["Sizes", "explore"]

#: Points of the even design, of the plausible region, and around each variant's optimum.
Sizes = tuple[int, int, int]

_NEIGHBOURHOOD = 0.15

#: Mean errors (point, condition, robot), m, at points in units of the upper bounds.
Laboratory = Callable[[FloatArray], FloatArray]


def explore(laboratory: Laboratory, likelihood: Likelihood, sizes: Sizes) -> Surrogate:
    """Run the laboratory at a design of points and build the surrogate through them.

    A quarter of the points has no arm mass on top: there both variants are the same model. The laboratory
    runs all points with the same random numbers, so that the surrogate is smooth. Further points are spent
    where the likelihood is high, and around both optima.
    """
    even, plausible, near = sizes
    points = _sobol_design_points(even, 1)
    surrogate = Surrogate(points, laboratory(points))
    candidates = _sobol_design_points(16 * max(plausible, 64), 2)
    deviance = likelihood.deviance(surrogate(candidates))
    inside = candidates[deviance <= deviance.min() + threshold(len(likelihood.mean), len(NAMES))]
    if len(inside) < plausible:
        inside = candidates[np.argsort(deviance, kind="stable")[:plausible]]
    surrogate = _add_design_points(surrogate, inside[:plausible], laboratory)
    for number, variant in enumerate(VARIANTS):
        free = free_unknowns(variant)
        best, _ = optimum(surrogate, likelihood, free)
        around = best + 2 * _NEIGHBOURHOOD * (_sobol_design_points(near, 3 + number, every=0) - 0.5)
        around = np.clip(around, 0.0, 1.0)
        fixed = [i for i in range(len(NAMES)) if i not in free]
        around[:, fixed] = best[fixed]
        surrogate = _add_design_points(surrogate, around, laboratory)
    return surrogate


def _sobol_design_points(count: int, seed: int, every: int = 4) -> FloatArray:
    """Sobol's points over the unit cube, one in `every` of them moved to no arm mass."""
    from scipy.stats import qmc

    # Sobol sequences have powers of two
    points = qmc.Sobol(len(NAMES), seed=seed).random_base2(max(count - 1, 1).bit_length())[:count]
    if every:
        points[::every, 0] = 0.0
    return np.asarray(points)


def _add_design_points(surrogate: Surrogate, points: FloatArray, laboratory: Laboratory) -> Surrogate:
    # a repeated point, as bounds cause, would make the interpolation singular
    both = np.concatenate([surrogate.points, points])
    _, first = np.unique(np.round(both, 9), axis=0, return_index=True)
    new = both[np.sort(first[first >= len(surrogate.points)])]
    errors = laboratory(new)
    return Surrogate(np.concatenate([surrogate.points, new]), np.concatenate([surrogate.errors, errors]))
