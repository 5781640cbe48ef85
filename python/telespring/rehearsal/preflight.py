"""What a study file already tells of its rehearsal: the target's path, and what will spoil the trials."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._core import Arm, LaboratorySettings
from telespring._types import FloatArray
from telespring.rehearsal.target import path_of_program
from telespring.study.target import figure_eight_path

if TYPE_CHECKING:
    from telespring._core import Experiment
    from telespring.model import Study

__all__ = ["laboratory_settings", "target_path", "warnings_of"]

#: m; how near to an end of its reach an arm may come before a warning.
_NEAR = 0.03
#: Points of one period of the figure of eight: between two of them it moves by less than 1 % of its size.
_POINTS = 720


def laboratory_settings(study: Study) -> dict[str, Any]:
    """List the settings of a study's laboratory, and its friction."""
    experiment = study.experiment
    settings = LaboratorySettings() if experiment is None else experiment.settings
    return settings.to_dict() | {"coulomb": study.coulomb.tolist()}


def target_path(experiment: Experiment, modules: Path | None = None) -> FloatArray:
    """Follow the target: through one period of the figure of eight, or a whole trial of a target in Python.

    Parameters
    ----------
    experiment
        A study's protocol.
    modules
        Where a target in Python is looked up first: the folder of the study's file.

    Returns
    -------
    ndarray, (point, 2)
        Places in their order, m.

    Raises
    ------
    telespring.InvalidInput
        Where a target in Python is not found or returns what is no target.

    Examples
    --------
    >>> import telespring as ts
    >>> abs(target_path(ts.Study.paper().experiment)).max(axis=0).round(6).tolist()
    [0.05, 0.1]
    """
    if experiment.task.kind != "python":
        return figure_eight_path(experiment, _POINTS)[0]
    found = path_of_program(experiment, modules)
    return found[:: max(1, len(found) // 4000)]


def warnings_of(study: Study, modules: Path | None = None) -> list[str]:
    """Tell, before any trial is run, what of a study will spoil its trials.

    Nothing of it is refused: a network that loses everything is a study too.

    Parameters
    ----------
    study
        Any study; one without an experiment has no warnings.
    modules
        Where a target in Python is looked up first: the folder of the study's file.

    Returns
    -------
    list of str
        A sentence or two each; empty where nothing is foreseen.

    Raises
    ------
    telespring.InvalidInput
        Where a target in Python is not found or returns what is no target.

    Examples
    --------
    >>> import telespring as ts
    >>> from telespring.study.editing import with_values
    >>> warnings_of(ts.Study.paper())
    []
    >>> warnings_of(with_values(ts.Study.paper(), {"laboratory": {"loss": 1.0}}))
    ['laboratory.loss = 1: no packet ever arrives, so each spring pulls to where the partner began.']
    """
    experiment = study.experiment
    if experiment is None:
        return []
    settings = experiment.settings
    found = []
    if settings.jitter >= experiment.duration:
        found.append(
            f"laboratory.jitter = {settings.jitter:g} s is no shorter than a trial of "
            f"{experiment.duration:g} s: most packets arrive after its end."
        )
    if settings.loss >= 1.0:
        found.append(
            "laboratory.loss = 1: no packet ever arrives, so each spring pulls to where the partner began."
        )
    jointed = [(i, arm) for i, arm in enumerate(experiment.arms, start=1) if arm.kind == "two-link"]
    if jointed:
        path = target_path(experiment, modules)
        for i, arm in jointed:
            found += _at_the_end_of_its_reach(i, arm, path)
    return found


def _at_the_end_of_its_reach(number: int, arm: Arm, path: FloatArray) -> list[str]:
    assert arm.link_length is not None  # a two-link arm
    upper, lower = arm.link_length
    distance = np.hypot(*(path - np.asarray(arm.base, float)).T)
    ends = (
        ("full reach", upper + lower, upper + lower - distance, "beyond"),
        ("shortest reach", abs(upper - lower), distance - abs(upper - lower), "inside of"),
    )
    found = []
    for name, reach, room, past in ends:
        worst = int(np.argmin(room))
        # A nanometre for rounding: just 3 cm are enough.
        if room[worst] >= _NEAR - 1e-9:
            continue
        x, y = (f"{1e3 * each + 0.0:.0f}" for each in path[worst].tolist())
        left = 1e3 * float(room[worst])
        how = f"comes within {left:.0f} mm of" if left >= 0.0 else f"goes {-left:.0f} mm {past}"
        found.append(
            f"arm{number}: the target {how} its {name} of {1e3 * reach:.0f} mm, at ({x}, {y}) mm. "
            f"A hand that is pushed farther ends the trial as out of reach."
        )
    return found
