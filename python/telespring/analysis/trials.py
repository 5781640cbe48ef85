"""The one door to the analysis: a dataset of trials, checked once and laid out as plain arrays."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.study.conditions import condition_label

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Trials", "status_of", "take_trials"]

#: Share of a sample by which a sample's time may miss the end of the discarded part, for rounding.
_ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class Trials:
    """All trials of an experiment as arrays, in the order condition, trial, time, robot, axis.

    Attributes
    ----------
    labels
        A name per condition, "UM" or as in "CM-36-167".
    stiffness
        N/m per condition, NaN in the unconnected mode.
    delay
        One-way delay, s, per condition.
    status
        (condition, trial): "completed", "absent" where a condition has fewer trials than others, or how
        the trial ended before its time.
    time
        s from the start of a trial.
    position
        m.
    target
        m, (condition, trial, time, axis); the first two dimensions are 1 where all trials share it.
    velocity, coupling_force, agent_force
        m/s and N, or None where they were not recorded.
    window
        (condition, trial, time): the samples that the analysis takes, none of a trial that was not
        completed.
    discard
        First part of every trial that is left out, s.
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
        """Which trials ran to their end, (condition, trial)."""
        return np.asarray(self.status == "completed")

    @property
    def ended_early(self) -> NDArray[np.bool_]:
        """Which trials were begun and did not reach their end, (condition, trial)."""
        return np.asarray((self.status != "completed") & (self.status != "absent"))


def take_trials(dataset: xr.Dataset, discard: float | None = None) -> Trials:
    """Check a dataset of trials and lay it out as arrays.

    Parameters
    ----------
    dataset
        ``position`` (m) over (condition, trial, time, robot, axis) with two robots and the axes x and y;
        ``target`` (m) over (time, axis) or (condition, trial, time, axis); where they were recorded
        ``velocity`` (m/s), ``coupling_force`` and ``agent_force`` (N) as ``position``; ``status``
        (condition, trial) unless all were completed, ``samples`` (condition, trial) where trials differ
        in length; coordinates ``stiffness`` (N/m, NaN unconnected) and ``delay`` (s) over condition, and
        ``time`` (s).
    discard
        First part of every trial to leave out, s; the dataset's own attribute ``discard`` unless given,
        nothing where there is none.

    Returns
    -------
    Trials
        The arrays and the samples to take.

    Raises
    ------
    telespring.InvalidInput
        Where something is missing, or a completed trial holds a value that is not a number.
    """
    order = ("condition", "trial", "time", "robot", "axis")
    for name, dimensions in (("position", order), ("target", ("time", "axis"))):
        if name not in dataset.variables or not set(dimensions) <= set(dataset[name].dims):
            raise _not_trials(name, f"{name} over {', '.join(dimensions)} is needed")
    for name in ("time", "stiffness", "delay"):
        if name not in dataset.variables:
            raise _not_trials(name, f"a coordinate {name} is needed")
    sizes = dataset.sizes
    if sizes["robot"] != 2 or sizes["axis"] != 2 or 0 in sizes.values():
        raise _not_trials(
            "position", "two robots, two axes and at least one condition, trial and sample are needed"
        )
    time = np.asarray(dataset["time"], dtype=float)
    if len(time) < 2:
        raise InvalidInput(
            "time",
            f"{len(time)} sample",
            "trials of two samples or more are needed",
            "Record longer trials, or keep more samples per second.",
        )
    if not np.all(np.diff(time) > 0.0):
        raise _not_trials("time", "times that increase are needed")
    stiffness = np.asarray(dataset["stiffness"], dtype=float)
    delay = np.asarray(dataset["delay"], dtype=float)
    if dataset["condition"].dtype.kind in "UOT" and "condition" in dataset.coords:
        labels = tuple(str(label) for label in np.asarray(dataset["condition"]))
    else:
        labels = tuple(condition_label(k, d) for k, d in zip(stiffness.tolist(), delay.tolist(), strict=True))
    shape = (sizes["condition"], sizes["trial"])
    status = status_of(dataset, shape)
    samples = np.full(shape, len(time))
    if "samples" in dataset.variables:
        samples = np.asarray(dataset["samples"].transpose("condition", "trial"), dtype=int)
    left_out = float(dataset.attrs.get("discard", 0.0)) if discard is None else discard
    if not (math.isfinite(left_out) and left_out >= 0.0):
        raise InvalidInput(
            "discard", str(left_out), "a time of 0 s or more is needed", "Leave it away to discard nothing."
        )
    step = float(np.median(np.diff(time)))
    taken = time >= left_out - _ROUNDING * step
    window = taken & (np.arange(len(time)) < samples[..., None]) & (status == "completed")[..., None]
    empty = (status == "completed") & (window.sum(axis=-1) < 2)
    if np.any(empty):
        condition, trial = np.argwhere(empty)[0]
        end = time[max(0, samples[condition, trial] - 1)]
        raise InvalidInput(
            "discard",
            f"{left_out:g} s",
            f"trial {trial + 1} of {labels[condition]} ends at {end:g} s, less must be left out",
            "Give a shorter --discard, or leave that trial away.",
        )
    target = dataset["target"]
    if "condition" in target.dims:
        goals = np.ascontiguousarray(target.transpose("condition", "trial", "time", "axis"), dtype=float)
    else:
        goals = np.ascontiguousarray(target.transpose("time", "axis"), dtype=float)[None, None]
    # In one order of memory, so that sums round alike wherever the trials come from.
    series = {
        name: np.ascontiguousarray(dataset[name].transpose(*order), dtype=float)
        if name in dataset.variables and set(order) == set(dataset[name].dims)
        else None
        for name in ("position", "velocity", "coupling_force", "agent_force")
    }
    position = series["position"]
    assert position is not None
    for name, values in {**series, "target": goals[..., None, :]}.items():
        if values is not None:
            _refuse_gaps(name, values, window, labels, time)
    return Trials(
        labels=labels,
        stiffness=stiffness,
        delay=delay,
        status=status,
        time=time,
        position=position,
        target=goals,
        velocity=series["velocity"],
        coupling_force=series["coupling_force"],
        agent_force=series["agent_force"],
        window=window,
        discard=left_out,
    )


