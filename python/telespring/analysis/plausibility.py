"""Trials that count as completed, and perhaps should not: far shorter than others, or a handle that stuck."""

from __future__ import annotations

import numpy as np

from telespring.analysis.trials import Trials

__all__ = ["doubts"]

#: A completed trial shorter than this share of the median one was perhaps cut off.
_SHORT = 0.9
#: A handle that moves less than this share of the target's extent, over this share of the trial, stuck.
_REST, _PART = 1e-3, 0.4


def doubts(trials: Trials) -> list[str]:
    """Say which completed trials look as if they were not.

    Parameters
    ----------
    trials
        As `telespring.analysis.take_trials` gives them.

    Returns
    -------
    list of str
        Sentences that name condition, trial and robot.
    """
    completed = np.argwhere(trials.completed)
    if len(completed) == 0:
        return []
    counts = trials.window.sum(axis=-1)
    usual = float(np.median(counts[trials.completed]))
    step = float(np.median(np.diff(trials.time)))
    said = []
    for condition, trial in completed:
        name = f"Trial {trial + 1} of {trials.labels[condition]}"
        count = int(counts[condition, trial])
        if count < _SHORT * usual:
            said.append(
                f"{name} counts as completed with {count * step:.4g} s where {usual * step:.4g} s are usual: "
                "if it was cut off, give it the status stopped."
            )
        window = trials.window[condition, trial]
        goal = trials.target[condition % trials.target.shape[0], trial % trials.target.shape[1]][window]
        limit = _REST * float(np.ptp(goal, axis=0).max())
        for robot in (0, 1):
            path = trials.position[condition, trial, window, robot]
            resting = _resting_at_the_end(path, limit)
            if limit > 0.0 and resting >= _PART * count:
                since = (
                    "throughout"
                    if resting == count
                    else f"from {trials.time[window][count - resting]:.4g} s to its end"
                )
                said.append(
                    f"{name}: the handle of robot {robot + 1} does not move {since}, and is analysed as if "
                    "it had followed the target."
                )
    return said


def _resting_at_the_end(path: np.ndarray[tuple[int, ...], np.dtype[np.float64]], limit: float) -> int:
    """Count the last samples (sample, axis) that stay within so many m of the very last."""
    away = np.abs(path - path[-1]).max(axis=-1) > limit
    return len(path) if not away.any() else int(away[::-1].argmax())
