"""The command `telespring analyse`: measure and compare trials, and write tables and figures."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.text import Text

from telespring._errors import InvalidInput
from telespring._files import replacing, write_whole
from telespring.cli.analyse_session import analyse_session_file
from telespring.cli.common import TaskStudy, print_json, refusals
from telespring.cli.figure_file import check_folder_keeps_inputs
from telespring.cli.other_files import pointing_elsewhere
from telespring.cli.terminal import show
from telespring.cli.units import TIME, number
from telespring.model import Study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from telespring.analysis.trials import Trials

__all__ = ["analyse_command"]

_TABLES = ("analysis.json", "table1.csv")
_FIGURES = tuple(f"{stem}.{form}" for stem in ("trajectories", "tracking-errors") for form in ("svg", "png"))


def analyse_command(
    path: Annotated[
        Path | None,
        typer.Argument(
            metavar="PATH",
            help="A rehearsal (.nc or its folder), recorded trials (CSV) or a live session (.mcap, .xdf).",
        ),
    ] = None,
    study: TaskStudy = None,
    discard: Annotated[
        float | None,
        typer.Option(
            parser=number(TIME),
            metavar="TIME",
            help="Duration to leave out at the start of every trial, s. Default: as recorded.",
        ),
    ] = None,
    baseline: Annotated[
        str | None,
        typer.Option(help="Reference condition of the tests (its TE2). Default: the unconnected mode."),
    ] = None,
    out: Annotated[
        Path,
        typer.Option(
            help="Folder for analysis.json, table1.csv, the figures and a session's dataset (netCDF)."
        ),
    ] = Path("out/analysis"),
    export: Annotated[Path | None, typer.Option(help="Also write the trials as CSV to this folder.")] = None,
    figures: Annotated[
        bool,
        typer.Option(help="Draw the figures: tracking errors and trajectories, or the session over time."),
    ] = True,
    template: Annotated[
        Path | None, typer.Option(help="Only write an example of recorded trials to this folder.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print analysis.json instead of the table.")
    ] = False,
) -> None:
    """Measure the trials of an experiment, rehearsed, recorded or live, and compare its conditions."""
    with refusals():
        from telespring import analysis
        from telespring.analysis.sources import files_of_trials, open_trials
        from telespring.recording import is_recording
        from telespring.show.screens.analysis import analysis_screen

        if template is not None:
            show(Text(f"Written: {analysis.write_template(template)}"))
            return
        if path is None:
            raise InvalidInput(
                "PATH", "missing", "a rehearsal or recorded trials are required", "Name a file or a folder."
            )
        if is_recording(path):
            analyse_session_file(
                path,
                out,
                discard=discard,
                baseline=baseline,
                figures=figures,
                as_json=as_json,
                refused={"--study": study, "--export": export},
            )
            return
        experiment = None if study is None else Study.read(study).experiment
        if study is not None and experiment is None:
            raise InvalidInput(
                "study",
                str(study),
                "a study whose robots have the axes x and y is required",
                "Use a study with these axes: only such a study has a task.",
            )
        with pointing_elsewhere("analyse", [path]):
            dataset = open_trials(path, None if experiment is None else experiment.task)
        _check_outputs(out, export, figures, [*files_of_trials(path), *([] if study is None else [study])])
        if discard is None and experiment is not None and "discard" not in dataset.attrs:
            discard = experiment.discard
        trials = analysis.Trials.from_dataset(dataset, discard)
        numbers = analysis.compare_conditions(trials, baseline)
        written = _write_analysis(trials, numbers, out, figures=figures)
        if export is not None:
            written.append(analysis.write_recorded(dataset, export))
    if as_json:
        print_json(numbers)
        return
    show(analysis_screen(numbers, str(path), dataset.attrs.get("resampled_to")))
    show(Text(f"Written: {', '.join(str(file) for file in written)}"))


def _check_outputs(out: Path, export: Path | None, figures: bool, inputs: list[Path]) -> None:
    """Refuse folders where an input would be overwritten."""
    check_folder_keeps_inputs("--out", out, [*_TABLES, *(_FIGURES if figures else ())], inputs)
    if export is None:
        return
    for read in inputs:
        # A trial's file gets a name by its condition, and a file there may have it.
        if read.suffix.lower() != ".nc" and export.resolve() == read.resolve().parent:
            raise InvalidInput(
                "--export",
                str(export),
                f"trials would be written there, and {read.name} in it is an input of the command",
                "Choose another folder.",
            )


def _write_analysis(trials: Trials, numbers: Mapping[str, Any], folder: Path, *, figures: bool) -> list[Path]:
    """Write ``analysis.json``, ``table1.csv`` and Figs. 7 and 8, each file whole or not at all."""
    from telespring.analysis.table import table_1_csv

    text = json.dumps(numbers, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    written = [
        write_whole(folder / "analysis.json", text),
        write_whole(folder / "table1.csv", table_1_csv(numbers["table1"])),
    ]
    if figures:
        from telespring.show.drawings.trials import draw_errors, draw_trajectories

        written += _write_analysis_figure(folder / "trajectories", draw_trajectories(trials))
        written += _write_analysis_figure(folder / "tracking-errors", draw_errors(numbers))
    return written


def _write_analysis_figure(stem: Path, figure: Figure) -> list[Path]:
    """Write a figure as SVG and PNG; the same figure gives the same bytes."""
    from telespring.show.figures.style import figure_style

    paths = [stem.with_suffix(suffix) for suffix in (".svg", ".png")]
    for path in paths:
        is_svg = path.suffix == ".svg"
        with replacing(path) as beside, figure_style(**{"svg.hashsalt": stem.name}):
            figure.savefig(
                beside, dpi="figure" if is_svg else 200.0, metadata={"Date": None} if is_svg else None
            )
    return paths
