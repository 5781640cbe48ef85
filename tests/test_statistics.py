"""Rank tests, Holm's correction and effect sizes against examples, enumeration and hand-written formulas."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from telespring.analysis import compare, compare_pairs, holm, kruskal_wallis, superiority_interval
from telespring.references import read_reference


def ranks(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rank from 1, ties by their mean, by counting."""
    below = (values[None, :] < values[:, None]).sum(axis=1)
    same = (values[None, :] == values[:, None]).sum(axis=1)
    return np.asarray(below + 0.5 * (same + 1.0))


def tie_term(values: NDArray[np.float64]) -> float:
    _, counts = np.unique(values, return_counts=True)
    return float((counts**3 - counts).sum())


def test_ref_wilcoxon_of_hollander_and_wolfe() -> None:
    example = read_reference("hollander1973")["rank_sum"]
    found = compare(example["term"], example["earlier"])
    assert found.statistic == example["statistic"]
    assert found.method == "exact"
    assert found.p_value is not None
    # printed with four digits, one-sided
    assert found.p_value / 2.0 == pytest.approx(example["p_greater"], abs=5e-5)


@pytest.mark.parametrize("name", ["hollander1973", "dobson1983"])
def test_ref_kruskal_wallis_of_textbooks(name: str) -> None:
    example = read_reference(name)["kruskal_wallis"]
    groups = {key: values for key, values in example.items() if isinstance(values, list)}
    found = kruskal_wallis(groups)
    assert found.statistic is not None
    assert found.p_value is not None
    # half a unit of the last digit printed
    assert found.statistic == pytest.approx(example["statistic"], abs=5e-5)
    assert found.degrees_of_freedom == example["degrees_of_freedom"]
    # the books' p is chi-squared's, which ours is with ten values or more in every group
    chi_squared = float(stats.chi2.sf(found.statistic, found.degrees_of_freedom))
    assert chi_squared == pytest.approx(example["p"], abs=5e-6 if name == "dobson1983" else 5e-3)
    assert found.method == ("chi-squared" if name == "dobson1983" else "permutation")
    if found.method == "chi-squared":
        assert found.p_value == chi_squared


def test_ref_superiority_of_bonett() -> None:
    example = read_reference("bonett2021")["superiority"]
    assert compare(example["first"], example["second"]).superiority == example["estimate"]


@pytest.mark.parametrize(("first", "second"), [(3, 4), (5, 6), (2, 9), (7, 4)])
def test_cross_exact_p_is_the_share_of_all_assignments(first: int, second: int) -> None:
    rng = np.random.default_rng(11 * first + second)
    for shift in (0.0, 0.7, 2.0):
        one, other = rng.normal(shift, 1.0, first), rng.normal(0.0, 1.0, second)
        together = ranks(np.concatenate([one, other]))
        sums = np.array(
            [together[list(chosen)].sum() for chosen in combinations(range(first + second), first)]
        )
        observed, middle = together[:first].sum(), first * (first + second + 1) / 2.0
        share = np.mean(np.abs(sums - middle) >= abs(observed - middle) - 1e-9)
        found = compare(one, other)
        assert found.method == "exact"
        # both count the same integers
        assert found.p_value == pytest.approx(float(share), rel=1e-12)


@given(st.integers(0, 1000), st.integers(51, 60), st.integers(8, 60))
def test_cross_tied_p_of_large_groups_is_that_of_the_rank_formula(
    seed: int, n_first: int, n_second: int
) -> None:
    rng = np.random.default_rng(seed)
    first, second = rng.integers(0, 7, n_first), rng.integers(0, 7, n_second)
    one, other = np.array(first, dtype=float), np.array(second, dtype=float)
    together = np.concatenate([one, other])
    found = compare(one, other)
    n1, n2, n = len(one), len(other), len(together)
    u = ranks(together)[:n1].sum() - n1 * (n1 + 1) / 2.0
    assert found.statistic == pytest.approx(u, abs=1e-9)
    if np.ptp(together) == 0.0:
        assert found.method == "all equal"
        assert found.p_value == 1.0
        return
    if len(np.unique(together)) == n:
        return
    variance = n1 * n2 / 12.0 * (n + 1.0 - tie_term(together) / (n * (n - 1.0)))
    z = max(0.0, abs(u - n1 * n2 / 2.0) - 0.5) / math.sqrt(variance)
    assert found.method == "asymptotic"
    # the same formula in another order of rounding
    assert found.p_value == pytest.approx(math.erfc(z / math.sqrt(2.0)), rel=1e-9)


