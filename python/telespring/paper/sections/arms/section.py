"""Stability of the study's conditions with the handles held by its arms and agents."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from telespring.decision.arm_stability import ArmStability, arm_stability
from telespring.model import Operator
from telespring.paper.published import EXPERIMENT_STIFFNESSES
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section
from telespring.paper.sections.arms.boundary import (
    AxisVerdicts,
    boundary_in_arms,
    draw_arms_boundary,
)
from telespring.show import figures
from telespring.show.screens.arms import (
    PATH_SECTIONS,
    describe_arm_pace,
    describe_arm_poses,
    describe_unavailable_arms,
)

if TYPE_CHECKING:
    from telespring.decision.arm_stability import ConditionStability, PoseSample
    from telespring.decision.equivalent_operators import EquivalentOperators
    from telespring.show.figures import StudyMark

__all__ = ["SECTION", "find_arms"]

Condition = tuple[float, float]


def find_arms(scene: Scene) -> Findings:
    """Assess the experiment's conditions with free handles and held by the study's arms and agents."""
    experiment = scene.study.experiment
    if experiment is None:
        return Findings()
    connected = [(k, delay) for k, delay in experiment.conditions if k is not None]
    stability = arm_stability(scene.study, connected, scene.modules)
    if stability.operators is None:
        reason = f"Unknown: {describe_unavailable_arms(stability)}."
        return Findings(numbers={"arms": {"known": False, "statements": [reason], "conditions": []}})
    numbers = {
        "known": True,
        "depends_on_pose": stability.poses is not None,
        **_arm_operator_numbers(stability.operators),
    }
    if stability.poses is None:
        # For the paper's robots also its two largest stiffnesses as printed, rounded.
        printed = EXPERIMENT_STIFFNESSES[-2:] if scene.of_the_paper else ()
        more, drawing = _boundary_findings(stability.operators, connected, printed, scene.mark)
    else:
        more, drawing = _path_findings(stability, stability.operators, stability.poses)
    return Findings(numbers={"arms": {**numbers, **more}}, drawings={"arms": drawing})


SECTION = Section(
    name="arms",
    anchor="arms",
    title="How arms shift the stability boundary",
    step="stability with arms",
    find=find_arms,
)


def _arm_operator_numbers(operators: EquivalentOperators) -> dict[str, Any]:
    return {
        "agent_stiffness": list(operators.agent_stiffness),
        "agent_damping": list(operators.agent_damping),
        "arm_mass": [list(mass) for mass in operators.arm_mass],
        "arm_damping": [list(damping) for damping in operators.arm_damping],
        "massless": operators.arm_kinds == ("massless", "massless"),
    }


def _boundary_findings(
    operators: EquivalentOperators,
    connected: list[Condition],
    printed: tuple[float, ...],
    mark: StudyMark | None,
) -> tuple[dict[str, Any], str]:
    """Compute the boundary over stiffness and delay for arms that do not depend on the pose."""
    first, second = (Operator(operator.mass, operator.damping) for operator in operators.held.operators)
    boundary = boundary_in_arms(
        operators.free,
        sorted({k for k, _ in connected} | set(printed)),
        agent_stiffness=operators.agent_stiffness,
        arms=(first, second),
        conditions=connected,
        horizon=max(1.0, *(1.1 * delay for _, delay in connected), 0.0),
    )
    drawing = figures.to_svg(
        draw_arms_boundary(boundary, mark=mark),
        "arms",
        "Stability over stiffness and delay with the handles held by arms",
        "One panel per axis. Shaded: stable while arms and agents hold both handles. Dashed: the boundary "
        "with free handles. Marks: the experiment's conditions. " + " ".join(boundary.statements()),
    )
    return boundary.numbers(), drawing


def _path_findings(
    stability: ArmStability, operators: EquivalentOperators, poses: PoseSample
) -> tuple[dict[str, Any], str]:
    """Compute how stable the conditions are in the poses along the target's path."""
    free = list(operators.free)
    conditions = []
    for condition in stability.conditions:
        delay = 0.5 * sum(condition.delay)
        verdicts = AxisVerdicts.on(free, condition.stiffness, delay)
        assert condition.worst_position is not None
        conditions.append(
            {
                "stiffness": condition.stiffness,
                "delay": delay,
                "free": verdicts.word,
                "in_arms": "stable" if condition.stable else "unstable",
                "unstable_axes_free": verdicts.unstable,
                "unstable_axes_in_arms": None,
                "marginal_axes_free": verdicts.marginal,
                "marginal_axes_in_arms": None,
                "spectral_abscissa": condition.spectral_abscissa,
                "least_abscissa": condition.least_abscissa,
                "independent_abscissa": condition.independent_abscissa,
                "unstable_poses": condition.unstable_poses,
                "worst_position": list(condition.worst_position),
                "complete": condition.complete,
            }
        )
    statements = _statements_on_poses(stability.conditions, poses)
    drawing = figures.to_svg(
        figures.poses_figure(
            [
                figures.PoseRange(
                    f"{condition.stiffness:.4g} N/m, {500.0 * sum(condition.delay):.4g} ms",
                    condition.least_abscissa,
                    condition.spectral_abscissa,
                    condition.independent_abscissa,
                    condition.worst_position or (0.0, 0.0),
                )
                for condition in stability.conditions
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


def _statements_on_poses(conditions: tuple[ConditionStability, ...], poses: PoseSample) -> list[str]:
    sentences = [f"{describe_arm_poses(poses)}."]
    for condition in conditions:
        name = f"Condition {condition.stiffness:.0f} N/m, {500.0 * sum(condition.delay):.0f} ms"
        if not condition.stable:
            sentences.append(
                f"{name}: unstable in {condition.unstable_poses} of {len(poses.positions)} poses, "
                f"{describe_arm_pace(condition)} in the worst."
            )
        if not condition.complete:
            sentences.append(f"{name}: it is not confirmed in every pose that no root was missed.")
    if conditions and all(condition.stable for condition in conditions):
        sentences.append("Every condition is stable in every pose.")
    return sentences
