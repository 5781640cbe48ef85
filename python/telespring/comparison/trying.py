"""Whether a study can have an architecture: tried for a few ticks before anything long runs."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from telespring._core import Experiment, Study
from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.rehearsal.run import require_experiment
from telespring.rehearsal.traces import read_traces

__all__ = ["refusal_of"]

#: Sample periods of a try.
_TICKS = 2


def refusal_of(study: Study, modules: Path | None) -> InvalidInput | None:
    """Return why the laboratory refuses a study in one of its conditions; None if it runs them all.

    Agents and a target written in Python are replaced by still ones: they are not what is tried.
    """
    experiment = require_experiment(study)
    laboratory = read_traces(experiment, modules).laboratory(experiment)
    period = experiment.sample_period
    still = [_no_force if agent.class_ is not None else None for agent in experiment.agents]
    for stiffness, delay in experiment.conditions:
        try:
            laboratory.run(
                stiffness,
                delay,
                0,
                _TICKS * period,
                1.0 / period,
                agents=still if any(still) else None,
                target=_still_target(experiment),
                coupling_damping=experiment.coupling_damping,
            )
        except InvalidInput as refused:
            return refused
    return None


def _no_force(
    _time: float, _position: FloatArray, _velocity: FloatArray, _target: FloatArray
) -> tuple[float, float]:
    return 0.0, 0.0


def _still_target(experiment: Experiment) -> FloatArray | None:
    return np.zeros((_TICKS + 1, 2)) if experiment.task.function is not None else None
