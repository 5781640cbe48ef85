"""Stability of the study's conditions with the handles held by its arms and agents."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from telespring.decision.arms import InArms, stability_in_arms
from telespring.model import Operator
from telespring.paper.published import EXPERIMENT_STIFFNESSES
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section
from telespring.paper.sections.arms.boundary import boundary_in_arms, draw
from telespring.show import figures

if TYPE_CHECKING:
    from telespring.decision.arms import ConditionInArms, Poses
    from telespring.decision.handles import Holding

__all__ = ["SECTION", "find_arms"]

Condition = tuple[float, float]


def find_arms(scene: Scene) -> Findings:
    """Assess the experiment's conditions with free handles and held by the study's arms and agents."""
    experiment = scene.study.experiment
    if experiment is None:
        return Findings()
    connected = [(k, delay) for k, delay in experiment.conditions if k is not None]
    in_arms = stability_in_arms(scene.study, connected, scene.modules)
    if in_arms.holding is None:
        reason = f"Not known: {in_arms.unknown}."
        return Findings(numbers={"arms": {"known": False, "statements": [reason], "conditions": []}})
    numbers = {"known": True, "depends_on_pose": in_arms.poses is not None, **_holding(in_arms.holding)}
    if in_arms.poses is None:
        # For the paper's robots also its two largest stiffnesses as printed, rounded.
        printed = EXPERIMENT_STIFFNESSES[-2:] if scene.of_the_paper else ()
        more, drawing = _boundary(in_arms.holding, connected, printed)
    else:
        more, drawing = _along_the_path(in_arms, in_arms.holding, in_arms.poses)
    return Findings(numbers={"arms": {**numbers, **more}}, drawings={"arms": drawing})


SECTION = Section(
    name="arms",
    anchor="arms",
    title="How arms move the stability boundary",
    step="stability in arms",
    find=find_arms,
)


def _holding(holding: Holding) -> dict[str, Any]:
    return {
        "agent_stiffness": list(holding.agent_stiffness),
        "agent_damping": list(holding.agent_damping),
        "arm_mass": [list(mass) for mass in holding.arm_mass],
        "arm_damping": [list(damping) for damping in holding.arm_damping],
        "massless": not holding.has_arms,
    }


def _boundary(
    holding: Holding, connected: list[Condition], printed: tuple[float, ...]
) -> tuple[dict[str, Any], str]:
    """Compute the boundary over stiffness and delay for arms that do not depend on the pose."""
    first, second = (Operator(operator.mass, operator.damping) for operator in holding.held.operators)
    boundary = boundary_in_arms(
        holding.free,
        sorted({k for k, _ in connected} | set(printed)),
        agent_stiffness=holding.agent_stiffness,
        arms=(first, second),
        conditions=connected,
        horizon=max(1.0, *(1.1 * delay for _, delay in connected), 0.0),
    )
    drawing = figures.to_svg(
        draw(boundary),
        "arms",
        "Stability over stiffness and delay with the handles in arms",
        "One panel per axis. Shaded: stable while arms and agents hold both handles. Dashed: the boundary "
        "with free handles. Marks: the experiment's conditions. " + " ".join(boundary.statements()),
    )
    return boundary.numbers(), drawing


def _along_the_path(in_arms: InArms, holding: Holding, poses: Poses) -> tuple[dict[str, Any], str]:
    """Compute how stable the conditions are in the poses along the target's path."""
    free = [holding.free[name] for name in holding.free.axes]
    conditions = []
    for condition in in_arms.conditions:
        delay = 0.5 * sum(condition.delay)
        lost = [axis.name for axis in free if not axis.is_stable(condition.stiffness, delay)]
        assert condition.worst_position is not None
        conditions.append(
            {
                "stiffness": condition.stiffness,
                "delay": delay,
                "free": "unstable" if lost else "stable",
                "in_arms": "stable" if condition.stable else "unstable",
                "unstable_axes_free": lost,
                "unstable_axes_in_arms": None,
                "spectral_abscissa": condition.spectral_abscissa,
                "least_abscissa": condition.least_abscissa,
                "independent_abscissa": condition.independent_abscissa,
                "unstable_poses": condition.unstable_poses,
                "worst_position": list(condition.worst_position),
                "complete": condition.complete,
            }
        )
    statements = _statements(in_arms.conditions, poses)
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
                for condition in in_arms.conditions
            ],
            poses.places,
            poses.cross_inertia,
        ),
        "arms",
        "Stability in the poses along the target's path",
        "Left: the path with the cross-axis inertia of both sides. Right: for each condition the range of "
        "the spectral abscissa over the poses; above zero is unstable. " + " ".join(statements),
    )
    numbers = {
        "poses": len(poses.places),
        "along": poses.along,
        "axes_independent": poses.axes_are_independent,
        "cross_inertia": poses.cross_inertia.max(axis=0).tolist(),
        "conditions": conditions,
        "statements": statements,
    }
    return numbers, drawing


def _statements(conditions: tuple[ConditionInArms, ...], poses: Poses) -> list[str]:
    sentences = [f"{poses.in_words()}."]
    for condition in conditions:
        where = f"Condition {condition.stiffness:.0f} N/m, {500.0 * sum(condition.delay):.0f} ms"
        if not condition.stable:
            sentences.append(
                f"{where}: unstable in {condition.unstable_poses} of {len(poses.places)} poses, "
                f"{condition.pace()} in the worst."
            )
        if not condition.complete:
            sentences.append(f"{where}: it is not confirmed in every pose that no root was missed.")
    if conditions and all(condition.stable for condition in conditions):
        sentences.append("Every condition is stable in every pose.")
    return sentences
