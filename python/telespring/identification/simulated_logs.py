"""Logs of the simulated robots: each handle is driven through a two-link arm by a velocity servo.

The servo follows a movement; what is logged at 1 kHz is the handle's position by an encoder and the force at
the handle by a sensor, or instead of the latter the force that the arm's joint torques make at its hand.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from telespring import _core
from telespring._types import FloatArray
from telespring.identification.excitation import Excitation, paper_excitation
from telespring.model import Dyad, Study, hman

__all__ = ["ARM", "Noise", "RigLog", "rig_log"]

#: The rate of log and servo, Hz.
RATE = 1000.0
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

#: What moves an axis alone, kg and N·s/m: about as heavy as such an arm is to its hand.
_ONE_AXIS_ARM = {"kind": "lumped", "mass": 0.5, "damping": 1.0}


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
    robots: Study | Dyad | None = None,
    movement: Excitation | None = None,
    *,
    arm: dict[str, Any] | None = None,
    periods: float = PERIODS,
) -> RigLog:
    """Drive both robots on all axes, each axis a quarter of a period after the one before.

    The paper commands the same movement on both axes. Then no log can tell whether one axis feels the
    other's acceleration; a quarter of a period apart it can. The noise of the sensors does not enter the
    servo, so that one run serves any number of noisy logs.

    Parameters
    ----------
    robots
        A study, whose robots are taken with their Coulomb friction, or a dyad, without; the paper's unless
        given. What holds the handles is left out.
    movement
        What the servo follows; the paper's unless given.
    arm
        Both arms, as in a study file; unless given `ARM`, and where there are not two axes, which no planar
        arm can move, a mass and a damping on every axis alone.
    periods
        How many periods are logged.

    Returns
    -------
    RigLog
        Positions and forces at 1 kHz.

    Raises
    ------
    telespring.InvalidInput
        Where the movement leaves the arm's reach.
    """
    command = movement or paper_excitation()
    sections = _bare_robots(robots)
    count = len(sections[0]["mass"])
    if count == 2:
        return _run(sections, command, (0.0, 0.25), arm or ARM, periods)
    alone = [
        _run(
            [{key: [values[i]] * 2 for key, values in section.items()} for section in sections],
            command,
            (0.25 * i, 0.25 * i),
            arm or _ONE_AXIS_ARM,
            periods,
        )
        for i in range(count)
    ]
    return RigLog(
        alone[0].time,
        *(
            np.concatenate([getattr(each, name)[:, :, :1] for each in alone], axis=2)
            for name in ("position", "handle_force", "joint_force")
        ),
    )


def _bare_robots(robots: Study | Dyad | None) -> list[dict[str, list[float]]]:
    """List mass, damping and Coulomb friction of both robots, per axis."""
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


def _run(
    sections: list[dict[str, list[float]]],
    command: Excitation,
    lags: tuple[float, float],
    arm: dict[str, Any],
    periods: float,
) -> RigLog:
    """Drive two robots of two axes; `lags` are in periods of the movement."""
    from telespring.study.editing import with_values

    driven = with_values(
        Study.paper(),
        {
            "robot1": sections[0],
            "robot2": sections[1],
            "arm1": arm,
            "arm2": arm,
            "agent1": _SERVO,
            "agent2": _SERVO,
            "laboratory": {"sample_period": 1.0 / RATE},
        },
    )
    assert driven.experiment is not None  # robots of two axes have one
    ticks = int(periods * command.period * RATE)
    time = np.arange(ticks + 1) / RATE
    target = np.column_stack([command.position(time - lag * command.period) for lag in lags])
    run = driven.experiment.laboratory.run(
        None, 0.0, 0, ticks / RATE, RATE, target=np.ascontiguousarray(target)
    )
    before = np.empty_like(run["handle_force"])
    for robot in range(2):
        positions = np.ascontiguousarray(run["position"][:, robot])
        before[:, robot] = _before_the_tick(
            run["handle_force"][:, robot],
            run["agent_force"][:, robot],
            np.diag(driven.dyad.robots[robot].mass),
            _core.arm_operator(driven.experiment.arms[robot], positions)[0],
        )
    # The first tick, at which the servo jumps to its task, has nothing before it.
    return RigLog(
        time=time[1:],
        position=run["position"][1:],
        handle_force=0.5 * (before + run["handle_force"])[1:],
        joint_force=0.5 * (run["agent_force"][1:] + run["agent_force"][:-1]),
    )


def _before_the_tick(
    handle_force: FloatArray, hand_force: FloatArray, handle_mass: FloatArray, arm_mass: FloatArray
) -> FloatArray:
    """Give the force at the handle just before each tick, which is recorded just after it.

    At a tick only the servo's force jumps. Both masses then share the jump: the handle gets
    M_h (M_h + M_arm)^-1 of it. A sensor sees the mean of before and after: taking the values after the ticks
    would make the force half a sample early, and the mass wrong by half a sample times the damping.
    """
    jump = np.diff(hand_force, axis=0, prepend=0.0)
    accelerations = np.linalg.solve(handle_mass + arm_mass, jump[..., None])[..., 0]
    return np.asarray(handle_force - accelerations @ handle_mass.T)
