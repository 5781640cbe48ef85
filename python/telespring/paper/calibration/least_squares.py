"""The other likelihood: all cells alike, by least squares, straight on the laboratory.

Where cells are weighed alike the best point lies at the edge of stability, where errors jump: the
surrogate, which is built where the chosen likelihood is high, does not follow them there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from telespring._types import FloatArray
from telespring.paper.calibration.likelihood import Likelihood
from telespring.paper.calibration.surrogate import cap
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
    """Where the fitted cells are missed least, all of them alike, the arm's inertia on top.

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
        """Give plain values for JSON, SI units but the errors, mm."""
        return {
            "unknowns": {
                each.name: {"value": self.values[each.name], "unit": each.unit, "upper_bound": each.high}
                for each in UNKNOWNS
            },
            "rms_error_of_fitted_cells": 1e3 * self.rms,
            "rms_error_of_fitted_cells_at_on_top": 1e3 * self.rms_of_fit,
        }


def least_squares(
    few: Laboratory, many: Laboratory, likelihood: Likelihood, start: FloatArray
) -> LeastSquares:
    """Go down from the optimum of the chosen likelihood to the nearest one of the sum of squares.

    Gauss-Newton within bounds and within a box that shrinks where a step does not pay.

    Parameters
    ----------
    few, many
        Run the laboratory: with a trial or two of each condition, for the way down; with as many as the
        predictions have, by which the way's end is corrected and gone on from.
    likelihood
        Holds the published means.
    start
        In units of the upper bounds.

    Returns
    -------
    LeastSquares
        The same input gives the same output.
    """

    def misses(errors: FloatArray) -> FloatArray:
        return np.asarray((cap(errors) - likelihood.mean).ravel())

    reached, lowest = start, misses(many(start))
    of_fit = float(np.sqrt(np.mean(lowest**2)))
    point, correction = start, lowest - misses(few(start))
    for _ in range(_CONFIRMATIONS):
        offset = correction
        point = _descend(lambda at: misses(few(at)) + offset, point)  # noqa: B023 - called in this turn only
        own = misses(many(point))
        if own @ own < lowest @ lowest:
            reached, lowest = point, own
        correction = own - misses(few(point))
        if np.max(np.abs(correction - offset)) < 1e-4:
            break
    return LeastSquares(
        values={name: float(value) for name, value in zip(NAMES, reached * HIGH, strict=True)},
        point=reached,
        rms=float(np.sqrt(np.mean(lowest**2))),
        rms_of_fit=of_fit,
    )


def _descend(misses: Callable[[FloatArray], FloatArray], start: FloatArray) -> FloatArray:
    from scipy.optimize import lsq_linear

    point, here, size = start, misses(start), _FIRST_STEP
    slope: FloatArray | None = None
    for _ in range(_STEPS):
        if slope is None:
            slope = _slope(misses, point, here)
        low, high = np.maximum(-point, -size), np.minimum(1.0 - point, size)
        # on a bound the box would have no width
        step = lsq_linear(slope, -here, bounds=(low - 1e-12, high + 1e-12)).x
        offered = np.clip(point + step, 0.0, 1.0)
        there = misses(offered)
        if there @ there < here @ here:
            point, here, slope, size = offered, there, None, min(2 * size, _FIRST_STEP)
        else:
            size /= 4
        if size < _SMALLEST_STEP or np.max(np.abs(step)) < _SMALLEST_STEP:
            break
    return point


def _slope(misses: Callable[[FloatArray], FloatArray], point: FloatArray, here: FloatArray) -> FloatArray:
    columns = []
    for i in range(len(point)):
        aside = point.copy()
        aside[i] += _DIFFERENCE if point[i] + _DIFFERENCE <= 1.0 else -_DIFFERENCE
        columns.append((misses(aside) - here) / (aside[i] - point[i]))
    return np.array(columns).T
