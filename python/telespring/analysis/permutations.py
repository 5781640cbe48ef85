"""Permutation p values of rank tests of several groups: all permutations, or random ones if too many."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations, product
from typing import Literal

import numpy as np

from telespring._types import FloatArray

__all__ = ["PermutationTest", "permute_friedman", "permute_kruskal_wallis"]

#: Up to so many permutations are counted one by one; of more, so many random ones are drawn. Their seed is
#: fixed, so that the same trials give the same p.
_PERMUTATIONS, _SEED = 9999, 20250617
#: Statistics this close, relative to them, are equal: they are sums of the same ranks in another order.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class PermutationTest:
    """Result of a permutation test.

    Attributes
    ----------
    p_value
        Share of the permutations with a statistic at least as large as the observed one.
    least_p
        The smallest p that these ranks can have; None where not all permutations were counted.
    method
        "exact": all permutations; "permutation": random ones.
    drawn
        Number of random permutations, which give no p below 1/(drawn + 1); None where all were counted.
    """

    p_value: float
    least_p: float | None
    method: Literal["exact", "permutation"]
    drawn: int | None = None


def permute_kruskal_wallis(ranks: FloatArray, sizes: Sequence[int]) -> PermutationTest:
    """Test by all assignments of the ranks to groups of these sizes, or random ones, with H as statistic.

    `ranks` are those of the first group, then of the second, and so on.

    Examples
    --------
    The most extreme of the 1680 assignments of nine values to three groups: six of them.

    >>> test = permute_kruskal_wallis(np.arange(1.0, 10.0), (3, 3, 3))
    >>> round(1680 * test.p_value, 9), test.least_p == test.p_value, test.method
    (6.0, True, 'exact')
    """
    starts = np.cumsum([0, *sizes[:-1]])

    def spread(arranged: FloatArray) -> FloatArray:
        # H grows with the squared rank sums, each over its group's size.
        return np.asarray((np.add.reduceat(arranged, starts, axis=-1) ** 2 / np.asarray(sizes)).sum(axis=-1))

    count = len(ranks)
    if math.factorial(count) // math.prod(math.factorial(size) for size in sizes) <= _PERMUTATIONS:
        assigned = np.array(list(_partitions(tuple(range(count)), tuple(sizes))))
        return _count_all(spread(ranks[assigned]), float(spread(ranks)))
    rng = np.random.default_rng(_SEED)
    drawn = spread(rng.permuted(np.tile(ranks, (_PERMUTATIONS, 1)), axis=1))
    return _count_random(drawn, float(spread(ranks)))


def permute_friedman(ranks: FloatArray) -> PermutationTest:
    """Test by all permutations within rows, or random ones, with Friedman's statistic.

    `ranks` has a row per block (a dyad), ranked within it, and a column per group.

    Examples
    --------
    Three blocks with the same order of three groups: 6 of 216 permutations.

    >>> test = permute_friedman(np.tile([1.0, 2.0, 3.0], (3, 1)))
    >>> round(216 * test.p_value, 9), test.method
    (6.0, 'exact')
    """
    blocks, groups = ranks.shape

    def spread(arranged: FloatArray) -> FloatArray:
        return np.asarray((arranged.sum(axis=-2) ** 2).sum(axis=-1))

    if math.factorial(groups) ** blocks <= _PERMUTATIONS:
        arranged = np.array(list(product(*(permutations(row) for row in ranks.tolist()))))
        return _count_all(spread(arranged), float(spread(ranks)))
    rng = np.random.default_rng(_SEED)
    drawn = spread(rng.permuted(np.tile(ranks, (_PERMUTATIONS, 1, 1)), axis=2))
    return _count_random(drawn, float(spread(ranks)))


def _partitions(items: tuple[int, ...], sizes: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    """Yield all ways to split items into groups of these sizes, the groups one after another."""
    if len(sizes) == 1:
        yield items
        return
    for chosen in combinations(items, sizes[0]):
        rest = tuple(item for item in items if item not in chosen)
        for others in _partitions(rest, sizes[1:]):
            yield (*chosen, *others)


def _count_all(statistics: FloatArray, observed: float) -> PermutationTest:
    largest = float(statistics.max())
    return PermutationTest(
        _count(statistics, observed) / len(statistics), _count(statistics, largest) / len(statistics), "exact"
    )


def _count_random(statistics: FloatArray, observed: float) -> PermutationTest:
    # The observed arrangement is one of all, so that p is never 0.
    count = len(statistics)
    return PermutationTest((_count(statistics, observed) + 1) / (count + 1), None, "permutation", count)


def _count(statistics: FloatArray, limit: float) -> int:
    return int(np.count_nonzero(statistics >= limit * (1.0 - _ROUNDING)))
