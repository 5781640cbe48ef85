"""The path of an experiment's target, of a figure eight or of a target written in Python."""

from __future__ import annotations

from pathlib import Path

from telespring._core import Experiment
from telespring._types import FloatArray
from telespring.rehearsal.user_code import load_user_code
from telespring.study.target import figure_eight_path

__all__ = ["target_path", "user_target_path"]

#: Steps of one period of the figure eight: in each it moves by less than 1 % of its size.
_STEPS = 720
#: Points of the path of a target written in Python, about.
_POINTS = 4000


def target_path(experiment: Experiment, modules: Path | None = None) -> FloatArray:
    """Compute the path of the target: one period of the figure eight, or a whole trial of a Python target.

    Parameters
    ----------
    experiment
        The experiment of a study.
    modules
        Folder of the study file, where the module of a Python target is looked up first.

    Returns
    -------
    ndarray, (point, 2)
        Consecutive positions, m.

    Raises
    ------
    telespring.InvalidInput
        If a Python target is missing or its positions are invalid.

    Examples
    --------
    >>> import telespring as ts
    >>> abs(target_path(ts.Study.paper().experiment)).max(axis=0).round(6).tolist()
    [0.05, 0.1]
    """
    if experiment.task.kind != "python":
        return figure_eight_path(experiment, _STEPS)[0]
    path = user_target_path(experiment, modules)
    return path[:: max(1, len(path) // _POINTS)]


def user_target_path(experiment: Experiment, modules: Path | None) -> FloatArray:
    """Compute the positions of a Python target at every tick of a trial, m, (tick, 2).

    Raises
    ------
    telespring.InvalidInput
        If the target is missing or its positions are invalid.
    """
    positions = load_user_code(experiment, modules).target_positions(
        experiment.tick_count, experiment.sample_period
    )
    assert positions is not None  # the task is a Python target
    return positions
