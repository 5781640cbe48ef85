"""Likelihood of the published mean errors under a model with misfit.

The two errors of one condition come from one coupled motion: a model that is wrong in one is wrong in the
other in the same direction. A single misfit, independent from cell to cell, would therefore count the same
deviation twice. It would also trade a better average for the difference between the two agents, which alone
determines the disturbance: least squares over the ten cells of Table I puts the spots at rest, although the
less skilled agent errs by 4 mm more when unconnected. The likelihood therefore separates each condition's
two cells into the mean of both errors and half their difference. Both are Gaussian, each with an unknown
misfit that is profiled out and is never smaller than the sampling error of the means.

The published standard deviations enter as that sampling error only. They are no further data: TE1 varies
between trials (by 2.7 mm in the unconnected mode) for reasons that the laboratory does not model, whose
skilled agent repeats itself exactly there, and TE2 is measured on the same apparatus.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from telespring._types import FloatArray
from telespring.paper.published import TRIALS, PublishedRow

__all__ = ["Likelihood", "threshold"]


@dataclass(frozen=True)
class Likelihood:
    """Published means of some conditions and their sampling error.

    Attributes
    ----------
    mean
        (condition, robot), m.
    sampling_variance
        Variance of the difference between a measured and a simulated mean of both errors, m², where it is
        largest. Half the difference of both errors has the same, as the trials of both robots are taken
        to be uncorrelated (the paper gives no correlation). As many trials are simulated as were measured,
        with the same variance.
    """

    mean: FloatArray
    sampling_variance: float

    @classmethod
    def of(cls, rows: Sequence[PublishedRow]) -> Likelihood:
        """Build the likelihood from the means and standard deviations of published rows."""
        deviation = np.array([row.standard_deviation for row in rows])
        # of (TE1 + TE2)/2 and of (TE2 - TE1)/2
        variance = 2 * float(np.max(np.sum(deviation**2, axis=1) / 4 / TRIALS))
        return cls(np.array([row.mean for row in rows]), variance)

    def components(self, simulated: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Residuals of (..., condition, robot) in the mean of both errors and in half their difference, m."""
        residual = simulated - self.mean
        return (residual[..., 0] + residual[..., 1]) / 2, (residual[..., 1] - residual[..., 0]) / 2

    def variances(self, simulated: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Most likely variance of both components, sampling error and misfit together, m²."""
        common, difference = (np.mean(part**2, axis=-1) for part in self.components(simulated))
        return np.maximum(common, self.sampling_variance), np.maximum(difference, self.sampling_variance)

    def deviance(self, simulated: FloatArray) -> FloatArray:
        """Minus twice the logarithm of the profile likelihood, up to a constant."""
        conditions = self.mean.shape[0]
        total = np.zeros(simulated.shape[:-2])
        for part, variance in zip(self.components(simulated), self.variances(simulated), strict=True):
            total = total + conditions * np.log(variance) + np.sum(part**2, axis=-1) / variance
        return np.asarray(total)


def threshold(conditions: int, unknowns: int, level: float = 0.95) -> float:
    """Rise of the deviance up to which a value lies inside its profile interval.

    For a linear model with one unknown variance the likelihood ratio of one unknown is a function of
    Student's t, and the limit n log(1 + t²/ν) is exact. Here n is the number of conditions, and all
    unknowns but the disturbance, which mostly sets the difference, take their degree of freedom from the
    means; for the disturbance the same limit is conservative. The 3.84 of chi-squared, right for many
    conditions, would be far too small for five.

    Examples
    --------
    >>> round(threshold(5, 3), 2), round(threshold(5, 4), 2), round(threshold(10_000, 4), 2)
    (7.38, 11.64, 3.84)
    """
    from scipy.stats import t

    freedom = conditions - (unknowns - 1)
    return float(conditions * math.log1p(float(t.ppf(0.5 + level / 2, freedom)) ** 2 / freedom))
