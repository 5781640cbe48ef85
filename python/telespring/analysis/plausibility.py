"""Completed trials that look wrong: cut off, a handle that is stuck or jumps, or coordinates that do not fit.

Units, axes and offsets usually belong to a set-up: what most trials of a robot show is reported once. What
only some trials show is reported with their names.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from telespring._types import FloatArray
from telespring.analysis.coordinates import (
    CENTIMETRES,
    DOUBTS,
    MILLIMETRES,
    CoordinateFault,
    Doubt,
    find_coordinate_fault,
)
from telespring.analysis.trials import Trials

__all__ = [
    "FrozenHandle",
    "Implausible",
    "ShortTrial",
    "Spikes",
    "StillHandle",
    "SuspectCoordinates",
    "implausible_trials",
]

#: A completed trial shorter than this fraction of the median one may have been cut off.
_SHORT = 0.9
#: A handle is still if it moves less than this fraction of the target's extent at the end of a trial, for at
#: least this fraction of the trial.
_STILL_EXTENT, _STILL_TIME = 1e-3, 0.4
#: Samples that repeat for so long, s, and then jump by so many times the largest usual move were stuck.
_FROZEN, _FROZEN_JUMP = 0.1, 5.0
#: A sample that lies off its neighbours by so many times what samples usually do, and by so much of the
#: target's extent, is a spike.
_SPIKE, _SPIKE_EXTENT = 8.0, 0.02
#: What this fraction of the trials of a robot show alike belongs to the set-up.
_SYSTEMATIC = 0.8


@dataclass(frozen=True)
class ShortTrial:
    """A completed trial much shorter than the median one; durations in s."""

    trial: str
    duration: float
    usual_duration: float


@dataclass(frozen=True)
class StillHandle:
    """A handle that does not move from `since` (s) to the end; None: throughout. `robot` is 1 or 2."""

    trial: str
    robot: int
    since: float | None


@dataclass(frozen=True)
class FrozenHandle:
    """A position that repeats from `since` for `duration` (s) and then jumps by `jump` (m)."""

    trial: str
    robot: int
    since: float
    duration: float
    jump: float


@dataclass(frozen=True)
class Spikes:
    """Single samples far off the path: how many, and the largest, m, and its time, s."""

    trial: str
    robot: int
    count: int
    size: float
    time: float


@dataclass(frozen=True)
class SuspectCoordinates:
    """What `trials` (their names) of the `of` completed trials of a robot show: see `CoordinateFault`."""

    robot: int
    kind: Doubt
    value: float | str
    trials: tuple[str, ...]
    of: int
    is_systematic: bool


Implausible: TypeAlias = ShortTrial | StillHandle | FrozenHandle | Spikes | SuspectCoordinates


def implausible_trials(trials: Trials) -> list[Implausible]:
    """List what looks wrong with completed trials: coordinates first, then trial by trial."""
    completed = np.argwhere(trials.completed)
    if len(completed) == 0:
        return []
    counts = trials.window.sum(axis=-1)
    usual = float(np.median(counts[trials.completed]))
    step = trials.sample_period
    implausible: list[Implausible] = []
    faults: dict[int, dict[str, CoordinateFault]] = {0: {}, 1: {}}
    for condition, trial in completed.tolist():
        name = trials.trial_name(condition, trial)
        count = int(counts[condition, trial])
        if count < _SHORT * usual:
            implausible.append(ShortTrial(name, count * step, usual * step))
        window = trials.window[condition, trial]
        time = trials.time[window]
        target = trials.trial_target(condition, trial)[window]
        extent = float(np.ptp(target, axis=0).max())
        if extent == 0.0:
            continue
        for robot in (0, 1):
            path = trials.position[condition, trial, window, robot]
            still = _still_samples_at_the_end(path, _STILL_EXTENT * extent)
            if still >= _STILL_TIME * count:
                since = None if still == count else float(time[count - still])
                implausible.append(StillHandle(name, robot + 1, since))
                continue
            frozen = _longest_freeze(path, step)
            if frozen is not None:
                start, length, jump = frozen
                implausible.append(FrozenHandle(name, robot + 1, float(time[start]), length * step, jump))
            spikes = _find_spikes(path, extent)
            if spikes is not None:
                found, size, place = spikes
                implausible.append(Spikes(name, robot + 1, found, size, float(time[place])))
            fault = find_coordinate_fault(path, target, step)
            if fault is not None:
                faults[robot][name] = fault
    return [*_suspect_coordinates(faults, len(completed), trials.is_simulated), *implausible]


def _suspect_coordinates(
    faults: dict[int, dict[str, CoordinateFault]], of: int, is_simulated: bool
) -> list[SuspectCoordinates]:
    """Report what most trials of a robot show alike, and then what single ones show.

    A simulation has one set of coordinates: what single simulated trials show is their motion.
    """
    found: list[SuspectCoordinates] = []
    for robot, of_robot in faults.items():
        for kind in DOUBTS:
            alike = {name: fault.value for name, fault in of_robot.items() if fault.kind == kind}
            if len(alike) >= _SYSTEMATIC * of:
                value = _typical(list(alike.values()))
                found.append(SuspectCoordinates(robot + 1, kind, value, tuple(alike), of, True))
            elif not is_simulated:
                found += _of_single_trials(robot + 1, kind, alike, of)
    return sorted(found, key=lambda suspect: not suspect.is_systematic)


def _of_single_trials(
    robot: int, kind: Doubt, values: dict[str, float | str], of: int
) -> list[SuspectCoordinates]:
    """Report single trials: those with the same axes together, and a scale only if it may be another unit.

    A person who stays beside the target, or moves too far, does so in the right coordinates.
    """
    if kind == "offset":
        return []
    grouped: dict[str, list[str]] = {}
    for name, value in values.items():
        if kind == "scale":
            factor = max(float(value), 1.0 / float(value))
            if factor < CENTIMETRES:
                continue
            grouped.setdefault(f"{float(value) > 1.0}, {factor < MILLIMETRES}", []).append(name)
        else:
            grouped.setdefault(str(value), []).append(name)
    return [
        SuspectCoordinates(robot, kind, _typical([values[name] for name in names]), tuple(names), of, False)
        for names in grouped.values()
    ]


def _typical(values: list[float | str]) -> float | str:
    """Return the median of numbers, or the most frequent word."""
    numbers = [value for value in values if isinstance(value, float)]
    return float(np.median(numbers)) if numbers else max(set(values), key=values.count)


def _still_samples_at_the_end(path: FloatArray, limit: float) -> int:
    """Count the last samples (sample, axis) within `limit` (m) of the very last."""
    moved = np.abs(path - path[-1]).max(axis=-1) > limit
    return len(path) if not moved.any() else int(moved[::-1].argmax())


def _longest_freeze(path: FloatArray, step: float) -> tuple[int, int, float] | None:
    """Return start, samples and jump (m) of the longest part in which a path repeats and then jumps."""
    moves = np.abs(np.diff(path, axis=0)).max(axis=-1)
    moving = moves[moves > 0.0]
    shortest = max(3, round(_FROZEN / step))
    if moving.size < shortest:
        return None
    limit = _FROZEN_JUMP * float(np.quantile(moving, 0.9))
    changes = np.flatnonzero(moves > 0.0)
    lengths = np.diff(np.concatenate([[-1], changes]))
    stuck = np.flatnonzero((lengths > shortest) & (moves[changes] > limit))
    if not stuck.size:
        return None
    longest = int(stuck[np.argmax(lengths[stuck])])
    end, length = int(changes[longest]), int(lengths[longest])
    return end - length + 1, length, float(moves[end])


def _find_spikes(path: FloatArray, extent: float) -> tuple[int, float, int] | None:
    """Return number, size (m) and place of samples that lie off the cubic through their neighbours."""
    if len(path) < 50:
        return None
    off = np.abs(path[2:-2] - (4.0 * (path[1:-3] + path[3:-1]) - path[:-4] - path[4:]) / 6.0).max(axis=-1)
    limit = max(_SPIKE_EXTENT * extent, _SPIKE * float(np.quantile(off, 0.98)))
    places = np.flatnonzero(off > limit)
    # The neighbours of a spike are off, too, and a step is off on both sides: only the return tells a spike.
    sizes = np.abs(path[places + 2] - 0.5 * (path[places + 1] + path[places + 3])).max(axis=-1)
    returns = np.abs(path[places + 3] - path[places + 1]).max(axis=-1) < 0.5 * sizes
    places, sizes = places[returns & (sizes > limit)], sizes[returns & (sizes > limit)]
    if not places.size:
        return None
    largest = int(np.argmax(sizes))
    return places.size, float(sizes[largest]), int(places[largest]) + 2
