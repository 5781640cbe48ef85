"""Figs. 1, 2 and 6: what is coupled, how, and what stands in the laboratory."""

from __future__ import annotations

from typing import Literal

from telespring.model import Experiment
from telespring.paper.scene import Found, Scene
from telespring.rehearsal.target import target_path
from telespring.show import figures

__all__ = ["find_schematics"]


def find_schematics(scene: Scene) -> Found:
    """Draw the model, its control loop and, for robots with the laboratory's two axes, the laboratory."""
    drawings = {
        "dyad": figures.to_svg(
            figures.dyad_schematic(),
            "dyad",
            "Two robots joined by a virtual spring",
            "Two masses m1 and m2, each with a damper b1 or b2 to the ground, with a virtual spring k "
            "between them. The operators push with f1 and f2. Each end of the spring takes the partner's "
            "position one delay late.",
        ),
        "loop": figures.to_svg(
            figures.loop_schematic(),
            "loop",
            "Control loop of the dyad with its round trip",
            "A ring. The position of robot 1 goes through a delay to robot 2, whose position goes "
            "through a delay back to robot 1. In each robot the spring k pulls by the difference from "
            "the delayed position, the operator's force is added, and mass and damper answer.",
        ),
    }
    experiment = scene.study.experiment
    if experiment is not None:
        sides = (_side(scene, experiment, 0), _side(scene, experiment, 1))
        drawings["laboratory"] = figures.to_svg(
            figures.laboratory_schematic(target_path(experiment, scene.modules), sides),
            "laboratory",
            "The laboratory: two robots and what holds them",
            "The target's path, once for each agent, above the robots from above. "
            + " ".join(
                f"{side.robot}: agent {' '.join(side.agent.split())}, {' '.join(side.arm.split())}."
                for side in sides
            )
            + " A virtual spring over a delayed network joins the two handles.",
        )
    return Found(drawings=drawings)


def _side(scene: Scene, experiment: Experiment, i: int) -> figures.DrawnSide:
    """Say what stands on one side of the laboratory."""
    agent, arm = experiment.agents[i], experiment.arms[i]
    spots = agent["spots"] if agent["kind"] == "blurred" else 0
    if agent["kind"] == "python":
        followed = "program\n" + agent["class"].rpartition(":")[2][-18:]
    elif spots:
        followed = f"less skilled:\n{spots} spot{'s' if spots > 1 else ''}"
    else:
        followed = "skilled"
    links: dict[str, tuple[Literal["drawn", "dashed", "block", "none"], str]] = {
        "two-link": ("drawn", "two-link arm"),
        "lumped": ("block", "arm: a mass and a damper"),
        "massless": ("none", "massless arm"),
    }
    drawn, words = links[arm["kind"]]
    elbow = arm.get("elbow") or ("left", "right")[i]
    if arm["kind"] == "massless" and scene.of_the_papers_experiment:
        drawn, words = "dashed", "two-link arm,\nhere massless"
    return figures.DrawnSide(scene.robot_name(i), followed, spots, words, drawn, elbow)
