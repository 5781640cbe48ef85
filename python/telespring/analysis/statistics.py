"""Rank tests between two groups of trials, with effect sizes, and Holm's correction of a family of tests."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from telespring._arrays import as_numbers
from telespring._types import FloatArray
from telespring.analysis.dyads import dyad_means, matched_dyads, split_dyads
from telespring.analysis.effect_sizes import paired_shift, paired_superiority_interval, superiority_interval
from telespring.analysis.rank_distributions import rank_sum_p_values, signed_rank_p_values

__all__ = ["LEVEL", "Comparison", "compare", "compare_pairs", "fewest_values", "holm", "present_values"]

#: Significance level of the paper's arrows.
LEVEL = 0.05

#: The exact distribution is used up to this many values in either group.
_EXACT_UP_TO = 50


@dataclass(frozen=True)
class Comparison:
    """A two-sided rank test of two groups, with its effect size.

    Attributes
    ----------
    first, second
        Names of the groups.
    sizes
        Number of independent values in each group: of trials, or of dyads.
    test
        "rank-sum": Wilcoxon's (Mann and Whitney's) of unpaired values. "signed-rank": Wilcoxon's of the
        differences within dyads.
    unit
        What counts as one independent value, "trial" or "dyad".
    statistic
        Of the rank-sum test, U of the first group: the number of pairs in which its value is the larger;
        ties count half. Of the signed-rank test, the rank sum of the positive differences.
    p_value
        Two-sided; None if a group has no values.
    p_holm
        Corrected within the comparison's family.
    least_p
        The smallest p that groups of these sizes, with these ties, can have. None without a test.
    method
        "exact" with up to 50 values in each group, also if values are tied; otherwise "asymptotic": normal,
        corrected for ties and continuity; "all equal" if all values are the same, then p is 1.
    superiority
        Vargha and Delaney's A = U/(n1 n2): the probability that a value of the first group is the
        larger. Cliff's delta and the rank-biserial correlation are 2A − 1. Within dyads: the share of dyads
        whose first value is the larger.
    superiority_interval
        95 % interval: of A by Newcombe's method 5, of the share of dyads by Clopper and Pearson's.
    shift
        Hodges and Lehmann's estimate of the difference first − second, in the unit of the values.
    """

    first: str
    second: str
    sizes: tuple[int, int]
    test: Literal["rank-sum", "signed-rank"]
    unit: Literal["trial", "dyad"]
    statistic: float | None
    p_value: float | None
    p_holm: float | None
    least_p: float | None
    method: Literal["exact", "asymptotic", "all equal", "no values"]
    superiority: float | None
    superiority_interval: tuple[float, float] | None
    shift: float | None

    @property
    def cliffs_delta(self) -> float | None:
        """Cliff's delta 2A − 1, from −1 (the first group is always the smaller) to 1."""
        return None if self.superiority is None else 2.0 * self.superiority - 1.0

    def arrow(self, *, corrected: bool = False) -> Literal["↑", "↓", ""]:
        """Return the arrow of Table I: "↑" if the first group is larger, "↓" if smaller, "" if p ≥ 0.05.

        The paper uses the raw p; `corrected` takes Holm's.
        """
        p_value = self.p_holm if corrected else self.p_value
        if p_value is None or p_value >= LEVEL or self.superiority is None or self.shift is None:
            return ""
        larger = self.shift if self.test == "signed-rank" else self.superiority - 0.5
        return "↑" if larger > 0.0 else "↓" if larger < 0.0 else ""

    def to_json(self) -> dict[str, Any]:
        """Convert a comparison to plain values."""
        interval = self.superiority_interval
        return {
            "first": self.first,
            "second": self.second,
            "sizes": list(self.sizes),
            "test": self.test,
            "unit": self.unit,
            "u": self.statistic if self.test == "rank-sum" else None,
            "w": self.statistic if self.test == "signed-rank" else None,
            "p": self.p_value,
            "p_holm": self.p_holm,
            "least_p": self.least_p,
            "method": self.method,
            "superiority": self.superiority,
            "superiority_interval": None if interval is None else list(interval),
            "cliffs_delta": self.cliffs_delta,
            "cliffs_delta_interval": None if interval is None else [2.0 * end - 1.0 for end in interval],
            "shift": self.shift,
            "arrow": self.arrow(),
            "arrow_holm": self.arrow(corrected=True),
        }


