"""All parts of a study, one after the other: numbers first, then the page, then files."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from telespring._files import replacing
from telespring.model import Study
from telespring.paper.page import render
from telespring.paper.scene import Part, Scene
from telespring.paper.sections.arms.section import find_arms
from telespring.paper.sections.calibration.section import find_calibration
from telespring.paper.sections.experiment.section import find_experiment
from telespring.paper.sections.frequency.section import find_frequency
from telespring.paper.sections.identification.section import find_identification
from telespring.paper.sections.laboratory.section import find_laboratory
from telespring.paper.sections.map.section import find_examples, find_map
from telespring.paper.sections.misprints.section import find_misprints
from telespring.paper.sections.model.section import find_schematics
from telespring.paper.sections.number_sets.section import find_number_sets
from telespring.paper.sections.nyquist.section import find_nyquist
from telespring.paper.sections.responses.section import find_responses
from telespring.paper.sections.robots.section import find_allowed, find_reference

__all__ = ["PARTS", "STEPS", "Analysis", "analyse", "write"]

#: In the order in which they are found and in which their keys stand in `study.json`.
PARTS = (
    Part("what the dyad may use", find_allowed),
    Part("Figs. 1 and 2, schematics", find_schematics),
    Part("Table III", find_reference),
    Part("Table II", find_number_sets),
    Part("Fig. 3, Nyquist loci", find_nyquist),
    Part("Fig. 4, frequency response", find_frequency),
    Part("Fig. 5, responses", find_responses),
    Part("stability map", find_map),
    Part("Fig. 6, the laboratory", find_laboratory),
    Part("Figs. 7 and 8, Table I", find_experiment),
    Part("fit of the real arms", find_calibration),
    Part("the arms' own stiffness", find_arms),
    Part("Figs. 9 and 10, identification", find_identification),
    Part("where the formulas fail", find_examples),
    Part("misprints", find_misprints),
)

#: The names of the steps, in order, as `progress` is told them.
STEPS = (*(part.name for part in PARTS), "report")


@dataclass(frozen=True)
class Analysis:
    """What a study's analysis found.

    Attributes
    ----------
    numbers
        The content of `study.json`.
    html
        The report, one page with nothing loaded from elsewhere.
    """

    numbers: dict[str, Any]
    html: str


def analyse(
    study: Study,
    progress: Callable[[str], None] | None = None,
    *,
    rehearsal: str | os.PathLike[str] | None = None,
    modules: Path | None = None,
    parts: Sequence[Part] | None = None,
) -> Analysis:
    """Run the paper on a study's robots.

    Parameters
    ----------
    study
        Robots, coupling and network, as `telespring.Study.read` gives them.
    progress
        Called with the name of each step (one of `STEPS`) as it begins; nothing is called unless given.
    rehearsal
        Folder in which the experiment's trials are kept, in the end as `rehearsal.nc`; trials of this study
        that are there are not run again, those of another are removed. Nothing is kept unless given.
    modules
        Where agents and targets in Python are looked up first.
    parts
        Which of `PARTS` to find, in their order, the first among them; all unless given. A part that looks
        at the same study finds the same, whatever others are found.

    Returns
    -------
    Analysis
        Numbers and page. The same study gives the same bytes.

    Raises
    ------
    telespring.InvalidInput
        Where the robots allow no such study: one has no damping, or so much or so little that a figure
        would leave the ranges in which the core computes. Where a program of an agent or a target fails.
    OSError
        Where the rehearsal cannot be kept.
    """
    begin = progress or _say_nothing
    scene = Scene.of(study, None if rehearsal is None else Path(rehearsal), modules)
    numbers: dict[str, Any] = {"schema": "telespring study 1"}
    drawings: dict[str, str] = {}
    for part in PARTS if parts is None else parts:
        begin(part.name)
        found = part.find(scene)
        numbers.update(found.numbers)
        drawings.update(found.drawings)
    begin(STEPS[-1])
    return Analysis(numbers=numbers, html=render(numbers, drawings))


def _say_nothing(step: str) -> None:
    """Take the place of a progress bar that nobody asked for."""


def write(analysis: Analysis, folder: str | os.PathLike[str]) -> tuple[Path, Path]:
    """Write `report.html` and `study.json` into `folder`.

    Both are written whole and flushed to the disk beside their places before either is moved there, so
    that no page stands beside another study's numbers.

    Parameters
    ----------
    analysis
        What `analyse` returned.
    folder
        Made where it is missing.

    Returns
    -------
    report, numbers
        The two paths.

    Raises
    ------
    OSError
        Where the folder cannot be written.
    """
    text = json.dumps(analysis.numbers, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    report, numbers = Path(folder) / "report.html", Path(folder) / "study.json"
    with replacing(report) as report_beside, replacing(numbers) as numbers_beside:
        for beside, content in ((report_beside, analysis.html), (numbers_beside, text)):
            with beside.open("wb") as file:
                file.write(content.encode())
                file.flush()
                os.fsync(file.fileno())
    return report, numbers
