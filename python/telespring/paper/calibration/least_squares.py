"""The alternative likelihood: all cells weighted equally, by least squares directly on the laboratory.

With equal weights the optimum lies at the edge of stability, where errors jump; the surrogate, which is
built where the chosen likelihood is high, does not follow them there. The search is our own for the same
reason: `scipy.optimize.least_squares` ends at 5.8 mm (trf) or 6.2 mm (dogbox) where this reaches 5.7 mm.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from telespring._types import FloatArray
from telespring.paper.calibration.likelihood import Likelihood
from telespring.paper.calibration.surrogate import cap_errors
from telespring.paper.calibration.unknowns import HIGH, NAMES, UNKNOWNS

__all__ = ["LeastSquares", "least_squares"]

#: The laboratory's mean errors (condition, robot), m, at a point in units of the upper bounds.
Laboratory = Callable[[FloatArray], FloatArray]

_DIFFERENCE = 0.01
_FIRST_STEP, _SMALLEST_STEP = 0.1, 0.001
_STEPS = 20
_CONFIRMATIONS = 2


@dataclass(frozen=True)
class LeastSquares:
    """Least-squares optimum over the fitted cells, the arm's inertia on top of Table III.

    Attributes
    ----------
    values
        The unknowns, SI units.
    point
        The same in units of their upper bounds.
    rms
        Root mean square over the fitted cells there, m.
    rms_of_fit
        The same at the optimum of the chosen likelihood, m.
    """

    values: dict[str, float]
    point: FloatArray
    rms: float
    rms_of_fit: float

    def numbers(self) -> dict[str, Any]:
        """Least-squares optimum for JSON; SI units, errors in mm."""
        return {
            "unknowns": {
                unknown.name: {
                    "value": self.values[unknown.name],
                    "unit": unknown.unit,
                    "upper_bound": unknown.high,
                }
                for unknown in UNKNOWNS
            },
            "rms_error_of_fitted_cells": 1e3 * self.rms,
            "rms_error_of_fitted_cells_at_on_top": 1e3 * self.rms_of_fit,
        }


def least_squares(
    few: Laboratory, many: Laboratory, likelihood: Likelihood, start: FloatArray
) -> LeastSquares:
    """Descend from the optimum of the chosen likelihood to the nearest minimum of the sum of squares.

    Gauss-Newton within bounds and within a box that shrinks after a step that does not improve. `few` runs
    the laboratory with a trial or two of each condition, for the descent; `many` with as many as the
    predictions have, to correct the result of a descent and continue from it. Points are in units of the
    upper bounds.
    """

    def residuals(errors: FloatArray) -> FloatArray:
        return np.asarray((cap_errors(errors) - likelihood.mean).ravel())

    best, least = start, residuals(many(start))
    of_fit = float(np.sqrt(np.mean(least**2)))
    point, correction = start, least - residuals(few(start))
    for _ in range(_CONFIRMATIONS):
        offset = correction
        point = _descend_sum_of_squares(lambda at: residuals(few(at)) + offset, point)  # noqa: B023 - called in this turn
        confirmed = residuals(many(point))
        if confirmed @ confirmed < least @ least:
            best, least = point, confirmed
        correction = confirmed - residuals(few(point))
        if np.max(np.abs(correction - offset)) < 1e-4:
            break
    return LeastSquares(
        values={name: float(value) for name, value in zip(NAMES, best * HIGH, strict=True)},
        point=best,
        rms=float(np.sqrt(np.mean(least**2))),
        rms_of_fit=of_fit,
    )


def _descend_sum_of_squares(residuals: Callable[[FloatArray], FloatArray], start: FloatArray) -> FloatArray:
    from scipy.optimize import lsq_linear

    point, residual, size = start, residuals(start), _FIRST_STEP
    jacobian: FloatArray | None = None
    for _ in range(_STEPS):
        if jacobian is None:
            jacobian = _jacobian_of_residuals(residuals, point, residual)
        low, high = np.maximum(-point, -size), np.minimum(1.0 - point, size)
        # on a bound the box would have no width
        step = lsq_linear(jacobian, -residual, bounds=(low - 1e-12, high + 1e-12)).x
        candidate = np.clip(point + step, 0.0, 1.0)
        candidate_residual = residuals(candidate)
        if candidate_residual @ candidate_residual < residual @ residual:
            point, residual, jacobian, size = candidate, candidate_residual, None, min(2 * size, _FIRST_STEP)
        else:
            size /= 4
        if size < _SMALLEST_STEP or np.max(np.abs(step)) < _SMALLEST_STEP:
            break
    return point


def _jacobian_of_residuals(
    residuals: Callable[[FloatArray], FloatArray], point: FloatArray, residual: FloatArray
) -> FloatArray:
    columns = []
    for i in range(len(point)):
        neighbour = point.copy()
        neighbour[i] += _DIFFERENCE if point[i] + _DIFFERENCE <= 1.0 else -_DIFFERENCE
        columns.append((residuals(neighbour) - residual) / (neighbour[i] - point[i]))
    return np.array(columns).T
