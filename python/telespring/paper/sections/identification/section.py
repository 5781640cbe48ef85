"""Figs. 9 and 10: identification of both robots on the simulated rig."""

from __future__ import annotations

from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Place, Section
from telespring.show import figures

__all__ = ["SECTION", "find_identification"]


def find_identification(scene: Scene) -> Findings:
    """Drive the study's bare robots with the paper's excitation and identify them from noisy logs."""
    from telespring.paper.sections.identification.numbers import study_identification
    from telespring.show.drawings.identification import draw_excitation, draw_regression, draw_residuals

    identification = study_identification(scene.study)
    names = [scene.robot_name(i) for i in (0, 1)]
    drawings = {
        "excitation": figures.to_svg(
            draw_excitation(identification.movements),
            "excitation",
            "Velocity, position and acceleration of the excitation",
            "Two columns, the paper's movement and a designed one, over one period.",
        ),
        "regression": figures.to_svg(
            draw_regression(list(zip(names, identification.robots, strict=True))),
            "regression",
            "Measured and estimated force, and its plane over velocity and acceleration",
            "A row per robot and axis: force over time on the left, samples and plane on the right.",
        ),
    }
    for i, (name, robot) in enumerate(zip(names, identification.robots, strict=True), start=1):
        drawings[f"residuals{i}"] = figures.to_svg(
            draw_residuals(robot),
            f"residuals{i}",
            f"Residuals of the force, {name}",
            "A row per axis: over time, over velocity, and the autocorrelation.",
        )
    return Findings(numbers={"identification": identification.numbers}, drawings=drawings)


SECTION = Section(
    name="identification",
    anchor="identification",
    title="Identification",
    step="Figs. 9 and 10, identification",
    find=find_identification,
    holds=(Place("Fig. 9", "figure-excitation"), Place("Fig. 10", "figure-regression")),
    mentions=("laboratory",),
    is_long=True,
)
