"""The answer in short: how stiff the spring may be, by delay and by what the network promises."""

from __future__ import annotations

import math

from telespring.paper.reference import FACTORS
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section
from telespring.paper.sections.summary.allowed import summarise
from telespring.paper.sections.summary.answer import answer_study

__all__ = ["SECTION", "find_summary"]


def find_summary(scene: Scene) -> Findings:
    """Answer the study's question, and compute the largest stiffness by delay and by network."""
    answer = answer_study(scene.study, scene.modules) if scene.is_condition_given else None
    if answer is not None:
        answer["figure_5_panel"] = _panel_of_figure_5(scene)
    return Findings(numbers={"summary": {"answer": answer, **summarise(scene.study)}})


def _panel_of_figure_5(scene: Scene) -> str | None:
    """Return the letter of the paper's Fig. 5 that shows this very condition, to half a percent."""
    if not scene.of_the_paper:
        return None
    stiffness = scene.study.stiffness / scene.reference.stiffness
    delay = 0.5 * sum(scene.study.delay) / scene.reference.delay
    letters = iter("abcdefghijkl")
    for stiffness_factor in FACTORS:
        for delay_factor in (0.5, 1.0, 2.0):
            letter = next(letters)
            pairs = ((stiffness, stiffness_factor), (delay, delay_factor))
            if all(math.isclose(own, factor, rel_tol=5e-3) for own, factor in pairs):
                return letter
    return None


SECTION = Section(
    name="summary",
    anchor="summary",
    step="allowed stiffness",
    find=find_summary,
    mentions=("experiment", "calibration", "arms", "misprints"),
)
