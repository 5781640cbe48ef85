"""What the arms and agents that hold the handles do to the stability of the study's conditions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from telespring.decision.arm_stability import ArmStability, arm_stability
from telespring.model import Operator
from telespring.paper.as_printed import EXPERIMENT_STIFFNESSES
from telespring.paper.scene import Found, Scene
from telespring.paper.sections.arms.boundary import boundary_in_arms, draw
from telespring.show import figures
from telespring.show.screens.arms import PATH_SECTIONS, describe_pace, describe_poses, describe_unavailable
from telespring.theory.axis import axes_of

if TYPE_CHECKING:
    from telespring.decision.arm_stability import ConditionStability, PoseSample
    from telespring.decision.equivalent_operators import EquivalentOperators

__all__ = ["find_arms"]

Condition = tuple[float, float]


def find_arms(scene: Scene) -> Found:
    """Judge the experiment's conditions with free handles and held by the study's arms and agents."""
    experiment = scene.study.experiment
    if experiment is None:
        return Found()
    connected = [(k, delay) for k, delay in experiment.conditions if k is not None]
    found = arm_stability(scene.study, connected, scene.modules)
    if found.operators is None:
        why = f"Not known: {describe_unavailable(found)}."
        return Found(numbers={"arms": {"known": False, "statements": [why], "conditions": []}})
    numbers = {"known": True, "depends_on_pose": found.poses is not None, **_operators(found.operators)}
    if found.poses is None:
        # For its robots also the two largest stiffnesses as the paper prints them, rounded.
        printed = EXPERIMENT_STIFFNESSES[-2:] if scene.of_the_paper else ()
        more, drawing = _boundary(found.operators, connected, printed)
    else:
        more, drawing = _along_the_path(found, found.operators, found.poses)
    return Found(numbers={"arms": {**numbers, **more}}, drawings={"arms": drawing})


def _operators(operators: EquivalentOperators) -> dict[str, Any]:
    return {
        "agent_stiffness": list(operators.agent_stiffness),
        "agent_damping": list(operators.agent_damping),
        "arm_mass": [list(each) for each in operators.arm_mass],
        "arm_damping": [list(each) for each in operators.arm_damping],
        "massless": operators.arm_kinds == ("massless", "massless"),
    }


def _boundary(
    operators: EquivalentOperators, connected: list[Condition], printed: tuple[float, ...]
) -> tuple[dict[str, Any], str]:
    """Find the boundary over stiffness and delay, where arms are alike in every pose."""
    first, second = (Operator(each.mass, each.damping) for each in operators.held.operators)
    found = boundary_in_arms(
        operators.free,
        sorted({k for k, _ in connected} | set(printed)),
        agent_stiffness=operators.agent_stiffness,
        arms=(first, second),
        conditions=connected,
        horizon=max(1.0, *(1.1 * delay for _, delay in connected), 0.0),
    )
    drawing = figures.to_svg(
        draw(found),
        "arms",
        "Stability over stiffness and delay with the handles in arms",
        "One panel per axis. Shaded is what is stable while arms and agents hold both handles; a "
        "dashed line is the boundary with free handles; marks are the experiment's conditions. "
        + " ".join(found.statements()),
    )
    return found.numbers(), drawing


def _along_the_path(
    found: ArmStability, operators: EquivalentOperators, poses: PoseSample
) -> tuple[dict[str, Any], str]:
    """Tell how stable the conditions are in the poses along the target's path."""
    free = axes_of(operators.free)
    conditions = []
    for each in found.conditions:
        delay = 0.5 * sum(each.delay)
        lost = [axis.name for axis in free if not axis.is_stable(each.stiffness, delay)]
        assert each.worst_position is not None
        conditions.append(
            {
                "stiffness": each.stiffness,
                "delay": delay,
                "free": "unstable" if lost else "stable",
                "in_arms": "stable" if each.stable else "unstable",
                "unstable_axes_free": lost,
                "unstable_axes_in_arms": None,
                "spectral_abscissa": each.spectral_abscissa,
                "least_abscissa": each.least_abscissa,
                "independent_abscissa": each.independent_abscissa,
                "unstable_poses": each.unstable_poses,
                "worst_position": list(each.worst_position),
                "complete": each.complete,
            }
        )
    statements = _statements(found.conditions, poses)
    drawing = figures.to_svg(
        figures.poses_figure(
            [
                figures.PoseRange(
                    f"{each.stiffness:.4g} N/m, {500.0 * sum(each.delay):.4g} ms",
                    each.least_abscissa,
                    each.spectral_abscissa,
                    each.independent_abscissa,
                    each.worst_position or (0.0, 0.0),
                )
                for each in found.conditions
            ],
            poses.positions,
            poses.cross_inertia,
        ),
        "arms",
        "Stability in the poses along the target's path",
        "Left: the path with the cross-axis inertia of both sides. Right: for each condition the range of "
        "the spectral abscissa over the poses; above zero is unstable. " + " ".join(statements),
    )
    numbers = {
        "poses": len(poses.positions),
        "along": PATH_SECTIONS[poses.section],
        "axes_independent": poses.axes_are_independent,
        "cross_inertia": poses.cross_inertia.max(axis=0).tolist(),
        "conditions": conditions,
        "statements": statements,
    }
    return numbers, drawing


def _statements(conditions: tuple[ConditionStability, ...], poses: PoseSample) -> list[str]:
    found = [f"{describe_poses(poses)}."]
    for each in conditions:
        where = f"Condition {each.stiffness:.0f} N/m, {500.0 * sum(each.delay):.0f} ms"
        if not each.stable:
            found.append(
                f"{where}: unstable in {each.unstable_poses} of {len(poses.positions)} poses, "
                f"{describe_pace(each)} in the worst."
            )
        if not each.complete:
            found.append(f"{where}: that no root was missed is not certain in every pose.")
    if conditions and all(each.stable for each in conditions):
        found.append("Every condition is stable in every pose.")
    return found
