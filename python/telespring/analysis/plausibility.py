"""Completed trials that look cut off, or in which a handle stopped moving."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from telespring._types import FloatArray
from telespring.analysis.trials import Trials

__all__ = ["ShortTrial", "StillHandle", "implausible_trials"]

#: A completed trial shorter than this fraction of the median one may have been cut off.
_SHORT = 0.9
#: A handle is still if it moves less than this fraction of the target's extent at the end of a trial, for at
#: least this fraction of the trial.
_STILL_EXTENT, _STILL_TIME = 1e-3, 0.4


@dataclass(frozen=True)
class ShortTrial:
    """A completed trial much shorter than the median one; durations in s."""

    condition: str
    trial: str
    duration: float
    usual_duration: float


@dataclass(frozen=True)
class StillHandle:
    """A handle that does not move from `since` (s) to the end; None: throughout. `robot` is 1 or 2."""

    condition: str
    trial: str
    robot: int
    since: float | None


def implausible_trials(trials: Trials) -> list[ShortTrial | StillHandle]:
    """List completed trials that look cut off or stuck, in the order of conditions and trials."""
    completed = np.argwhere(trials.completed)
    if len(completed) == 0:
        return []
    counts = trials.window.sum(axis=-1)
    usual = float(np.median(counts[trials.completed]))
    step = trials.sample_period
    implausible: list[ShortTrial | StillHandle] = []
    for condition, trial in completed.tolist():
        label, number = trials.labels[condition], trials.trial_number(condition, trial)
        count = int(counts[condition, trial])
        if count < _SHORT * usual:
            implausible.append(ShortTrial(label, number, count * step, usual * step))
        window = trials.window[condition, trial]
        target = trials.trial_target(condition, trial)[window]
        limit = _STILL_EXTENT * float(np.ptp(target, axis=0).max())
        for robot in (0, 1):
            still = _still_samples_at_the_end(trials.position[condition, trial, window, robot], limit)
            if limit > 0.0 and still >= _STILL_TIME * count:
                since = None if still == count else float(trials.time[window][count - still])
                implausible.append(StillHandle(label, number, robot + 1, since))
    return implausible


def _still_samples_at_the_end(path: FloatArray, limit: float) -> int:
    """Count the last samples (sample, axis) within `limit` (m) of the very last."""
    moved = np.abs(path - path[-1]).max(axis=-1) > limit
    return len(path) if not moved.any() else int(moved[::-1].argmax())
