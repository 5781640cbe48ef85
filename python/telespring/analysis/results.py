"""The whole analysis of an experiment as plain values, the contents of `analysis.json`."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._json import finite_or_none
from telespring._quantities import format_time
from telespring._types import FloatArray
from telespring.analysis.copies import find_same_recordings
from telespring.analysis.dyads import dyad_means
from telespring.analysis.group_tests import kruskal_wallis
from telespring.analysis.measures import MEASURES, measure_trials
from telespring.analysis.plausibility import implausible_trials
from telespring.analysis.plausibility_messages import implausible_trial_warning
from telespring.analysis.statistics import holm
from telespring.analysis.table import choose_baseline, compare_with_baseline, mean_sd_median, table_1_rows
from telespring.analysis.tracking_errors import TrackingErrors, group_tracking_errors, tracking_error_name
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
    A trial that repeats another one of its condition to the nanometre counts once, per robot. If the data
    name several dyads, a dyad counts once: its value in a condition is the mean of its trials.

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
    tracking_error = np.asarray(measured["tracking_error"])
    errors = group_tracking_errors(trials, tracking_error)
    with_baseline = compare_with_baseline(errors, trials, baseline)
    reference_median = (
        None
        if baseline is None
        else mean_sd_median(errors.independent_values(tracking_error_name(2, baseline)))["median"]
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
            "simulated": trials.is_simulated,
            "unit": "trial" if errors.dyads is None else "dyad",
            "dyads": _dyad_labels(trials),
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
        "conditions": _condition_summaries(trials, measured, errors),
        "warnings": [
            *_label_warnings(trials),
            *_same_recording_warnings(trials, tracking_error, errors),
            *(implausible_trial_warning(implausible) for implausible in implausible_trials(trials)),
        ],
    }


def _holm_family(description: str, comparisons: list[dict[str, Any]]) -> dict[str, Any]:
    return {"family": description, "size": len(comparisons), "comparisons": comparisons}


def _holm_pair_family(
    description: str, pairs: list[tuple[str, str]], errors: TrackingErrors
) -> dict[str, Any]:
    return _holm_family(description, [comparison.to_json() for comparison in errors.compare(pairs)])


def _kruskal_wallis_tests(
    errors: TrackingErrors, trials: Trials, baseline: str | None
) -> list[dict[str, Any]]:
    """Test TE1 and TE2 over all conditions, and per stiffness with and without the baseline."""
    rows: list[dict[str, Any]] = []

    def add(over: str, robot: int, family: str, labels: list[str]) -> None:
        names = [tracking_error_name(robot, label) for label in labels]
        dyads = None if errors.dyads is None else {name: errors.dyads[name] for name in names}
        test = kruskal_wallis({name: errors.values[name] for name in names}, dyads)
        rows.append({"over": over, "robot": robot, "family": family, **test.to_json()})

    for robot in (1, 2):
        add("all conditions", robot, "TE1 and TE2 over all conditions", list(trials.labels))
    for robot in (1, 2):
        family = f"TE{robot} per stiffness, with and without the baseline"
        for stiffness, over in _stiffness_names(trials).items():
            same = [label for label, k in zip(trials.labels, trials.stiffness, strict=True) if k == stiffness]
            if baseline is not None and baseline not in same:
                add(f"{over} and {baseline}", robot, family, [baseline, *same])
            if len(same) > 1:
                add(over, robot, family, same)
    for family in {row["family"] for row in rows}:
        members = [row for row in rows if row["family"] == family]
        for row, p_holm in zip(members, holm([row["p"] for row in members]), strict=True):
            row["p_holm"] = p_holm
    return rows


def _stiffness_names(trials: Trials) -> dict[float, str]:
    """Name every stiffness of the experiment, with as many digits as tell them apart."""
    values = sorted({float(k) for k in trials.stiffness if np.isfinite(k)})
    names: list[str] = []
    for digits in range(4, 18):
        names = [f"{value:.{digits}g} N/m" for value in values]
        if len(set(names)) == len(values):
            break
    return dict(zip(values, names, strict=True))


def _dyad_labels(trials: Trials) -> list[str] | None:
    """List the labels of all dyads; None if the data name none."""
    if trials.dyads is None:
        return None
    labels = np.unique(trials.dyads[trials.status != "absent"])
    return [str(label) for label in labels]


def _condition_summaries(
    trials: Trials, measured: xr.Dataset, errors: TrackingErrors
) -> list[dict[str, Any]]:
    """Summarise every condition: how its trials ended, and its measures by robot and trial.

    Means, deviations and medians leave out copies, and are over the dyads' means if there are several dyads;
    the values of all trials are listed.
    """

    def summary(values: FloatArray, copies: NDArray[np.bool_], condition: int) -> dict[str, Any]:
        distinct = np.where(copies, np.nan, values)
        by_dyad = None
        if errors.dyads is not None and trials.dyads is not None:
            by_dyad = dyad_means(distinct, trials.dyads[condition])
        return {
            **mean_sd_median(distinct if by_dyad is None else np.array(list(by_dyad.values()))),
            "dyad_means": by_dyad,
            "values": [finite_or_none(value) for value in values],
        }

    rows = []
    for i, label in enumerate(trials.labels):
        endings, counts = np.unique(trials.status[i], return_counts=True)
        measures: dict[str, Any] = {}
        for name in _SUMMARISED:
            if name in measured.variables:
                values = np.asarray(measured[name])[i]
                measures[name] = {"unit": MEASURES[name][0]} | {
                    f"robot{robot + 1}": summary(values[:, robot], errors.copies[i, :, robot], i)
                    for robot in range(2)
                }
        rows.append(
            {
                "condition": label,
                "stiffness": finite_or_none(trials.stiffness[i]),
                "delay": finite_or_none(trials.delay[i]),
                "trials": [
                    None if status == "absent" else number.item()
                    for number, status in zip(trials.numbers[i], trials.status[i], strict=True)
                ],
                "dyads": None if trials.dyads is None else [str(dyad) or None for dyad in trials.dyads[i]],
                "status": dict(zip(endings.tolist(), counts.tolist(), strict=True)),
                "measures": measures,
            }
        )
    return rows


def _label_warnings(trials: Trials) -> list[str]:
    """Warn of conditions that are the same, and of trials that cannot be told apart by their numbers."""
    warnings = []
    unconnected = [i for i, k in enumerate(trials.stiffness) if np.isnan(k)]
    if len(unconnected) > 1:
        names = ", ".join(trials.labels[i] for i in unconnected)
        delays = ", ".join(format_time(trials.delay[i]) for i in unconnected)
        warnings.append(
            f"{names}: all are unconnected, with the delays {delays}. Without a spring a delay changes "
            "nothing; with the same delay they would be one condition."
        )
    settings = [(float(k), float(delay)) for k, delay in zip(trials.stiffness, trials.delay, strict=True)]
    for setting in dict.fromkeys(settings):
        same = [label for label, each in zip(trials.labels, settings, strict=True) if each == setting]
        if len(same) > 1:
            warnings.append(
                f"{', '.join(same)}: stiffness and delay are the same, but are listed separately."
            )
    for i, label in enumerate(trials.labels):
        present = np.flatnonzero(trials.status[i] != "absent").tolist()
        names_of_trials = [trials.trial_number(i, trial) for trial in present]
        repeated = sorted({name for name in names_of_trials if names_of_trials.count(name) > 1})
        if repeated:
            warnings.append(
                f"{label}: {len(repeated)} trial {'number' if len(repeated) == 1 else 'numbers'} "
                f"({', '.join(repeated[:3])}{', …' if len(repeated) > 3 else ''}) occur more than once, so "
                "these trials cannot be told apart by number."
            )
    return warnings


def _same_recording_warnings(trials: Trials, errors: FloatArray, grouped: TrackingErrors) -> list[str]:
    """Warn of trials of different conditions in which both robots move alike."""
    return [
        f"T{trials.trial_name(*one)[1:]} and {trials.trial_name(*other)} are alike to the nanometre: one "
        "recording listed twice, or conditions that make no difference."
        for one, other in find_same_recordings(trials, errors, grouped.copies)
    ]
