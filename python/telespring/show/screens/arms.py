"""Stability with arms at the handles, in words, for the screens and the report."""

from __future__ import annotations

from telespring.decision.arm_stability import ArmStability, ConditionStability, PoseSample
from telespring.decision.equivalent_operators import EquivalentOperators
from telespring.show.quantities import format_doubling_time, format_pair, format_position

__all__ = [
    "PATH_SECTIONS",
    "describe_arm_operators",
    "describe_arm_pace",
    "describe_arm_poses",
    "describe_arm_stability",
    "describe_arm_verdict",
    "describe_unavailable_arms",
]

PATH_SECTIONS = {
    "period": "one period of the target",
    "part of a period": "the target's path in a trial",
    "whole trial": "the target's path in a whole trial",
}


def describe_arm_verdict(condition: ConditionStability) -> str:
    """Describe the verdict on one condition in arms, short enough for a column of a table."""
    if condition.worst_position is None:
        axes = " and ".join(condition.unstable_axes or ())
        return "stable" if condition.stable else f"unstable on {axes}"
    verdict = "stable" if condition.stable else "unstable"
    return f"{verdict}, worst at {format_position(condition.worst_position)}"


def describe_arm_pace(condition: ConditionStability) -> str:
    """Describe how fast the slowest motion in arms decays, or the worst one grows."""
    rate = condition.spectral_abscissa
    if rate == 0.0:
        return "neither growing nor decaying"
    return f"{'doubling' if rate > 0.0 else 'halving'} every {format_doubling_time(rate)}"


def describe_arm_poses(poses: PoseSample) -> str:
    """Describe where the poses of the arms lie, and whether the axes are independent there."""
    one, two = (f"{100.0 * largest:.2g} %" for largest in poses.cross_inertia.max(axis=0))
    how = "nearly" if poses.axes_are_independent else "not"
    return (
        f"Worst of {len(poses.positions)} poses along {PATH_SECTIONS[poses.section]}; x and y are {how} "
        f"independent: the cross-axis inertia is up to {one} (robot 1) and {two} (robot 2) of the diagonal"
    )


def describe_arm_operators(operators: EquivalentOperators) -> str:
    """Describe the arms and agents that hold the handles."""
    agents = f"agents with {format_pair(operators.agent_stiffness, 'N/m')}"
    if any(operators.agent_damping):
        agents += f", {format_pair(operators.agent_damping, 'N·s/m')}"
    one, two = operators.arm_kinds
    return f"{one} arms, {agents}" if one == two else f"a {one} and a {two} arm, {agents}"


def describe_unavailable_arms(arms: ArmStability) -> str | None:
    """Describe why there is no verdict in arms; None if there is one."""
    if arms.unavailable == "agent program":
        programs = [f"agent {number} is the program {name}" for number, name in arms.programs.items()]
        whose = "whose stiffness is" if len(programs) == 1 else "whose stiffnesses are"
        return f"{' and '.join(programs)}, {whose} not known"
    if arms.unavailable == "out of reach":
        return "the target leaves the reach of an arm"
    if arms.target_error is not None:
        error = arms.target_error
        return f"the target {error.value} cannot be followed: {error.allowed}"
    return None


def describe_arm_stability(arms: ArmStability) -> str:
    """Describe what the verdicts in arms hold for, or why there are none."""
    if arms.operators is None:
        return f"unknown: {describe_unavailable_arms(arms)}."
    text = f"{describe_arm_operators(arms.operators)}; continuous controllers, constant delay."
    return text if arms.poses is None else f"{text} {describe_arm_poses(arms.poses)}."
