"""The answer in short: how stiff the spring may be, by delay and by what the network promises."""

from __future__ import annotations

from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section
from telespring.paper.sections.summary.allowed import summarise
from telespring.paper.sections.summary.answer import answer_study

__all__ = ["SECTION", "find_summary"]


def find_summary(scene: Scene) -> Findings:
    """Answer the study's question, and compute the largest stiffness by delay and by network."""
    answer = answer_study(scene.study) if scene.is_condition_given else None
    return Findings(numbers={"summary": {"answer": answer, **summarise(scene.study)}})


SECTION = Section(
    name="summary",
    anchor="summary",
    step="allowed stiffness",
    find=find_summary,
    mentions=("experiment", "calibration", "arms", "misprints"),
)
