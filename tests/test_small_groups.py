"""Exact p values of small and tied groups, copies of trials, and trials of several dyads."""

from __future__ import annotations

import math
import os
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from made_trials import experiment, figure_eight, offsets
from telespring.analysis import analyse_trials, compare, kruskal_wallis
from telespring.analysis.statistics import fewest_values
from telespring.references import read_reference
from telespring.show.drawings.trials import draw_errors

UM_AND_CM = [(math.nan, 0.0), (36.0, 0.0)]
Floats = NDArray[np.float64]


# exact p values


def test_ref_rank_sum_with_ties_of_statxact() -> None:
    example = read_reference("mehta1999")["rank_sum"]
    found = compare(example["treated"], example["control"])
    assert found.method == "exact"
    # printed with four digits
    assert found.p_value == pytest.approx(example["p"], abs=5e-5)


def within(values: list[float], others: list[float]) -> Any:
    """Compare as two conditions of as many dyads."""
    dyads = [f"dyad {i}" for i in range(len(values))]
    return compare(values, others, dyads=(dyads, dyads))


def test_ref_signed_rank_with_ties_and_zeros_of_statxact() -> None:
    example = read_reference("mehta1999")["signed_rank"]
    found = within(example["before"], example["after"])
    assert found.test == "signed-rank"
    assert found.p_value == pytest.approx(example["p"], abs=5e-5)


def test_ref_signed_rank_of_hollander_and_wolfe() -> None:
    example = read_reference("hollander1973")["signed_rank"]
    found = within(example["first"], example["second"])
    assert found.statistic == example["statistic"]
    # printed with four digits, one-sided; without ties the distribution is symmetric
    assert found.p_value / 2.0 == pytest.approx(example["p_greater"], abs=5e-6)


def test_ref_kruskal_and_wallis_s_table_of_exact_probabilities() -> None:
    table = read_reference("kruskal1952")["exact_probabilities"]
    exact: dict[float, float] = {}
    least = set()
    for chosen in combinations(range(9), 3):
        for other in combinations([i for i in range(9) if i not in chosen], 3):
            rest = [i for i in range(9) if i not in (*chosen, *other)]
            if chosen[0] != 0:
                continue  # the groups have no order
            found = kruskal_wallis({"a": chosen, "b": other, "c": rest})
            assert found.method == "exact"
            assert found.statistic is not None
            assert found.p_value is not None
            exact[round(found.statistic, 4)] = found.p_value
            least.add(found.least_p)
    # six of the 1680 assignments
    assert least == {6 / 1680} == {min(exact.values())}
    for h, p in zip(table["h"], table["p"], strict=True):
        # half a unit of the last digit printed
        assert exact[h] == pytest.approx(p, abs=5e-4)


def test_ref_friedman_of_hollander_and_wolfe() -> None:
    example = read_reference("hollander1973")["friedman"]
    times = np.array(example["times"])
    players = [f"player {i}" for i in range(len(times))]
    groups = {str(method): times[:, method] for method in range(3)}
    found = kruskal_wallis(groups, dict.fromkeys(groups, players))
    assert found.test == "Friedman"
    assert found.statistic == pytest.approx(example["statistic"], abs=5e-5)
    assert found.degrees_of_freedom == example["degrees_of_freedom"]
    assert found.p_value == pytest.approx(example["p"], abs=5e-7)
    # Kendall's W is Friedman's Q over n (k − 1)
    assert found.kendalls_w == pytest.approx(example["statistic"] / 44.0, abs=5e-6)


@given(
    st.lists(st.integers(0, 4), min_size=2, max_size=6), st.lists(st.integers(0, 4), min_size=2, max_size=6)
)
def test_cross_tied_p_is_the_share_of_all_assignments(first: list[int], second: list[int]) -> None:
    found = compare(first, second)
    together = stats.rankdata([*first, *second])
    sums = np.array(
        [together[list(chosen)].sum() for chosen in combinations(range(len(together)), len(first))]
    )
    distance = np.abs(sums - sums.mean())
    observed = abs(together[: len(first)].sum() - sums.mean())
    # both count the same integers
    assert found.p_value == pytest.approx(np.mean(distance >= observed - 1e-9), rel=1e-12)
    assert found.least_p == pytest.approx(np.mean(distance >= distance.max() - 1e-9), rel=1e-12)


