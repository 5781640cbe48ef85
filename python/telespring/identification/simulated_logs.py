"""Simulated logs for identification: a velocity servo drives each handle through a two-link arm.

The servo follows an excitation movement. The log has, at 1 kHz, the handle's position from an encoder and the
force at the handle from a sensor or, instead, the force that the arm's joint torques exert at its hand.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import telespring._core as core
from telespring._types import FloatArray
from telespring.identification.excitation import Excitation, paper_excitation
from telespring.model import Dyad, Study, hman

__all__ = ["ARM", "SensorNoise", "SimulatedLog", "simulate_log"]

#: Rate of the log and of the servo, Hz.
RATE = 1000.0
#: Periods of the movement in a log: 20 s of the paper's.
PERIODS = 4.0
#: Gains of the servo: N·s/m on the velocity, and N/m on the position to prevent drift.
_SERVO = {"kind": "skilled", "stiffness": 200.0, "damping": 80.0}

#: A two-link arm of HEBI X-series parts, 0.45 m behind the centre of the task; the paper gives no numbers.
#: The values and their sources are those of `TwoLinkArm::HEBI_X8` in the core.
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

#: Drives a single axis, kg and N·s/m: about the inertia of such an arm at its hand.
_ONE_AXIS_ARM = {"kind": "lumped", "mass": 0.5, "damping": 1.0}


@dataclass(frozen=True)
class SensorNoise:
    """Noise of the simulated sensors, the same for all axes.

    Attributes
    ----------
    force
        Standard deviation of the force, N: a six-axis sensor of ±100 N resolves about 0.02 N, and its
        amplifier at 1 kHz adds a few times that.
    position_step
        Resolution of the encoder, m: 4096 counts on a pulley of 13 mm radius, as in small planar robots.
    position_jitter
        Standard deviation of the handle's position about that of the encoder (backlash), m.
    """

    force: float = 0.1
    position_step: float = 20e-6
    position_jitter: float = 5e-6


@dataclass(frozen=True)
class SimulatedLog:
    """A log of both robots without sensor noise; arrays over (time, robot, axis).

    Attributes
    ----------
    time
        s, shape (n,).
    position
        m, shape (n, 2, 2).
    handle_force, joint_force
        N, shape (n, 2, 2): the arm's force on the handle, and the force of its joint torques at its hand.
    """

    time: FloatArray
    position: FloatArray
    handle_force: FloatArray
    joint_force: FloatArray

    def measured(
        self, random: np.random.Generator, noise: SensorNoise | None = None, *, at: str = "handle"
    ) -> tuple[FloatArray, FloatArray]:
        """Return position (m) and force (N, at "handle" or "joints") of a simulated log with noise."""
        added = noise or SensorNoise()
        force = self.handle_force if at == "handle" else self.joint_force
        play = random.normal(0.0, added.position_jitter, self.position.shape)
        # The encoder's zero lies anywhere between two of its steps.
        zero = random.uniform(0.0, added.position_step, self.position.shape[1:])
        counts = np.round((self.position + play + zero) / added.position_step)
        return counts * added.position_step - zero, force + random.normal(0.0, added.force, force.shape)


def simulate_log(
    robots: Study | Dyad | None = None,
    movement: Excitation | None = None,
    *,
    arm: dict[str, Any] | None = None,
    periods: float = PERIODS,
) -> SimulatedLog:
    """Simulate a log of both robots on all axes, each axis a quarter of a period after the one before.

    The paper commands the same movement on both axes. Then no log can show whether the axes are coupled by
    inertia; with a quarter of a period between them it can. Sensor noise does not enter the servo, so one
    simulation serves any number of noisy logs. A study's robots have their Coulomb friction, a dyad's have
    none; operators that hold the handles are ignored. `arm`, that of both sides, is by default `ARM` or, for
    other than two axes, which no planar arm can move, a mass and a damping on every axis separately.
    """
    command = movement or paper_excitation()
    sections = _robot_sections(robots)
    count = len(sections[0]["mass"])
    if count == 2:
        return _simulate_two_axes(sections, command, (0.0, 0.25), arm or ARM, periods)
    single_axes = [
        _simulate_two_axes(
            [{key: [values[i]] * 2 for key, values in section.items()} for section in sections],
            command,
            (0.25 * i, 0.25 * i),
            arm or _ONE_AXIS_ARM,
            periods,
        )
        for i in range(count)
    ]
    return SimulatedLog(
        single_axes[0].time,
        *(
            np.concatenate([getattr(log, name)[:, :, :1] for log in single_axes], axis=2)
            for name in ("position", "handle_force", "joint_force")
        ),
    )


def _robot_sections(robots: Study | Dyad | None) -> list[dict[str, list[float]]]:
    """Return mass, damping and Coulomb friction of both robots, per axis, as in a study file."""
    dyad = hman() if robots is None else robots.dyad if isinstance(robots, Study) else robots
    friction = robots.coulomb if isinstance(robots, Study) else np.zeros((2, len(dyad.axes)))
    return [
        {
            "mass": robot.mass.tolist(),
            "damping": robot.damping.tolist(),
            "coulomb": friction[index].tolist(),
        }
        for index, robot in enumerate(dyad.robots)
    ]


def _simulate_two_axes(
    sections: list[dict[str, list[float]]],
    command: Excitation,
    lags: tuple[float, float],
    arm: dict[str, Any],
    periods: float,
) -> SimulatedLog:
    """Simulate two robots with two axes; `lags` are in periods of the movement."""
    driven = Study.paper().replace(
        robot1=sections[0],
        robot2=sections[1],
        arm1=arm,
        arm2=arm,
        agent1=_SERVO,
        agent2=_SERVO,
        laboratory={"sample_period": 1.0 / RATE},
        # Whoever made these robots has accepted them.
        allow_unusual=True,
    )
    assert driven.experiment is not None  # robots of two axes have one
    ticks = int(periods * command.period * RATE)
    time = np.arange(ticks + 1) / RATE
    target = np.column_stack([command.position(time - lag * command.period) for lag in lags])
    run = driven.experiment.laboratory.run(
        None, 0.0, 0, ticks / RATE, RATE, target=np.ascontiguousarray(target)
    )
    before = np.empty_like(run.handle_force)
    for robot in range(2):
        positions = np.ascontiguousarray(run.position[:, robot])
        before[:, robot] = _force_before_ticks(
            run.handle_force[:, robot],
            run.agent_force[:, robot],
            np.diag(driven.dyad.robots[robot].mass),
            core.arm_operator(driven.experiment.arms[robot], positions)[0],
        )
    # The first tick, at which the servo starts abruptly, has no force before it.
    return SimulatedLog(
        time=time[1:],
        position=run.position[1:],
        handle_force=0.5 * (before + run.handle_force)[1:],
        joint_force=0.5 * (run.agent_force[1:] + run.agent_force[:-1]),
    )


def _force_before_ticks(
    handle_force: FloatArray, hand_force: FloatArray, handle_mass: FloatArray, arm_mass: FloatArray
) -> FloatArray:
    """Return the force at the handle just before each tick of the servo, from the one recorded just after it.

    At a tick only the servo's force jumps. Both masses share the jump: the handle gets M_h (M_h + M_arm)^-1
    of it. A sensor measures the mean of before and after: the values after the ticks would be half a sample
    early, and bias the mass by half a sample times the damping.
    """
    jump = np.diff(hand_force, axis=0, prepend=0.0)
    accelerations = np.linalg.solve(handle_mass + arm_mass, jump[..., None])[..., 0]
    return np.asarray(handle_force - accelerations @ handle_mass.T)
