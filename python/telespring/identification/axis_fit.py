"""The regression of one axis: F = m a + b v + F_c sign v + F_0 fitted to filtered signals."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification import regression
from telespring.identification.filtering import Signals
from telespring.identification.results import AxisIdentification, Estimate, Method

__all__ = ["AxisModel", "axis_regressor", "fit_axis"]


@dataclass(frozen=True)
class AxisModel:
    """Which terms are fitted in addition to mass and damping, and by which method."""

    coulomb: bool
    offset: bool
    method: Method
    iterations: int

    @property
    def omitted(self) -> tuple[str, ...]:
        """The optional terms that are not in the model."""
        return tuple(name for name in ("coulomb", "offset") if not getattr(self, name))


def axis_regressor(signals: Signals, index: int, model: AxisModel) -> FloatArray:
    """Build the regressor that one axis is fitted with, in SI units."""
    return regression.regressor_matrix(
        signals.acceleration[index],
        signals.velocity[index],
        signals.direction[index] if model.coulomb else None,
        offset=model.offset,
    )


def fit_axis(name: str, index: int, signals: Signals, model: AxisModel) -> AxisIdentification:
    """Estimate mass, damping and friction of the axis in row `index` of the signals.

    InvalidInput where the columns of the regressor are nearly multiples of each other.
    """
    regressor, force = axis_regressor(signals, index, model), signals.force[index]
    condition = _scaled_condition_number(regressor)
    if not condition < 1e6:
        raise InvalidInput(
            f"position ({name})",
            f"condition number {condition:.3g}",
            "a movement is required whose acceleration and velocity are not multiples of each other",
            "Excite it with several frequencies, as telespring.identification.paper_excitation does.",
        )
    if model.method == "paper":
        fit = regression.paper_least_squares(regressor, force, model.iterations)
    elif model.method == "ols":
        fit = regression.least_squares(regressor, force)
    else:
        fit = regression.robust_least_squares(regressor, force)
    half, error = fit.half_width(), fit.standard_error
    estimates = [
        Estimate(float(value), float(error[i]), (float(value - half[i]), float(value + half[i])))
        for i, value in enumerate(fit.estimate)
    ]
    variation = float(((force - force.mean()) ** 2).sum())
    squares = float((fit.residual**2).sum())
    return AxisIdentification(
        axis=name,
        mass=estimates[0],
        damping=estimates[1],
        coulomb=estimates[2] if model.coulomb else None,
        offset=estimates[-1] if model.offset else None,
        correlation=float(fit.covariance[0, 1] / (error[0] * error[1])) if error[0] * error[1] > 0.0 else 0.0,
        condition_number=float(np.linalg.cond(regressor)),
        r_squared=1.0 - squares / variation if variation > 0.0 else 0.0,
        relative_force_error=math.sqrt(squares / float((force**2).sum())) if force.any() else math.inf,
        time_shift=None,
        signals_index=index,
        estimated_force=force - fit.residual,
        residual=fit.residual,
        weights=fit.weights,
        fit=fit,
    )


def _scaled_condition_number(columns: FloatArray) -> float:
    """Return the condition number of columns scaled to unit length, which does not depend on their units."""
    size = np.linalg.norm(columns, axis=0)
    return float(np.linalg.cond(columns / np.where(size > 0.0, size, 1.0))) if size.all() else math.inf
