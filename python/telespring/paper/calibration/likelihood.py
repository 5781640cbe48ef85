"""How likely published mean errors are under a model that is not quite true.

The two errors of one condition come from one coupled motion: where the model misses one it misses the
other in the same direction. A single misfit common to all ten cells, independent from cell to cell, would
therefore count the same miss twice and would buy a better average with the difference between the two
agents, the only thing that tells the disturbance: least squares over the ten cells of Table I lets the spots
stand still, although the less skilled agent errs by 4 mm more when alone. The likelihood takes each
condition's two cells apart into the mean of both errors and half their difference, both Gaussian, each with
a misfit of its own size that is not known and is profiled out; neither is taken smaller than the sampling
error of the means.

The published standard deviations enter as that sampling error only. They are no further data: TE1 scatters
between trials (by 2.7 mm in the unconnected mode) from sources that the laboratory does not have - its
skilled agent repeats itself exactly there - and TE2 is measured on the same apparatus.
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
        Of the difference between a measured and a simulated mean of both errors, m², where that is largest;
        half the difference of both errors has the same, for the trials of both robots are taken as
        uncorrelated: the paper does not say. As many trials are simulated as were measured, and they
        scatter alike.
    """

    mean: FloatArray
    sampling_variance: float

    @classmethod
    def of(cls, rows: Sequence[PublishedRow]) -> Likelihood:
        """Take the means and their sampling error from rows of the table."""
        deviation = np.array([row.standard_deviation for row in rows])
        # of (TE1 + TE2)/2 and of (TE2 - TE1)/2
        variance = 2 * float(np.max(np.sum(deviation**2, axis=1) / 4 / TRIALS))
        return cls(np.array([row.mean for row in rows]), variance)

    def components(self, simulated: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give the misses of (..., condition, robot): of the mean of both, of half the difference, m."""
        miss = simulated - self.mean
        return (miss[..., 0] + miss[..., 1]) / 2, (miss[..., 1] - miss[..., 0]) / 2

    def variances(self, simulated: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give the most likely variance of both components, sampling error and misfit together, m²."""
        common, difference = (np.mean(each**2, axis=-1) for each in self.components(simulated))
        return np.maximum(common, self.sampling_variance), np.maximum(difference, self.sampling_variance)

    def deviance(self, simulated: FloatArray) -> FloatArray:
        """Give minus twice the logarithm of the profile likelihood, up to a constant."""
        conditions = self.mean.shape[0]
        total = np.zeros(simulated.shape[:-2])
        for miss, variance in zip(self.components(simulated), self.variances(simulated), strict=True):
            total = total + conditions * np.log(variance) + np.sum(miss**2, axis=-1) / variance
        return np.asarray(total)


def threshold(conditions: int, unknowns: int, level: float = 0.95) -> float:
    """Give the rise of the deviance up to which a value lies inside its profile interval.

    For a linear model with one unknown variance the likelihood ratio of one unknown is a function of
    Student's t, and the interval n log(1 + t²/ν) is exact. Here n is the number of conditions, and all
    unknowns but the disturbance, which mostly sets the difference, take their degree of freedom from the
    means; for the disturbance the same limit is on the safe side. Chi-squared's 3.84, right for many
    conditions, would be far too short for five.

    Parameters
    ----------
    conditions, unknowns
        How many are fitted, and by how many.
    level
        Of the interval.

    Returns
    -------
    float
        Rise of the deviance.

    Examples
    --------
    >>> round(threshold(5, 3), 2), round(threshold(5, 4), 2), round(threshold(10_000, 4), 2)
    (7.38, 11.64, 3.84)
    """
    from scipy.stats import t

    freedom = conditions - (unknowns - 1)
    return float(conditions * math.log1p(float(t.ppf(0.5 + level / 2, freedom)) ** 2 / freedom))
