"""Logs of the simulated robots: each handle is driven through its arm by a velocity servo.

The servo follows a movement; what is logged is the handle's position by an encoder and the force at the handle
by a sensor, at 1 kHz, or instead of the latter the force that the arm's joint torques make.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

import telespring as ts
from telespring._types import FloatArray
from telespring.identify.excitation import Excitation, paper_excitation

__all__ = ["ARM_DAMPING", "ARM_MASS", "Noise", "RigLog", "rig_log"]

#: The log's rate, Hz.
RATE = 1000.0
#: Periods of the movement in a log: 20 s of the paper's.
PERIODS = 4.0
#: The arm in whose place a mass and a damping stand, kg and N·s/m: a light arm of two links of 0.3 m with
#: HEBI-like actuators, seen at its hand.
ARM_MASS, ARM_DAMPING = 0.5, 1.0
#: Gains of the servo: N·s/m on the velocity, N/m on the position, so that it does not drift away.
_VELOCITY_GAIN, _POSITION_GAIN = 80.0, 200.0


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
    """One run of a dyad's robots, without noise; arrays have time, robot, axis.

    Attributes
    ----------
    time
        s, shape (n,).
    position
        m, shape (n, 2, axes).
    handle_force, joint_force
        N, shape (n, 2, axes): what the arm does to the handle, and what its torques make at its hand.
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


def rig_log(dyad: ts.Dyad, movement: Excitation | None = None, *, periods: float = PERIODS) -> RigLog:
    """Drive both robots of a dyad on all axes, each axis a quarter of a period after the one before.

    The paper commands the same movement on both axes. Then no log can tell whether one axis feels the
    other's acceleration; a quarter of a period apart it can.

    Parameters
    ----------
    dyad
        The robots; what holds their handles is left out.
    movement
        What the servo follows; the paper's unless given.
    periods
        How many periods are logged.

    Returns
    -------
    RigLog
        Positions and forces at 1 kHz.
    """
    command = movement or paper_excitation()
    samples = round(periods * command.period * RATE) + 1
    time = np.arange(samples) / RATE
    count = len(dyad.axes)
    arrays = {name: np.empty((samples, 2, count)) for name in ("position", "handle", "joints")}
    for i in range(count):
        ahead = time - i * command.period / 4.0
        wanted = np.stack([command.position(ahead), command.velocity(ahead)])
        for robot in range(2):
            mass, damping = float(dyad.robots[robot].mass[i]), float(dyad.robots[robot].damping[i])
            driven = _drive(mass, damping, wanted)
            for name, values in zip(arrays, driven, strict=True):
                arrays[name][:, robot, i] = values
    return RigLog(time, arrays["position"], arrays["handle"], arrays["joints"])


def _drive(mass: float, damping: float, wanted: FloatArray) -> tuple[list[float], list[float], list[float]]:
    """Position, handle force and joint force of one axis under the servo, exact between the ticks."""
    total_mass, total_damping = mass + ARM_MASS, damping + ARM_DAMPING
    step = 1.0 / RATE
    rate = total_damping / total_mass
    decay = math.exp(-rate * step)
    reach = -math.expm1(-rate * step) / rate
    push = (step - reach) / total_damping
    share = mass / total_mass
    own = damping - share * total_damping
    x, v, force = float(wanted[0, 0]), 0.0, 0.0
    position, handle, joints = [], [], []
    for target, speed in wanted.T.tolist():
        before = force
        force = _VELOCITY_GAIN * (speed - v) + _POSITION_GAIN * (target - x)
        position.append(x)
        # A sensor sees the mean of what the force was and what it becomes at the tick.
        handle.append(share * 0.5 * (before + force) + own * v)
        joints.append(0.5 * (before + force))
        x, v = x + reach * v + push * force, decay * v + reach / total_mass * force
    return position, handle, joints
