"""Several logs of one robot taken together: the scatter between logs enters the interval.

Each log gives an estimate with its own error. What differs from log to log (temperature of the bearings, the
sensor's mounting and zero, the way that the robot was moved) is a random effect, whose variance the estimator
of DerSimonian and Laird [1]_ gives. The interval is that of Hartung and Knapp [2]_ with Student's t, which
holds for few logs, and never narrower than that of the random effect with the errors of the logs alone [3]_.

References
----------
.. [1] R. DerSimonian, N. Laird, "Meta-analysis in clinical trials", Controlled Clinical Trials 7 (1986)
   177-188.
.. [2] J. Hartung, G. Knapp, "A refined method for the meta-analysis of controlled clinical trials with binary
   outcome", Statistics in Medicine 20 (2001) 3875-3889.
.. [3] C. Röver, G. Knapp, T. Friede, "Hartung-Knapp-Sidik-Jonkman approach and its modification for
   random-effects meta-analysis with few studies", BMC Medical Research Methodology 15 (2015) 99.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from telespring._types import FloatArray
from telespring.identification.covariance import NORMAL_HALF_WIDTH
from telespring.identification.results import Estimate

__all__ = ["Combined", "combine_correlations", "combine_estimates"]


@dataclass(frozen=True)
class Combined:
    """One parameter from several logs.

    Attributes
    ----------
    estimate
        With an interval that includes the scatter between logs.
    between
        Standard deviation between logs, in the parameter's unit; 0 where the logs agree within their errors.
    disagree
        Whether the logs differ by more than their errors, at a significance level of 0.001.
    weights
        Of the logs; they add up to 1.
    """

    estimate: Estimate
    between: float
    disagree: bool
    weights: FloatArray


def combine_estimates(estimates: Sequence[Estimate]) -> Combined:
    """Combine one parameter of several logs, two at least.

    A log's standard error is taken from its interval, which allows for the bandwidth of its covariance.

    Examples
    --------
    Two logs that differ by six times their errors, and leave the value open by much more than either does:

    >>> both = combine_estimates([Estimate(95.1, 0.1, (94.9, 95.3)), Estimate(93.8, 0.1, (93.6, 94.0))])
    >>> low, high = both.estimate.interval
    >>> low < 93.8 and high > 95.1, both.disagree
    (True, True)
    """
    from scipy import stats
    from statsmodels.stats.meta_analysis import combine_effects

    values = np.array([estimate.value for estimate in estimates])
    errors = np.array([(e.interval[1] - e.interval[0]) / (2.0 * NORMAL_HALF_WIDTH) for e in estimates])
    count = values.size
    if not (errors > 0.0).all():
        # Without noise there is nothing to weigh by.
        errors = np.full(count, max(float(errors.max()), 1e-12 * float(np.abs(values).max()), 1e-12))
    scale = float(errors.mean())
    # Where the logs agree better than their errors, the variance is below 0.
    with np.errstate(invalid="ignore", divide="ignore"):
        both = combine_effects(values / scale, (errors / scale) ** 2, method_re="chi2")
    variance = max(0.0, float(both.tau2))
    weights = 1.0 / (variance + (errors / scale) ** 2)
    weights /= weights.sum()
    value = float(weights @ values)
    plain = scale * math.sqrt(1.0 / float((1.0 / (variance + (errors / scale) ** 2)).sum()))
    # Hartung and Knapp: the scatter that was seen, instead of the one that the errors predict.
    seen = math.sqrt(float(weights @ (values - value) ** 2) / (count - 1))
    half = max(float(stats.t.ppf(0.975, count - 1)) * seen, NORMAL_HALF_WIDTH * plain)
    excess = float((((values - np.average(values, weights=errors**-2.0)) / errors) ** 2).sum())
    return Combined(
        Estimate(value, max(seen, plain), (value - half, value + half)),
        scale * math.sqrt(variance),
        excess > float(stats.chi2.ppf(0.999, count - 1)),
        weights,
    )


def combine_correlations(correlations: Sequence[float], mass: Combined, damping: Combined) -> float:
    """Combine the correlations of the errors of mass and damping; scatter between logs has none."""
    within = float(np.mean(correlations))
    shares = [
        1.0 - min(1.0, parameter.between**2 / (len(correlations) * parameter.estimate.standard_error**2))
        if parameter.estimate.standard_error > 0.0
        else 1.0
        for parameter in (mass, damping)
    ]
    return within * math.sqrt(shares[0] * shares[1])
