"""Where the target of a study's task goes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from telespring._types import FloatArray

if TYPE_CHECKING:
    from telespring._core import Experiment

__all__ = ["figure_of_eight", "path_of_program"]


def figure_of_eight(experiment: Experiment, points: int) -> tuple[FloatArray, bool]:
    """Follow Eq. 12 through one period, or to the end of the trial where that comes first.

    Parameters
    ----------
    experiment
        A protocol whose task is the figure of eight.
    points
        Steps, even in phase.

    Returns
    -------
    path : ndarray, (points + 1, 2)
        Places in their order, m.
    whole : bool
        Whether it is a whole period.

    Examples
    --------
    >>> import telespring as ts
    >>> path, whole = figure_of_eight(ts.Study.paper().experiment, 720)
    >>> abs(path).max(axis=0).round(6).tolist(), whole
    ([0.05, 0.1], True)
    """
    task = experiment.task
    end = min(2.0 * math.pi, float(task["angular_frequency"]) * experiment.duration)
    phase = np.linspace(0.0, end, points + 1)
    across, along = task["amplitude"]
    return np.column_stack([across * np.sin(2.0 * phase), along * np.sin(phase)]), end == 2.0 * math.pi


def path_of_program(experiment: Experiment, modules: Path | None) -> FloatArray:
    """Follow a target in Python through a whole trial.

    Parameters
    ----------
    experiment
        A protocol whose task is a program.
    modules
        Where it is looked up first: the folder of the study's file.

    Returns
    -------
    ndarray, (tick, 2)
        Its place at every tick of the controllers, m.

    Raises
    ------
    telespring.InvalidInput
        Where it is not found or returns what is no target.
    """
    from telespring.rehearsal.schedule import tick_count
    from telespring.rehearsal.user_code import programs_of

    found = programs_of(experiment, modules).positions(tick_count(experiment), experiment.sample_period)
    assert found is not None
    return found
