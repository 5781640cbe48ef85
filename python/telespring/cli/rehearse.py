"""The command `telespring rehearse`."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.text import Text

from telespring.model import Arm, Study
from telespring.rehearsal.preflight import warnings_of
from telespring.show.screens.decision import refusal_screen

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from telespring._types import FloatArray
    from telespring.rehearsal import Outcome

__all__ = ["rehearse"]

_OUT_OF_REACH = "out_of_reach"  # as the dataset spells it


def rehearse(
    study: Annotated[
        Path | None,
        typer.Argument(metavar="[STUDY.toml]", help="Laboratory and protocol; the paper's own unless given."),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for the trials and in the end for rehearsal.nc.")] = Path(
        "out/rehearsal"
    ),
    workers: Annotated[
        int | None, typer.Option(help="Trials that run at the same time; all cores unless given.")
    ] = None,
    robot1: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="A robot file, as `identify` writes it, for robot 1."),
    ] = None,
    robot2: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="A robot file, as `identify` writes it, for robot 2."),
    ] = None,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Remove the rehearsal that is in the folder and start anew.")
    ] = False,
) -> None:
    """Run a study's whole experiment on simulated robots, arms, agents and network.

    Stopped at any moment, by Ctrl-C or by a crash, the same command goes on where it was.
    """
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from telespring.rehearsal import run_protocol

    console = Console(highlight=False)
    asked = Study.paper() if study is None else Study.read(study)
    for side, robot in ((1, robot1), (2, robot2)):
        if robot is not None:
            from telespring.study.editing import with_robot

            asked = with_robot(asked, side, robot)
    modules = None if study is None else study.parent
    for warning in warnings_of(asked, modules):
        console.print(Text.assemble(("Warning: ", "yellow"), warning))
    finished, trials = 0, 0
    begin = time.perf_counter()
    try:
        with Progress(
            TextColumn("trials"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        ) as bar:
            task = bar.add_task("trials", total=None)

            def progress(done: int, total: int) -> None:
                nonlocal finished, trials
                finished, trials = done, total
                bar.update(task, completed=done, total=total)

            outcome = run_protocol(asked, out, progress, workers, fresh=fresh, modules=modules)
    except KeyboardInterrupt:
        console.print(f"Stopped. {_kept(finished, trials)}", markup=False)
        raise typer.Exit(130) from None
    except OSError as trouble:
        if not trials:  # nothing was begun: a file to read, or the folder itself
            raise
        refusal_screen(
            Console(stderr=True, highlight=False),
            "out",
            str(trouble.filename or out),
            f"a folder that can be written, with enough room, is needed ({trouble.strerror or trouble})",
            f"Mend that. {_kept(finished, trials)}",
        )
        raise typer.Exit(2) from None
    _tell(console, outcome, time.perf_counter() - begin)
    _tell_conditions(console, outcome, asked, modules)
    console.print(f"Dataset: {outcome.dataset}", markup=False)


def _arm_at_its_end(position: Any, arms: Sequence[Arm], gone: NDArray[np.bool_], ended_at: FloatArray) -> str:
    """Name the arm that was nearest to an end of its reach when the first trial of a condition left it."""
    import numpy as np

    if not gone.any():
        return ""
    places = position[int(np.argmin(np.where(gone, ended_at, np.inf)))]
    places = places[np.isfinite(places).all(axis=(-2, -1))]
    room = []
    for robot, arm in enumerate(arms):
        if arm.link_length is None or arm.base is None or not len(places):
            continue
        upper, lower = arm.link_length
        distance = float(np.hypot(*(places[-1, robot] - np.asarray(arm.base))))
        room.append((min(upper + lower - distance, distance - abs(upper - lower)), robot + 1))
    return f" of arm {min(room)[1]}" if room else ""


def _kept(finished: int, trials: int) -> str:
    if not finished:
        return "No trial is finished yet."
    return f"{finished} of {trials} trials are kept; the same command goes on with the others."


def _tell(console: Console, outcome: Outcome, seconds: float) -> None:
    import h5netcdf

    with h5netcdf.File(outcome.dataset, "r") as file:
        name = str(file.attrs["name"])
        status = Counter(file.variables["status"][...].ravel().tolist())
        meanings = file.variables["status"].attrs["flag_meanings"].split()
        conditions = len(file.dimensions["condition"])
        duration = float(file.attrs["duration"])
    console.print(f"[bold]{escape(name)}[/bold]")
    each = outcome.trials // conditions
    length = f"{conditions} conditions × {each} trials of {duration:.4g} s"
    if outcome.found == outcome.trials:
        console.print(f"{length}, complete already", markup=False)
    else:
        before = f", after {outcome.found} that were kept" if outcome.found else ""
        ran = outcome.trials - outcome.found
        console.print(f"{length}; {ran} run in {seconds:.1f} s{before}", markup=False)
    for value, meaning in enumerate(meanings):
        if value and status[value]:
            told = f"  {status[value]} of {outcome.trials} ended early: {meaning.replace('_', ' ')}"
            console.print(told, markup=False)


def _tell_conditions(console: Console, outcome: Outcome, study: Study, modules: Path | None) -> None:
    """Tell for each condition whether it is stable in the study's arms, and how its trials ended."""
    import h5netcdf
    from rich.table import Table

    from telespring.decision.arms import stability_in_arms
    from telespring.study.conditions import condition_labels

    experiment = study.experiment
    assert experiment is not None  # it has been rehearsed
    with h5netcdf.File(outcome.dataset, "r") as file:
        status = file.variables["status"][...]
        meanings = file.variables["status"].attrs["flag_meanings"].split()
        ended_at = file.variables["ended_at"][...]
        arms = [
            _arm_at_its_end(positions, experiment.arms, ended == meanings.index(_OUT_OF_REACH), at)
            for positions, ended, at in zip(file.variables["position"], status, ended_at, strict=True)
        ]
    found = stability_in_arms(study, [(k, at) for k, at in experiment.conditions if k is not None], modules)
    table = Table(box=None, pad_edge=False)
    table.add_column("condition", no_wrap=True)
    table.add_column("in arms")
    table.add_column("completed", justify="right", no_wrap=True)
    table.add_column("ended early", no_wrap=True)
    verdicts = iter(found.conditions)
    for label, (k, _), ended, at, arm in zip(
        condition_labels(experiment.conditions), experiment.conditions, status, ended_at, arms, strict=True
    ):
        words, style = "–", None
        if k is not None and found.unknown is None:
            verdict = next(verdicts)
            words, style = verdict.verdict(), None if verdict.stable else "red"
        elif k is not None:
            words = "not known"
        count = Counter(ended.tolist())
        early = "; ".join(
            f"{count[value]} {meaning.replace('_', ' ')}"
            f"{arm if meaning == _OUT_OF_REACH else ''}, the first at {at[ended == value].min():.3g} s"
            for value, meaning in enumerate(meanings)
            if value and count[value]
        )
        table.add_row(label, Text(words, style=style or ""), str(count[0]), early or "–")
    console.print(table)
    console.print(f"In arms: {found.in_words()}", markup=False)
