"""Positions along the target's path at which the poses of two-link arms are judged."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from telespring._types import FloatArray
from telespring.rehearsal.target import user_target_path
from telespring.study.target import figure_eight_path

if TYPE_CHECKING:
    from telespring._core import Experiment

__all__ = ["PathSection", "target_positions"]

#: A period of the figure of eight, the part of it that fits into a trial, or a program's whole trial.
PathSection: TypeAlias = Literal["period", "part of a period", "whole trial"]

#: The abscissa is flat at the worst pose, so that 32 steps per period of the figure of eight find it to
#: second order; the four outermost points are among them.
_STEPS = 32


def target_positions(experiment: Experiment, modules: Path | None = None) -> tuple[FloatArray, PathSection]:
    """Choose distinct positions (m) along the path of the target, and name the part of it that they cover.

    They are evenly spaced in phase on the figure of eight, and spread as far apart as possible over the trial
    of a target in Python, which is looked up in `modules`, the folder of the study's file, first.

    Examples
    --------
    >>> import telespring as ts
    >>> positions, section = target_positions(ts.Study.paper().experiment)
    >>> len(positions), section  # the centre is passed twice
    (31, 'period')
    """
    if experiment.task.kind == "python":
        return _farthest_target_points(user_target_path(experiment, modules), _STEPS), "whole trial"
    path, is_whole = figure_eight_path(experiment, _STEPS)
    # Rounded, so that sin(2π) is sin(0): far below what moves a pose.
    positions = np.unique(np.round(path, 12) + 0.0, axis=0)
    return positions, "period" if is_whole else "part of a period"


def _farthest_target_points(path: FloatArray, count: int) -> FloatArray:
    """Pick points of a path one by one, each the farthest from those before it."""
    chosen = [int(np.argmax(np.hypot(*(path - path.mean(axis=0)).T)))]
    distance = np.hypot(*(path - path[chosen[0]]).T)
    while len(chosen) < count and distance.max() > 0.0:
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.hypot(*(path - path[chosen[-1]]).T))
    return path[sorted(chosen)]
