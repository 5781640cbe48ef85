"""What the arms and agents that hold the handles do to the stability of the study's conditions."""

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
    """Judge the experiment's conditions with free handles and held by the study's arms and agents."""
    experiment = scene.study.experiment
    if experiment is None:
        return Findings()
    connected = [(k, delay) for k, delay in experiment.conditions if k is not None]
    found = stability_in_arms(scene.study, connected, scene.modules)
    if found.holding is None:
        why = f"Not known: {found.unknown}."
        return Findings(numbers={"arms": {"known": False, "statements": [why], "conditions": []}})
    numbers = {"known": True, "depends_on_pose": found.poses is not None, **_holding(found.holding)}
    if found.poses is None:
        # For its robots also the two largest stiffnesses as the paper prints them, rounded.
        printed = EXPERIMENT_STIFFNESSES[-2:] if scene.of_the_paper else ()
        more, drawing = _boundary(found.holding, connected, printed)
    else:
        more, drawing = _along_the_path(found, found.holding, found.poses)
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
        "arm_mass": [list(each) for each in holding.arm_mass],
        "arm_damping": [list(each) for each in holding.arm_damping],
        "massless": not holding.has_arms,
    }


def _boundary(
    holding: Holding, connected: list[Condition], printed: tuple[float, ...]
) -> tuple[dict[str, Any], str]:
    """Find the boundary over stiffness and delay, where arms are alike in every pose."""
    first, second = (Operator(each.mass, each.damping) for each in holding.held.operators)
    found = boundary_in_arms(
        holding.free,
        sorted({k for k, _ in connected} | set(printed)),
        agent_stiffness=holding.agent_stiffness,
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


def _along_the_path(found: InArms, holding: Holding, poses: Poses) -> tuple[dict[str, Any], str]:
    """Tell how stable the conditions are in the poses along the target's path."""
    free = [holding.free[name] for name in holding.free.axes]
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
    found = [f"{poses.in_words()}."]
    for each in conditions:
        where = f"Condition {each.stiffness:.0f} N/m, {500.0 * sum(each.delay):.0f} ms"
        if not each.stable:
            found.append(
                f"{where}: unstable in {each.unstable_poses} of {len(poses.places)} poses, {each.pace()} "
                f"in the worst."
            )
        if not each.complete:
            found.append(f"{where}: that no root was missed is not certain in every pose.")
    if conditions and all(each.stable for each in conditions):
        found.append("Every condition is stable in every pose.")
    return found
