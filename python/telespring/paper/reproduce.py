"""Reproduce the paper on a study's robots: compute all sections, render the page, write the files."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from telespring._files import replacing
from telespring.model import Study
from telespring.paper.page import render
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section
from telespring.paper.sections import SECTIONS, order_of_computation

__all__ = ["PARTS", "QUICK_PARTS", "STEPS", "Analysis", "analyse", "write"]

#: The sections that compute something, in the order of their keys in `study.json`.
PARTS = order_of_computation(SECTIONS)

#: Those of a quick reproduction: none that runs an experiment.
QUICK_PARTS = tuple(section for section in PARTS if not section.is_long)


def _awaited_last(parts: Sequence[Section]) -> list[Section]:
    """Order sections so that those which compute beside the others are awaited after them."""
    return sorted(parts, key=lambda section: section.start is not None)


#: The names of the steps, in order, as `progress` receives them.
STEPS = (*(section.step for section in _awaited_last(PARTS)), "report")


@dataclass(frozen=True)
class Analysis:
    """Numbers and report of one study.

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
    parts: Sequence[Section] | None = None,
    date: str = "",
) -> Analysis:
    """Compute the paper's figures, tables and experiment for a study's robots.

    Parameters
    ----------
    study
        Robots, coupling and network, as `telespring.Study.read` returns them.
    progress
        Called with the name of each step (one of `STEPS`) as it begins.
    rehearsal
        Folder for the experiment's trials, which end up there as `rehearsal.nc`. Trials of this study that
        are already there are not run again; those of another study are removed. By default no trial is kept.
    modules
        Folder in which Python agents and targets are looked up first.
    parts
        Any of `PARTS`, in their order; all by default. The results of a section do not depend on which
        others are computed.

    date
        When the page is made, as it is to be printed on it; by default no date is printed.

    Returns
    -------
    Analysis
        Numbers and page. The same study and date give the same bytes.

    Raises
    ------
    telespring.InvalidInput
        If the robots allow no such study (one has no damping, or so much or so little that a figure would
        leave the ranges in which the core computes), or if the program of an agent or a target fails.
    OSError
        If the rehearsal cannot be written.
    """
    findings: dict[str, Findings] = {}
    computed = [section for section in (PARTS if parts is None else parts) if section.find is not None]
    with ExitStack() as begun:
        if rehearsal is None:
            rehearsal = begun.enter_context(TemporaryDirectory(prefix="telespring-"))
        scene = Scene.of(study, Path(rehearsal), modules)
        wait_for = {
            section.name: begun.enter_context(section.start(scene)) for section in computed if section.start
        }
        for section in _awaited_last(computed):
            assert section.find is not None
            if progress is not None:
                progress(section.step)
            wait = wait_for.get(section.name)
            findings[section.name] = section.find(scene) if wait is None else wait()
    if progress is not None:
        progress(STEPS[-1])
    described = scene.describe_study()
    numbers: dict[str, Any] = {"schema": "telespring study 2", "study": described}
    for section in computed:
        numbers |= findings[section.name].numbers
    return Analysis(numbers=numbers, html=render(described, findings, date))


def write(analysis: Analysis, folder: str | os.PathLike[str]) -> tuple[Path, Path]:
    """Write `report.html` and `study.json` into `folder`, created if it is missing; return both paths.

    Both are completely written and flushed to the disk before either replaces an older file, so that a page
    is never next to another study's numbers.
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
