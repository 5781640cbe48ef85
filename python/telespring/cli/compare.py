"""The command `telespring compare`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from telespring.cli.common import AllowUnusual, Robot1, Robot2, Robots, ShardOption, Workers
from telespring.cli.figure_file import check_folder_keeps_inputs, save_figure
from telespring.cli.question import StudyOptions
from telespring.cli.resuming import resuming
from telespring.cli.terminal import screen_console
from telespring.comparison import Comparison, run_comparison
from telespring.comparison.shares import run_comparison_share
from telespring.comparison.store import COMPARISON_FILES
from telespring.model import Dyad, Study
from telespring.rehearsal.preflight import preflight_warnings
from telespring.rehearsal.shards import read_shard
from telespring.show.drawings.comparison import COMPARISON_FIGURES, draw_comparison
from telespring.show.screens.comparison import comparison_screen
from telespring.show.screens.rehearsal import preflight_screen
from telespring.show.screens.shards import share_outcome_screen

__all__ = ["compare_command", "show_comparison"]


def compare_command(
    study: Annotated[
        Path | None,
        typer.Argument(
            metavar="[STUDY.toml]", help="Laboratory, protocol and what to compare. Default: the paper's."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Folder for comparison.nc, compare.json, recommended.toml and the figures.",
            show_default="out/comparison, or out/comparison-quick with --quick",
        ),
    ] = None,
    quick: Annotated[
        bool,
        typer.Option(
            "--quick",
            help="Compare only the bare spring, the guard, and the guard with a shared target. Few trials.",
        ),
    ] = False,
    shard: ShardOption = None,
    workers: Workers = None,
    robot: Robots = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Remove the comparison in the folder and start over.")
    ] = False,
    allow_unusual: AllowUnusual = False,
) -> None:
    """Rehearse a study with different control architectures, and say which is the best safe choice.

    The section comparison of a study lists the architectures and the networks. Without it eleven are
    compared: the bare spring, the guard with every predictor, and those of the literature.

    If interrupted, by Ctrl-C or by a crash, run the same command again to resume.

    Example: telespring compare --quick
    """
    console = screen_console()
    share = read_shard(shard)
    asked = StudyOptions(study)
    asked.take_robots(robot, robot1, robot2)
    folder = out or Path("out/comparison-quick" if quick else "out/comparison")
    check_folder_keeps_inputs("--out", folder, (*COMPARISON_FILES, *COMPARISON_FIGURES), asked.inputs)
    asked.allow_unusual(is_allowed=allow_unusual)
    compared = asked.read(Study.paper())
    modules = None if study is None else study.parent
    preflight_screen(console, preflight_warnings(compared, modules))
    if share is not None:
        with resuming(console, folder) as progress:
            outcome = run_comparison_share(
                compared, folder, share, progress, workers, quick=quick, fresh=fresh, modules=modules
            )
        share_outcome_screen(console, share, outcome.dataset.parent, folder, outcome.trials)
        return
    with resuming(console, folder) as progress:
        comparison = run_comparison(
            compared, folder, progress, workers, quick=quick, fresh=fresh, modules=modules
        )
    show_comparison(console, comparison, compared.dyad)


def show_comparison(console: Console, comparison: Comparison, dyad: Dyad) -> None:
    """Write the figures of a comparison, and print what it found."""
    folder = comparison.folder
    for name, figure in draw_comparison(comparison.dataset, comparison.recommendation, dyad):
        save_figure(figure, folder / name)
    comparison_screen(console, comparison)
    if comparison.recommended is not None:
        console.print(f"Rehearse it: telespring rehearse {folder / 'recommended.toml'}", markup=False)
    console.print(f"Folder: {folder}", markup=False)
