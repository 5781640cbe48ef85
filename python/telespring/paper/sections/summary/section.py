"""The answer in short: how stiff the spring may be, by delay and by what the network promises."""

from __future__ import annotations

from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section
from telespring.paper.sections.summary.allowed import summarise

__all__ = ["SECTION", "find_summary"]


def find_summary(scene: Scene) -> Findings:
    """Compute the largest stiffness for each one-way delay and each promise of the network."""
    return Findings(numbers={"summary": summarise(scene.study)})


SECTION = Section(name="summary", anchor="summary", step="allowed stiffness", find=find_summary)
