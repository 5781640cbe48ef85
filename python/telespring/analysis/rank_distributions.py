"""Exact distributions of rank statistics with ties: the shift algorithm of Streitberg and Röhmel (1986)."""

from __future__ import annotations

import math

import numpy as np

from telespring._types import FloatArray

__all__ = ["rank_sum_p_values", "signed_rank_p_values"]

#: Sums of ranks differ by half a rank or more, so this only absorbs rounding of their mean.
_ROUNDING = 1e-9


def rank_sum_p_values(first: FloatArray, second: FloatArray) -> tuple[float, float]:
    """Compute the exact two-sided p of Wilcoxon's rank-sum test, and the least p that these ranks allow.

    All assignments of the values to the two groups count alike. p is the share of those whose rank sum is at
    least as far from its mean as the observed one. Ties have their mean rank.

    Examples
    --------
    >>> [round(p, 3) for p in rank_sum_p_values(np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0]))]
    [0.1, 0.1]
    """
    doubled = _doubled_ranks(np.concatenate([first, second]))
    observed = int(doubled[: len(first)].sum())
    chosen = len(first)
    # Row j counts the choices of j values by the sum of their ranks, doubled so that it is whole.
    counts = np.zeros((chosen + 1, int(doubled.sum()) + 1))
    counts[0, 0] = 1.0
    for rank in doubled.tolist():
        counts[1:, rank:] += counts[:-1, : counts.shape[1] - rank]
    return _two_sided_p_values(counts[chosen], observed, chosen * float(doubled.mean()))


def signed_rank_p_values(differences: FloatArray) -> tuple[float, float]:
    """Compute the exact two-sided p of Wilcoxon's signed-rank test, and the least p that these ranks allow.

    All signs of the differences count alike; differences of zero are left out.

    Examples
    --------
    >>> signed_rank_p_values(np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]))
    (0.03125, 0.03125)
    """
    present = differences[differences != 0.0]
    doubled = _doubled_ranks(np.abs(present))
    counts = np.zeros(int(doubled.sum()) + 1)
    counts[0] = 1.0
    for rank in doubled.tolist():
        counts[rank:] += counts[: len(counts) - rank]
    return _two_sided_p_values(counts, int(doubled[present > 0.0].sum()), 0.5 * float(doubled.sum()))


def _doubled_ranks(values: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    from scipy import stats

    return np.asarray(np.rint(2.0 * stats.rankdata(values)), dtype=np.int64)


def _two_sided_p_values(counts: FloatArray, observed: int, mean: float) -> tuple[float, float]:
    """Return the share of outcomes at least as far from the mean as the observed one, and as the farthest."""
    distance = np.abs(np.arange(len(counts)) - mean)
    total = math.fsum(counts)

    def share(limit: float) -> float:
        return min(1.0, math.fsum(counts[distance >= limit - _ROUNDING]) / total)

    return share(abs(observed - mean)), share(float(distance[counts > 0.0].max()))
