"""Rank tests of several groups of trials: Kruskal and Wallis's, and Friedman's within dyads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from telespring._types import FloatArray
from telespring.analysis.dyads import dyad_means, matched_dyads, split_dyads
from telespring.analysis.permutations import permute_friedman, permute_kruskal_wallis
from telespring.analysis.statistics import Comparison, compare, present_values

__all__ = ["GroupTest", "kruskal_wallis"]

#: With at least this many values in every group, or dyads, p is from chi-squared.
_CHI_SQUARED_FROM = 10


_Method = Literal["exact", "permutation", "chi-squared", "asymptotic", "all equal", "no values"]


@dataclass(frozen=True)
class GroupTest:
    """A rank test of several groups.

    Attributes
    ----------
    groups
        Names of the groups.
    sizes
        Number of independent values in each group: of trials, or of dyads.
    test
        "Kruskal-Wallis" of independent values; "Friedman" within dyads.
    unit
        What counts as one independent value, "trial" or "dyad".
    statistic
        H or Friedman's Q, corrected for ties; None if fewer than two groups have values.
    degrees_of_freedom
        Number of groups minus one.
    p_value
        None without a statistic.
    p_holm
        Corrected within the test's family.
    least_p
        The smallest p that groups of these sizes, with these ties, can have; None if it was not counted.
    method
        "exact": all permutations of the ranks, and for two groups the p of `compare`; "permutation": 9999
        random permutations with a fixed seed; "chi-squared", with ten values or more in every group;
        "asymptotic", two large groups; "all equal"; "no values".
    permutations
        Number of random permutations; with the smallest p that they can give, 1/(permutations + 1), p is an
        upper bound. None with another method.
    epsilon_squared
        Effect size H/(n − 1) of Kruskal and Wallis's test, from 0 (ranks do not depend on the group) to 1
        (Tomczak and Tomczak 2014).
    kendalls_w
        Effect size of Friedman's test, from 0 to 1 (all dyads have the same order).
    """

    groups: tuple[str, ...]
    sizes: tuple[int, ...]
    test: Literal["Kruskal-Wallis", "Friedman"]
    unit: Literal["trial", "dyad"]
    statistic: float | None
    degrees_of_freedom: int
    p_value: float | None
    p_holm: float | None
    least_p: float | None
    method: _Method
    epsilon_squared: float | None
    kendalls_w: float | None
    permutations: int | None = None

    @property
    def is_p_bound(self) -> bool:
        """Whether p is no more than an upper bound: no random permutation was as extreme."""
        return self.permutations is not None and self.p_value == 1.0 / (self.permutations + 1)

    def to_json(self) -> dict[str, Any]:
        """Convert a test of several groups to plain values."""
        return {
            "groups": list(self.groups),
            "sizes": list(self.sizes),
            "test": self.test,
            "unit": self.unit,
            "h": self.statistic if self.test == "Kruskal-Wallis" else None,
            "q": self.statistic if self.test == "Friedman" else None,
            "degrees_of_freedom": self.degrees_of_freedom,
            "p": self.p_value,
            "p_holm": self.p_holm,
            "least_p": self.least_p,
            "method": self.method,
            "permutations": self.permutations,
            "is_p_bound": self.is_p_bound,
            "epsilon_squared": self.epsilon_squared,
            "kendalls_w": self.kendalls_w,
        }


def kruskal_wallis(
    groups: Mapping[str, ArrayLike], dyads: Mapping[str, ArrayLike] | None = None
) -> GroupTest:
    """Test whether groups differ (Kruskal and Wallis 1952).

    With `dyads`, each dyad has one value per group, the mean of its trials. If most dyads are in all groups,
    these are compared within dyads, by Friedman's test; otherwise the dyads that are in one group only.

    Parameters
    ----------
    groups : mapping
        Values per name. NaN marks a missing value; a group without values is left out.
    dyads : mapping, optional
        Label of the dyad of each value, by the same names.

    Returns
    -------
    GroupTest
        With the raw p as `p_holm`; `holm` corrects a family of tests.

    Examples
    --------
    Half-times of mucociliary clearance, Hollander and Wolfe 1973, p. 116. Of all 756,756 ways to share out
    the 14 values, 71 % have an H as large; chi-squared says 68 %.

    >>> test = kruskal_wallis({
    ...     "normal": [2.9, 3.0, 2.5, 2.6, 3.2],
    ...     "obstructive": [3.8, 2.7, 4.0, 2.4],
    ...     "asbestosis": [2.8, 3.4, 3.7, 2.2, 2.0],
    ... })
    >>> round(test.statistic, 5), test.degrees_of_freedom, test.method, round(test.p_value, 2)
    (0.77143, 2, 'permutation', 0.71)
    """
    if dyads is None:
        return _kruskal_wallis({name: present_values(values) for name, values in groups.items()}, "trial")
    means = {name: dyad_means(values, dyads[name]) for name, values in groups.items()}
    means = {name: group for name, group in means.items() if group}
    matched = matched_dyads(list(means.values())) if len(means) > 1 else None
    if matched is None:
        return _kruskal_wallis(dict(zip(means, split_dyads(list(means.values())), strict=True)), "dyad")
    return _friedman({name: np.array([group[dyad] for dyad in matched]) for name, group in means.items()})


def _kruskal_wallis(groups: Mapping[str, FloatArray], unit: Literal["trial", "dyad"]) -> GroupTest:
    from scipy import stats

    present = {name: values for name, values in groups.items() if len(values)}
    names, values = tuple(present), tuple(present.values())
    sizes = tuple(len(group) for group in values)
    count, freedom = sum(sizes), max(0, len(names) - 1)
    if len(names) < 2 or count < 3:
        return GroupTest(
            names, sizes, "Kruskal-Wallis", unit, None, freedom, None, None, None, "no values", None, None
        )
    together = np.concatenate(values)
    if np.ptp(together) == 0.0:
        return GroupTest(
            names, sizes, "Kruskal-Wallis", unit, 0.0, freedom, 1.0, 1.0, 1.0, "all equal", 0.0, None
        )
    test = stats.kruskal(*values)
    statistic = float(test.statistic)
    least: float | None = None
    drawn: int | None = None
    method: _Method = "chi-squared"
    p_value = float(test.pvalue)
    if len(names) == 2:
        # H of two groups is the square of U's standard score, so both tests have one p.
        p_value, least, method = _of_two_groups(compare(values[0], values[1]))
    elif min(sizes) < _CHI_SQUARED_FROM:
        permuted = permute_kruskal_wallis(stats.rankdata(together), sizes)
        p_value, least, method = permuted.p_value, permuted.least_p, permuted.method
        drawn = permuted.drawn
    return GroupTest(
        names,
        sizes,
        "Kruskal-Wallis",
        unit,
        statistic,
        freedom,
        p_value,
        p_value,
        least,
        method,
        statistic / (count - 1),
        None,
        drawn,
    )


def _friedman(groups: Mapping[str, FloatArray]) -> GroupTest:
    """Test whether groups of the same dyads differ within dyads (Friedman 1937)."""
    from scipy import stats

    names, values = tuple(groups), np.stack(list(groups.values()))
    count, dyads = values.shape
    sizes = (dyads,) * count
    if np.all(values == values[0]):
        return GroupTest(
            names, sizes, "Friedman", "dyad", 0.0, count - 1, 1.0, 1.0, 1.0, "all equal", None, 0.0
        )
    ranks = stats.rankdata(values, axis=0)
    # Friedman's Q with its correction for ties (Conover 1999, Eq. 5.8.4).
    spread = ((ranks.mean(axis=1) - 0.5 * (count + 1.0)) ** 2).sum()
    statistic = float((count - 1) * dyads**2 * spread / ((ranks - 0.5 * (count + 1.0)) ** 2).sum())
    least: float | None = None
    drawn: int | None = None
    method: _Method = "chi-squared"
    p_value = float(stats.chi2.sf(statistic, count - 1))
    if count == 2:
        labels = np.arange(dyads).astype(str)
        p_value, least, method = _of_two_groups(compare(values[0], values[1], dyads=(labels, labels)))
    elif dyads < _CHI_SQUARED_FROM:
        permuted = permute_friedman(ranks.T)
        p_value, least, method = permuted.p_value, permuted.least_p, permuted.method
        drawn = permuted.drawn
    return GroupTest(
        names,
        sizes,
        "Friedman",
        "dyad",
        statistic,
        count - 1,
        p_value,
        p_value,
        least,
        method,
        None,
        statistic / (dyads * (count - 1)),
        drawn,
    )


def _of_two_groups(comparison: Comparison) -> tuple[float, float | None, _Method]:
    assert comparison.p_value is not None
    return comparison.p_value, comparison.least_p, comparison.method
