"""The unknowns of the paper's real arms, from five rows of its Table I, and the rest predicted."""

from __future__ import annotations

from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section
from telespring.show import figures

__all__ = ["SECTION", "find_calibration"]


def find_calibration(scene: Scene) -> Findings:
    """Fit and predict, for the paper's own experiment only: nobody published a table of another."""
    from telespring.paper.calibration import calibrate, draw_cells, draw_pairs, draw_profiles

    if scene.study.experiment is None or not scene.of_the_papers_experiment:
        return Findings()
    found = calibrate(scene.study)
    return Findings(
        numbers={"calibration": found.numbers()},
        drawings={
            "calibration": figures.to_svg(
                draw_cells(found),
                "calibration",
                "Simulated beside published tracking error, every cell of Table I",
                "Conditions that were fitted stand apart from those that were predicted.",
            ),
            "profiles": figures.to_svg(
                draw_profiles(found),
                "profiles",
                "Profile likelihood of each unknown",
                "A panel per unknown: how the deviance rises, the others fitted again.",
            ),
            "pairs": figures.to_svg(
                draw_pairs(found),
                "pairs",
                "Likelihood of pairs of unknowns",
                "A panel per pair: where the fit is nearly as good as at the best point.",
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
