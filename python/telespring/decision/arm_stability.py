"""Stability of a study's conditions when its own arms and agents hold the handles.

Arms that do not depend on the pose are operators, and the exact criteria apply axis by axis. Two-link arms
couple x and y, differently in every pose: the verdict is then the worst over poses along the target.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.decision.equivalent_operators import EquivalentOperators, equivalent_operators
from telespring.decision.target_positions import PathSection, target_positions
from telespring.model import Study
from telespring.theory.poses import SIGNIFICANT_CROSS_INERTIA, cross_inertia, pose_stability

__all__ = ["ArmStability", "ConditionStability", "PoseSample", "arm_stability"]


@dataclass(frozen=True)
class ConditionStability:
    """Stability of one stiffness and delay with arms at the handles.

    Attributes
    ----------
    stiffness
        Of the virtual spring, N/m.
    delay
        One-way delay, forward and backward, s.
    unstable_axes
        Names of the unstable axes; None if the arms couple the axes.
    spectral_abscissa
        Largest real part of the characteristic roots without s = 0, 1/s, the worst over axes and poses.
    least_abscissa
        The same in the best pose.
    independent_abscissa
        The worst over the poses with all coupling between x and y removed.
    unstable_poses
        Number of unstable poses; None if the pose does not matter.
    worst_position
        Position of both handles in the worst pose, m; None if the pose does not matter.
    stable
        Whether every axis and every pose is stable.
    complete
        Whether it is certain that no characteristic root was missed.
    """

    stiffness: float
    delay: tuple[float, float]
    unstable_axes: tuple[str, ...] | None
    spectral_abscissa: float
    least_abscissa: float
    independent_abscissa: float
    unstable_poses: int | None
    worst_position: tuple[float, float] | None
    stable: bool
    complete: bool


@dataclass(frozen=True, eq=False)
class PoseSample:
    """The poses in which arms that depend on the pose were judged.

    Attributes
    ----------
    positions
        Of both handles, m, shape (pose, 2).
    section
        The part of the target's path that they cover.
    cross_inertia
        For each pose and robot, arm included: |m_xy| over the geometric mean of m_xx and m_yy.
    """

    positions: FloatArray
    section: PathSection
    cross_inertia: FloatArray

    @property
    def axes_are_independent(self) -> bool:
        """Whether the cross-axis inertia is below 5 % in every pose and on both sides."""
        return bool((self.cross_inertia < SIGNIFICANT_CROSS_INERTIA).all())


@dataclass(frozen=True, eq=False)
class ArmStability:
    """Stability of some conditions in a study's own arms.

    Attributes
    ----------
    unavailable
        Why there is no verdict, or None if there is: an agent is a program, whose stiffness nobody
        knows; the program of the target failed; or the target leaves the reach of an arm.
    programs
        Agents that are programs: their number, 1 or 2, and their class.
    target_error
        How the program of the target failed.
    operators
        What holds the handles; None without a verdict.
    poses
        Where the arms were judged; None if the pose does not matter.
    conditions
        The verdicts, in the order of the conditions given.
    """

    unavailable: Literal["agent program", "target program", "out of reach"] | None = None
    programs: Mapping[int, str] = field(default_factory=dict)
    target_error: InvalidInput | None = None
    operators: EquivalentOperators | None = None
    poses: PoseSample | None = None
    conditions: tuple[ConditionStability, ...] = ()


def arm_stability(
    study: Study,
    conditions: Sequence[tuple[float, float | tuple[float, float]]],
    modules: Path | None = None,
) -> ArmStability:
    """Judge conditions with the handles held by the study's own arms and agents.

    A condition is a stiffness (N/m) and a one-way delay (s), or the pair (forward, backward). Controllers are
    continuous and the delay is constant. Coulomb friction and torque limits are left out. Poses are frozen,
    with both handles on the target: the effect of moving between poses is not included. `modules`, the folder
    of the study's file, is where a target in Python is looked up first.

    Examples
    --------
    >>> import telespring as ts
    >>> arms = arm_stability(ts.Study.paper(), [(71.2, 0.084), (142.0, 0.084)])
    >>> [condition.unstable_axes for condition in arms.conditions]
    [(), ('x',)]
    """
    experiment = study.experiment
    if experiment is None:
        raise InvalidInput(
            "robot1.axes",
            ", ".join(study.dyad.axes),
            "arms hold robots with exactly two axes",
            "Describe both robots with the axes x and y.",
        )
    programs = {
        number: agent.class_ or ""
        for number, agent in enumerate(experiment.agents, start=1)
        if agent.kind == "python"
    }
    if programs:
        return ArmStability("agent program", programs)
    pairs = [(float(stiffness), _delay_both_ways(delay)) for stiffness, delay in conditions]
    operators = equivalent_operators(study, experiment)
    if not operators.depends_on_pose:
        verdicts = tuple(_judge_arms_axis_by_axis(operators, *pair) for pair in pairs)
        return ArmStability(operators=operators, conditions=verdicts)
    try:
        positions, section = target_positions(experiment, modules)
    except InvalidInput as error:
        return ArmStability("target program", target_error=error)
    try:
        cross = cross_inertia(operators.held, operators.jointed, positions)
    except InvalidInput as error:
        if not error.field.startswith("positions"):
            raise
        return ArmStability("out of reach")
    verdicts = tuple(_judge_arms_over_poses(operators, positions, *pair) for pair in pairs)
    poses = PoseSample(positions, section, cross)
    return ArmStability(operators=operators, poses=poses, conditions=verdicts)


def _judge_arms_axis_by_axis(
    operators: EquivalentOperators, stiffness: float, delay: tuple[float, float]
) -> ConditionStability:
    axes = list(operators.held)
    worst = max(axis.spectral_abscissa(stiffness, delay) for axis in axes)
    unstable = tuple(axis.name for axis in axes if not axis.is_stable(stiffness, 0.5 * sum(delay)))
    return ConditionStability(
        stiffness=stiffness,
        delay=delay,
        unstable_axes=unstable,
        spectral_abscissa=worst,
        least_abscissa=worst,
        independent_abscissa=worst,
        unstable_poses=None,
        worst_position=None,
        stable=not unstable,
        complete=True,
    )


def _judge_arms_over_poses(
    operators: EquivalentOperators, positions: FloatArray, stiffness: float, delay: tuple[float, float]
) -> ConditionStability:
    poses = pose_stability(operators.held, operators.jointed, stiffness, delay, positions)
    x, y = poses.worst_position.tolist()
    unstable = int(np.count_nonzero(poses.spectral_abscissa >= 0.0))
    return ConditionStability(
        stiffness=stiffness,
        delay=delay,
        unstable_axes=None,
        spectral_abscissa=poses.worst_abscissa,
        least_abscissa=float(poses.spectral_abscissa.min()),
        independent_abscissa=float(poses.uncoupled_abscissa.max()),
        unstable_poses=unstable,
        worst_position=(x, y),
        stable=unstable == 0,
        complete=poses.complete,
    )


def _delay_both_ways(delay: float | tuple[float, float]) -> tuple[float, float]:
    forward, backward = np.broadcast_to(delay, 2).tolist()
    return forward, backward
