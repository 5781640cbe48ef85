"""Trials of an experiment as checked arrays: status, analysed samples, positions, target and forces."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.study.conditions import condition_labels

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Trials", "trial_statuses"]

_PER_SAMPLE = ("condition", "trial", "time", "robot", "axis")
#: The discarded part may end this fraction of a sample after a sample that is still kept, for rounding.
_ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class Trials:
    """All trials of an experiment as arrays, in the order condition, trial, time, robot, axis.

    Attributes
    ----------
    labels
        Names of the conditions, such as "UM" or "CM-36-167".
    stiffness
        N/m per condition, NaN in the unconnected mode.
    delay
        One-way delay, s, per condition.
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

    def trial_target(self, condition: int, trial: int) -> FloatArray:
        """Return the target of one trial, (time, axis), m."""
        shared = self.target.shape[:2]
        return np.asarray(self.target[condition % shared[0], trial % shared[1]])

    @classmethod
    def from_dataset(cls, dataset: xr.Dataset, discard: float | None = None) -> Trials:
        """Check a dataset of trials and lay it out as arrays.

        Parameters
        ----------
        dataset : xarray.Dataset
            ``position`` (m) over (condition, trial, time, robot, axis) with two robots and the axes x and
            y; ``target`` (m) over (time, axis) or (condition, trial, time, axis). Optional: ``velocity``
            (m/s), ``coupling_force`` and ``agent_force`` (N), shaped as ``position``; ``status``
            (condition, trial), without which all trials count as completed; ``samples`` (condition, trial)
            where trials differ in length. Coordinates ``stiffness`` (N/m, NaN unconnected) and ``delay``
            (s) over condition, and ``time`` (s).
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
            If a variable is missing, or a completed trial has a value that is not a number.
        """
        _check_trials_layout(dataset)
        time = _trial_times(dataset)
        stiffness = np.asarray(dataset["stiffness"], dtype=float)
        delay = np.asarray(dataset["delay"], dtype=float)
        if dataset["condition"].dtype.kind in "UOT" and "condition" in dataset.coords:
            labels = tuple(str(label) for label in np.asarray(dataset["condition"]))
        else:
            pairs = zip(stiffness.tolist(), delay.tolist(), strict=True)
            labels = tuple(condition_labels([(None if math.isnan(k) else k, d) for k, d in pairs]))
        status = trial_statuses(dataset)
        if discard is None:
            discard = float(dataset.attrs.get("discard", 0.0))
        target = dataset["target"]
        if "condition" in target.dims:
            targets = _contiguous_signal(target.transpose("condition", "trial", "time", "axis"))
        else:
            targets = _contiguous_signal(target.transpose("time", "axis"))[None, None]
        series = {
            name: _contiguous_signal(dataset[name].transpose(*_PER_SAMPLE))
            for name in ("position", "velocity", "coupling_force", "agent_force")
            if name in dataset.variables and set(_PER_SAMPLE) == set(dataset[name].dims)
        }
        window = _analysed_trial_samples(dataset, status, labels, time, discard)
        for name, values in {**series, "target": targets[..., None, :]}.items():
            _check_trials_finite(name, values, window, labels, time)
        return cls(
            labels=labels,
            stiffness=stiffness,
            delay=delay,
            status=status,
            time=time,
            position=series["position"],
            target=targets,
            velocity=series.get("velocity"),
            coupling_force=series.get("coupling_force"),
            agent_force=series.get("agent_force"),
            window=window,
            discard=discard,
        )


def trial_statuses(dataset: xr.Dataset) -> NDArray[np.str_]:
    """Decode how every trial ended, (condition, trial): words, or flags as the CF conventions write them."""
    if "status" not in dataset.variables:
        return np.full((dataset.sizes["condition"], dataset.sizes["trial"]), "completed")
    status = dataset["status"].transpose("condition", "trial")
    raw: NDArray[Any] = np.asarray(status)
    meanings = status.attrs.get("flag_meanings")
    if raw.dtype.kind in "iu" and meanings is not None:
        words = dict(zip(np.ravel(status.attrs["flag_values"]).tolist(), str(meanings).split(), strict=True))
        return np.array([[words[int(flag)].replace("_", " ") for flag in row] for row in raw])
    return raw.astype(str)


