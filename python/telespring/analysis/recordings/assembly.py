"""Assemble recorded trials into one dataset like a rehearsal's, resampled where sample times differ."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._errors import InvalidInput
from telespring._quantities import format_number
from telespring._types import FloatArray
from telespring.analysis.recordings.checks import refuse
from telespring.analysis.recordings.layout import AXES, QUANTITIES, SI, TARGET
from telespring.study.conditions import condition_labels
from telespring.study.target import target_positions

if TYPE_CHECKING:
    import xarray as xr

    from telespring.model import Task

__all__ = ["RecordedTrial", "TrialEntry", "assemble_dataset"]


@dataclass(frozen=True)
class TrialEntry:
    """A line of the list of trials: stiffness in N/m (None unconnected), times in s.

    `ended_at` (NaN if empty), `seed`, `discard` and `dyad` are None if the list has no such column. `place`
    names the line.
    """

    file: str
    stiffness: float | None
    delay: float
    number: int
    status: str
    ended_at: float | None = None
    seed: int | None = None
    discard: float | None = None
    dyad: str | None = None
    place: str = ""

    @property
    def condition(self) -> tuple[float | None, float]:
        """Stiffness and delay, which identify the condition."""
        return self.stiffness, self.delay


@dataclass(frozen=True, eq=False)
class RecordedTrial:
    """One recorded trial: its line in the list, its times (s) and its series by quantity."""

    entry: TrialEntry
    time: FloatArray
    series: dict[str, FloatArray]


def assemble_dataset(
    trials: list[RecordedTrial], task: Task | Mapping[str, Any] | None, study: str | None
) -> xr.Dataset:
    """Assemble recorded trials, in the order of the list, into one dataset over conditions and trials.

    `task` is a study's, for trials without a target; `study` the text of the study file, if there is one.
    """
    import xarray as xr

    _check_same_recorded_quantities(trials)
    trials, period = _resample_recorded_trials(trials)
    conditions = list(dict.fromkeys(trial.entry.condition for trial in trials))
    placed, labels = _place_trials(trials, conditions)
    time = max((trial.time for trial in trials), key=len)
    shape = (len(conditions), 1 + max(j for _, j, _ in placed))
    series = {
        name: np.full((*shape, len(time), *values.shape[1:]), np.nan)
        for name, values in trials[0].series.items()
    }
    status = np.full(shape, "absent", dtype=object)
    samples = np.full(shape, 0)
    for i, j, trial in placed:
        count = samples[i, j] = len(trial.time)
        status[i, j] = trial.entry.status
        for name, values in trial.series.items():
            series[name][i, j, :count] = values
    per_sample = ("condition", "trial", "time", "robot", "axis")
    per_trial = ("condition", "trial")
    variables: dict[str, Any] = {
        name: (per_sample, series[name], {"units": SI[unit]})
        for name, unit in QUANTITIES.items()
        if name in series
    }
    variables["target"] = _recorded_target(trials, series.get("target"), task, time)
    variables["status"] = (per_trial, status.astype(str))
    if np.any((status == "completed") & (samples < len(time))):
        variables["samples"] = (per_trial, samples)
    files = np.full(shape, "", dtype=object)
    for i, j, trial in placed:
        files[i, j] = trial.entry.file
    variables["file"] = (per_trial, files.astype(str))
    first = trials[0].entry
    if first.ended_at is not None:
        ended_at = np.full(shape, np.nan)
        for i, j, trial in placed:
            ended_at[i, j] = trial.entry.ended_at
        variables["ended_at"] = (per_trial, ended_at, {"units": "s"})
    if first.seed is not None:
        seeds = np.zeros(shape, dtype=np.uint64)
        for i, j, trial in placed:
            seeds[i, j] = trial.entry.seed or 0
        variables["seed"] = (per_trial, seeds)
    if first.dyad is not None:
        dyads = np.full(shape, "", dtype=object)
        for i, j, trial in placed:
            dyads[i, j] = trial.entry.dyad
        variables["dyad"] = (per_trial, dyads.astype(str))
    if labels is None:
        numbers = np.zeros(shape, dtype=int)
        for i, j, trial in placed:
            numbers[i, j] = trial.entry.number
        variables["trial_number"] = (per_trial, numbers)
    attributes = {"discard": first.discard, "resampled_to": period, "study": study}
    return xr.Dataset(
        variables,
        coords={
            "condition": ("condition", condition_labels(conditions)),
            "stiffness": (
                "condition",
                [math.nan if stiffness is None else stiffness for stiffness, _ in conditions],
                {"units": "N/m"},
            ),
            "delay": ("condition", [delay for _, delay in conditions], {"units": "s"}),
            **({} if labels is None else {"trial": ("trial", labels)}),
            "time": ("time", time, {"units": "s"}),
            "robot": ("robot", [1, 2]),
            "axis": ("axis", list(AXES)),
        },
        attrs={name: value for name, value in attributes.items() if value is not None},
    )


def _place_trials(
    trials: list[RecordedTrial], conditions: list[tuple[float | None, float]]
) -> tuple[list[tuple[int, int, RecordedTrial]], list[int] | None]:
    """Place every trial in the grid of conditions and trials; also return the labels of its columns.

    A column has the trials of one number. If that leaves half of the grid empty or more, because the
    conditions number their trials differently, or if dyads repeat a number, the trials of a condition are
    side by side in the order of their numbers, and the columns have no labels.
    """
    numbers = sorted({trial.entry.number for trial in trials})
    occupied = {(trial.entry.condition, trial.entry.number) for trial in trials}
    if len(occupied) == len(trials) and len(conditions) * len(numbers) < 2 * len(trials):
        placed = [
            (conditions.index(trial.entry.condition), numbers.index(trial.entry.number), trial)
            for trial in trials
        ]
        return sorted(placed, key=lambda place: place[:2]), numbers
    placed = []
    for i, condition in enumerate(conditions):
        group = [trial for trial in trials if trial.entry.condition == condition]
        group.sort(key=lambda trial: (trial.entry.dyad or "", trial.entry.number))
        placed += [(i, j, trial) for j, trial in enumerate(group)]
    return placed, None


def _check_same_recorded_quantities(trials: list[RecordedTrial]) -> None:
    first = trials[0]
    for trial in trials[1:]:
        for quantity in {*first.series} ^ {*trial.series}:
            having, lacking = (first, trial) if quantity in first.series else (trial, first)
            refuse(
                f"{lacking.entry.file}: {quantity}",
                "missing",
                f"all trials must have the same columns, and {having.entry.file} has this one",
                f"Add it here, or remove the columns {quantity}_... from all other trials.",
            )


def _resample_recorded_trials(trials: list[RecordedTrial]) -> tuple[list[RecordedTrial], float | None]:
    """Resample trials by linear interpolation, unless they share their times; also return the period, s."""
    longest = max((trial.time for trial in trials), key=len)
    step = float(np.median(np.diff(longest)))
    if all(
        np.allclose(trial.time, longest[: len(trial.time)], rtol=0.0, atol=1e-6 * step) for trial in trials
    ):
        return trials, None
    period = float(np.median(np.concatenate([np.diff(trial.time) for trial in trials])))
    begin = max(trial.time[0] for trial in trials)
    resampled = []
    for trial in trials:
        count = math.floor((trial.time[-1] - begin) / period + 1e-9) + 1
        if count < 2:
            refuse(
                trial.entry.file,
                f"ends at {format_number(trial.time[-1], 6)} s",
                f"trials must overlap in time, but others begin only at {format_number(begin, 6)} s",
                "Remove this trial, or record all trials from their start.",
            )
        time = begin + period * np.arange(count)
        series = {
            name: np.stack(
                [np.interp(time, trial.time, column) for column in values.reshape(len(values), -1).T], axis=-1
            ).reshape(count, *values.shape[1:])
            for name, values in trial.series.items()
        }
        resampled.append(replace(trial, time=time, series=series))
    return resampled, period


def _recorded_target(
    trials: list[RecordedTrial],
    targets: FloatArray | None,
    task: Task | Mapping[str, Any] | None,
    time: FloatArray,
) -> tuple[tuple[str, ...], FloatArray, dict[str, str]]:
    """Choose the target: one for all trials, recorded or from the task, or one per trial."""
    units = {"units": "m"}
    if targets is None:
        if task is None:
            refuse(
                f"{trials[0].entry.file}: {TARGET[0]}",
                "missing",
                f"the columns {' and '.join(TARGET)} are required, or a study whose task defines the target",
                "Add them, or name the study: --study as an option, in Python task=study.experiment.task.",
            )
        try:
            positions = target_positions(task, time)
        except InvalidInput as refused:
            refuse(
                refused.field,
                refused.value,
                refused.allowed,
                f"Record the target itself, in the columns {' and '.join(TARGET)}.",
            )
        return ("time", "axis"), positions, units
    shared = max((trial.series["target"] for trial in trials), key=len)
    if all(np.array_equal(trial.series["target"], shared[: len(trial.time)]) for trial in trials):
        return ("time", "axis"), shared, units
    return ("condition", "trial", "time", "axis"), targets, units
