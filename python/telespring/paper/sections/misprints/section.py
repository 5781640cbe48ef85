"""The paper's misprints, each with the numbers that prove it."""

from __future__ import annotations

from telespring.paper.misprints import misprints
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section

__all__ = ["SECTION", "find_misprints"]


def find_misprints(scene: Scene) -> Findings:
    """Compute printed and correct values; the misprints are the same in every study."""
    if not scene.of_the_paper:
        return Findings()
    return Findings(numbers={"misprints": [misprint.to_json() for misprint in misprints()]})


SECTION = Section(
    name="misprints",
    anchor="misprints",
    title="The paper's misprints, with numbers",
    step="misprints",
    find=find_misprints,
)
