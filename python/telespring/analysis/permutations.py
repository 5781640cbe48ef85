"""Permutation p values of rank tests of several groups: all permutations, or random ones if too many."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations, permutations, product
from typing import Literal

import numpy as np

from telespring._types import FloatArray

__all__ = ["friedman_p_value", "kruskal_wallis_p_value"]

#: Up to so many permutations are counted one by one; of more, so many random ones are drawn. Their seed is
#: fixed, so that the same trials give the same p.
_PERMUTATIONS, _SEED = 9999, 20250617
#: Statistics this close, relative to them, are equal: they are sums of the same ranks in another order.
_ROUNDING = 1e-12

_Method = Literal["exact", "permutation"]


def kruskal_wallis_p_value(ranks: FloatArray, sizes: Sequence[int]) -> tuple[float, _Method]:
    """Compute the share of assignments of the ranks to groups of these sizes with an H at least as large.

    `ranks` are those of the first group, then of the second, and so on.

    Examples
    --------
    The most extreme of the 1680 assignments of nine values to three groups: six of them.

    >>> p_value, method = kruskal_wallis_p_value(np.arange(1.0, 10.0), (3, 3, 3))
    >>> round(1680 * p_value, 9), method
    (6.0, 'exact')
    """
    starts = np.cumsum([0, *sizes[:-1]])

    def spread(arranged: FloatArray) -> FloatArray:
        # H grows with the squared rank sums, each over its group's size.
        return np.asarray((np.add.reduceat(arranged, starts, axis=-1) ** 2 / np.asarray(sizes)).sum(axis=-1))

    count = len(ranks)
    if math.factorial(count) // math.prod(math.factorial(size) for size in sizes) <= _PERMUTATIONS:
        assigned = np.array(list(_partitions(tuple(range(count)), tuple(sizes))))
        return _share(spread(ranks[assigned]), float(spread(ranks)), 0), "exact"
    rng = np.random.default_rng(_SEED)
    drawn = spread(rng.permuted(np.tile(ranks, (_PERMUTATIONS, 1)), axis=1))
    return _share(drawn, float(spread(ranks)), 1), "permutation"


def friedman_p_value(ranks: FloatArray) -> tuple[float, _Method]:
    """Compute the share of permutations within rows with a Friedman statistic at least as large.

    `ranks` has a row per block (a dyad), ranked within it, and a column per group.

    Examples
    --------
    Three blocks with the same order of three groups: 6 of 216 permutations.

    >>> p_value, method = friedman_p_value(np.tile([1.0, 2.0, 3.0], (3, 1)))
    >>> round(216 * p_value, 9), method
    (6.0, 'exact')
    """
    blocks, groups = ranks.shape

    def spread(arranged: FloatArray) -> FloatArray:
        return np.asarray((arranged.sum(axis=-2) ** 2).sum(axis=-1))

    if math.factorial(groups) ** blocks <= _PERMUTATIONS:
        arranged = np.array(list(product(*(permutations(row) for row in ranks.tolist()))))
        return _share(spread(arranged), float(spread(ranks)), 0), "exact"
    rng = np.random.default_rng(_SEED)
    drawn = spread(rng.permuted(np.tile(ranks, (_PERMUTATIONS, 1, 1)), axis=2))
    return _share(drawn, float(spread(ranks)), 1), "permutation"


def _partitions(items: tuple[int, ...], sizes: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    """Yield all ways to split items into groups of these sizes, the groups one after another."""
    if len(sizes) == 1:
        yield items
        return
    for chosen in combinations(items, sizes[0]):
        rest = tuple(item for item in items if item not in chosen)
        for others in _partitions(rest, sizes[1:]):
            yield (*chosen, *others)


def _share(statistics: FloatArray, observed: float, itself: int) -> float:
    """Return the share of permutations at least as extreme; random ones count the observed one too."""
    extreme = int(np.count_nonzero(statistics >= observed * (1.0 - _ROUNDING)))
    return (extreme + itself) / (len(statistics) + itself)
