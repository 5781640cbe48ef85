"""Figs. 1 and 2: two robots joined by a virtual spring, and the control loop that they make."""

from __future__ import annotations

from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Place, Section
from telespring.show import figures

__all__ = ["SECTION", "draw_model"]


def draw_model(_scene: Scene) -> Findings:
    """Draw the dyad and its control loop; both are the same in every study."""
    return Findings(
        drawings={
            "dyad": figures.to_svg(
                figures.dyad_schematic(),
                "dyad",
                "Two robots joined by a virtual spring",
                "Two masses m1 and m2, each with a damper b1 or b2 to the ground, with a virtual spring k "
                "between them. The operators push with f1 and f2. Each end of the spring receives the "
                "partner's position after one delay.",
            ),
            "loop": figures.to_svg(
                figures.loop_schematic(),
                "loop",
                "Control loop of the dyad with its round trip",
                "A ring. The position of robot 1 goes through a delay to robot 2, whose position goes "
                "through a delay back to robot 1. In each robot the spring k pulls by the difference from "
                "the delayed position, the operator's force is added, and mass and damper respond.",
            ),
        }
    )


SECTION = Section(
    name="model",
    anchor="model",
    title="The model",
    step="Figs. 1 and 2, schematics",
    find=draw_model,
    holds=(Place("Fig. 1", "figure-dyad"), Place("Fig. 2", "figure-loop")),
)
