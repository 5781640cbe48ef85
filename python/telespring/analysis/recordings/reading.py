"""Read trials that a lab recorded: one CSV file per trial and one that lists them."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.analysis.recordings.checks import (
    TrialFile,
    number_of,
    read_index,
    read_trial,
    refuse,
    whole_number_of,
)
from telespring.analysis.recordings.layout import (
    AXES,
    INDEX,
    QUANTITIES,
    SI,
    TARGET,
)
from telespring.study.conditions import condition_label
from telespring.study.target import target_positions

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["read_recorded", "target_of"]


def read_recorded(path: str | os.PathLike[str], task: Mapping[str, Any] | None = None) -> xr.Dataset:
    """Read recorded trials into the layout of a rehearsal.

    Parameters
    ----------
    path : path
        A folder that holds ``trials.csv``, or that file.
    task : mapping, optional
        A study's task, from which the target is computed where the files have none.

    Returns
    -------
    xarray.Dataset
        As `telespring.analysis.take_trials` wants it: conditions in the order in which the list names
        them first, trials by their number. Trials whose samples lie at the same times are taken as they
        are. Else all are put on one grid by straight lines between samples, and
        ``attrs["resampled_to"]`` is its period, s.

    Raises
    ------
    telespring.InvalidInput
        Where a column is missing, a unit seems wrong, a trial is listed twice, time does not increase,
        or a value is not a number.
    OSError
        Where a file cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> from telespring.analysis import write_template
    >>> index = write_template(tempfile.mkdtemp() + "/lab")
    >>> read_recorded(index).condition.values.tolist()
    ['UM', 'CM-36-167']
    """
    place = Path(path)
    index = place / INDEX if place.is_dir() else place
    rows = read_index(index)
    trials = [read_trial(index.parent, row) for row in rows]
    _refuse_mixed(trials)
    trials, period = _on_one_grid(trials)
    return _dataset(trials, rows, task, period, index.parent)


def target_of(task: Mapping[str, Any], time: FloatArray) -> FloatArray:
    """Compute the target of a study's task, as `telespring.study.target.target_positions` does.

    Raises
    ------
    telespring.InvalidInput
        Where the task is a program: that alone knows its target.

    Examples
    --------
    >>> import numpy as np
    >>> task = {"kind": "figure-eight", "amplitude": [0.05, 0.1], "angular_frequency": np.pi}
    >>> target_of(task, np.array([0.0, 0.25])).round(4).tolist()
    [[0.0, 0.0], [0.05, 0.0707]]
    """
    kind = task.get("kind", "figure-eight")
    if kind != "figure-eight":
        raise InvalidInput(
            "task.kind",
            str(kind),
            "only the target of a figure-eight can be computed for recorded trials",
            f"Record the target itself, in the columns {' and '.join(TARGET)}.",
        )
    return target_positions(task, time)


def _refuse_mixed(trials: list[TrialFile]) -> None:
    first = trials[0]
    for trial in trials[1:]:
        for quantity in {*first.series} ^ {*trial.series}:
            having, lacking = (first, trial) if quantity in first.series else (trial, first)
            refuse(
                f"{lacking.file}: {quantity}",
                "missing",
                f"{having.file} has it, and all trials must have the same columns",
                f"Add it here, or take all columns {quantity}_... away from the others.",
            )


def _on_one_grid(trials: list[TrialFile]) -> tuple[list[TrialFile], float | None]:
    """Take trials as they are where they share their times, else put them on one grid."""
    longest = max((trial.time for trial in trials), key=len)
    step = float(np.median(np.diff(longest)))
    if all(np.allclose(each.time, longest[: len(each.time)], rtol=0.0, atol=1e-6 * step) for each in trials):
        return trials, None
    period = float(np.median(np.concatenate([np.diff(trial.time) for trial in trials])))
    begin = max(trial.time[0] for trial in trials)
    placed = []
    for trial in trials:
        count = math.floor((trial.time[-1] - begin) / period + 1e-9) + 1
        if count < 2:
            refuse(trial.file, f"ends at {trial.time[-1]:g} s", f"others begin at {begin:g} s only")
        time = begin + period * np.arange(count)
        series = {
            name: np.stack(
                [np.interp(time, trial.time, column) for column in values.reshape(len(values), -1).T], axis=-1
            ).reshape(count, *values.shape[1:])
            for name, values in trial.series.items()
        }
        placed.append(TrialFile(trial.file, trial.key, trial.number, trial.row, time, series))
    return placed, period


def _dataset(
    trials: list[TrialFile],
    rows: list[dict[str, str]],
    task: Mapping[str, Any] | None,
    period: float | None,
    folder: Path,
) -> xr.Dataset:
    import xarray as xr

    # NaN equals nothing, so that conditions are told apart by their text.
    keys = list(dict.fromkeys(repr(trial.key) for trial in trials))
    groups = [
        sorted((trial for trial in trials if repr(trial.key) == key), key=lambda trial: trial.number)
        for key in keys
    ]
    labels = [condition_label(*group[0].key) for group in groups]
    if len(set(labels)) < len(labels):
        labels = [
            "UM" if math.isnan(k) else f"CM-{k:.6g}-{1e3 * d:.6g}" for k, d in (g[0].key for g in groups)
        ]
    time = max((trial.time for trial in trials), key=len)
    shape = (len(groups), max(len(group) for group in groups))
    quantities = [name for name in QUANTITIES if name in trials[0].series]
    arrays = {name: np.full((*shape, len(time), 2, 2), np.nan) for name in quantities}
    goals = np.full((*shape, len(time), 2), np.nan)
    status = np.full(shape, "absent", dtype=object)
    samples = np.full(shape, 0)
    for i, group in enumerate(groups):
        for j, trial in enumerate(group):
            count = samples[i, j] = len(trial.time)
            status[i, j] = trial.row.get("status") or "completed"
            for name in quantities:
                arrays[name][i, j, :count] = trial.series[name]
            if "target" in trial.series:
                goals[i, j, :count] = trial.series["target"]
    per_sample = ("condition", "trial", "time", "robot", "axis")
    variables: dict[str, Any] = {
        name: (per_sample, values, {"units": SI[QUANTITIES[name]]}) for name, values in arrays.items()
    }
    variables["target"] = _target(trials, goals, task, time)
    variables["status"] = (("condition", "trial"), status.astype(str))
    if np.any((status == "completed") & (samples < len(time))):
        variables["samples"] = (("condition", "trial"), samples)
    for column, name, kind in (("ended_at_s", "ended_at", float), ("seed", "seed", np.uint64)):
        if column in rows[0]:
            values = np.full(shape, np.nan if kind is float else 0, dtype=kind)
            for i, group in enumerate(groups):
                for j, trial in enumerate(group):
                    where = f"{trial.file}: {column}"
                    text = trial.row[column]
                    if kind is not float and not text:
                        refuse(
                            where,
                            "empty",
                            "a whole number from 0 in every line, or no such column, is needed",
                            f"Take the column {column} out of {INDEX}: trials of people have no seed.",
                        )
                    if kind is not float:
                        values[i, j] = np.uint64(whole_number_of(text, where))
                    elif text:
                        values[i, j] = number_of(text, where)
            variables[name] = (("condition", "trial"), values, {"units": "s"} if kind is float else {})
    attributes: dict[str, Any] = {}
    if "discard_s" in rows[0]:
        told = {row["discard_s"] for row in rows}
        if len(told) > 1:
            refuse(f"{INDEX}: discard_s", " and ".join(sorted(told)), "one value for all trials is needed")
        attributes["discard"] = number_of(told.pop(), f"{INDEX}: discard_s")
    if period is not None:
        attributes["resampled_to"] = period
    study = folder / "study.toml"
    if study.is_file():
        attributes["study"] = study.read_text(encoding="utf-8")
    return xr.Dataset(
        variables,
        coords={
            "condition": ("condition", labels),
            "stiffness": ("condition", [group[0].key[0] for group in groups], {"units": "N/m"}),
            "delay": ("condition", [group[0].key[1] for group in groups], {"units": "s"}),
            "trial": ("trial", np.arange(1, shape[1] + 1)),
            "time": ("time", time, {"units": "s"}),
            "robot": ("robot", [1, 2]),
            "axis": ("axis", list(AXES)),
        },
        attrs=attributes,
    )


def _target(
    trials: list[TrialFile], goals: FloatArray, task: Mapping[str, Any] | None, time: FloatArray
) -> tuple[tuple[str, ...], FloatArray, dict[str, str]]:
    units = {"units": "m"}
    if "target" not in trials[0].series:
        if task is None:
            refuse(
                f"{trials[0].file}: {TARGET[0]}",
                "missing",
                f"the columns {' and '.join(TARGET)} are needed, or a study whose task is the target",
                "Add them, or give the study by --study.",
            )
        return ("time", "axis"), target_of(task, time), units
    shared = max((trial.series["target"] for trial in trials), key=len)
    if all(np.array_equal(trial.series["target"], shared[: len(trial.time)]) for trial in trials):
        return ("time", "axis"), shared, units
    return ("condition", "trial", "time", "axis"), goals, units
