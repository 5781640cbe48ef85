"""Effect sizes of comparisons and their confidence intervals."""

from __future__ import annotations

import math

import numpy as np

from telespring._types import FloatArray

__all__ = ["paired_shift", "paired_superiority_interval", "superiority_interval"]


def superiority_interval(
    superiority: float, sizes: tuple[int, int], confidence: float = 0.95
) -> tuple[float, float]:
    """Compute a confidence interval of Vargha and Delaney's A that stays meaningful at 0 and 1.

    Parameters
    ----------
    superiority : float
        A, from 0 to 1.
    sizes : (int, int)
        Number of independent values in the two groups.
    confidence : float
        Probability that the interval contains the true A.

    Returns
    -------
    low, high : float
        The values of A from which the observed one is just as far as its standard error allows: Hanley and
        McNeil's, with the mean of both sizes in place of each (Newcombe 2006, Statistics in Medicine 25,
        559-573, method 5).

    Examples
    --------
    Two groups of twenty that do not overlap at all.

    >>> low, high = superiority_interval(1.0, (20, 20))
    >>> round(low, 3), high
    (0.899, 1.0)
    """
    from scipy import optimize, stats

    width = float(stats.norm.ppf(0.5 + 0.5 * confidence))
    others = 0.5 * (sizes[0] + sizes[1]) - 1.0

    def excess(truth: float) -> float:
        inflation = 1.0 + others * ((1.0 - truth) / (2.0 - truth) + truth / (1.0 + truth))
        variance = truth * (1.0 - truth) * inflation / (sizes[0] * sizes[1])
        return abs(superiority - truth) - width * math.sqrt(max(0.0, variance))

    # At the observed value the excess is negative (or zero, at 0 and 1), at the far ends positive.
    inside = min(max(superiority, 1e-12), 1.0 - 1e-12)
    low = 0.0 if superiority == 0.0 else float(optimize.brentq(excess, 0.0, inside, xtol=1e-12))
    high = 1.0 if superiority == 1.0 else float(optimize.brentq(excess, inside, 1.0, xtol=1e-12))
    return low, high


def paired_superiority_interval(superiority: float, pairs: int) -> tuple[float, float]:
    """Compute the 95 % interval of Clopper and Pearson for the share of pairs whose first value is larger.

    Examples
    --------
    Eight of eight: the lower end is 0.025^(1/8).

    >>> [round(end, 4) for end in paired_superiority_interval(1.0, 8)]
    [0.6306, 1.0]
    """
    from statsmodels.stats.proportion import proportion_confint

    low, high = proportion_confint(superiority * pairs, pairs, method="beta")
    return float(low), float(high)


def paired_shift(differences: FloatArray) -> float:
    """Compute the median of the means of all two differences, each with itself too (Hodges and Lehmann).

    Examples
    --------
    >>> paired_shift(np.array([1.0, 2.0, 6.0]))
    2.75
    """
    one, other = np.triu_indices(len(differences))
    return float(np.median(0.5 * (differences[one] + differences[other])))