@given(st.lists(st.lists(st.integers(0, 9), min_size=3, max_size=9), min_size=3, max_size=3))
def test_cross_h_is_the_rank_formula(drawn: list[list[int]]) -> None:
    groups = [np.array(values, dtype=float) for values in drawn]
    together = np.concatenate(groups)
    found = kruskal_wallis({str(i): values for i, values in enumerate(groups)})
    if np.ptp(together) == 0.0:
        assert (found.statistic, found.p_value) == (0.0, 1.0)
        return
    ranked, n, start, total = ranks(together), len(together), 0, 0.0
    for values in groups:
        total += ranked[start : start + len(values)].sum() ** 2 / len(values)
        start += len(values)
    h = (12.0 / (n * (n + 1.0)) * total - 3.0 * (n + 1.0)) / (1.0 - tie_term(together) / (n**3 - n))
    # sums of squares of ranks up to 27² lose three digits against their mean
    assert found.statistic == pytest.approx(h, abs=1e-10)
    assert found.epsilon_squared == pytest.approx(h * (n + 1.0) / (n**2 - 1.0), abs=1e-10)


def test_cross_kruskal_wallis_p_is_near_that_of_permutations() -> None:
    rng = np.random.default_rng(7)
    groups = [rng.normal(shift, 1.0, 20) for shift in (0.0, 0.5, 0.6)]
    found = kruskal_wallis({str(i): values for i, values in enumerate(groups)})
    assert found.statistic is not None
    ranked = ranks(np.concatenate(groups))
    shuffled = rng.permuted(np.tile(ranked, (20000, 1)), axis=1).reshape(20000, 3, 20)
    h = 12.0 / (60.0 * 61.0) * (shuffled.sum(axis=2) ** 2 / 20.0).sum(axis=1) - 3.0 * 61.0
    share = float(np.mean(h >= found.statistic - 1e-9))
    # four standard errors of 20,000 draws, and what the chi-squared tail misses at n = 20
    assert found.p_value == pytest.approx(share, abs=4.0 * math.sqrt(share / 20000) + 0.003)


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=40))
def test_ref_holm_by_its_definition(p_values: list[float]) -> None:
    """Holm 1979: in order of p, the largest so far of (tests left) times p, at most 1."""
    order = sorted(range(len(p_values)), key=lambda i: p_values[i])
    expected, largest = [0.0] * len(p_values), 0.0
    for place, i in enumerate(order):
        largest = max(largest, min(1.0, (len(p_values) - place) * p_values[i]))
        expected[i] = largest
    with_gaps = [None if i is None else p_values[i] for i in (None, *range(len(p_values)), None)]
    found = holm(with_gaps)
    assert found[0] is None
    assert found[-1] is None
    assert found[1:-1] == pytest.approx(expected, abs=1e-15)


def test_law_a_family_is_corrected_together_and_what_was_not_tested_does_not_count() -> None:
    values = {"a": np.arange(8.0), "b": np.arange(8.0) + 5.3, "c": np.arange(8.0) + 0.4, "none": np.array([])}
    pairs = [("a", "b"), ("a", "none"), ("a", "c"), ("b", "c")]
    found = compare_pairs(pairs, values)
    assert [(each.first, each.second) for each in found] == pairs
    raw = [compare(values[one], values[other]).p_value for one, other in pairs]
    assert [each.p_value for each in found] == raw
    assert [each.p_holm for each in found] == holm(raw)
    assert found[1].method == "no values"
    assert found[1].p_holm is None
    assert found[0].p_holm == pytest.approx(3.0 * (found[0].p_value or 0.0))


