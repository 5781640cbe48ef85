"""A comparison from beginning to end: rehearse every architecture on every network, measure, and choose."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, overload

from telespring._core import Study
from telespring._errors import InvalidInput
from telespring._files import write_whole
from telespring._json import json_ready
from telespring.comparison.assembly import assemble_comparison
from telespring.comparison.cells import (
    comparison_store,
    progress_after,
    rehearsals_of,
    trial_count,
)
from telespring.comparison.companions import Companion, study_companions
from telespring.comparison.recommendation import recommend
from telespring.comparison.recommended_study import recommended_study
from telespring.comparison.reduction import measure_connected, measure_unconnected
from telespring.comparison.results import Comparison
from telespring.comparison.schedule import Cell, ComparisonSchedule, schedule_comparison
from telespring.comparison.shares import run_comparison_share
from telespring.comparison.spring_verdicts import SpringVerdicts
from telespring.comparison.store import UNCONNECTED_FOLDER, ComparisonStore
from telespring.rehearsal.executors import Executor, refuse_workers
from telespring.rehearsal.run import Progress, run_protocol
from telespring.rehearsal.shards import ShardLike, read_shard
from telespring.rehearsal.store import create_folder, lock_folder

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["compare", "run_comparison"]


@overload
def compare(
    study: Study | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    *,
    quick: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
    fresh: bool = False,
    executor: Executor | None = None,
    shard: None = None,
) -> Comparison: ...


@overload
def compare(
    study: Study | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    *,
    quick: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
    fresh: bool = False,
    executor: Executor | None = None,
    shard: ShardLike,
) -> None: ...


def compare(
    study: Study | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    *,
    quick: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
    fresh: bool = False,
    executor: Executor | None = None,
    shard: ShardLike | None = None,
) -> Comparison | None:
    r"""Rehearse a study with different control architectures and networks, and choose the best safe one.

    Every architecture of the study's ``[comparison]`` is rehearsed on each of its networks with all
    stiffnesses and delays of the protocol, and the same random numbers. If a comparison is interrupted by
    Ctrl-C, an error or the death of the process, call the function again to resume it; after the end the
    function returns the result.

    Parameters
    ----------
    study : Study, str or path
        The study, or its file. Agents, targets and recorded traces are looked up first in its folder, so that
        a study with such parts is better passed as its file.
    folder : str or path
        Folder for ``comparison.nc``, ``compare.json`` and ``recommended.toml``. It is created if it is
        missing, and refused if it contains another comparison.
    quick : bool
        Compare the bare spring, the guard, and the guard with a shared target only, with at most four trials
        of each condition.
    workers : int, optional
        Number of trials that run at the same time; by default all cores, or one where an agent is written
        in Python.
    progress : callable, optional
        Called with the number of finished trials and the number of all trials.
    fresh : bool
        Remove the comparison in the folder, whichever it is, and start over.
    executor : concurrent.futures.Executor or the like, optional
        Runs the trials instead of threads of this process: anything whose ``submit`` returns a future.
    shard : pair of int or str, optional
        Run only this share of the trials, such as ``(2, 8)`` or "2/8", in a folder of its own inside
        `folder`. `telespring.merge_shards` makes the comparison of all shares.

    Returns
    -------
    Comparison
        None of a share. Otherwise the dataset, the best safe choice and why, and what became of the others.
        ``docs/compare.md`` describes everything.

    Raises
    ------
    InvalidInput
        If the study cannot be rehearsed or names an architecture that it cannot have, an agent or target
        written in Python fails, or the folder is in use or holds something else.
    OSError
        If a file cannot be read or written; finished trials are kept.

    Examples
    --------
    >>> import tempfile
    >>> import telespring as ts
    >>> short = {"stiffness": [71.2], "delay": [0.0, 0.084], "trials": 2, "duration": 6.0, "discard": 2.0}
    >>> study = ts.Study.paper().replace(protocol=short)
    >>> comparison = ts.compare(study, tempfile.mkdtemp(), quick=True)
    >>> comparison.dataset.architecture.values.tolist()
    ['spring', 'guard', 'guard + shared-target']
    >>> comparison.recommended.architecture
    'guard + shared-target'
    """
    modules = None
    if not isinstance(study, Study):
        modules = Path(study).parent
        study = Study.read(study)
    share = read_shard(shard)
    if share is not None:
        run_comparison_share(
            study,
            Path(folder),
            share,
            progress,
            workers,
            quick=quick,
            fresh=fresh,
            modules=modules,
            executor=executor,
        )
        return None
    return run_comparison(
        study, folder, progress, workers, quick=quick, fresh=fresh, modules=modules, executor=executor
    )


def run_comparison(
    study: Study,
    folder: str | os.PathLike[str],
    progress: Progress | None = None,
    workers: int | None = None,
    *,
    quick: bool = False,
    fresh: bool = False,
    modules: Path | None = None,
    executor: Executor | None = None,
) -> Comparison:
    """Run a comparison as `compare` does; `modules` is the folder of the study file."""
    refuse_workers(executor, workers)
    schedule = schedule_comparison(study, quick=quick, modules=modules)
    companions = study_companions(schedule, modules)
    store = comparison_store(Path(folder), schedule, quick=quick, modules=modules)
    create_folder(store.path)
    if fresh or not store.is_complete():
        with lock_folder(store.path):
            if fresh:
                store.remove_comparison()
            if not store.is_complete():  # by another process, since the check above
                for each in companions:
                    each.check(store.path)
                store.begin()
                store.write_dataset(_run_cells(schedule, store, progress, workers, modules, executor))
    return _finish(schedule, store, companions)


def _run_cells(
    schedule: ComparisonSchedule,
    store: ComparisonStore,
    progress: Progress | None,
    workers: int | None,
    modules: Path | None,
    executor: Executor | None,
) -> xr.Dataset:
    """Run what is missing of all rehearsals, and lay their numbers side by side."""
    ages = [SpringVerdicts(each) for each in schedule.network_studies]

    def measure_cell(dataset: Path, cell: Cell) -> xr.Dataset:
        return measure_connected(dataset, cell.study, ages[cell.network])

    jobs = rehearsals_of(schedule)
    measures: dict[str, Callable[[Path], xr.Dataset]] = {
        UNCONNECTED_FOLDER: measure_unconnected,
        **{cell.folder: partial(measure_cell, cell=cell) for cell in schedule.cells},
    }
    measured = {folder: found for folder in jobs if (found := store.read_cell(folder)) is not None}
    done = sum(trial_count(jobs[folder]) for folder in measured)
    if progress is not None:
        progress(done, schedule.trials)
    for folder, study in jobs.items():
        if folder in measured:
            continue
        outcome = run_protocol(
            study,
            store.path / folder,
            None if progress is None else progress_after(progress, done, schedule.trials),
            workers,
            replace_others=True,
            modules=modules,
            executor=executor,
        )
        measured[folder] = measures[folder](outcome.dataset)
        store.write_cell(folder, measured[folder])
        done += outcome.trials
    return assemble_comparison(schedule, measured.pop(UNCONNECTED_FOLDER), measured)


def _finish(schedule: ComparisonSchedule, store: ComparisonStore, companions: list[Companion]) -> Comparison:
    """Write what follows from the dataset, and remove what it contains."""
    dataset = store.read_dataset()
    comparison = Comparison(
        dataset=dataset, recommendation=recommend(dataset), left_out=schedule.left_out, folder=store.path
    )
    if comparison.recommended is not None:
        for each in companions:
            each.copy(store.path)
        _write_changed(store.study, recommended_study(schedule, dataset, comparison.recommended).to_toml())
    else:
        store.study.unlink(missing_ok=True)
    summary = json.dumps(json_ready(comparison.to_dict()), indent=1, ensure_ascii=False)
    _write_changed(store.summary, f"{summary}\n")
    # What a process killed at the very end left is of no use, and in nobody's way.
    with suppress(InvalidInput, OSError), lock_folder(store.path):
        store.remove_cells()
    return comparison


def _write_changed(path: Path, content: str) -> None:
    """Write a file unless it has this content: a finished comparison may lie where nothing can be written."""
    if not path.exists() or path.read_text(encoding="utf-8") != content:
        write_whole(path, content)
