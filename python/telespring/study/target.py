"""The target of a figure-eight task: its positions at given times, and its path (Eq. 12)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from telespring._core import Experiment, Task
from telespring._types import FloatArray

__all__ = ["figure_eight_path", "target_positions"]


def target_positions(task: Task | Mapping[str, Any], time: FloatArray) -> FloatArray:
    """Compute the positions of the target of a figure-eight task.

    Parameters
    ----------
    task
        The task of a study, or its keys as a dataset records them.
    time
        Times since the start of the trial, s.

    Returns
    -------
    ndarray, (time, axis)
        Positions, m: (A sin 2ωt, B sin ωt), Eq. 12.

    Raises
    ------
    telespring.InvalidInput
        If the target is written in Python: only its function knows the positions.

    Examples
    --------
    >>> import numpy as np
    >>> import telespring as ts
    >>> target_positions(ts.Study.paper().experiment.task, np.array([0.0, 0.3])).round(4).tolist()
    [[0.0, 0.0], [0.05, 0.0701]]
    """
    task = task if isinstance(task, Task) else Task(**task)
    return task.positions(time)


def figure_eight_path(experiment: Experiment, steps: int) -> tuple[FloatArray, bool]:
    """Compute the path of a figure eight over one period, or over the trial where that is shorter.

    Parameters
    ----------
    experiment
        An experiment whose task is a figure eight.
    steps
        Number of steps, equal in phase.

    Returns
    -------
    path : ndarray, (steps + 1, 2)
        Consecutive positions, m.
    is_whole : bool
        Whether the path covers a whole period.

    Examples
    --------
    >>> import telespring as ts
    >>> path, is_whole = figure_eight_path(ts.Study.paper().experiment, 720)
    >>> abs(path).max(axis=0).round(6).tolist(), is_whole
    ([0.05, 0.1], True)
    """
    frequency = experiment.task.angular_frequency
    assert frequency is not None  # the task is a figure eight
    period = 2.0 * math.pi / frequency if frequency > 0.0 else math.inf
    end = min(period, experiment.duration)
    return experiment.task.positions(np.linspace(0.0, end, steps + 1)), end == period
