"""A share of a comparison, run on one of several machines."""

from __future__ import annotations

from pathlib import Path

from telespring._core import Study
from telespring.comparison.cells import (
    comparison_store,
    progress_after,
    rehearsals_of,
    trial_count,
)
from telespring.comparison.schedule import schedule_comparison
from telespring.rehearsal.executors import Executor, refuse_workers
from telespring.rehearsal.run import Progress, RehearsalOutcome, run_share
from telespring.rehearsal.shards import Shard, ShardFacts
from telespring.rehearsal.store import create_folder, lock_folder

__all__ = ["run_comparison_share"]


def run_comparison_share(
    study: Study,
    folder: Path,
    shard: Shard,
    progress: Progress | None = None,
    workers: int | None = None,
    *,
    quick: bool = False,
    fresh: bool = False,
    modules: Path | None = None,
    executor: Executor | None = None,
) -> RehearsalOutcome:
    """Run a share of every rehearsal of a comparison in a folder of its own inside `folder`."""
    refuse_workers(executor, workers)
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
