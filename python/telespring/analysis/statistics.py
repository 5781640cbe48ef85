"""Rank tests between groups of trials, Holm's correction, and effect sizes with their intervals.

The tests are SciPy's and statsmodels'. This module chooses between exact and asymptotic p values, defines the
families of tests, and adds effect sizes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from telespring._types import FloatArray

__all__ = [
    "LEVEL",
    "Comparison",
    "GroupTest",
    "compare",
    "compare_pairs",
    "holm",
    "kruskal_wallis",
    "superiority_interval",
]

#: Significance level of the paper's arrows.
LEVEL = 0.05

#: The exact distribution is used up to this many values in either group, unless values are tied.
_EXACT_UP_TO = 50


@dataclass(frozen=True)
class GroupTest:
    """A Kruskal-Wallis test of several groups.

    Attributes
    ----------
    groups
        Names of the groups.
    sizes
        Number of values in each group.
    statistic
        H, corrected for ties; None if fewer than two groups have values.
    degrees_of_freedom
        Number of groups minus one.
    p_value
        From the chi-squared distribution; None without H.
    p_holm
        Corrected within the test's family.
    epsilon_squared
        Effect size H/(n − 1), from 0 (ranks do not depend on the group) to 1 (Tomczak and Tomczak 2014).
    """

    groups: tuple[str, ...]
    sizes: tuple[int, ...]
    statistic: float | None
    degrees_of_freedom: int
    p_value: float | None
    p_holm: float | None
    epsilon_squared: float | None

    def to_json(self) -> dict[str, Any]:
        """Convert a Kruskal-Wallis test to plain values."""
        return {
            "groups": list(self.groups),
            "sizes": list(self.sizes),
            "h": self.statistic,
            "degrees_of_freedom": self.degrees_of_freedom,
            "p": self.p_value,
            "p_holm": self.p_holm,
            "epsilon_squared": self.epsilon_squared,
        }


@dataclass(frozen=True)
class Comparison:
    """A two-sided Wilcoxon rank-sum test of two groups, with its effect size.

    Attributes
    ----------
    first, second
        Names of the groups.
    sizes
        Number of values in each group.
    statistic
        U of the first group: the number of pairs in which its value is the larger; ties count half.
    p_value
        Two-sided; None if a group has no values.
    p_holm
        Corrected within the comparison's family.
    method
        "exact" without ties and with up to 50 values in each group, otherwise "asymptotic": normal,
        corrected for ties and continuity; "all equal" if all values are the same, then p is 1.
    superiority
        Vargha and Delaney's A = U/(n1 n2): the probability that a value of the first group is the
        larger. Cliff's delta and the rank-biserial correlation are 2A − 1.
    superiority_interval
        95 % interval of A by Newcombe's method 5.
    shift
        Median of all differences first − second (Hodges and Lehmann), in the unit of the values.
    """

    first: str
    second: str
    sizes: tuple[int, int]
    statistic: float | None
    p_value: float | None
    p_holm: float | None
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
        if p_value is None or p_value >= LEVEL or self.superiority is None or self.superiority == 0.5:
            return ""
        return "↑" if self.superiority > 0.5 else "↓"

    def to_json(self) -> dict[str, Any]:
        """Convert a rank-sum comparison to plain values."""
        interval = self.superiority_interval
        return {
            "first": self.first,
            "second": self.second,
            "sizes": list(self.sizes),
            "u": self.statistic,
            "p": self.p_value,
            "p_holm": self.p_holm,
            "method": self.method,
            "superiority": self.superiority,
            "superiority_interval": None if interval is None else list(interval),
            "cliffs_delta": self.cliffs_delta,
            "cliffs_delta_interval": None if interval is None else [2.0 * end - 1.0 for end in interval],
            "shift": self.shift,
            "arrow": self.arrow(),
            "arrow_holm": self.arrow(corrected=True),
        }


def kruskal_wallis(groups: Mapping[str, ArrayLike]) -> GroupTest:
    """Test whether groups differ (Kruskal and Wallis 1952).

    Parameters
    ----------
    groups : mapping
        Values per name. NaN marks a missing value; a group without values is left out.

    Returns
    -------
    GroupTest
        With the raw p as `p_holm`; `holm` corrects a family of tests.

    Examples
    --------
    Half-times of mucociliary clearance, Hollander and Wolfe 1973, p. 116.

    >>> test = kruskal_wallis({
    ...     "normal": [2.9, 3.0, 2.5, 2.6, 3.2],
    ...     "obstructive": [3.8, 2.7, 4.0, 2.4],
    ...     "asbestosis": [2.8, 3.4, 3.7, 2.2, 2.0],
    ... })
    >>> round(test.statistic, 5), test.degrees_of_freedom, round(test.p_value, 2)
    (0.77143, 2, 0.68)
    """
    from scipy import stats

    present = {name: _drop_missing_values(values) for name, values in groups.items()}
    present = {name: values for name, values in present.items() if len(values)}
    names, sizes = tuple(present), tuple(len(values) for values in present.values())
    count = sum(sizes)
    freedom = max(0, len(names) - 1)
    if len(names) < 2 or count < 3:
        return GroupTest(names, sizes, None, freedom, None, None, None)
    if np.ptp(np.concatenate(list(present.values()))) == 0.0:
        return GroupTest(names, sizes, 0.0, freedom, 1.0, 1.0, 0.0)
    test = stats.kruskal(*present.values())
    statistic, p_value = float(test.statistic), float(test.pvalue)
    return GroupTest(names, sizes, statistic, freedom, p_value, p_value, statistic / (count - 1))


def compare(first: ArrayLike, second: ArrayLike, names: tuple[str, str] = ("first", "second")) -> Comparison:
    """Compare two unpaired groups by Wilcoxon's rank-sum test (Mann and Whitney's U).

    Parameters
    ----------
    first, second : array_like
        Values; NaN marks a missing one.
    names : (str, str)
        Names of the groups.

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
    """
    from scipy import stats

    one, other = _drop_missing_values(first), _drop_missing_values(second)
    sizes = (len(one), len(other))
    if 0 in sizes:
        return Comparison(*names, sizes, None, None, None, "no values", None, None, None)
    together = np.concatenate([one, other])
    tied = len(np.unique(together)) < len(together)
    method: Literal["exact", "asymptotic", "all equal"]
    if np.ptp(together) == 0.0:
        method, statistic, p_value = "all equal", 0.5 * sizes[0] * sizes[1], 1.0
    else:
        method = "asymptotic" if tied or max(sizes) > _EXACT_UP_TO else "exact"
        test = stats.mannwhitneyu(one, other, alternative="two-sided", method=method)
        statistic, p_value = float(test.statistic), min(1.0, float(test.pvalue))
    superiority = statistic / (sizes[0] * sizes[1])
    return Comparison(
        *names,
        sizes,
        statistic,
        p_value,
        p_value,
        method,
        superiority,
        superiority_interval(superiority, sizes),
        float(np.median(np.subtract.outer(one, other))),
    )


def compare_pairs(
    pairs: Sequence[tuple[str, str]], values: Mapping[str, ArrayLike]
) -> tuple[Comparison, ...]:
    """Compare pairs of groups, by their names in `values`, as one family: p is corrected by Holm's method.

    A comparison without values does not count towards the family.

    Examples
    --------
    >>> family = compare_pairs(
    ...     [("a", "b"), ("a", "c")], {"a": range(5), "b": range(10, 15), "c": [1.5, 2.5, 3.5]}
    ... )
    >>> [round(test.p_value, 4) for test in family], [round(test.p_holm, 4) for test in family]
    ([0.0079, 0.7857], [0.0159, 0.7857])
    """
    raw = [compare(values[first], values[second], (first, second)) for first, second in pairs]
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


def superiority_interval(
    superiority: float, sizes: tuple[int, int], confidence: float = 0.95
) -> tuple[float, float]:
    """Compute a confidence interval of Vargha and Delaney's A that stays meaningful at 0 and 1.

    Parameters
    ----------
    superiority : float
        A, from 0 to 1.
    sizes : (int, int)
        Number of values in the two groups.
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


def _drop_missing_values(values: ArrayLike) -> FloatArray:
    array = np.asarray(values, dtype=float).reshape(-1)
    return np.asarray(array[~np.isnan(array)])
