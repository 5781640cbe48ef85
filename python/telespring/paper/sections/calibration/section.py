"""What explains the published Table I: named hypotheses beside the printed values and the null."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TYPE_CHECKING

from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section
from telespring.show import figures

if TYPE_CHECKING:
    from telespring.paper.calibration import Calibration

__all__ = ["SECTION", "find_calibration", "start_calibration"]


def find_calibration(scene: Scene) -> Findings:
    """Fit and judge, for the paper's own experiment only: no table of another is published."""
    with start_calibration(scene) as wait:
        return wait()


@contextmanager
def start_calibration(scene: Scene) -> Iterator[Callable[[], Findings]]:
    """Begin the fits, which other processes compute; give the function that waits for their findings."""
    from telespring.paper.calibration import calibrate
    from telespring.paper.calibration.processes import Processes

    if scene.study.experiment is None or not scene.of_the_papers_experiment:
        yield Findings
        return
    processes = Processes()
    with ThreadPoolExecutor(1) as thread:
        calibration = thread.submit(calibrate, scene.study, processes=processes)
        try:
            yield lambda: _findings(calibration.result())
        finally:
            processes.end()


def _findings(calibration: Calibration) -> Findings:
    """Write the numbers and draw the figure: here, because matplotlib draws in one thread only."""
    from telespring.paper.sections.calibration.drawing import draw_cells
    from telespring.paper.sections.calibration.numbers import calibration_numbers
    from telespring.paper.sections.calibration.statements import calibration_statements

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
    start=start_calibration,
    is_long=True,
)
