"""The whole analysis of an experiment as plain values, the contents of `analysis.json`."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._json import finite_or_none
from telespring._types import FloatArray
from telespring.analysis.measures import MEASURES, measure_trials
from telespring.analysis.plausibility import ShortTrial, StillHandle, implausible_trials
from telespring.analysis.statistics import compare_pairs, holm, kruskal_wallis
from telespring.analysis.table import (
    choose_baseline,
    compare_with_baseline,
    mean_sd_median,
    table_1_rows,
    tracking_error_name,
)
from telespring.analysis.trials import Trials

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["analyse_trials", "compare_conditions"]

#: Measures that are summarised per condition.
_SUMMARISED = tuple(name for name in MEASURES if name != "lag_correlation")


def analyse_trials(
    dataset: xr.Dataset, discard: float | None = None, baseline: str | None = None
) -> dict[str, Any]:
    """Measure all trials of an experiment and compare its conditions.

    Parameters
    ----------
    dataset : xarray.Dataset
        Trials in the layout that `telespring.analysis.Trials.from_dataset` describes.
    discard : float, optional
        Duration to leave out at the start of every trial, s. Default: as recorded in the dataset.
    baseline : str, optional
        Condition whose TE2 is the reference of every comparison. Default: the unconnected mode.

    Returns
    -------
    dict
        The contents of `analysis.json` in SI units (Table I in mm); docs/recorded-trials.md lists its keys.

    Raises
    ------
    telespring.InvalidInput
        If the dataset does not hold such trials, or no condition has the baseline's name.

    Notes
    -----
    Holm's correction covers one family at a time, and the result states each family: all comparisons with
    the baseline (TE1 and TE2 together, as they share one table); all pairs of conditions, per robot; TE1
    against TE2 in every condition; the Kruskal-Wallis tests per stiffness, with and without the baseline,
    per robot; and the two Kruskal-Wallis tests over all conditions.
    """
    return compare_conditions(Trials.from_dataset(dataset, discard), baseline)


def compare_conditions(trials: Trials, baseline: str | None = None) -> dict[str, Any]:
    """Measure trials and compare their conditions; see `analyse_trials`."""
    measured = measure_trials(trials)
    baseline = choose_baseline(trials, baseline)
    errors: dict[str, FloatArray] = {
        tracking_error_name(robot, label): np.asarray(measured["tracking_error"])[i, :, robot - 1]
        for i, label in enumerate(trials.labels)
        for robot in (1, 2)
    }
    with_baseline = compare_with_baseline(errors, trials, baseline)
    reference_median = (
        None if baseline is None else mean_sd_median(errors[tracking_error_name(2, baseline)])["median"]
    )
    same_condition = [
        (tracking_error_name(1, label), tracking_error_name(2, label)) for label in trials.labels
    ]
    analysed = trials.time[trials.time >= trials.discard - 1e-9]
    return {
        "schema": "telespring analysis 1",
        "analysed": {
            "from": float(analysed[0]),
            "to": float(analysed[-1]),
            "discard": trials.discard,
            "sample_period": trials.sample_period,
        },
        "baseline": {"condition": baseline, "te2_median": reference_median},
        "table1": table_1_rows(errors, trials, with_baseline),
        "kruskal_wallis": _kruskal_wallis_tests(errors, trials, baseline),
        "wilcoxon": {
            "baseline": _holm_family(
                "TE1 and TE2 in every condition against TE2 in the baseline",
                [comparison.to_json() for comparison in with_baseline.values()],
            ),
            "robots": _holm_pair_family("TE1 against TE2 in every condition", same_condition, errors),
            **{
                f"te{robot}_pairs": _holm_pair_family(
                    f"TE{robot}, every pair of conditions",
                    list(combinations([tracking_error_name(robot, label) for label in trials.labels], 2)),
                    errors,
                )
                for robot in (1, 2)
            },
        },
        "conditions": _condition_summaries(trials, measured),
        "warnings": [_implausible_trial_warning(implausible) for implausible in implausible_trials(trials)],
    }


def _holm_family(description: str, comparisons: list[dict[str, Any]]) -> dict[str, Any]:
    return {"family": description, "size": len(comparisons), "comparisons": comparisons}


def _holm_pair_family(
    description: str, pairs: list[tuple[str, str]], errors: Mapping[str, FloatArray]
) -> dict[str, Any]:
    return _holm_family(description, [comparison.to_json() for comparison in compare_pairs(pairs, errors)])


def _kruskal_wallis_tests(
    errors: Mapping[str, FloatArray], trials: Trials, baseline: str | None
) -> list[dict[str, Any]]:
    """Test TE1 and TE2 over all conditions, and per stiffness with and without the baseline."""
    rows: list[dict[str, Any]] = []

    def add(over: str, robot: int, family: str, labels: list[str]) -> None:
        names = [tracking_error_name(robot, label) for label in labels]
        test = kruskal_wallis({name: errors[name] for name in names})
        rows.append({"over": over, "robot": robot, "family": family, **test.to_json()})

    for robot in (1, 2):
        add("all conditions", robot, "TE1 and TE2 over all conditions", list(trials.labels))
    for robot in (1, 2):
        family = f"TE{robot} per stiffness, with and without the baseline"
        for stiffness in sorted({float(k) for k in trials.stiffness if np.isfinite(k)}):
            same = [label for label, k in zip(trials.labels, trials.stiffness, strict=True) if k == stiffness]
            over = f"{stiffness:.4g} N/m"
            if baseline is not None and baseline not in same:
                add(f"{over} and {baseline}", robot, family, [baseline, *same])
            if len(same) > 1:
                add(over, robot, family, same)
    for family in {row["family"] for row in rows}:
        members = [row for row in rows if row["family"] == family]
        for row, p_holm in zip(members, holm([row["p"] for row in members]), strict=True):
            row["p_holm"] = p_holm
    return rows


def _condition_summaries(trials: Trials, measured: xr.Dataset) -> list[dict[str, Any]]:
    """Summarise every condition: how its trials ended, and its measures by robot and trial."""
    rows = []
    for i, label in enumerate(trials.labels):
        endings, counts = np.unique(trials.status[i], return_counts=True)
        measures: dict[str, Any] = {}
        for name in _SUMMARISED:
            if name in measured.variables:
                values = np.asarray(measured[name])[i]
                measures[name] = {"unit": MEASURES[name][0]} | {
                    f"robot{robot + 1}": {
                        **mean_sd_median(values[:, robot]),
                        "values": [finite_or_none(value) for value in values[:, robot]],
                    }
                    for robot in range(2)
                }
        rows.append(
            {
                "condition": label,
                "stiffness": finite_or_none(trials.stiffness[i]),
                "delay": finite_or_none(trials.delay[i]),
                "status": dict(zip(endings.tolist(), counts.tolist(), strict=True)),
                "measures": measures,
            }
        )
    return rows


def _implausible_trial_warning(implausible: ShortTrial | StillHandle) -> str:
    """Write the sentence that `analysis.json` holds for a trial that looks cut off or stuck."""
    trial = f"Trial {implausible.trial} of {implausible.condition}"
    if isinstance(implausible, ShortTrial):
        return (
            f"{trial} counts as completed after {implausible.duration:.4g} s, although "
            f"{implausible.usual_duration:.4g} s is usual: if it was cut off, set its status to stopped."
        )
    period = "throughout" if implausible.since is None else f"from {implausible.since:.4g} s to its end"
    return (
        f"{trial}: the handle of robot {implausible.robot} does not move {period}, but is analysed as if it "
        "had followed the target."
    )
