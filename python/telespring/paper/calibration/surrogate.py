"""A smooth stand-in for the laboratory: tracking errors as a function of the unknowns."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from telespring._types import FloatArray

__all__ = ["CAP", "Surrogate"]

#: Errors beyond this, m, count as this: where the dyad is unstable they grow without bound, nothing
#: published comes near, and an interpolant could not follow both.
CAP = 0.08

_FOLDS = 8


@dataclass(frozen=True)
class Surrogate:
    """Cubic radial basis functions on a quadratic trend, through the logarithm of the capped errors.

    Attributes
    ----------
    points
        Where the laboratory was run, (point, unknown), every unknown in units of its upper bound.
    errors
        Its mean tracking errors there, (point, condition, robot), m; not a number where it diverged.
    shift
        What is added to the logarithm, (condition, robot).
    """

    points: FloatArray
    errors: FloatArray
    shift: FloatArray = field(default_factory=lambda: np.zeros(()))

    @property
    def capped(self) -> FloatArray:
        """The errors as they are interpolated, m."""
        return cap(self.errors)

    @cached_property
    def _interpolant(self) -> object:
        return _through(self.points, np.log(self.capped))

    def __call__(self, points: FloatArray) -> FloatArray:
        """Give the errors at points (..., unknown) as (..., condition, robot), m."""
        shape = points.shape[:-1]
        flat = self._interpolant(points.reshape(-1, points.shape[-1]))  # type: ignore[operator]
        return np.asarray(np.exp(flat.reshape(*shape, *self.errors.shape[1:]) + self.shift))

    def through(self, point: FloatArray, errors: FloatArray) -> Surrogate:
        """Shift the stand-in so that it passes through these errors (condition, robot) at one point."""
        plain = Surrogate(self.points, self.errors)
        return Surrogate(self.points, self.errors, np.log(cap(errors)) - np.log(plain(point)))

    def cross_validated(self) -> FloatArray:
        """Give the stand-in's error at every point when it is built without that point's eighth, m."""
        out = np.empty_like(self.errors)
        values = np.log(self.capped)
        fold = np.arange(len(self.points)) % _FOLDS
        for each in range(_FOLDS):
            left_out = fold == each
            one = _through(self.points[~left_out], values[~left_out])
            out[left_out] = np.exp(one(self.points[left_out]).reshape(out[left_out].shape))
        return np.asarray(out - self.capped)


def cap(errors: FloatArray) -> FloatArray:
    """Bring errors beyond `CAP`, and those of trials that diverged, down to it."""
    return np.minimum(np.where(np.isfinite(errors), errors, CAP), CAP)


def _through(points: FloatArray, values: FloatArray):  # type: ignore[no-untyped-def]
    from scipy.interpolate import RBFInterpolator

    return RBFInterpolator(points, values.reshape(len(points), -1), kernel="cubic", degree=2)
