"""Tracking errors of the virtual laboratory for a setting, and which settings it can be given."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

import telespring._core as core
from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.model import Study
from telespring.paper.calibration.setting import Setting

__all__ = ["RigSimulator", "printed_laboratory", "printed_setting"]

Condition = tuple[float | None, float]

#: What a study can say of a setting.
_EXPRESSIBLE = ("agent_stiffness", "spot_lifetime", "arm_mass", "arm_damping", "coulomb", "coupling_lag")


def printed_laboratory(study: Study) -> Study:
    """Return the study with the paper's agents, and without what a study may add to its laboratory.

    Raises
    ------
    telespring.InvalidInput
        If the study has no two axes or not the paper's kinds of agents.
    """
    experiment = study.experiment
    if experiment is None:
        raise InvalidInput(
            "study",
            f"{len(study.dyad.axes)} axes",
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
    if experiment.task.kind != "figure-eight":
        raise InvalidInput(
            "task.kind",
            repr(str(experiment.task.kind)),
            'the published experiment had a "figure-eight"',
            "Remove [task] from the study.",
        )
    return study.replace(
        agent1={"stiffness": None, "damping": None},
        agent2=dict.fromkeys(("stiffness", "spots", "spot_velocity", "spot_lifetime")),
        coupling={"damping": None},
        laboratory=dict.fromkeys(("computing_tick", "actuator_lag", "encoder_resolution")),
        network=dict.fromkeys(
            (
                "jitter",
                "distribution",
                "loss",
                "burst",
                "duplicate",
                "order",
                "rate",
                "blackout",
                "trace",
            )
        ),
        robot1={"coulomb": None},
        robot2={"coulomb": None},
    )


def printed_setting(study: Study) -> Setting:
    """Return the setting of a study's own agents, without arms."""
    experiment = study.experiment
    assert experiment is not None
    stiffness, lifetime = experiment.agents[0].stiffness, experiment.agents[1].spot_lifetime
    assert stiffness is not None
    assert lifetime is not None
    return Setting(agent_stiffness=stiffness, spot_lifetime=lifetime)


@dataclass(frozen=True)
class RigSimulator:
    """Runs trials of a study in the virtual laboratory and computes their tracking error, Eq. 15.

    Attributes
    ----------
    study
        As `printed_laboratory` returns it. What a `Setting` says is replaced.
    """

    study: Study

    @staticmethod
    def can_run(setting: Setting) -> bool:
        """Whether a study can express everything in which the setting differs from the printed one."""
        plain = Setting(setting.agent_stiffness, setting.spot_lifetime)
        return all(
            getattr(setting, field.name) == getattr(plain, field.name)
            for field in fields(Setting)
            if field.name not in _EXPRESSIBLE
        )

    def at(self, setting: Setting) -> Study:
        """Return the study with this setting, which it must be able to express."""
        assert self.can_run(setting)
        arm = {"kind": "lumped", "mass": setting.arm_mass, "damping": setting.arm_damping}
        friction = {"coulomb": [setting.coulomb, setting.coulomb]}
        return self.study.replace(
            arm1=arm,
            arm2=arm,
            robot1=friction,
            robot2=friction,
            agent1={"stiffness": setting.agent_stiffness},
            agent2={"stiffness": setting.agent_stiffness, "spot_lifetime": setting.spot_lifetime},
            laboratory={"actuator_lag": setting.coupling_lag},
        )

    def errors(self, setting: Setting, conditions: Sequence[Condition], trials: int) -> FloatArray:
        """Run trials; return tracking errors (condition, trial, robot), m, NaN after an early end.

        Conditions are stiffness (N/m; None unconnected) and one-way delay (s). The random numbers of a
        trial depend on its own number and its condition's, not on the setting.
        """
        experiment = self.at(setting).experiment
        assert experiment is not None
        stiffness = np.repeat([math.nan if k is None else k for k, _ in conditions], trials)
        delay = np.repeat([delay for _, delay in conditions], trials)
        seeds = np.array(
            [
                core.trial_seed(experiment.seed, condition, trial)
                for condition in range(len(conditions))
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
