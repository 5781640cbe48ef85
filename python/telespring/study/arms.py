"""What the stiffness of the arms that hold the handles does to the stability boundary."""

from __future__ import annotations

from telespring import figures
from telespring.arms_boundary import boundary_in_arms, draw
from telespring.study.part import Found, Scene

__all__ = ["find_arms"]


def find_arms(scene: Scene) -> Found:
    """Judge the experiment's conditions with free handles and held by the agents' springs."""
    experiment = scene.study.experiment
    if experiment is None or any(agent["kind"] == "python" for agent in experiment.agents):
        # Of a program nobody knows the stiffness.
        return Found()
    one, two = (float(agent["stiffness"]) for agent in experiment.agents)
    connected = [(k, delay) for k, delay in experiment.conditions if k is not None]
    found = boundary_in_arms(
        scene.dyad,
        sorted({k for k, _ in connected}),
        agent_stiffness=(one, two),
        conditions=connected,
    )
    svg = figures.to_svg(
        draw(found),
        "arms",
        "Stability over stiffness and delay with the handles in arms",
        "One panel per axis. Shaded is what is stable while springs to the ground hold both handles; a "
        "dashed line is the boundary with free handles; marks are the experiment's conditions. "
        + " ".join(found.statements()),
    )
    return Found(numbers={"arms": found.numbers()}, drawings={"arms": svg})