@given(st.lists(st.integers(-4, 4), min_size=1, max_size=9))
def test_cross_signed_rank_p_is_the_share_of_all_signs(differences: list[int]) -> None:
    found = within([float(each) for each in differences], [0.0] * len(differences))
    present = np.array([each for each in differences if each], dtype=float)
    if not len(present):
        assert (found.p_value, found.method) == (1.0, "all equal")
        return
    size = stats.rankdata(np.abs(present))
    signs = np.array(np.meshgrid(*[[0.0, 1.0]] * len(present))).reshape(len(present), -1)
    distance = np.abs(size @ signs - 0.5 * size.sum())
    observed = abs(size[present > 0].sum() - 0.5 * size.sum())
    assert found.p_value == pytest.approx(np.mean(distance >= observed - 1e-9), rel=1e-12)
    assert found.least_p == pytest.approx(np.mean(distance >= distance.max() - 1e-9), rel=1e-12)


@pytest.mark.parametrize("sizes", [(4, 4), (7, 5), (3, 3, 2), (6, 5, 7)])
def test_cross_group_p_is_scipy_s_permutation_test(sizes: tuple[int, ...]) -> None:
    rng = np.random.default_rng(sum(sizes))
    groups = [np.round(rng.normal(0.6 * i, 1.0, size), 1) for i, size in enumerate(sizes)]

    def h(*values: Floats, axis: int) -> Any:
        return stats.kruskal(*values, axis=axis).statistic

    theirs = stats.permutation_test(
        groups, h, alternative="greater", n_resamples=9999, vectorized=True, rng=rng
    ).pvalue
    found = kruskal_wallis({str(i): values for i, values in enumerate(groups)})
    exact = math.factorial(sum(sizes)) / math.prod(math.factorial(size) for size in sizes) <= 9999
    assert found.method in ("exact", "permutation")
    # four standard errors of 9999 draws on either side, where they draw
    allowed = 1e-9 if exact else 8.0 * math.sqrt(theirs * (1.0 - theirs) / 9999)
    assert found.p_value == pytest.approx(theirs, abs=allowed)


def test_law_two_groups_have_one_p_whatever_the_test() -> None:
    rng = np.random.default_rng(3)
    for size in (3, 5, 20, 60):
        one, other = rng.normal(0.0, 1.0, size), rng.normal(0.8, 1.0, size)
        assert kruskal_wallis({"a": one, "b": other}).p_value == compare(one, other).p_value
    three = kruskal_wallis({"a": [1.0, 2.0, 3.0], "b": [4.0, 5.0, 6.0]})
    # 2 of 20 assignments; chi-squared says 0.0495
    assert three.method == "exact"
    assert three.p_value == pytest.approx(0.1)


def test_law_the_same_trials_give_the_same_p() -> None:
    rng = np.random.default_rng(8)
    groups = {str(i): rng.normal(size=6) for i in range(4)}
    assert kruskal_wallis(groups) == kruskal_wallis(groups)


@pytest.mark.parametrize("level", [0.05, 0.01, 0.05 / 33])
def test_ref_the_fewest_values_are_those_whose_least_p_is_below_the_level(level: float) -> None:
    for test, sizes in (("rank-sum", range(1, 9)), ("signed-rank", range(1, 14))):
        least: dict[int, float] = {}
        for size in sizes:
            high, low = [float(100 + i) for i in range(size)], [float(i * i) / 7 for i in range(size)]
            found = compare(high, low) if test == "rank-sum" else within(high, low)
            assert found.p_value == found.least_p
            least[size] = found.p_value or 0.0
        assert fewest_values(test, level) == min(size for size, p in least.items() if p < level)  # type: ignore[arg-type]


# copies


def copied(noise: float) -> xr.Dataset:
    """Make two conditions whose 20 trials all repeat one trial, but for some noise, m."""
    errors = np.full((2, 20, 2), 0.022)
    errors[1] += 1e-5
    errors[0, :, 1] += 2e-6
    made = offsets(errors, UM_AND_CM)
    made["position"] = made["position"] + noise * np.random.default_rng(1).normal(size=made["position"].shape)
    return made


