"""Figs. 1, 2 and 6: what is coupled, how, and what stands in the laboratory."""

from __future__ import annotations

from telespring import figures
from telespring.study.part import Found, Scene

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
    if len(scene.axes) == 2:
        drawings["laboratory"] = figures.to_svg(
            figures.laboratory_schematic(),
            "laboratory",
            "The laboratory: two robots, each moved by a two-link arm",
            "Left robot: its arm follows a target on a figure of eight. Right robot: its arm follows a "
            "cloud of ten spots about the same target. A virtual spring over a delayed network joins "
            "the two handles.",
        )
    return Found(drawings=drawings)