def _check_trials_layout(dataset: xr.Dataset) -> None:
    for name, dimensions in (("position", _PER_SAMPLE), ("target", ("time", "axis"))):
        if name not in dataset.variables or not set(dimensions) <= set(dataset[name].dims):
            raise _refuse_trials(name, f"{name} over {', '.join(dimensions)} is required")
    for name in ("time", "stiffness", "delay"):
        if name not in dataset.variables:
            raise _refuse_trials(name, f"a coordinate {name} is required")
    sizes = dataset.sizes
    if sizes["robot"] != 2 or sizes["axis"] != 2 or 0 in sizes.values():
        raise _refuse_trials(
            "position", "two robots, two axes and at least one condition, trial and sample are required"
        )


def _refuse_trials(field: str, allowed: str) -> InvalidInput:
    return InvalidInput(
        field,
        "missing, or of another shape",
        allowed,
        "Use a file from `telespring rehearse`, or recorded trials as in docs/recorded-trials.md.",
    )


def _trial_times(dataset: xr.Dataset) -> FloatArray:
    time = np.asarray(dataset["time"], dtype=float)
    if len(time) < 2:
        raise InvalidInput(
            "time",
            f"{len(time)} sample",
            "trials of two samples or more are required",
            "Record longer trials, or keep more samples per second.",
        )
    if not np.all(np.diff(time) > 0.0):
        raise _refuse_trials("time", "times that increase are required")
    return time


def _analysed_trial_samples(
    dataset: xr.Dataset, status: NDArray[np.str_], labels: tuple[str, ...], time: FloatArray, discard: float
) -> NDArray[np.bool_]:
    """Select the samples of completed trials after the discarded part, (condition, trial, time)."""
    if not (math.isfinite(discard) and discard >= 0.0):
        raise InvalidInput(
            "discard", str(discard), "a time of 0 s or more is required", "Omit it to discard nothing."
        )
    samples = np.full(status.shape, len(time))
    if "samples" in dataset.variables:
        samples = np.asarray(dataset["samples"].transpose("condition", "trial"), dtype=int)
    kept = time >= discard - _ROUNDING * float(np.median(np.diff(time)))
    completed = status == "completed"
    window = kept & (np.arange(len(time)) < samples[..., None]) & completed[..., None]
    too_short = completed & (window.sum(axis=-1) < 2)
    if np.any(too_short):
        condition, trial = np.argwhere(too_short)[0]
        end = time[max(0, samples[condition, trial] - 1)]
        raise InvalidInput(
            "discard",
            f"{discard:g} s",
            f"trial {trial + 1} of {labels[condition]} ends at {end:g} s, so less must be discarded",
            "Discard less (--discard), or remove that trial.",
        )
    return np.asarray(window)


def _contiguous_signal(values: xr.DataArray) -> FloatArray:
    # One memory layout, so that sums round alike wherever the trials come from.
    return np.ascontiguousarray(values, dtype=float)


def _check_trials_finite(
    name: str, values: FloatArray, window: NDArray[np.bool_], labels: tuple[str, ...], time: FloatArray
) -> None:
    missing = window & ~np.isfinite(values).all(axis=(-2, -1))
    if np.any(missing):
        condition, trial, sample = np.argwhere(missing)[0]
        raise InvalidInput(
            name,
            "not a number",
            f"trial {trial + 1} of {labels[condition]} counts as completed, but has no {name} at "
            f"{time[sample]:g} s",
            "Fill the gap, or set the trial's status to how it ended.",
        )
