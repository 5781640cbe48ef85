"""Two dyads on which the paper's formulas fail: by unequal dampings, and by a return of stability."""

from __future__ import annotations

import numpy as np

from telespring._json import finite_or_none
from telespring.model import DyadAxis
from telespring.paper.misprints import RETURNING
from telespring.paper.reference import classify
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section
from telespring.show import figures
from telespring.theory.criteria import maximum_delay

__all__ = ["SECTION", "find_examples"]


def find_examples(scene: Scene) -> Findings:
    """Compute the exact and the printed stable regions of both dyads, which are the same in every study."""
    if not scene.of_the_paper:
        return Findings()
    unequal = DyadAxis(1.0, 1.0, 1.0, 10.0)
    parameters, returning_stiffness = RETURNING
    returning = DyadAxis(*parameters)
    just_below_eq_5 = 0.99 * unequal.critical_stiffness("paper")
    panels, numbers = [], {}
    settings = (
        ("unequal_damping", unequal, "m = 1, 1 kg, b = 1, 10 N·s/m", 40.0, 0.8, (just_below_eq_5, 0.175)),
        (
            "stability_returns",
            returning,
            "m = 0.98, 0.30 kg, b = 2.2, 4.6 N·s/m",
            16.0,
            3.0,
            (returning_stiffness, 1.95),
        ),
    )
    for key, axis, title, widest, longest, mark in settings:
        stiffness = np.linspace(0.0, widest, 481)[1:]
        columns = [
            figures.MapColumn(float(k), axis.stable_delays(float(k), figures.HORIZON * longest))
            for k in stiffness
        ]
        printed = np.asarray(maximum_delay(*axis.parameters, stiffness, method="paper"), dtype=float)
        panels.append((title, columns, printed))
        numbers[key] = {
            "mass": list(axis.masses),
            "damping": list(axis.dampings),
            "critical_stiffness": axis.critical_stiffness(),
            "critical_stiffness_paper": axis.critical_stiffness("paper"),
            "boundary": [
                {
                    "stiffness": column.stiffness,
                    "stable_delays": [
                        list(interval) for interval in axis.stable_delays(column.stiffness, 1.01 * longest)
                    ],
                    "maximum_delay_paper": finite_or_none(float(delay)),
                }
                for column, delay in list(zip(columns, printed, strict=True))[::16]
            ],
            "mark": {"stiffness": mark[0], "delay": mark[1], "verdict": classify(axis, *mark)},
        }
    svg = figures.to_svg(
        figures.region_map(
            panels,
            longest=[longest for *_, longest, _ in settings],
            marks=[mark for *_, mark in settings],
        ),
        "examples",
        "Two dyads on which the paper's formulas fail",
        "Left: with dampings 1 and 10 the paper calls a hatched region stable that is not. Right: a dyad "
        "whose stable delays are two separate intervals, so that a cross lies in a stable region above an "
        "unstable one.",
    )
    return Findings(numbers={"examples": numbers}, drawings={"examples": svg})


SECTION = Section(
    name="examples",
    anchor="examples",
    title="Where the paper's formulas fail",
    step="where the formulas fail",
    find=find_examples,
)
