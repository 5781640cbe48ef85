"""A smooth surrogate of the laboratory: tracking errors as a function of the unknowns."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from telespring._types import FloatArray

__all__ = ["CAP", "Surrogate"]

#: Larger errors, m, count as this: where the dyad is unstable they grow without bound, no published error
#: comes near, and an interpolant could not follow both.
CAP = 0.08

_FOLDS = 8


@dataclass(frozen=True)
class Surrogate:
    """Cubic radial basis functions on a quadratic trend, through the logarithms of the capped errors.

    Attributes
    ----------
    points
        Where the laboratory was run, (point, unknown), every unknown in units of its upper bound.
    errors
        Its mean tracking errors there, (point, condition, robot), m; NaN if it diverged.
    shift
        Added to the logarithm, (condition, robot).
    """

    points: FloatArray
    errors: FloatArray
    shift: FloatArray = field(default_factory=lambda: np.zeros(()))

    @property
    def capped(self) -> FloatArray:
        """Errors as they are interpolated, m."""
        return cap_errors(self.errors)

    @cached_property
    def _interpolant(self) -> object:
        return _interpolant_through(self.points, np.log(self.capped))

    def __call__(self, points: FloatArray) -> FloatArray:
        """Interpolate the errors at points (..., unknown): (..., condition, robot), m."""
        shape = points.shape[:-1]
        flat = self._interpolant(points.reshape(-1, points.shape[-1]))  # type: ignore[operator]
        return np.asarray(np.exp(flat.reshape(*shape, *self.errors.shape[1:]) + self.shift))

    def through(self, point: FloatArray, errors: FloatArray) -> Surrogate:
        """Shift the surrogate so that it passes through these errors (condition, robot) at one point."""
        plain = Surrogate(self.points, self.errors)
        return Surrogate(self.points, self.errors, np.log(cap_errors(errors)) - np.log(plain(point)))

    def cross_validated(self) -> FloatArray:
        """Error of the surrogate at every point, m, when built without the eighth that the point is in."""
        predicted = np.empty_like(self.errors)
        values = np.log(self.capped)
        fold = np.arange(len(self.points)) % _FOLDS
        for number in range(_FOLDS):
            left_out = fold == number
            interpolant = _interpolant_through(self.points[~left_out], values[~left_out])
            logarithm = interpolant(self.points[left_out])
            predicted[left_out] = np.exp(logarithm.reshape(predicted[left_out].shape))
        return np.asarray(predicted - self.capped)


def cap_errors(errors: FloatArray) -> FloatArray:
    """Limit errors to `CAP`; those of trials that diverged become `CAP`."""
    return np.minimum(np.where(np.isfinite(errors), errors, CAP), CAP)


def _interpolant_through(points: FloatArray, values: FloatArray):  # type: ignore[no-untyped-def]
    from scipy.interpolate import RBFInterpolator

    return RBFInterpolator(points, values.reshape(len(points), -1), kernel="cubic", degree=2)
