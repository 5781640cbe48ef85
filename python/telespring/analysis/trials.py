"""Trials of an experiment as checked arrays: status, analysed samples, positions, target and forces."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._quantities import format_count, format_number
from telespring._types import FloatArray
from telespring.analysis.identifiers import (
    TrialNames,
    condition_names,
    trial_dyads,
    trial_files,
    trial_numbers,
)
from telespring.analysis.layout import PER_TRIAL, check_layout, refuse_trials, trial_statuses

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Trials"]

#: The discarded part may end this fraction of a sample after a sample that is still kept, for rounding.
_ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class Trials:
    """All trials of an experiment as arrays, in the order condition, trial, time, robot, axis.

    Attributes
    ----------
    labels
        Names of the conditions, such as "UM" or "CM-36-167", each different.
    stiffness
        N/m per condition, NaN in the unconnected mode.
    delay
        One-way delay, s, per condition.
    numbers
        (condition, trial): the number or label of every trial, as the data have it.
    trial
        The labels of the dimension ``trial``; None where it has none.
    has_numbers
        Whether the data number their trials one by one, in ``trial_number``.
    dyads
        (condition, trial): label of the dyad, or None if the data do not say.
    files
        (condition, trial): name of the trial's file, "" where it is not known; None if the data do not say.
    is_simulated
        Whether a simulation made the trials, so that their number was free to choose.
    status
        (condition, trial): "completed"; "absent" if a condition has fewer trials than others; otherwise
        how the trial ended early.
    time
        s from the start of a trial.
    position
        m.
    target
        m, (condition, trial, time, axis); the first two dimensions are 1 if all trials share one target.
    velocity, coupling_force, agent_force
        m/s and N, or None if they were not recorded.
    window
        (condition, trial, time): the analysed samples; none for a trial that was not completed.
    discard
        Duration left out at the start of every trial, s.
    """

    labels: tuple[str, ...]
    stiffness: FloatArray
    delay: FloatArray
    numbers: NDArray[Any]
    trial: NDArray[Any] | None
    has_numbers: bool
    dyads: NDArray[np.str_] | None
    files: NDArray[np.str_] | None
    is_simulated: bool
    status: NDArray[np.str_]
    time: FloatArray
    position: FloatArray
    target: FloatArray
    velocity: FloatArray | None
    coupling_force: FloatArray | None
    agent_force: FloatArray | None
    window: NDArray[np.bool_]
    discard: float

    @property
    def completed(self) -> NDArray[np.bool_]:
        """Which trials were completed, (condition, trial)."""
        return np.asarray(self.status == "completed")

    @property
    def ended_early(self) -> NDArray[np.bool_]:
        """Which trials began but were not completed, (condition, trial)."""
        return np.asarray((self.status != "completed") & (self.status != "absent"))

    @property
    def sample_period(self) -> float:
        """Median time between samples, s."""
        return float(np.median(np.diff(self.time)))

    @property
    def analysed(self) -> NDArray[np.bool_]:
        """The samples of a completed trial of full length that are analysed, (time)."""
        return _after_discard(self.time, self.discard)

    def trial_target(self, condition: int, trial: int) -> FloatArray:
        """Return the target of one trial, (time, axis), m."""
        shared = self.target.shape[:2]
        return np.asarray(self.target[condition % shared[0], trial % shared[1]])

    def trial_number(self, condition: int, trial: int) -> str:
        """Name one trial within its condition by its number and dyad, such as "3" or "3 of dyad B"."""
        return self._names.number(condition, trial)

    def trial_name(self, condition: int, trial: int) -> str:
        """Name one trial, with its file if that is known, such as "trial 3 of UM (um-3.csv)"."""
        return self._names(condition, trial)

    @property
    def _names(self) -> TrialNames:
        return TrialNames(self.labels, self.numbers, self.dyads, self.files)

    @classmethod
    def from_dataset(cls, dataset: xr.Dataset, discard: float | None = None) -> Trials:
        """Check a dataset of trials and lay it out as arrays.

        Parameters
        ----------
        dataset : xarray.Dataset
            ``position`` (m) over (condition, trial, time, robot, axis) with the robots 1 and 2 and the axes
            x and y; ``target`` (m) over (time, axis), and over condition and trial where it differs.
            Optional: ``velocity`` (m/s), ``coupling_force`` and ``agent_force`` (N), shaped as ``position``;
            ``status`` (condition, trial), words or numbers with ``flag_values`` and ``flag_meanings``,
            without which all trials count as completed; ``samples`` (condition, trial) where trials differ
            in length; ``dyad`` or ``participant`` (condition, trial); ``trial_number`` (condition, trial)
            where the dimension ``trial`` has no labels; ``file`` (condition, trial), named in messages.
            Coordinates ``stiffness`` (N/m, NaN unconnected) and ``delay`` (s) over condition, and ``time``
            (s). Repetitions that `xarray.concat` makes, dimensions of one condition or trial that indexing
            drops, and another order of robots and axes are repaired.
        discard : float, optional
            Duration to leave out at the start of every trial, s. Default: the dataset's attribute
            ``discard``, or nothing.

        Returns
        -------
        Trials
            The arrays and the window of analysis.

        Raises
        ------
        telespring.InvalidInput
            If a variable is missing or has other dimensions, another type or unit; a status is unknown; or a
            completed trial has a value that is not a number.
        """
        # Before float32 becomes float64, as its times are that much less exact.
        time_dtype = dataset["time"].dtype if "time" in getattr(dataset, "variables", {}) else None
        dataset = check_layout(dataset)
        time = _trial_times(dataset)
        stiffness, delay = _condition_values(dataset)
        labels = condition_names(dataset, stiffness, delay)
        status = trial_statuses(dataset)
        numbers = trial_numbers(dataset, status)
        dyads = trial_dyads(dataset, status)
        if discard is None:
            discard = _recorded_discard(dataset)
        series = {
            name: _contiguous_signal(dataset[name])
            for name in ("position", "velocity", "coupling_force", "agent_force")
            if name in dataset.variables
        }
        shared = {name: 1 for name in PER_TRIAL if name not in dataset["target"].dims}
        target = _contiguous_signal(
            dataset["target"].expand_dims(shared).transpose(*PER_TRIAL, "time", "axis")
        )
        window = _analysed_trial_samples(dataset, status, time, discard, time_dtype)
        files = trial_files(dataset)
        names = TrialNames(labels, numbers, dyads, files)
        _check_trial_lengths(window, status, names, time, discard, dataset)
        for name, values in {**series, "target": target[..., None, :]}.items():
            _check_trials_finite(name, values, window, names, time)
        return cls(
            labels=labels,
            stiffness=stiffness,
            delay=delay,
            numbers=numbers,
            trial=np.asarray(dataset["trial"]) if "trial" in dataset.coords else None,
            has_numbers="trial_number" in dataset.variables,
            dyads=dyads,
            files=files,
            is_simulated="seed" in dataset.variables
            or str(dataset.attrs.get("schema", "")).startswith("telespring rehearsal"),
            status=status,
            time=time,
            position=series["position"],
            target=target,
            velocity=series.get("velocity"),
            coupling_force=series.get("coupling_force"),
            agent_force=series.get("agent_force"),
            window=window,
            discard=discard,
        )


def _condition_values(dataset: xr.Dataset) -> tuple[FloatArray, FloatArray]:
    """Return stiffness and delay of every condition; a condition without a delay has neither."""
    stiffness, delay = np.asarray(dataset["stiffness"]), np.asarray(dataset["delay"])
    wrong = ~(np.isfinite(delay) & (delay >= 0.0))
    if wrong.any():
        raise refuse_trials(
            "delay",
            f"{delay[wrong][0]:g}",
            "a delay of 0 s or more for every condition is required",
            "Set it, or drop conditions that were not run (a join or reindex adds them).",
        )
    wrong = ~(np.isnan(stiffness) | (np.isfinite(stiffness) & (stiffness > 0.0)))
    if wrong.any():
        raise refuse_trials(
            "stiffness",
            f"{stiffness[wrong][0]:g}",
            "a stiffness above 0 N/m is required, or NaN in the unconnected mode",
            "Correct it.",
        )
    return stiffness, delay


def _recorded_discard(dataset: xr.Dataset) -> float:
    recorded = dataset.attrs.get("discard", 0.0)
    try:
        return float(recorded)
    except (TypeError, ValueError):
        raise refuse_trials(
            "discard", str(recorded), "the attribute must be a time in s", "Correct it, or remove it."
        ) from None


def _trial_times(dataset: xr.Dataset) -> FloatArray:
    time = np.asarray(dataset["time"])
    if len(time) < 2:
        raise InvalidInput(
            "time",
            format_count(len(time), "sample"),
            "trials of two samples or more are required",
            "Record longer trials, or keep more samples per second.",
        )
    steps = np.diff(time)
    if not np.all(steps > 0.0):
        place = int(np.argmax(~(steps > 0.0)))
        raise refuse_trials(
            "time",
            f"{time[place + 1]:.10g} after {time[place]:.10g}",
            "times that increase are required",
            "Sort the samples by time (.sortby('time')), and remove duplicates.",
        )
    return time


def _analysed_trial_samples(
    dataset: xr.Dataset, status: NDArray[np.str_], time: FloatArray, discard: float, dtype: Any
) -> NDArray[np.bool_]:
    """Select the samples of completed trials after the discarded part, (condition, trial, time)."""
    if not (math.isfinite(discard) and discard >= 0.0):
        raise InvalidInput(
            "discard", str(discard), "a time of 0 s or more is required", "Omit it to discard nothing."
        )
    samples = _sample_counts(dataset, status, len(time))
    kept = _after_discard(time, discard, discard * float(np.finfo(np.float32).eps) * (dtype == np.float32))
    completed = status == "completed"
    return np.asarray(kept & (np.arange(len(time)) < samples[..., None]) & completed[..., None])


def _after_discard(time: FloatArray, discard: float, inexactness: float = 0.0) -> NDArray[np.bool_]:
    """Select the samples after the discarded part; `inexactness` is the rounding of the times, s."""
    rounding = _ROUNDING * float(np.median(np.diff(time))) + inexactness
    return np.asarray(time >= discard - rounding)


def _sample_counts(dataset: xr.Dataset, status: NDArray[np.str_], longest: int) -> NDArray[np.int_]:
    """Return the number of samples of every trial, (condition, trial)."""
    if "samples" not in dataset.variables:
        return np.full(status.shape, longest)
    samples = np.asarray(dataset["samples"])
    needed = status == "completed"
    # There may be fewer times than samples, after a selection; the check of the values finds what is missing.
    valid = np.isfinite(samples) & (samples >= 0.0) & (samples % 1.0 == 0.0)
    if not np.all(valid | ~needed):
        raise refuse_trials(
            "samples",
            f"{samples[needed & ~valid][0]:g}",
            "a whole number of samples for every completed trial is required",
            "Correct it, or leave the variable out if no trial is shorter than others.",
        )
    return np.where(needed, samples, 0.0).astype(int)


def _check_trial_lengths(
    window: NDArray[np.bool_],
    status: NDArray[np.str_],
    names: TrialNames,
    time: FloatArray,
    discard: float,
    dataset: xr.Dataset,
) -> None:
    too_short = (status == "completed") & (window.sum(axis=-1) < 2)
    if np.any(too_short):
        condition, trial = np.argwhere(too_short)[0].tolist()
        count = min(int(_sample_counts(dataset, status, len(time))[condition, trial]), len(time))
        raise InvalidInput(
            "discard",
            f"{format_number(discard, 6)} s",
            f"{names(condition, trial)} ends at {format_number(time[max(0, count - 1)], 6)} s, so less must "
            "be discarded",
            "Discard less (--discard), or remove that trial.",
        )


def _contiguous_signal(values: xr.DataArray) -> FloatArray:
    # One memory layout, so that sums round alike wherever the trials come from.
    return np.ascontiguousarray(values, dtype=float)


def _check_trials_finite(
    name: str, values: FloatArray, window: NDArray[np.bool_], names: TrialNames, time: FloatArray
) -> None:
    missing = window & ~np.isfinite(values).all(axis=(-2, -1))
    if np.any(missing):
        condition, trial, sample = np.argwhere(missing)[0].tolist()
        without = "" if name in ("position", "target") else f", or drop {name} from all trials"
        raise InvalidInput(
            name,
            "not a number",
            f"{names(condition, trial)} counts as completed, but has no {name} at "
            f"{format_number(time[sample], 6)} s",
            f"Fill the gap, or set the trial's status to how it ended{without}.",
        )