@given(st.floats(0.0, 1.0), st.integers(2, 40), st.integers(2, 40))
def test_law_the_interval_of_the_effect_is_where_newcombe_puts_it(a: float, n1: int, n2: int) -> None:
    """Each end is as many of its own standard errors away as the normal distribution allows."""
    low, high = superiority_interval(a, (n1, n2))
    assert 0.0 <= low <= a <= high <= 1.0
    for end in (low, high):
        if 1e-6 < end < 1.0 - 1e-6:
            # Hanley and McNeil's variance in its own form, both sizes replaced by their mean
            q1, q2, mean = end / (2.0 - end), 2.0 * end**2 / (1.0 + end), 0.5 * (n1 + n2)
            variance = (end * (1.0 - end) + (mean - 1.0) * (q1 + q2 - 2.0 * end**2)) / (n1 * n2)
            # brentq stops at 1e-12 of the end, which near 0 and 1 is a larger share of the distance
            assert abs(a - end) == pytest.approx(1.959963984540054 * math.sqrt(variance), rel=1e-4, abs=1e-9)
    assert superiority_interval(1.0 - a, (n1, n2)) == pytest.approx((1.0 - high, 1.0 - low), abs=1e-9)


@pytest.mark.parametrize("shift", [0.0, 1.0, 2.5])
def test_law_the_interval_of_the_effect_holds_the_truth_in_95_of_100(shift: float) -> None:
    rng = np.random.default_rng(2006)
    truth = 0.5 * math.erfc(-shift / 2.0)
    repeats, hits = 1000, 0
    for _ in range(repeats):
        one, other = rng.normal(shift, 1.0, 20), rng.normal(0.0, 1.0, 20)
        low, high = superiority_interval(float(np.mean(one[:, None] > other)), (20, 20))
        hits += low <= truth <= high
    # three standard errors of 1000 draws are 2 %; Newcombe reports 93 to 98 % for such sizes
    assert 0.925 <= hits / repeats <= 0.995


def test_cross_effect_against_statsmodels() -> None:
    from statsmodels.stats.nonparametric import rank_compare_2indep

    rng = np.random.default_rng(3)
    for shift in (-1.0, 0.0, 0.8):
        one, other = rng.normal(shift, 1.0, 60), rng.normal(0.0, 1.0, 70)
        found, theirs = compare(one, other), rank_compare_2indep(one, other)
        assert found.superiority == pytest.approx(theirs.prob1, abs=1e-12)
        # Brunner and Munzel's interval is another one: a quarter of its width apart at most
        low, high = theirs.conf_int()
        assert found.superiority_interval == pytest.approx((low, high), abs=0.25 * (high - low))


def test_law_exchanging_the_groups_turns_everything_round() -> None:
    rng = np.random.default_rng(9)
    one, other = rng.normal(1.0, 1.0, 20), rng.normal(0.0, 1.0, 17)
    there, back = compare(one, other), compare(other, one)
    assert there.p_value == pytest.approx(back.p_value, rel=1e-12)
    assert there.cliffs_delta == pytest.approx(-(back.cliffs_delta or 0.0), abs=1e-12)
    assert there.shift == pytest.approx(-(back.shift or 0.0), abs=1e-15)
    assert (there.arrow(), back.arrow()) == ("↑", "↓")
    barely = replace(there, p_value=0.049, p_holm=0.05)
    assert (barely.arrow(), barely.arrow(corrected=True)) == ("↑", "")
    assert (there.statistic or 0.0) + (back.statistic or 0.0) == 20 * 17


def test_law_values_that_do_not_exist_are_left_out() -> None:
    rng = np.random.default_rng(4)
    one, other = rng.normal(size=8), rng.normal(size=9)
    gap = np.insert(one, 3, np.nan)
    assert compare(gap, other) == compare(one, other)
    assert kruskal_wallis({"a": gap, "b": other, "c": [np.nan]}) == kruskal_wallis({"a": one, "b": other})
    alone = kruskal_wallis({"a": one, "b": []})
    assert (alone.statistic, alone.p_value, alone.p_holm) == (None, None, None)


def test_ref_effects_of_groups_that_do_not_overlap() -> None:
    found = compare(np.arange(20.0) + 100.0, np.arange(20.0))
    assert found.superiority == 1.0
    assert found.cliffs_delta == 1.0
    assert found.shift == 100.0
    # 2 of C(40, 20) assignments are as extreme
    assert found.p_value == pytest.approx(2.0 / math.comb(40, 20), rel=1e-9)
    assert found.superiority_interval is not None
    assert 0.85 < found.superiority_interval[0] < 0.95
    assert found.superiority_interval[1] == 1.0
