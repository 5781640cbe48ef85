"""The command `telespring predictor`: which predictor foretells recorded motion best, and with what noise."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from telespring._errors import InvalidInput
from telespring.cli.common import LogRate, PositionScale, TaskStudy, TimeScale, print_json, refusals
from telespring.cli.other_files import pointing_elsewhere
from telespring.cli.terminal import show
from telespring.cli.units import TIME, number
from telespring.model import Study

if TYPE_CHECKING:
    from telespring.analysis.prediction import HandMotion

__all__ = ["predictor_command"]


def predictor_command(
    path: Annotated[
        Path,
        typer.Argument(
            metavar="PATH", help="A rehearsal (.nc or its folder), recorded trials, or a log of one handle."
        ),
    ],
    delay: Annotated[
        list[float] | None,
        typer.Option(
            "--delay",
            parser=number(TIME),
            metavar="TIME",
            help="One-way delay to predict over, such as 84ms; repeat for several.",
            show_default="20 to 334 ms",
        ),
    ] = None,
    study: TaskStudy = None,
    discard: Annotated[
        float | None,
        typer.Option(
            parser=number(TIME),
            metavar="TIME",
            help="Duration to leave out at the start of every trial, s.",
            show_default="as recorded",
        ),
    ] = None,
    time: Annotated[
        str, typer.Option("--time", help="Time column of a log: its name, or its number from 1.")
    ] = "time",
    position: Annotated[
        list[str] | None,
        typer.Option(
            "--position",
            help="Position column of a log; repeat for a second axis, or x,y or 2,3.",
            show_default="position_x, position_y",
        ),
    ] = None,
    rate: LogRate = None,
    time_scale: TimeScale = 1.0,
    position_scale: PositionScale = 1.0,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units instead of the table.")
    ] = False,
) -> None:
    """Compare predictors on recorded motion over a range of delays, with Kalman noise fitted to it."""
    with refusals({"delays": "--delay", "motions": str(path)}):
        from telespring.analysis.prediction import DELAYS, compare_predictors
        from telespring.show.screens.prediction import prediction_screen, study_text

        if _is_log(path):
            columns = {"time": time, "rate": rate, "time_scale": time_scale, "position_scale": position_scale}
            motions = _motions_of_log(path, position or [], columns)
        else:
            motions = _motions_of_trials(path, study, discard)
        comparison = compare_predictors(motions, DELAYS if delay is None else delay)
    if as_json:
        print_json({"source": str(path)} | comparison.to_json())
        return
    show(prediction_screen(comparison, str(path)))
    typer.echo(study_text(comparison))


def _is_log(path: Path) -> bool:
    """Tell a log of one handle from trials: neither a folder, a rehearsal nor a list of trials."""
    if path.is_dir() or path.suffix.lower() == ".nc":
        return False
    if path.suffix.lower() != ".csv":
        return True
    from telespring._tables import read_text_table

    table = read_text_table(path, path.name, as_texts=True)
    return not (table.has_names and "file" in {name.strip().lower() for name in table.names})


def _motions_of_log(path: Path, position: list[str], columns: dict[str, Any]) -> list[HandMotion]:
    """Read the runs of a log; samples without a position are left out."""
    from telespring.analysis.prediction import HandMotion
    from telespring.cli.identify import columns_of

    chosen = columns_of(position) or ["position_x", "position_y"]
    if len(chosen) > 2:
        raise InvalidInput(
            "--position", ", ".join(chosen), "a handle moves on one or two axes", "Name one or two columns."
        )
    from telespring.identification import read_log

    # A log has forces, too, which a prediction does not need: the positions stand in for them.
    log = read_log(path, position=chosen, force=chosen, **columns)
    motions = []
    for run, name in zip(log.split(), log.runs, strict=True):
        known = np.isfinite(run.position).all(axis=1)
        place = run.position[known]
        both = place if place.shape[1] == 2 else np.repeat(place, 2, axis=1)
        motions.append(
            HandMotion(f"{path.name}, run {name}" if len(log.runs) > 1 else path.name, run.time[known], both)
        )
    return motions


def _motions_of_trials(path: Path, study: Path | None, discard: float | None) -> list[HandMotion]:
    """Read the trials at a path, with the target of the study's task if they have none."""
    from telespring.analysis import Trials
    from telespring.analysis.prediction import motions_of_trials
    from telespring.analysis.sources import open_trials

    experiment = None if study is None else Study.read(study).experiment
    with pointing_elsewhere("analyse", [path]):
        dataset = open_trials(path, None if experiment is None else experiment.task)
    return motions_of_trials(Trials.from_dataset(dataset, discard))
