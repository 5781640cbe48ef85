"""Find trials that repeat another one: copies are no independent evidence, so tests count them once."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.analysis.trials import Trials

__all__ = ["find_copies", "find_same_recordings"]

#: Paths this close throughout, m, are one path: twice the step to which rehearsals are stored, and far below
#: the resolution of any robot's sensors.
_SAME = 2e-9
#: Then tracking errors differ at most by this, m: two coordinates of the path and two of the target.
_SAME_ERROR = 2.0 * np.sqrt(2.0) * _SAME

_Place = tuple[int, int]


def find_copies(trials: Trials, errors: FloatArray) -> NDArray[np.bool_]:
    """Mark what repeats an earlier trial of its condition, (condition, trial, robot).

    A robot repeats a trial if it moves along the same path, at the same times, after the same target; in a
    simulation without anything random all trials do. `errors` are the tracking errors, m, of the same shape.
    """
    copies = np.zeros(errors.shape, dtype=bool)
    for condition, completed in enumerate(trials.completed):
        for robot in (0, 1):
            kept: list[int] = []
            for trial in np.flatnonzero(completed).tolist():
                near = np.abs(errors[condition, kept, robot] - errors[condition, trial, robot]) <= _SAME_ERROR
                copies[condition, trial, robot] = any(
                    _is_same(trials, (condition, kept[place]), (condition, trial), (robot,))
                    for place in np.flatnonzero(near).tolist()
                )
                if not copies[condition, trial, robot]:
                    kept.append(trial)
    return copies


def find_same_recordings(
    trials: Trials, errors: FloatArray, copies: NDArray[np.bool_]
) -> list[tuple[_Place, _Place]]:
    """List pairs of trials (condition, trial) of different conditions in which both robots move alike.

    Trials that repeat one of their own condition are left out. Such a pair is one recording that is listed
    twice, or a simulation in which the conditions make no difference.
    """
    places = [
        (condition, trial)
        for condition, trial in np.argwhere(trials.completed).tolist()
        if not copies[condition, trial].all()
    ]
    places.sort(key=lambda place: float(errors[place][0]))
    pairs = []
    for i, one in enumerate(places):
        for other in places[i + 1 :]:
            if errors[other][0] - errors[one][0] > _SAME_ERROR:
                break
            if one[0] != other[0] and _is_same(trials, one, other, (0, 1)):
                pairs.append((min(one, other), max(one, other)))
    return sorted(pairs)


def _is_same(trials: Trials, one: _Place, other: _Place, robots: Iterable[int]) -> bool:
    windows = trials.window[one], trials.window[other]
    if not np.array_equal(*windows):
        return False
    targets = [
        trials.trial_target(*place)[window] for place, window in zip((one, other), windows, strict=True)
    ]
    paths = [
        trials.position[place][window][:, list(robots)]
        for place, window in zip((one, other), windows, strict=True)
    ]
    return bool(
        np.all(np.abs(targets[0] - targets[1]) <= _SAME) and np.all(np.abs(paths[0] - paths[1]) <= _SAME)
    )
