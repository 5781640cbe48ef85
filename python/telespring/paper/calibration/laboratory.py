"""Tracking errors of a study's own laboratory for given values of the unknowns."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from telespring import _core
from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.model import Study

__all__ = ["RigSimulator"]

Condition = tuple[float | None, float]


@dataclass(frozen=True)
class RigSimulator:
    """Runs trials of a study and computes their tracking error, Eq. 15.

    Attributes
    ----------
    study
        Robots with two axes, agent 2 with its cloud of spots. Arms and Coulomb friction are replaced.
    """

    study: Study

    def __post_init__(self) -> None:
        """Refuse a study without two axes or without the paper's kinds of agents."""
        experiment = self.study.experiment
        if experiment is None:
            raise InvalidInput(
                "study",
                f"{len(self.study.dyad.axes)} axes",
                "the laboratory has the axes x and y",
                "Give both robots two axes.",
            )
        for i, kind in enumerate(("skilled", "blurred")):
            agent = experiment.agents[i]
            if agent.kind != kind:
                raise InvalidInput(
                    f"agent{i + 1}.kind",
                    repr(str(agent.kind)),
                    f'the published experiment had a "{kind}" agent there',
                    f'Remove [agent{i + 1}] from the study, or set its kind to "{kind}".',
                )

    def at(self, unknowns: FloatArray) -> Study:
        """Return the study with these arm mass, arm damping, Coulomb friction and spot velocity, SI units."""
        mass, damping, coulomb, velocity = unknowns.tolist()
        arm = {"kind": "lumped", "mass": mass, "damping": damping}
        friction = {"coulomb": [coulomb, coulomb]}
        return self.study.replace(
            arm1=arm, arm2=arm, robot1=friction, robot2=friction, agent2={"spot_velocity": velocity}
        )

    def errors(
        self,
        conditions: Mapping[int, Condition],
        trials: int,
        unknowns: FloatArray | None = None,
    ) -> FloatArray:
        """Run trials of some conditions and compute their tracking errors.

        Parameters
        ----------
        conditions
            Stiffness (N/m; None unconnected) and one-way delay (s), by the condition's number.
        trials
            Of each condition. The random numbers of a trial depend on the condition's number and its own,
            not on the unknowns.
        unknowns
            SI units; by default the study is run as it is.

        Returns
        -------
        ndarray
            Tracking errors (condition, trial, robot), m; NaN if a trial ended early.
        """
        study = self.study if unknowns is None else self.at(unknowns)
        experiment = study.experiment
        assert experiment is not None
        stiffness = np.repeat([math.nan if k is None else k for k, _ in conditions.values()], trials)
        delay = np.repeat([delay for _, delay in conditions.values()], trials)
        seeds = np.array(
            [
                _core.trial_seed(experiment.seed, condition, trial)
                for condition in conditions
                for trial in range(trials)
            ],
            dtype=np.uint64,
        )
        recordings = experiment.laboratory.run_many(
            stiffness, delay, seeds, experiment.duration, experiment.record_rate
        )
        kept = recordings.time >= experiment.discard - 1e-9
        deviation = recordings.position[:, kept] - recordings.target[:, kept, None, :]
        errors = np.hypot(deviation[..., 0], deviation[..., 1]).mean(axis=1)
        return np.asarray(errors.reshape(len(conditions), trials, 2))
