"""The command `telespring analyse`."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from telespring._errors import InvalidInput
from telespring.cli.common import refusals
from telespring.model import Study

__all__ = ["analyse_command"]


def analyse_command(
    path: Annotated[
        Path | None,
        typer.Argument(metavar="PATH", help="A rehearsal (.nc or its folder) or recorded trials (CSV)."),
    ] = None,
    study: Annotated[
        Path | None, typer.Option(help="Study whose task is the target of trials recorded without one.")
    ] = None,
    discard: Annotated[
        float | None,
        typer.Option(help="First part of every trial to leave out, s; as recorded unless given."),
    ] = None,
    baseline: Annotated[
        str | None, typer.Option(help="Condition whose TE2 all is compared with; unconnected unless given.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for analysis.json, table1.csv and the figures.")] = Path(
        "out/analysis"
    ),
    export: Annotated[
        Path | None, typer.Option(help="Write the trials as CSV into this folder, too.")
    ] = None,
    figures: Annotated[bool, typer.Option(help="Draw Figs. 7 and 8.")] = True,
    template: Annotated[
        Path | None, typer.Option(help="Write an example of recorded trials into this folder, and stop.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print analysis.json instead of the table.")
    ] = False,
) -> None:
    """Measure the trials of an experiment, rehearsed or recorded, and compare its conditions."""
    console = Console(highlight=False)
    with refusals():
        from telespring import analysis
        from telespring.analysis.sources import open_trials, write_analysis
        from telespring.show.screens.analysis import analysis_screen

        if template is not None:
            console.print(f"Written: {analysis.write_template(template)}", markup=False)
            return
        if path is None:
            raise InvalidInput(
                "PATH", "missing", "a rehearsal or recorded trials are needed", "Name a file or a folder."
            )
        # Any: a study without an experiment has None there.
        asked: Any = None if study is None else getattr(Study.read(study), "experiment", None)
        if study is not None and asked is None:
            raise InvalidInput(
                "study",
                str(study),
                "a study whose robots have the axes x and y is needed",
                "Only those have a task.",
            )
        dataset = open_trials(path, None if asked is None else asked.task)
        if discard is None and asked is not None and "discard" not in dataset.attrs:
            discard = float(asked.discard)
        trials = analysis.take_trials(dataset, discard)
        numbers = analysis.analyse_taken(trials, analysis.measure_trials(trials), baseline)
        written = write_analysis(trials, numbers, out, figures=figures)
        if export is not None:
            written = (*written, analysis.write_recorded(dataset, export))
    if as_json:
        escape_letters = not sys.stdout.encoding.lower().startswith("utf")
        typer.echo(json.dumps(numbers, indent=1, ensure_ascii=escape_letters, allow_nan=False))
        return
    console.print(analysis_screen(numbers, str(path)))
    if "resampled_to" in dataset.attrs:
        period = 1e3 * dataset.attrs["resampled_to"]
        console.print(f"The trials' samples lay at different times: put on a grid of {period:.4g} ms.")
    console.print(f"Written: {', '.join(str(each) for each in written)}", markup=False)
