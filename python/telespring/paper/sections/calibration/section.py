"""Estimates of the paper's real arms from five rows of its Table I, and prediction of the other rows."""

from __future__ import annotations

from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section
from telespring.show import figures

__all__ = ["SECTION", "find_calibration"]


def find_calibration(scene: Scene) -> Findings:
    """Fit and predict, for the paper's own experiment only: no table of another is published."""
    from telespring.paper.calibration import calibrate, draw_cells, draw_pairs, draw_profiles
    from telespring.paper.sections.calibration.statements import calibration_statements

    if scene.study.experiment is None or not scene.of_the_papers_experiment:
        return Findings()
    calibration = calibrate(scene.study)
    return Findings(
        numbers={"calibration": {**calibration.numbers(), "statements": calibration_statements(calibration)}},
        drawings={
            "calibration": figures.to_svg(
                draw_cells(calibration),
                "calibration",
                "Simulated and published tracking error, every cell of Table I",
                "Fitted conditions are separate from predicted ones.",
            ),
            "profiles": figures.to_svg(
                draw_profiles(calibration),
                "profiles",
                "Profile likelihood of each unknown",
                "One panel per unknown: rise of the deviance with the other unknowns refitted.",
            ),
            "pairs": figures.to_svg(
                draw_pairs(calibration),
                "pairs",
                "Likelihood of pairs of unknowns",
                "A panel per pair: where the fit is nearly as good as at the optimum.",
            ),
        },
    )


SECTION = Section(
    name="calibration",
    anchor="calibration",
    title="Estimating the real arms from Table I",
    step="fit of the real arms",
    find=find_calibration,
)