@pytest.mark.parametrize("noise", [0.0, 1e-10])
def test_law_copies_of_a_trial_count_once(noise: float) -> None:
    found = analyse_trials(copied(noise))
    for row in found["table1"]:
        assert (row["trials"], row["te1_n"], row["te2_n"], row["te1_copies"]) == (20, 1, 1, 19)
        assert (row["te1_sd"], row["te1_arrow"], row["te2_arrow"]) == (None, "", "")
    for family in found["wilcoxon"].values():
        assert {each["p"] for each in family["comparisons"]} == {1.0}
        assert {tuple(each["sizes"]) for each in family["comparisons"]} == {(1, 1)}
        assert all(
            each["superiority_interval"][1] - each["superiority_interval"][0] > 0.5
            for each in family["comparisons"]
        )
    assert {test["p"] for test in found["kruskal_wallis"]} <= {None, 1.0}


def test_law_trials_that_differ_by_a_micrometre_are_no_copies() -> None:
    found = analyse_trials(copied(1e-6))
    assert {(row["te1_n"], row["te1_copies"]) for row in found["table1"]} == {(20, 0)}


def test_law_a_copy_counts_per_robot_and_the_rest_as_before() -> None:
    rng = np.random.default_rng(4)
    errors = 0.03 + 0.002 * rng.normal(size=(2, 6, 2))
    made = offsets(errors, UM_AND_CM)
    made["position"][0, 3, :, 0] = made["position"][0, 1, :, 0]
    found = analyse_trials(made)
    without = np.delete(errors[0, :, 0], 3)
    row = found["table1"][0]
    assert (row["te1_n"], row["te1_copies"], row["te2_n"], row["te2_copies"]) == (5, 1, 6, 0)
    assert row["te1_mean"] == pytest.approx(1e3 * without.mean(), rel=1e-12)
    assert row["te1_p"] == compare(without, errors[0, :, 1]).p_value
    # all values are still listed
    assert len(found["conditions"][0]["measures"]["tracking_error"]["robot1"]["values"]) == 6


def test_law_a_recording_in_two_conditions_is_reported() -> None:
    made = offsets(0.03 + 0.002 * np.random.default_rng(4).normal(size=(2, 4, 2)), UM_AND_CM)
    assert analyse_trials(made)["warnings"] == []
    made["position"][1, 2] = made["position"][0, 3]
    [warning] = analyse_trials(made)["warnings"]
    assert warning.startswith("Trial 4 of UM and trial 3 of CM-36-0 are alike to the nanometre")


# dyads


def dyad_trials(
    rng: np.random.Generator, conditions: int, dyads: int, trials: int, between: float, interaction: float
) -> tuple[list[Floats], list[str]]:
    """Draw trials of several dyads: dyads differ, and each responds to the conditions in its own way."""
    labels = [f"dyad {i}" for i in range(dyads) for _ in range(trials)]
    level = between * rng.normal(size=dyads)
    groups = [
        np.repeat(level + interaction * rng.normal(size=dyads), trials) + rng.normal(size=dyads * trials)
        for _ in range(conditions)
    ]
    return groups, labels


def false_alarms(repeats: int, seed: int) -> dict[str, float]:
    """Count how often p is below 0.05 where nothing differs."""
    rng = np.random.default_rng(seed)
    alarms: dict[str, int] = {}

    def count(name: str, p_value: float | None) -> None:
        assert p_value is not None
        alarms[name] = alarms.get(name, 0) + (p_value < 0.05)

    for _ in range(repeats):
        (one, other, third), labels = dyad_trials(rng, 3, 8, 10, 1.0, 1.0)
        count("within dyads", compare(one, other, dyads=(labels, labels)).p_value)
        count("pooled", compare(one, other).p_value)
        half = len(one) // 2
        count("between dyads", compare(one[:half], one[half:], dyads=(labels[:half], labels[half:])).p_value)
        groups = {"a": one, "b": other, "c": third}
        count("Friedman", kruskal_wallis(groups, dict.fromkeys(groups, labels)).p_value)
        tied = np.round(rng.normal(size=(3, 5)))
        count("5 and 5 with ties", compare(tied[0], tied[1]).p_value)
        count("4 and 4", compare(rng.normal(size=4), rng.normal(size=4)).p_value)
        count("three of 4", kruskal_wallis({str(i): rng.normal(size=4) for i in range(3)}).p_value)
        count("three of 5 with ties", kruskal_wallis({str(i): tied[i] for i in range(3)}).p_value)
        count("three of 10", kruskal_wallis({str(i): rng.normal(size=10) for i in range(3)}).p_value)
    return {name: number / repeats for name, number in alarms.items()}


