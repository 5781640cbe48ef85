"""Logs of the simulated robots: each handle is driven through a two-link arm by a velocity servo.

The servo follows a movement; what is logged is the handle's position by an encoder and the force at the handle
by a sensor, at 1 kHz, or instead of the latter the force that the arm's joint torques make at its hand.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import telespring as ts
from telespring._types import FloatArray
from telespring.identify.excitation import Excitation, paper_excitation

__all__ = ["ARM", "Noise", "RigLog", "rig_log"]

#: The log's rate, Hz, and how many times per sample the servo acts: drives run at about 10 kHz.
RATE = 1000.0
_ACTS = 10
#: Periods of the movement in a log: 20 s of the paper's.
PERIODS = 4.0
#: Gains of the servo: N·s/m on the velocity, N/m on the position, so that it does not drift away.
_SERVO = {"kind": "skilled", "stiffness": 200.0, "damping": 80.0}

#: A two-link arm of HEBI X-series parts, 0.45 m behind the middle of the task; the paper gives no numbers.
#: The values and where they come from are those of `TwoLinkArm::HEBI_X8` in the core.
ARM: dict[str, Any] = {
    "kind": "two-link",
    "base": [0.0, -0.45],
    "elbow": "right",
    "link_length": [0.325, 0.325],
    "link_mass": [0.882, 0.402],
    "link_centre": [0.2509, 0.1625],
    "link_inertia": [0.00986, 0.00362],
    "joint_damping": [0.5, 0.5],
    "rotor_inertia": [0.01, 0.01],
    "torque_limit": [20.0, 20.0],
}


@dataclass(frozen=True)
class Noise:
    """What sensors add, one value for all axes.

    Attributes
    ----------
    force
        Standard deviation of the force, N: a six-axis sensor of ±100 N resolves about 0.02 N, and its
        amplifier at 1 kHz brings a few times that.
    position_step
        Step of the encoder, m: 4096 counts on a pulley of 13 mm radius, as small planar robots have.
    position_jitter
        Standard deviation of the handle's play about the encoder's position, m.
    """

    force: float = 0.1
    position_step: float = 20e-6
    position_jitter: float = 5e-6


@dataclass(frozen=True)
class RigLog:
    """One run of a study's robots, without noise; arrays have time, robot, axis.

    Attributes
    ----------
    time
        s, shape (n,).
    position
        m, shape (n, 2, 2).
    handle_force, joint_force
        N, shape (n, 2, 2): what the arm does to the handle, and what its torques make at its hand.
    """

    time: FloatArray
    position: FloatArray
    handle_force: FloatArray
    joint_force: FloatArray

    def measured(
        self, random: np.random.Generator, noise: Noise | None = None, *, at: str = "handle"
    ) -> tuple[FloatArray, FloatArray]:
        """Give position (m) and force (N) as sensors show them.

        Parameters
        ----------
        random
            From which the noise is drawn.
        noise
            How much of it there is.
        at
            Where the force is measured, "handle" or "joints".
        """
        added = noise or Noise()
        force = self.handle_force if at == "handle" else self.joint_force
        play = random.normal(0.0, added.position_jitter, self.position.shape)
        # Nobody knows where the encoder's zero is between two of its steps.
        zero = random.uniform(0.0, added.position_step, self.position.shape[1:])
        counts = np.round((self.position + play + zero) / added.position_step)
        return counts * added.position_step - zero, force + random.normal(0.0, added.force, force.shape)


def rig_log(
    study: ts.Study | None = None,
    movement: Excitation | None = None,
    *,
    arm: dict[str, Any] | None = None,
    periods: float = PERIODS,
) -> RigLog:
    """Drive both robots of a study on both axes, y a quarter of a period after x.

    The paper commands the same movement on both axes. Then no log can tell whether one axis feels the
    other's acceleration; a quarter of a period apart it can. The noise of the sensors does not enter the
    servo, so that one run serves any number of noisy logs.

    Parameters
    ----------
    study
        The robots, Coulomb friction included; the paper's unless given.
    movement
        What the servo follows; the paper's unless given.
    arm
        Both arms, as in a study file; `ARM` unless given.
    periods
        How many periods are logged.

    Returns
    -------
    RigLog
        Positions and forces at 1 kHz.
    """
    from telespring.study_text import with_values

    command = movement or paper_excitation()
    driven = with_values(
        study or ts.Study.paper(),
        {
            "arm1": arm or ARM,
            "arm2": arm or ARM,
            "agent1": _SERVO,
            "agent2": _SERVO,
            "laboratory": {"sample_period": 1.0 / (_ACTS * RATE)},
        },
    )
    assert driven.experiment is not None  # it has arms, so it has two axes
    samples = int(periods * command.period * RATE) + 1
    # One sample more at the end, for the sensor's mean over it.
    ticks = _ACTS * samples
    time = np.arange(ticks + 1) / (_ACTS * RATE)
    target = np.column_stack([command.position(time), command.position(time - 0.25 * command.period)])
    run = driven.experiment.laboratory.run(
        None, 0.0, 0, ticks / (_ACTS * RATE), _ACTS * RATE, target=np.ascontiguousarray(target)
    )
    # The first tick, at which the servo jumps to its task, has no sample's width before it.
    at = _ACTS * np.arange(1, samples)
    return RigLog(
        time=time[at],
        position=run["position"][at],
        handle_force=_over_a_sample(run["handle_force"], at),
        joint_force=_over_a_sample(run["agent_force"], at),
    )


def _over_a_sample(force: FloatArray, at: np.ndarray[Any, np.dtype[np.int64]]) -> FloatArray:
    """Give the mean force over one sample's width about each tick, as a sensor does.

    A row holds the force right after its tick, held until the next as far as it comes from the servo. The
    mean is taken from half a sample before to half a sample after, the two readings of a row (held, or a
    sample of something smooth) in equal parts.
    """
    half = _ACTS // 2
    sums = np.concatenate([np.zeros((1, *force.shape[1:])), np.cumsum(force, axis=0)])
    held = sums[at + half] - sums[at - half]
    later = sums[at + half + 1] - sums[at - half + 1]
    return np.asarray((held + later) / (2 * _ACTS))
