"""What explains the published Table I: named hypotheses beside the printed values and the null."""

from __future__ import annotations

from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section
from telespring.show import figures

__all__ = ["SECTION", "find_calibration"]


def find_calibration(scene: Scene) -> Findings:
    """Fit and judge, for the paper's own experiment only: no table of another is published."""
    from telespring.paper.calibration import calibrate
    from telespring.paper.sections.calibration.drawing import draw_cells
    from telespring.paper.sections.calibration.numbers import calibration_numbers
    from telespring.paper.sections.calibration.statements import calibration_statements

    if scene.study.experiment is None or not scene.of_the_papers_experiment:
        return Findings()
    calibration = calibrate(scene.study)
    statements, questions = calibration_statements(calibration)
    return Findings(
        numbers={
            "calibration": {
                **calibration_numbers(calibration),
                "statements": statements,
                "questions": questions,
            }
        },
        drawings={
            "calibration": figures.to_svg(
                draw_cells(calibration),
                "calibration",
                "Published and computed tracking error of every condition of Table I",
                "One panel per robot: published means with standard deviations, and what each hypothesis "
                "gives.",
            ),
        },
    )


SECTION = Section(
    name="calibration",
    anchor="calibration",
    title="What explains the published Table I",
    step="hypotheses on Table I",
    find=find_calibration,
)