def check_false_alarms(repeats: int, seed: int) -> None:
    rates = false_alarms(repeats, seed)
    print(rates)
    # three standard errors above the nominal 5 %
    allowed = 0.05 + 3.0 * math.sqrt(0.05 * 0.95 / repeats)
    pooled = rates.pop("pooled")
    assert all(rate <= allowed for rate in rates.values()), rates
    # these data are a fair trial: taken as independent, they give false alarms
    assert pooled > 0.25


def test_law_false_alarms_are_no_more_than_five_in_a_hundred() -> None:
    check_false_alarms(200, 2025)


@pytest.mark.verify
@pytest.mark.timeout(1800)
def test_law_false_alarms_of_many_draws_are_no_more_than_five_in_a_hundred() -> None:
    check_false_alarms(4000, int(os.environ.get("TELESPRING_VERIFY", "1")))


def test_law_what_most_dyads_do_is_found() -> None:
    rng = np.random.default_rng(5)
    (one, other), labels = dyad_trials(rng, 2, 10, 6, 3.0, 0.2)
    one = one + 2.0
    found = compare(one, other, dyads=(labels, labels))
    assert found.p_value == pytest.approx(2.0**-9)
    assert (found.arrow(), found.superiority, found.sizes) == ("↑", 1.0, (10, 10))
    assert compare(other, one, dyads=(labels, labels)).arrow() == "↓"
    assert found.shift == pytest.approx(2.0, abs=0.6)
    # between dyads that differ by more, the same trials show nothing
    assert (compare(one[::2], other[1::2]).p_value or 0.0) > 0.01


def test_law_dyads_of_one_condition_only_are_compared_between_dyads() -> None:
    one, other = {"a": 1.0, "b": 2.0, "c": 3.0}, {"d": 4.0, "e": 5.0, "f": 6.0}
    twice = [value for value in one.values() for _ in range(4)]
    labels = [label for label in one for _ in range(4)]
    found = compare(twice, list(other.values()), dyads=(labels, list(other)))
    assert (found.test, found.unit, found.sizes) == ("rank-sum", "dyad", (3, 3))
    assert found.p_value == compare(list(one.values()), list(other.values())).p_value


def test_law_the_analysis_takes_the_dyads_of_the_data() -> None:
    rng = np.random.default_rng(6)
    errors = 0.03 + 0.001 * rng.normal(size=(2, 12, 2)) + 0.01 * np.repeat(rng.normal(size=4), 3)[:, None]
    labels = np.tile(np.repeat(["A", "B", "C", "D"], 3), (2, 1))
    made = offsets(errors, UM_AND_CM).assign(dyad=(("condition", "trial"), labels))
    found = analyse_trials(made)
    assert (found["analysed"]["unit"], found["analysed"]["dyads"]) == ("dyad", ["A", "B", "C", "D"])
    means = errors.reshape(2, 4, 3, 2).mean(axis=2)
    row = found["table1"][1]
    by_hand = stats.wilcoxon(means[1, :, 0], means[0, :, 1], method="exact")
    assert row["te1_p"] == pytest.approx(by_hand.pvalue, rel=1e-12)
    assert (row["te1_n"], row["te1_distinct"], row["te1_dyads"], row["te1_least_p"]) == (4, 12, 4, 0.125)
    one = analyse_trials(made.assign(dyad=(("condition", "trial"), np.full((2, 12), "A"))))
    assert (one["analysed"]["unit"], one["analysed"]["dyads"]) == ("trial", ["A"])
    assert one["table1"][1]["te1_p"] == compare(errors[1, :, 0], errors[0, :, 1]).p_value


