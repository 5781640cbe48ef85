"""The command `telespring sweep`."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from telespring.cli.common import AllowUnusual, Robot1, Robot2, Robots, ShardOption, Workers, print_json
from telespring.cli.figure_file import check_folder_keeps_inputs
from telespring.cli.question import StudyOptions
from telespring.cli.resuming import resuming
from telespring.cli.terminal import screen_console, show
from telespring.model import Study
from telespring.rehearsal.preflight import preflight_warnings
from telespring.rehearsal.shards import read_shard
from telespring.show.screens.rehearsal import preflight_screen
from telespring.show.screens.shards import share_outcome_screen

if TYPE_CHECKING:
    from telespring.sweeps.run import SweepOutcome

__all__ = ["show_sweep", "sweep_command"]


def sweep_command(
    study: Annotated[
        Path | None,
        typer.Argument(metavar="[STUDY.toml]", help="Laboratory and protocol. Default: the paper's."),
    ] = None,
    over: Annotated[
        list[str] | None,
        typer.Option(
            "--over",
            metavar="KEY=VALUES",
            help="A key of the study and its values, in SI units; write it once for each key. Values are "
            "a list (network.loss=0,0.1), a range from:to:how many (stiffness=20:200:10), one with equal "
            "ratios (robot1.damping=log:1:20:9), words, or a TOML list. stiffness and delay are those of "
            "coupling or network and of the protocol together.",
        ),
    ] = None,
    draws: Annotated[
        int, typer.Option(help="How many robots to draw from their uncertainty at each combination.")
    ] = 0,
    seed: Annotated[int, typer.Option(help="Seed of the draws.")] = 1,
    no_trials: Annotated[
        bool, typer.Option("--no-trials", help="Judge each point only, without any trial.")
    ] = False,
    quick: Annotated[
        bool,
        typer.Option(
            "--quick", help="First, middle and last value of each key, two trials and three draws at most."
        ),
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for sweep.nc.", show_default="out/sweep, or out/sweep-quick with --quick"),
    ] = None,
    zarr: Annotated[
        bool, typer.Option("--zarr", help="Write sweep.zarr, for results that do not fit into memory.")
    ] = False,
    shard: ShardOption = None,
    workers: Workers = None,
    robot: Robots = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Remove the sweep in the folder and start over.")
    ] = False,
    allow_unusual: AllowUnusual = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units instead of the tables.")
    ] = False,
) -> None:
    """Judge and rehearse a study at all combinations of some of its values.

    If interrupted, by Ctrl-C or by a crash, run the same command again to resume. The status is 1 where a
    guard broke its law.

    Example: telespring sweep --over network.loss=0:0.3:4 --over session.strategy=spring,guard --quick
    """
    from telespring.sweeps.plan import plan_sweep
    from telespring.sweeps.run import run_sweep
    from telespring.sweeps.store import SWEEP_FILES

    console = screen_console(stderr=as_json)
    share = read_shard(shard)
    asked = StudyOptions(study)
    asked.take_robots(robot, robot1, robot2)
    folder = out or Path("out/sweep-quick" if quick else "out/sweep")
    check_folder_keeps_inputs("--out", folder, SWEEP_FILES, asked.inputs)
    asked.allow_unusual(is_allowed=allow_unusual)
    swept = asked.read(Study.paper())
    modules = None if study is None else study.parent
    plan = plan_sweep(swept, over, draws=draws, seed=seed, trials=not no_trials, quick=quick)
    if plan.trials:
        preflight_screen(console, preflight_warnings(swept, modules))
    start = time.perf_counter()
    with resuming(console, folder, "results") as progress:
        outcome = run_sweep(
            plan, folder, progress, workers, shard=share, fresh=fresh, as_zarr=zarr, modules=modules
        )
    if share is not None:
        share_outcome_screen(console, share, outcome.dataset.parent, folder, outcome.done)
        return
    seconds = None if outcome.resumed == outcome.done else time.perf_counter() - start
    show_sweep(console, outcome, seconds, as_zarr=zarr, as_json=as_json)


def show_sweep(
    console: Console, outcome: SweepOutcome, seconds: float | None, *, as_zarr: bool, as_json: bool
) -> None:
    """Print how a sweep came out; `seconds` is how long it took, None if nothing was run.

    The command ends with status 1 where a guard broke its law.
    """
    from telespring.show.screens.sweep import sweep_screen
    from telespring.sweeps.assembly import read_sweep
    from telespring.sweeps.summary import summarise_sweep

    summary = summarise_sweep(read_sweep(outcome.dataset, as_zarr=as_zarr), outcome.plan.trials)
    if as_json:
        print_json(summary.to_dict() | {"dataset": str(outcome.dataset)})
    else:
        show(sweep_screen(summary, seconds))
        console.print(f"Dataset: {outcome.dataset}", markup=False)
    if summary.whole.guard_broken:
        raise typer.Exit(1)
