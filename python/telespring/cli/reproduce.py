"""The command `telespring reproduce`, and its earlier name `telespring study`."""

from __future__ import annotations

import sys
from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from telespring.cli.common import (
    AllowUnusual,
    Robot1,
    Robot2,
    Robots,
    StudyFile,
    print_notes,
    refusals,
)
from telespring.cli.figure_file import check_folder_keeps_inputs
from telespring.cli.question import StudyOptions
from telespring.cli.terminal import screen_console
from telespring.model import Study

__all__ = ["reproduce_command", "study_command"]

Out = Annotated[
    Path | None,
    typer.Option(
        help="Folder for report.html, study.json and rehearsal.nc.",
        show_default="out/study, or out/study-quick with --quick",
    ),
]


def reproduce_command(
    study: StudyFile = None,
    robot: Robots = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    out: Out = None,
    quick: Annotated[
        bool,
        typer.Option("--quick", help="Leave out all that needs trials: the experiment and what follows."),
    ] = False,
    allow_unusual: AllowUnusual = False,
) -> None:
    """Reproduce the paper: every figure and table, on the robots of a study, as one report.

    If interrupted, run the same command again to resume: finished trials are kept.
    """
    console = screen_console()
    folder = out or Path("out/study-quick" if quick else "out/study")
    asked = StudyOptions(study)
    with refusals(asked.options):
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        from telespring.paper import QUICK_PARTS, STEPS, analyse, write
        from telespring.rehearsal.store import REHEARSAL_FILES
        from telespring.show.screens.reproduction import allowed_stiffnesses

        asked.take_robots(robot, robot1, robot2)
        written = ("report.html", "study.json", *(() if quick else REHEARSAL_FILES))
        check_folder_keeps_inputs("--out", folder, written, asked.inputs)
        asked.allow_unusual(is_allowed=allow_unusual)
        read, records = asked.read(Study.paper()), asked.records()
        with Progress(
            TextColumn("{task.description:<28}"),
            BarColumn(),
            TimeElapsedColumn(),
            console=console,
            transient=True,
        ) as bar:
            steps = [*(part.step for part in QUICK_PARTS), STEPS[-1]] if quick else [*STEPS]
            task = bar.add_task("starting", total=len(steps))

            def progress(step: str) -> None:
                bar.update(task, description=step, completed=steps.index(step))

            modules = None if study is None else study.parent
            analysis = analyse(
                read,
                progress,
                rehearsal=None if quick else folder,
                modules=modules,
                parts=QUICK_PARTS if quick else None,
                date=f"{datetime.now().astimezone():%Y-%m-%d}",
            )
        report, numbers = write(analysis, folder)
    console.print(f"[bold]{escape(read.name)}[/bold]")
    for line in allowed_stiffnesses(analysis.numbers["summary"]):
        console.print(line, markup=False)
    print_notes(console, records)
    console.print(f"Report:  {report}\nNumbers: {numbers}", markup=False)
    if quick:
        console.print("Left out: the experiment, and what follows from it.", markup=False)
    if "experiment" in analysis.numbers:
        console.print(f"Trials:  {folder / 'rehearsal.nc'}", markup=False)


def study_command(
    study: StudyFile = None,
    robot: Robots = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    out: Out = None,
    allow_unusual: AllowUnusual = False,
) -> None:
    """Run `telespring reproduce` under its earlier name."""
    print("`telespring study` is now `telespring reproduce`.", file=sys.stderr)
    reproduce_command(study, robot, robot1, robot2, out, allow_unusual=allow_unusual)
