"""The command `telespring reproduce`, and its earlier name `telespring study`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape

from telespring.cli.common import Robot1, Robot2, StudyFile, read_study, refusals, robot_warnings
from telespring.show.screens.decision import digits_down

__all__ = ["reproduce_command", "study_command"]

Out = Annotated[Path, typer.Option(help="Folder for report.html, study.json and rehearsal.nc.")]


def reproduce_command(
    study: StudyFile = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    out: Out = Path("out/study"),
) -> None:
    """Run the whole paper on a study's robots, stability and experiment, and write a report.

    Stopped at any moment, the same command goes on with the trials that are not yet run.
    """
    console = Console(highlight=False)
    with refusals():
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        from telespring.paper import STEPS, analyse, write

        asked, beware = read_study(study, robot1, robot2), robot_warnings(robot1, robot2)
        with Progress(
            TextColumn("{task.description:<28}"),
            BarColumn(),
            TimeElapsedColumn(),
            console=console,
            transient=True,
        ) as bar:
            task = bar.add_task("starting", total=len(STEPS))

            def progress(step: str) -> None:
                bar.update(task, description=step, completed=STEPS.index(step))

            modules = None if study is None else study.parent
            analysis = analyse(asked, progress, rehearsal=out, modules=modules)
        report, numbers = write(analysis, out)
    summary = analysis.numbers["summary"]
    row = summary["rows"][summary["highlight"]]
    console.print(f"[bold]{escape(asked.name)}[/bold]")
    console.print(f"Over {1e3 * row['delay']:.0f} ms each way the spring may have up to")
    for tier in summary["tiers"]:
        entry = row[tier["key"]]
        if entry["unbounded"]:
            limit = "no limit"
        elif entry["stiffness"] is None:
            limit = "not available"
        else:
            limit = f"{digits_down(entry['stiffness'])} N/m (axis {entry['axis']})"
        console.print(f"  {limit:<24} {tier['name']}", markup=False)
    for line in beware:
        console.print(line, markup=False)
    console.print(f"Report:  {report}\nNumbers: {numbers}", markup=False)
    if "experiment" in analysis.numbers:
        console.print(f"Trials:  {out / 'rehearsal.nc'}", markup=False)


def study_command(
    study: StudyFile = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    out: Out = Path("out/study"),
) -> None:
    """Run `telespring reproduce` under its earlier name."""
    print("`telespring study` is now `telespring reproduce`.", file=sys.stderr)
    reproduce_command(study, robot1, robot2, out)