def _not_trials(field: str, allowed: str) -> InvalidInput:
    return InvalidInput(
        field,
        "not there, or not of that shape",
        allowed,
        "Give what `telespring rehearse` wrote, or recorded trials as docs/recorded-trials.md says.",
    )


def status_of(dataset: xr.Dataset, shape: tuple[int, int]) -> NDArray[np.str_]:
    """Say in words how every trial ended, (condition, trial)."""
    if "status" not in dataset.variables:
        return np.full(shape, "completed")
    status = dataset["status"].transpose("condition", "trial")
    raw: NDArray[Any] = np.asarray(status)
    meanings = status.attrs.get("flag_meanings")
    if raw.dtype.kind in "iu" and meanings is not None:
        # Numbers with their meaning beside, as the CF conventions write flags.
        words = dict(zip(np.ravel(status.attrs["flag_values"]).tolist(), str(meanings).split(), strict=True))
        return np.array([[words[int(each)].replace("_", " ") for each in row] for row in raw])
    return raw.astype(str)


def _refuse_gaps(
    name: str, values: FloatArray, window: NDArray[np.bool_], labels: tuple[str, ...], time: FloatArray
) -> None:
    broken = window & ~np.isfinite(values).all(axis=(-2, -1))
    if np.any(broken):
        condition, trial, sample = np.argwhere(broken)[0]
        raise InvalidInput(
            name,
            "not a number",
            f"trial {trial + 1} of {labels[condition]} counts as completed, but has no {name} at "
            f"{time[sample]:g} s",
            "Fill the gap, or give the trial the status that says how it ended.",
        )
