"""The command `telespring rehearse`."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from telespring.cli.common import AllowUnusual, Robot1, Robot2, Robots, ShardOption, Workers
from telespring.cli.figure_file import check_folder_keeps_inputs
from telespring.cli.question import StudyOptions
from telespring.cli.resuming import resuming
from telespring.cli.terminal import screen_console
from telespring.decision.arm_stability import arm_stability
from telespring.model import Study
from telespring.rehearsal import run_protocol
from telespring.rehearsal.preflight import preflight_warnings
from telespring.rehearsal.shards import read_shard
from telespring.rehearsal.store import REHEARSAL_FILES
from telespring.show.screens.rehearsal import (
    preflight_screen,
    rehearsal_outcome_screen,
    rehearsed_conditions_screen,
)
from telespring.show.screens.shards import share_outcome_screen

__all__ = ["rehearse"]


def rehearse(
    study: Annotated[
        Path | None,
        typer.Argument(metavar="[STUDY.toml]", help="Laboratory and protocol. Default: the paper's."),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for the trials and for rehearsal.nc.")] = Path(
        "out/rehearsal"
    ),
    shard: ShardOption = None,
    workers: Workers = None,
    robot: Robots = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Remove the rehearsal in the folder and start over.")
    ] = False,
    allow_unusual: AllowUnusual = False,
) -> None:
    """Run a study's whole experiment on simulated robots, arms, agents and network.

    If interrupted, by Ctrl-C or by a crash, run the same command again to resume.
    """
    from telespring.rehearsal.summary import summarise_dataset

    console = screen_console()
    share = read_shard(shard)
    asked = StudyOptions(study)
    asked.take_robots(robot, robot1, robot2)
    check_folder_keeps_inputs("--out", out, REHEARSAL_FILES, asked.inputs)
    asked.allow_unusual(is_allowed=allow_unusual)
    rehearsed = asked.read(Study.paper())
    modules = None if study is None else study.parent
    preflight_screen(console, preflight_warnings(rehearsed, modules))
    start = time.perf_counter()
    with resuming(console, out) as progress:
        outcome = run_protocol(rehearsed, out, progress, workers, fresh=fresh, modules=modules, shard=share)
    seconds = time.perf_counter() - start
    if share is not None:
        share_outcome_screen(console, share, outcome.dataset.parent, out, outcome.trials)
        return
    experiment = rehearsed.experiment
    assert experiment is not None  # it has been rehearsed
    summary = summarise_dataset(outcome.dataset, experiment)
    rehearsal_outcome_screen(console, outcome, summary, seconds)
    connected = [(k, delay) for k, delay in experiment.conditions if k is not None]
    stability = arm_stability(rehearsed, connected, modules)
    rehearsed_conditions_screen(console, summary, stability, rehearsed.session)
    console.print(f"Dataset: {outcome.dataset}", markup=False)