def test_law_means_deviations_and_figures_are_over_the_dyads() -> None:
    """Twenty trials of one dyad and two of the others: each dyad has one value, and so have they all."""
    rng = np.random.default_rng(8)
    labels = np.array([*(["A"] * 20), "B", "B", "C", "C"])
    level = {"A": 0.05, "B": 0.02, "C": 0.03}
    errors = np.array([level[label] for label in labels])[:, None] + 0.001 * rng.normal(size=(2, 24, 2))
    made = offsets(errors, UM_AND_CM).assign(dyad=(("condition", "trial"), np.tile(labels, (2, 1))))
    found = analyse_trials(made)
    frame = pd.DataFrame({"dyad": labels, "UM": errors[0, :, 1], "CM": errors[1, :, 1]})
    by_dyad = 1e3 * frame.groupby("dyad").mean()
    for row, name in zip(found["table1"], ("UM", "CM"), strict=True):
        expected = (by_dyad[name].mean(), by_dyad[name].std(), by_dyad[name].median())
        assert (row["te2_mean"], row["te2_sd"], row["te2_median"]) == pytest.approx(expected, rel=1e-9)
        assert (row["te2_n"], row["te2_distinct"], row["trials"]) == (3, 24, 24)
    assert 1e3 * found["baseline"]["te2_median"] == pytest.approx(by_dyad["UM"].median(), rel=1e-9)
    measured = found["conditions"][1]["measures"]["tracking_error"]["robot2"]
    assert 1e3 * measured["mean"] == pytest.approx(by_dyad["CM"].mean(), rel=1e-9)
    assert {dyad: 1e3 * value for dyad, value in measured["dyad_means"].items()} == pytest.approx(
        by_dyad["CM"].to_dict(), rel=1e-9
    )
    assert len(measured["values"]) == 24
    # three markers per box, not 24
    [axes] = [axes for axes in draw_errors(found).axes if axes.get_ylabel()]
    assert axes.get_ylabel() == "Tracking error, mean of each dyad, mm"
    markers = [line for line in axes.lines if line.get_marker() in ("o", "^")]
    assert [np.size(line.get_xdata()) for line in markers] == [3] * 4
    one = analyse_trials(made.drop_vars("dyad"))["conditions"][0]["measures"]["tracking_error"]["robot1"]
    assert one["dyad_means"] is None


def test_law_the_least_p_of_random_permutations_is_a_bound() -> None:
    apart = {name: np.arange(8.0) + 100.0 * i for i, name in enumerate("abc")}
    found = kruskal_wallis(apart)
    assert (found.method, found.permutations, found.p_value) == ("permutation", 9999, 1e-4)
    assert found.is_p_bound
    # of all arrangements 6 are as extreme
    assert found.p_value is not None
    assert found.p_value > 6.0 * math.factorial(8) ** 3 / math.factorial(24)
    rng = np.random.default_rng(1)
    assert not kruskal_wallis({name: rng.normal(size=8) for name in "abc"}).is_p_bound
    assert (
        kruskal_wallis({name: np.arange(3.0) + 10.0 * i for i, name in enumerate("abc")}).permutations is None
    )


def test_law_simulated_trials_are_known() -> None:
    errors = 0.03 + 0.001 * np.random.default_rng(1).normal(size=(2, 3, 2))
    made = offsets(errors, UM_AND_CM)
    assert analyse_trials(made)["analysed"]["simulated"] is False
    seeds = np.arange(6, dtype=np.uint64).reshape(2, 3)
    assert analyse_trials(made.assign(seed=(("condition", "trial"), seeds)))["analysed"]["simulated"] is True
    assert analyse_trials(made.assign_attrs(schema="telespring rehearsal 1"))["analysed"]["simulated"] is True


def test_law_targets_that_differ_make_no_copies() -> None:
    """A handle at rest after two targets: the same path, but two trials."""
    time = np.arange(201) / 100.0
    made = experiment(np.zeros((1, 2, 201, 2, 2)), UM_AND_CM[:1])
    made["target"] = ("trial", "time", "axis"), np.stack([figure_eight(time), 1.1 * figure_eight(time)])
    row = analyse_trials(made)["table1"][0]
    assert (row["te1_n"], row["te1_copies"]) == (2, 0)


def test_law_the_same_test_reads_alike_for_both_robots() -> None:
    """A p that no permutation reaches beside one that one permutation reaches."""
    from telespring.show.screens.analysis import _group_test_sentence  # one line of a long screen

    test = {"test": "Friedman", "q": 14.04, "degrees_of_freedom": 3, "kendalls_w": 0.8, "least_p": None}
    test |= {"method": "permutation", "permutations": 9999}
    one = _group_test_sentence(test | {"robot": 1, "p": 1e-4, "is_p_bound": True})
    two = _group_test_sentence(test | {"robot": 2, "p": 2e-4, "is_p_bound": False})
    assert one.replace("TE1", "TE2") == two
    assert "p < 0.001, by 9,999 random permutations;" in one