def compare(
    first: ArrayLike,
    second: ArrayLike,
    names: tuple[str, str] = ("first", "second"),
    dyads: tuple[ArrayLike, ArrayLike] | None = None,
) -> Comparison:
    """Compare two groups by a two-sided Wilcoxon test.

    Without `dyads` the values are independent: the rank-sum test (Mann and Whitney's U). With `dyads` each
    dyad has one value, the mean of its trials. If most dyads are in both groups, these are compared within
    dyads, by the signed-rank test; otherwise the dyads that are in one group only, by the rank-sum test.

    Parameters
    ----------
    first, second : array_like
        Values; NaN marks a missing one.
    names : (str, str)
        Names of the groups.
    dyads : (array_like, array_like), optional
        Label of the dyad of each value, per group.

    Returns
    -------
    Comparison
        With the raw p as `p_holm`; `compare_pairs` corrects a family of comparisons.

    Examples
    --------
    Permeability of the human chorioamnion at term and earlier, Hollander and Wolfe 1973, p. 69.

    >>> comparison = compare(
    ...     [0.80, 0.83, 1.89, 1.04, 1.45, 1.38, 1.91, 1.64, 0.73, 1.46], [1.15, 0.88, 0.90, 0.74, 1.21]
    ... )
    >>> comparison.statistic, round(comparison.p_value, 4), comparison.method
    (35.0, 0.2544, 'exact')
    >>> comparison.superiority, [round(end, 2) for end in comparison.superiority_interval]
    (0.7, [0.39, 0.89])

    Three dyads with two trials each: however large a difference, p cannot be less than 0.25.

    >>> labels = ["a", "a", "b", "b", "c", "c"]
    >>> comparison = compare([5, 6, 7, 9, 6, 8], [1, 2, 2, 1, 3, 1], dyads=(labels, labels))
    >>> comparison.test, comparison.sizes, comparison.p_value, comparison.least_p
    ('signed-rank', (3, 3), 0.25, 0.25)
    """
    if dyads is None:
        return _compare_unpaired(present_values(first), present_values(second), names, "trial")
    groups = [dyad_means(values, labels) for values, labels in zip((first, second), dyads, strict=True)]
    matched = matched_dyads(groups)
    if matched is None:
        one, other = split_dyads(groups)
        return _compare_unpaired(one, other, names, "dyad")
    return _compare_paired(np.array([groups[0][dyad] - groups[1][dyad] for dyad in matched]), names)


def _compare_unpaired(
    one: FloatArray, other: FloatArray, names: tuple[str, str], unit: Literal["trial", "dyad"]
) -> Comparison:
    from scipy import stats

    sizes = (len(one), len(other))
    if 0 in sizes:
        return Comparison(
            *names, sizes, "rank-sum", unit, None, None, None, None, "no values", None, None, None
        )
    together = np.concatenate([one, other])
    tied = len(np.unique(together)) < len(together)
    # Without ties: the two assignments in which all values of one group are the larger ones.
    least = min(1.0, 2.0 / math.comb(sum(sizes), sizes[0]))
    method: Literal["exact", "asymptotic", "all equal"]
    if np.ptp(together) == 0.0:
        method, statistic, p_value, least = "all equal", 0.5 * sizes[0] * sizes[1], 1.0, 1.0
    else:
        method = "asymptotic" if max(sizes) > _EXACT_UP_TO else "exact"
        scipys = "asymptotic" if tied else method
        test = stats.mannwhitneyu(one, other, alternative="two-sided", method=scipys)
        statistic, p_value = float(test.statistic), min(1.0, float(test.pvalue))
        if tied and method == "exact":
            # SciPy's exact distribution has no ties.
            p_value, least = rank_sum_p_values(*sorted((one, other), key=len))
    superiority = statistic / (sizes[0] * sizes[1])
    return Comparison(
        *names,
        sizes,
        "rank-sum",
        unit,
        statistic,
        p_value,
        p_value,
        least,
        method,
        superiority,
        superiority_interval(superiority, sizes),
        float(np.median(np.subtract.outer(one, other))),
    )


