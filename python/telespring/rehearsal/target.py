"""Where the target of a study's task goes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from telespring._types import FloatArray

if TYPE_CHECKING:
    from telespring._core import Experiment

__all__ = ["path_of_program"]


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
