"""A comparison shared out to several machines, and its shares put together."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

from telespring._core import Study
from telespring.comparison.results import Comparison
from telespring.comparison.run import (
    comparison_store,
    progress_after,
    rehearsals_of,
    run_comparison,
    trial_count,
)
from telespring.comparison.schedule import schedule_comparison
from telespring.comparison.store import IDENTITY_FILE
from telespring.rehearsal.executors import Executor
from telespring.rehearsal.merging import gather_trials, missing_refusal, refusing_shares
from telespring.rehearsal.run import RehearsalOutcome, run_share
from telespring.rehearsal.shards import Shard, ShardFacts
from telespring.rehearsal.store import create_folder, lock_folder
from telespring.rehearsal.work import prepare_runner

__all__ = ["merge_comparison", "run_comparison_share"]


def run_comparison_share(
    study: Study,
    folder: Path,
    shard: Shard,
    progress: Callable[[int, int], None] | None = None,
    workers: int | None = None,
    *,
    quick: bool = False,
    fresh: bool = False,
    modules: Path | None = None,
    executor: Executor | None = None,
) -> RehearsalOutcome:
    """Run a share of every rehearsal of a comparison in a folder of its own inside `folder`."""
    schedule = schedule_comparison(study, quick=quick, modules=modules)
    store = comparison_store(shard.folder(folder), schedule, quick=quick, modules=modules)
    create_folder(store.path)
    rehearsals = rehearsals_of(schedule)
    trials = {name: len(shard.select(range(trial_count(each)))) for name, each in rehearsals.items()}
    total, done, resumed = sum(trials.values()), 0, 0
    with lock_folder(store.path):
        if fresh:
            store.remove_comparison()
        store.begin()
        ShardFacts.of("comparison", shard, total, modules).write(store.path)
        for name, each in rehearsals.items():
            told = None if progress is None else progress_after(progress, done, total)
            outcome = run_share(each, store.path / name, shard, told, workers, modules, executor, job=None)
            done += outcome.trials
            resumed += outcome.resumed
    return RehearsalOutcome(store.dataset, total, resumed)


def merge_comparison(shares: Sequence[Path], folder: Path, modules: Path | None) -> Comparison:
    """Finish a comparison from the folders of all its shares.

    The result is the one of a single machine. InvalidInput where trials are missing, or a share is of another
    comparison.
    """
    identity = json.loads((shares[0] / IDENTITY_FILE).read_text(encoding="utf-8"))
    study, quick = Study.from_toml(identity["study"]), bool(identity["is_quick"])
    schedule = schedule_comparison(study, quick=quick, modules=modules)
    store = comparison_store(folder, schedule, quick=quick, modules=modules)
    create_folder(folder)
    if not store.is_complete():
        for share in shares:
            with refusing_shares(share):
                comparison_store(share, schedule, quick=quick, modules=modules).require_own_trials()
        with lock_folder(folder):
            store.begin()
        missing: list[int] = []
        for name, each in rehearsals_of(schedule).items():
            if store.read_cell(name) is None:
                runner = prepare_runner(each, modules)
                missing += gather_trials(runner, folder / name, [share / name for share in shares])
        if missing:
            raise missing_refusal(missing, schedule.trials, shares)
    return run_comparison(study, folder, quick=quick, modules=modules)