def _compare_paired(differences: FloatArray, names: tuple[str, str]) -> Comparison:
    from scipy import stats

    count = len(differences)
    method: Literal["exact", "asymptotic", "all equal"]
    if not differences.any():
        method, statistic, p_value, least = "all equal", 0.0, 1.0, 1.0
    else:
        present = differences[differences != 0.0]
        statistic = float(stats.rankdata(np.abs(present))[present > 0.0].sum())
        if count <= _EXACT_UP_TO:
            method = "exact"
            p_value, least = signed_rank_p_values(differences)
        else:
            method = "asymptotic"
            test = stats.wilcoxon(differences, correction=True, method="approx")
            p_value, least = float(test.pvalue), 0.5 ** (len(present) - 1)
    superiority = float((np.sign(differences) + 1.0).mean() / 2.0)
    return Comparison(
        *names,
        (count, count),
        "signed-rank",
        "dyad",
        statistic,
        p_value,
        p_value,
        least,
        method,
        superiority,
        paired_superiority_interval(superiority, count),
        paired_shift(differences),
    )


def compare_pairs(
    pairs: Sequence[tuple[str, str]],
    values: Mapping[str, ArrayLike],
    dyads: Mapping[str, ArrayLike] | None = None,
) -> tuple[Comparison, ...]:
    """Compare pairs of groups, by their names in `values`, as one family: p is corrected by Holm's method.

    `dyads` has the dyad of each value, by the same names. A comparison without values does not count towards
    the family.

    Examples
    --------
    >>> family = compare_pairs(
    ...     [("a", "b"), ("a", "c")], {"a": range(5), "b": range(10, 15), "c": [1.5, 2.5, 3.5]}
    ... )
    >>> [round(test.p_value, 4) for test in family], [round(test.p_holm, 4) for test in family]
    ([0.0079, 0.7857], [0.0159, 0.7857])
    """
    raw = [
        compare(
            values[first],
            values[second],
            (first, second),
            None if dyads is None else (dyads[first], dyads[second]),
        )
        for first, second in pairs
    ]
    corrected = holm([comparison.p_value for comparison in raw])
    return tuple(replace(comparison, p_holm=p) for comparison, p in zip(raw, corrected, strict=True))


def holm(p_values: Sequence[float | None]) -> list[float | None]:
    """Correct the p values of one family by Holm's method (1979).

    None is a comparison without a test; it does not count towards the family.

    Examples
    --------
    >>> holm([0.01, None, 0.04, 0.03])
    [0.03, None, 0.06, 0.06]
    """
    tested = [p for p in p_values if p is not None]
    if not tested:
        return [None] * len(p_values)
    from statsmodels.stats.multitest import multipletests

    corrected = iter(multipletests(tested, method="holm")[1].tolist())
    return [None if p is None else next(corrected) for p in p_values]


def fewest_values(test: Literal["rank-sum", "signed-rank"], level: float = LEVEL) -> int:
    """Compute how many values without ties each of two groups needs for a p below `level` to be possible.

    Examples
    --------
    >>> fewest_values("rank-sum"), fewest_values("signed-rank")
    (4, 6)
    >>> fewest_values("rank-sum", 0.05 / 33)
    7
    """
    count = 1
    while (2.0 / math.comb(2 * count, count) if test == "rank-sum" else 0.5 ** (count - 1)) >= level:
        count += 1
    return count


def present_values(values: ArrayLike) -> FloatArray:
    """Return the values that are not NaN, as one row."""
    array = as_numbers("values", values).reshape(-1)
    return np.asarray(array[~np.isnan(array)])
