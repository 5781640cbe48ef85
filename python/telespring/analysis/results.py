"""The whole analysis as plain values, for `analysis.json` and `study.json`."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._types import FloatArray
from telespring.analysis.measures import measure_trials
from telespring.analysis.plausibility import doubts
from telespring.analysis.statistics import GroupTest, compare_pairs, holm, kruskal_wallis
from telespring.analysis.table import baseline_of, compare_with_baseline, describe, group_name, table1
from telespring.analysis.trials import Trials, take_trials
from telespring.theory.axis import finite_or_none

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["analyse_taken", "analyse_trials"]

#: Per measure the name of its variable and its SI unit.
_MEASURES = {
    "tracking_error": "m",
    "interaction_force_rms": "N",
    "interaction_force_peak": "N",
    "lag": "s",
    "effort_rms": "N",
    "power": "W",
}


def analyse_trials(
    dataset: xr.Dataset, discard: float | None = None, baseline: str | None = None
) -> dict[str, Any]:
    """Measure and compare all trials of an experiment.

    Parameters
    ----------
    dataset : xarray.Dataset
        Trials, as `telespring.analysis.take_trials` describes them.
    discard : float, optional
        First part of every trial to leave out, s; the dataset's own unless given.
    baseline : str, optional
        Condition whose TE2 all is compared with; the unconnected mode unless given.

    Returns
    -------
    dict
        What `analysis.json` holds, in SI units (Table I in mm), as docs/recorded-trials.md lists it.

    Raises
    ------
    telespring.InvalidInput
        Where the dataset holds no such trials.

    Notes
    -----
    Holm's correction goes over families that are stated in the result: all comparisons with the baseline
    (TE1 and TE2 together, as they stand in one table); all pairs of conditions, per robot; TE1 against
    TE2 in each condition; and per robot the Kruskal-Wallis tests per stiffness, with and without the
    baseline. The two tests over all conditions are one family too.
    """
    trials = take_trials(dataset, discard)
    return analyse_taken(trials, measure_trials(trials), baseline)


def analyse_taken(trials: Trials, measured: xr.Dataset, baseline: str | None = None) -> dict[str, Any]:
    """Do what `analyse_trials` does with trials that were checked and measured already."""
    chosen = baseline_of(trials, baseline)
    errors: dict[str, FloatArray] = {
        group_name(robot, label): np.asarray(measured["tracking_error"])[i, :, robot - 1]
        for i, label in enumerate(trials.labels)
        for robot in (1, 2)
    }
    against = compare_with_baseline(errors, trials, chosen)
    every_pair = {
        robot: list(combinations([group_name(robot, label) for label in trials.labels], 2))
        for robot in (1, 2)
    }
    used = trials.time[trials.time >= trials.discard - 1e-9]
    return {
        "schema": "telespring analysis 1",
        "analysed": {
            "from": float(used[0]),
            "to": float(used[-1]),
            "discard": trials.discard,
            "sample_period": float(np.median(np.diff(trials.time))),
        },
        "baseline": {
            "condition": chosen,
            "te2_median": None if chosen is None else describe(errors[group_name(2, chosen)])["median"],
        },
        "table1": table1(errors, trials, against),
        "kruskal_wallis": _group_tests(errors, trials, chosen),
        "wilcoxon": {
            "baseline": _family(
                "TE1 and TE2 in every condition against TE2 in the baseline",
                [found.to_json() for found in against.values()],
            ),
            "robots": _family(
                "TE1 against TE2 in every condition",
                _pairs([(group_name(1, label), group_name(2, label)) for label in trials.labels], errors),
            ),
            **{
                f"te{robot}_pairs": _family(f"TE{robot}, every pair of conditions", _pairs(pairs, errors))
                for robot, pairs in every_pair.items()
            },
        },
        "conditions": _conditions(trials, measured),
        "warnings": doubts(trials),
    }


def _family(words: str, comparisons: list[dict[str, Any]]) -> dict[str, Any]:
    return {"family": words, "size": len(comparisons), "comparisons": comparisons}


def _pairs(pairs: list[tuple[str, str]], errors: Mapping[str, FloatArray]) -> list[dict[str, Any]]:
    return [found.to_json() for found in compare_pairs(pairs, errors)]


def _group_tests(
    errors: Mapping[str, FloatArray], trials: Trials, baseline: str | None
) -> list[dict[str, Any]]:
    stiffnesses = sorted({float(k) for k in trials.stiffness if np.isfinite(k)})
    asked: list[tuple[str, str, int, list[str]]] = [
        ("all conditions", "TE1 and TE2 over all conditions", robot, list(trials.labels)) for robot in (1, 2)
    ]
    for robot in (1, 2):
        family = f"TE{robot} per stiffness, with and without the baseline"
        for stiffness in stiffnesses:
            same = [label for label, k in zip(trials.labels, trials.stiffness, strict=True) if k == stiffness]
            words = f"{stiffness:.4g} N/m"
            if baseline is not None and baseline not in same:
                asked.append((f"{words} and {baseline}", family, robot, [baseline, *same]))
            if len(same) > 1:
                asked.append((words, family, robot, same))
    found: list[GroupTest] = [
        kruskal_wallis({group_name(robot, label): errors[group_name(robot, label)] for label in labels})
        for _, _, robot, labels in asked
    ]
    rows = [
        {"over": over, "robot": robot, "family": family, **test.to_json()}
        for (over, family, robot, _), test in zip(asked, found, strict=True)
    ]
    for family in {row["family"] for row in rows}:
        members = [row for row in rows if row["family"] == family]
        for row, p_value in zip(members, holm([each["p"] for each in members]), strict=True):
            row["p_holm"] = p_value
    return rows


def _conditions(trials: Trials, measured: xr.Dataset) -> list[dict[str, Any]]:
    rows = []
    for i, label in enumerate(trials.labels):
        endings, counts = np.unique(trials.status[i], return_counts=True)
        row: dict[str, Any] = {
            "condition": label,
            "stiffness": finite_or_none(trials.stiffness[i]),
            "delay": finite_or_none(trials.delay[i]),
            "status": dict(zip(endings.tolist(), counts.tolist(), strict=True)),
            "measures": {},
        }
        for name, unit in _MEASURES.items():
            if name in measured.variables:
                values = np.asarray(measured[name])[i]
                row["measures"][name] = {
                    "unit": unit,
                    **{
                        f"robot{robot + 1}": {
                            **describe(values[:, robot]),
                            "values": [finite_or_none(value) for value in values[:, robot]],
                        }
                        for robot in range(2)
                    },
                }
        rows.append(row)
    return rows
