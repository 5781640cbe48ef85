"""Tracking errors of a study's own laboratory, with the unknowns put into its text."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from telespring import _core
from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.model import Study
from telespring.study.editing import with_values

__all__ = ["RigSimulator"]

Condition = tuple[float | None, float]


@dataclass(frozen=True)
class RigSimulator:
    """Runs trials of a study and measures them by Eq. 15.

    Attributes
    ----------
    study
        Robots with two axes, agent 2 with its cloud of spots. Arms and Coulomb friction are replaced.
    """

    study: Study

    def __post_init__(self) -> None:
        """Refuse a study that has no such laboratory."""
        experiment = self.study.experiment
        if experiment is None:
            raise InvalidInput(
                "study",
                f"{len(self.study.dyad.axes)} axes",
                "the laboratory has the axes x and y",
                "Give both robots two axes.",
            )
        for place, kind, wanted in (("agent1", 0, "skilled"), ("agent2", 1, "blurred")):
            found = str(experiment.agents[kind]["kind"])
            if found != wanted:
                raise InvalidInput(
                    f"{place}.kind",
                    repr(found),
                    f'the published experiment had a "{wanted}" agent there',
                    "Take that section out of the study that is calibrated.",
                )

    def at(self, unknowns: FloatArray) -> Study:
        """Give the study with arm mass, arm damping, Coulomb friction and spot velocity put in, SI units."""
        mass, damping, coulomb, velocity = (float(each) for each in unknowns)
        arm = {"kind": "lumped", "mass": mass, "damping": damping}
        return with_values(
            self.study,
            {
                "arm1": arm,
                "arm2": arm,
                "robot1": {"coulomb": [coulomb, coulomb]},
                "robot2": {"coulomb": [coulomb, coulomb]},
                "agent2": {"spot_velocity": velocity},
            },
        )

    def errors(
        self,
        conditions: Mapping[int, Condition],
        trials: int,
        unknowns: FloatArray | None = None,
    ) -> FloatArray:
        """Run conditions and measure.

        Parameters
        ----------
        conditions
            Stiffness (N/m; None unconnected) and one-way delay (s), by the condition's number.
        trials
            Of each; trial i of the condition with a number has the same random numbers whatever the
            unknowns are.
        unknowns
            SI units; the study as it is unless given.

        Returns
        -------
        ndarray
            Tracking errors (condition, trial, robot), m; not a number where a trial ended early.
        """
        study = self.study if unknowns is None else self.at(unknowns)
        experiment = study.experiment
        assert experiment is not None
        stiffness = np.repeat([math.nan if k is None else k for k, _ in conditions.values()], trials)
        delay = np.repeat([each for _, each in conditions.values()], trials)
        seeds = np.array(
            [
                _core.trial_seed(experiment.seed, condition, trial)
                for condition in conditions
                for trial in range(trials)
            ],
            dtype=np.uint64,
        )
        found = experiment.laboratory.run_many(
            stiffness, delay, seeds, experiment.duration, experiment.record_rate
        )
        kept = found["time"] >= experiment.discard - 1e-9
        apart = found["position"][:, kept] - found["target"][:, kept, None, :]
        mean = np.hypot(apart[..., 0], apart[..., 1]).mean(axis=1)
        return np.asarray(mean.reshape(len(conditions), trials, 2))
