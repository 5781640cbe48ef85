"""The rule of the best safe choice, and what `compare.json` says of it."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
import xarray as xr

from telespring.comparison.choices import LeftOut
from telespring.comparison.recommendation import recommend
from telespring.comparison.summary import comparison_json, condition_rows

PARTS = {
    "spring": ("spring", "hold"),
    "spring + linear": ("spring", "linear"),
    "guard": ("guard", "hold"),
    "guard + shared-target": ("guard", "shared-target"),
    "wave-variables": ("wave-variables", "hold"),
}
STIFFNESSES, DELAYS, NETWORKS = (71.2, 142.5), (0.0, 0.084), ("campus", "5G")
PLACE = ("architecture", "network", "condition")


def comparison(errors: dict[str, tuple[float, float]], trials: int = 3) -> xr.Dataset:
    """Make a comparison with these mean errors with each stiffness, mm, in which every spring is stable."""
    conditions = [(k, delay) for k in STIFFNESSES for delay in DELAYS]
    shape = (len(errors), len(NETWORKS), len(conditions), trials)
    error = np.empty((*shape, 2))
    for a, both in enumerate(errors.values()):
        for c, (k, _) in enumerate(conditions):
            error[a, :, c] = 1e-3 * both[STIFFNESSES.index(k)]
    # Person 2 and later trials are worse, the same everywhere.
    error *= np.array([0.9, 1.1])
    error += 1e-5 * (np.arange(trials) - 0.5 * (trials - 1))[:, None]
    ones = np.ones((*shape, 2))
    per_robot, per_trial = (*PLACE, "trial", "robot"), (*PLACE, "trial")
    return xr.Dataset(
        {
            "tracking_error": (per_robot, error),
            **dict.fromkeys(("limited_share", "withheld_share", "force_fidelity"), (per_robot, 0.1 * ones)),
            **dict.fromkeys(("coupling_energy", "coupling_energy_minimum"), (per_trial, ones[..., 0])),
            **{
                name: ((*PLACE, "robot"), age * ones[..., 0, :])
                for name, age in (("age_low", 0.05), ("age_mean", 0.06), ("age_high", 0.09))
            },
            "within_age_range": ((*PLACE, "robot"), ones[..., 0, :]),
            "status": (per_trial, np.zeros(shape, np.int8)),
            "diverged": (per_trial, np.zeros(shape, bool)),
            "verdict": (PLACE, np.full(shape[:3], "stable", dtype=object)),
            "guard_overdraft": (("condition",), np.full(len(conditions), 1e-4)),
            "is_rehearsed": (("network", "condition"), np.ones(shape[1:3], bool)),
            "tracking_error_unconnected": (("trial", "robot"), 0.03 * ones[0, 0, 0]),
        },
        coords={
            "architecture": list(errors),
            "strategy": ("architecture", [PARTS[label][0] for label in errors]),
            "predictor": ("architecture", [PARTS[label][1] for label in errors]),
            "playout": ("architecture", ["fixed"] * len(errors)),
            "network": list(NETWORKS),
            "condition": [f"CM-{k:.0f}-{1e3 * delay:.0f}" for k, delay in conditions],
            "stiffness": ("condition", [k for k, _ in conditions]),
            "delay": ("condition", [delay for _, delay in conditions]),
            "trial": np.arange(1, trials + 1),
            "robot": [1, 2],
        },
        attrs={"name": "made"},
    )


def put(data: xr.Dataset, name: str, value: Any, **place: Any) -> None:
    data[name].loc[place] = value


def test_law_the_smallest_mean_error_of_the_safe_choices_wins() -> None:
    found = recommend(
        comparison({"spring": (30.0, 33.0), "guard": (29.0, 28.0), "wave-variables": (31.0, 27.0)})
    )
    best = found.candidate
    assert best is not None
    assert (best.architecture, best.stiffness, best.grounds) == ("wave-variables", 142.5, "stable spring")
    assert best.tracking_error == pytest.approx((0.9 * 0.027, 1.1 * 0.027))
    assert best.mean_tracking_error == pytest.approx(0.027)
    assert (found.conditions, found.trials, found.rejections) == (4, 12, ())
    following = found.next_best
    assert following is not None
    assert following.architecture == "guard"
    assert following.difference == pytest.approx(0.001)
    # The trials differ alike everywhere, so that their pairs do not.
    assert following.difference_error == pytest.approx(0.0, abs=1e-12)
    assert [each.architecture for each in found.alternatives] == ["spring", "guard"]


def test_law_one_trial_that_runs_away_on_one_network_excludes_that_stiffness_only() -> None:
    data = comparison({"guard": (29.0, 28.0)})
    put(data, "diverged", True, architecture="guard", network="5G", condition="CM-142-84", trial=2)
    found = recommend(data)
    assert found.candidate is not None
    assert found.candidate.stiffness == 71.2
    [rejection] = found.rejections
    assert (rejection.stiffness, rejection.objection, rejection.trials) == (142.5, "ran away", 1)
    assert (rejection.network, rejection.delay) == ("5G", 0.084)


def test_law_a_trial_that_ended_early_excludes_too() -> None:
    data = comparison({"guard": (29.0, 28.0)})
    put(data, "status", 2, architecture="guard", network="campus", condition="CM-71-0", trial=1)
    put(data, "tracking_error", np.nan, architecture="guard", network="campus", condition="CM-71-0", trial=1)
    found = recommend(data)
    assert found.candidate is not None
    assert found.candidate.stiffness == 142.5
    assert [each.objection for each in found.rejections] == ["ended early"]


def test_law_a_guard_that_is_not_proven_at_a_stiffness_is_no_choice_there() -> None:
    data = comparison({"guard": (29.0, 20.0), "spring": (31.0, 30.0)})
    data["guard_overdraft"][:] = np.where(data.stiffness > 100.0, 0.11, 0.1)
    found = recommend(data)
    assert found.candidate is not None
    assert (found.candidate.architecture, found.candidate.stiffness) == ("guard", 71.2)
    [rejection] = found.rejections
    assert (rejection.stiffness, rejection.objection) == (142.5, "overdraft")
    data["guard_overdraft"][:] = 0.11
    found = recommend(data)
    assert found.candidate is not None
    # the bare spring needs no account
    assert (found.candidate.architecture, found.candidate.stiffness) == ("spring", 142.5)
    assert [each.objection for each in found.alternatives[0].rejections] == ["overdraft"] * 2


@pytest.mark.parametrize("verdict", ["marginal", "unstable", "not proven", ""])
def test_law_what_is_not_the_guard_needs_a_stable_spring_on_every_network(verdict: str) -> None:
    data = comparison({"spring": (20.0, 19.0), "wave-variables": (18.0, 17.0), "guard": (30.0, 31.0)})
    put(data, "verdict", verdict, network="5G", condition="CM-71-84")
    put(data, "verdict", "unstable", network="campus", condition="CM-142-84")
    found = recommend(data)
    assert found.candidate is not None
    assert (found.candidate.architecture, found.candidate.grounds) == ("guard", "any network")
    for alternative in found.alternatives:
        assert alternative.candidate is None
        assert np.isnan(alternative.difference)
        assert [(each.objection, each.verdict) for each in alternative.rejections] == [
            ("not proven", verdict),
            ("not proven", "unstable"),
        ]


def test_law_the_verdict_of_the_spring_is_none_of_a_spring_that_predicts() -> None:
    found = recommend(comparison({"spring + linear": (10.0, 10.0), "spring": (30.0, 31.0)}))
    assert found.candidate is not None
    assert found.candidate.architecture == "spring"
    assert [each.objection for each in found.alternatives[0].rejections] == ["not proven"] * 2


def test_law_a_choice_must_have_been_rehearsed_at_every_delay_of_every_network() -> None:
    data = comparison({"guard": (29.0, 28.0)})
    place = {"network": "5G", "condition": "CM-142-84"}
    put(data, "is_rehearsed", False, **place)
    put(data, "tracking_error", np.nan, architecture="guard", **place)
    found = recommend(data)
    assert found.candidate is not None
    assert found.candidate.stiffness == 71.2
    assert [each.objection for each in found.rejections] == ["not at every delay"]
    # If the network has that delay with no stiffness, nothing is missing.
    put(data, "is_rehearsed", False, network="5G", condition="CM-71-84")
    assert recommend(data).candidate is not None
    assert recommend(data).candidate.stiffness == 142.5  # type: ignore[union-attr]


def test_law_of_equals_the_one_listed_first_and_the_softer_wins() -> None:
    found = recommend(comparison({"spring": (30.0, 30.0), "guard": (30.0, 30.0)}))
    assert found.candidate is not None
    assert (found.candidate.architecture, found.candidate.stiffness) == ("spring", 71.2)


def test_law_without_a_safe_choice_there_is_none() -> None:
    data = comparison({"guard": (29.0, 28.0), "spring": (20.0, 20.0)})
    data["diverged"][:] = True
    found = recommend(data)
    assert (found.candidate, found.next_best) == (None, None)
    assert comparison_json(data, found, ())["recommended"] is None
    assert {each.architecture for each in found.alternatives} == {"guard", "spring"}


def test_law_one_trial_has_no_standard_error() -> None:
    found = recommend(comparison({"guard": (29.0, 28.0), "spring": (30.0, 30.0)}, trials=1))
    assert np.isnan(found.alternatives[0].difference_error)


def test_cross_the_standard_error_is_that_of_the_pairs() -> None:
    data = comparison({"guard": (29.0, 28.0), "spring": (30.0, 30.0)}, trials=6)
    rng = np.random.default_rng(3)
    data["tracking_error"][:] = data["tracking_error"] + 1e-3 * rng.normal(size=data["tracking_error"].shape)
    found = recommend(data)
    assert found.candidate is not None
    alternative = found.alternatives[0]
    assert alternative.candidate is not None
    pairs = []
    for trial in range(6):
        one, other = (
            np.mean(
                [
                    float(data["tracking_error"].sel(architecture=label)[n, c, trial, robot])
                    for n in range(2)
                    for c in np.flatnonzero(data["stiffness"].values == k)
                    for robot in range(2)
                ]
            )
            for label, k in (
                (alternative.architecture, alternative.candidate.stiffness),
                (found.candidate.architecture, found.candidate.stiffness),
            )
        )
        pairs.append(one - other)
    assert alternative.difference == pytest.approx(np.mean(pairs))
    assert alternative.difference_error == pytest.approx(np.std(pairs, ddof=1) / 6**0.5)


def test_law_compare_json_has_a_row_for_every_rehearsed_condition_with_its_means() -> None:
    data = comparison({"guard": (29.0, 28.0), "spring": (30.0, 32.0)})
    put(data, "is_rehearsed", False, network="5G", condition="CM-71-84")
    put(data, "diverged", True, architecture="spring", network="campus", condition="CM-142-84")
    put(data, "tracking_error", np.nan, architecture="spring", network="campus", condition="CM-142-84")
    put(data, "tracking_error", np.nan, architecture="guard", network="5G", condition="CM-142-84", trial=3)
    rows = condition_rows(data)
    assert len(rows) == 2 * 7
    found = {(row["architecture"], row["network"], row["condition"]): row for row in rows}
    row = found["guard", "campus", "CM-71-84"]
    assert row["te1_mean"] == pytest.approx(0.9 * 29.0)
    assert row["te2_mean"] == pytest.approx(1.1 * 29.0)
    assert row["te1_sd"] == pytest.approx(0.01)
    assert (row["trials"], row["diverged"], row["verdict"]) == (3, 0, "stable")
    assert (row["strategy"], row["predictor"], row["playout"]) == ("guard", "hold", "fixed")
    assert (row["stiffness"], row["delay"], row["limited_share"]) == (71.2, 0.084, pytest.approx(0.1))
    assert (row["age_low"], row["age_high"]) == (0.05, 0.09)
    row = found["spring", "campus", "CM-142-84"]
    assert (row["te1_mean"], row["te1_sd"], row["diverged"]) == (None, None, 3)
    assert found["guard", "5G", "CM-142-84"]["te1_mean"] == pytest.approx(0.9 * 28.0 - 0.005)


def test_law_compare_json_is_json_and_explains_the_choice() -> None:
    data = comparison({"guard": (29.0, 28.0), "spring": (30.0, 32.0)}, trials=1)
    put(data, "verdict", "unstable", condition="CM-142-84")
    text = json.dumps(
        comparison_json(data, recommend(data), (LeftOut("two-layer", "no damper"),)), allow_nan=False
    )
    content = json.loads(text)
    assert content["schema"] == 1
    assert content["recommended"]["architecture"] == "guard"
    assert [reason["reason"] for reason in content["recommended"]["reasons"]] == [
        "no trial ran away",
        "safe",
        "smallest tracking error",
    ]
    assert content["recommended"]["reasons"][2]["next"] == "spring"
    assert content["alternatives"][0]["rejected"][0]["verdict"] == "unstable"
    assert content["alternatives"][0]["safe"]["stiffness"] == 71.2
    assert content["left_out"] == [{"architecture": "two-layer", "reason": "no damper"}]
    assert content["unconnected"]["te1_mean"] == pytest.approx(30.0)
    named = {name for row in content["conditions"] for name, value in row.items() if isinstance(value, float)}
    assert named <= set(content["units"])
