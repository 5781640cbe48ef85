"""A rehearsal from beginning to end: run all trials, keep each when it is finished, write the dataset."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, TypeAlias, overload

from telespring._core import Study
from telespring._errors import InvalidInput
from telespring.rehearsal.executors import Executor, refuse_workers, run_tasks, tasks_in_flight
from telespring.rehearsal.identity import SCHEMA, RehearsalIdentity, core_version
from telespring.rehearsal.schedule import ScheduledTrial, schedule_trials
from telespring.rehearsal.shards import Job, Shard, ShardFacts, ShardLike, read_shard
from telespring.rehearsal.store import RehearsalStore, create_folder, lock_folder
from telespring.rehearsal.trial_file import TrialRecord
from telespring.rehearsal.work import TrialRunner, prepare_runner, require_experiment, run_trial_anywhere

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "Progress",
    "RehearsalOutcome",
    "rehearse",
    "remove_rehearsal",
    "require_experiment",
    "run_protocol",
    "run_share",
]

Progress: TypeAlias = Callable[[int, int], None]


@dataclass(frozen=True)
class RehearsalOutcome:
    """The result of a rehearsal.

    Attributes
    ----------
    dataset
        The file of the dataset; of a share of the trials the file that it would be.
    trials
        Number of trials of the protocol, or of the share.
    resumed
        Number of trials that had been finished before; all of them if the dataset existed already.
    """

    dataset: Path
    trials: int
    resumed: int


@overload
def rehearse(
    study: Study | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    progress: Progress | None = None,
    workers: int | None = None,
    *,
    fresh: bool = False,
    executor: Executor | None = None,
    shard: None = None,
) -> xr.Dataset: ...


@overload
def rehearse(
    study: Study | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    progress: Progress | None = None,
    workers: int | None = None,
    *,
    fresh: bool = False,
    executor: Executor | None = None,
    shard: ShardLike,
) -> None: ...


def rehearse(
    study: Study | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    progress: Progress | None = None,
    workers: int | None = None,
    *,
    fresh: bool = False,
    executor: Executor | None = None,
    shard: ShardLike | None = None,
) -> xr.Dataset | None:
    r"""Run a study's whole protocol on the virtual laboratory and return one dataset.

    Finished trials are kept in `folder`. If a rehearsal is interrupted by Ctrl-C, an error or the death of
    the process, call the function again to resume it; after the end the function returns the dataset.
    The same study gives the same dataset, however often it was interrupted and on any number of threads.

    Parameters
    ----------
    study : Study, str or path
        The study, or its file. Agents and targets written in Python are looked up first in its folder, so
        that a study with such parts is better passed as its file.
    folder : str or path
        Folder for the trials and for the dataset, ``rehearsal.nc``. It is created if it is missing, and
        refused if it contains a rehearsal of another study.
    progress : callable, optional
        Called with the number of finished trials and the number of all trials, at the beginning and
        after each trial.
    workers : int, optional
        Number of trials that run at the same time; by default all cores, or one where an agent is written
        in Python.
    fresh : bool
        Remove the rehearsal in the folder, whichever it is, and start over.
    executor : concurrent.futures.Executor or the like, optional
        Runs the trials instead of threads of this process: anything whose ``submit`` returns a future.
        Its workers need the same telespring and the folder of the study. It is not shut down.
    shard : pair of int or str, optional
        Run only this share of the trials, such as ``(2, 8)`` or "2/8", in a folder of its own inside
        `folder`. `telespring.merge_shards` makes the dataset of all shares.

    Returns
    -------
    xarray.Dataset
        None of a share. Otherwise
        ``position`` (m), ``velocity`` (m/s), ``coupling_force`` and ``agent_force`` (N) over (condition,
        trial, time, robot, axis), NaN after an early end; ``target`` (m) over (time, axis); ``seed``,
        ``status``, ``ended_at`` (s) and ``order`` over (condition, trial); ``stiffness`` (N/m, NaN:
        unconnected) and ``delay`` (s) along condition; what the coupling reports of each trial, such as
        ``limited_share`` over (condition, trial, robot), and ``account`` (J) over (condition, trial, time,
        robot) where the strategy of the study's session keeps one. The study and all parameters are in its
        attributes. ``docs/rehearse.md`` describes everything.

    Raises
    ------
    InvalidInput
        If the study cannot be rehearsed, an agent or target written in Python fails, or the folder
        is in use or holds something else.
    OSError
        If a file cannot be read or written; finished trials are kept.

    Examples
    --------
    >>> import tempfile
    >>> import telespring as ts
    >>> study = ts.Study.paper().replace(
    ...     protocol={"stiffness": [35.6], "delay": [0.167], "trials": 2, "duration": 2.5, "discard": 0.5}
    ... )
    >>> trials = ts.rehearse(study, tempfile.mkdtemp())
    >>> trials.condition.values.tolist()
    ['UM', 'CM-36-167']
    >>> trials.position.dims
    ('condition', 'trial', 'time', 'robot', 'axis')
    """
    import xarray as xr

    share = read_shard(shard)
    outcome = run_protocol(study, folder, progress, workers, fresh=fresh, executor=executor, shard=share)
    if share is not None:
        return None
    return xr.load_dataset(outcome.dataset, engine="h5netcdf")


def run_protocol(
    study: Study | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    progress: Progress | None = None,
    workers: int | None = None,
    *,
    fresh: bool = False,
    replace_others: bool = False,
    modules: Path | None = None,
    executor: Executor | None = None,
    shard: Shard | None = None,
) -> RehearsalOutcome:
    """Run a rehearsal as `rehearse` does, and leave the dataset on the disk.

    With `replace_others` a rehearsal of another study is removed instead of refused. `modules` is the folder
    in which agents and targets written in Python are looked up first; by default that of the study's file.
    """
    if not isinstance(study, Study):
        modules = Path(study).parent if modules is None else modules
        study = Study.read(study)
    path = Path(folder)
    if shard is None:
        return _run_all(study, path, progress, workers, fresh, replace_others, modules, executor)
    create_folder(path)
    return run_share(study, shard.folder(path), shard, progress, workers, modules, executor, fresh=fresh)


def _run_all(
    study: Study,
    folder: Path,
    progress: Progress | None,
    workers: int | None,
    fresh: bool,
    replace_others: bool,
    modules: Path | None,
    executor: Executor | None,
) -> RehearsalOutcome:
    """Run what is missing of all trials, and write the dataset."""
    runner = prepare_runner(study, modules)
    run = _how_to_run(runner, workers, executor)
    trials = schedule_trials(runner.experiment)
    store = RehearsalStore(folder, runner.identity)
    create_folder(store.path)
    fresh = fresh or (replace_others and store.holds_other_rehearsal())
    if not fresh and store.is_complete():
        _remove_leftover_trials(store)
        return RehearsalOutcome(store.dataset, len(trials), len(trials))

    target = runner.recorded_target()
    with lock_folder(store.path):
        if fresh:
            store.remove_rehearsal()
        elif store.is_complete():  # by another process, since the check above
            return RehearsalOutcome(store.dataset, len(trials), len(trials))
        store.begin()
        resumed = _run_missing(store, trials, run, progress)
        from telespring.rehearsal.dataset import write_dataset

        write_dataset(store, runner.identity, study, runner.experiment, trials, target)
        store.flush_folder()
        store.remove_trials()
    return RehearsalOutcome(store.dataset, len(trials), resumed)


def run_share(
    study: Study,
    folder: Path,
    shard: Shard,
    progress: Progress | None,
    workers: int | None,
    modules: Path | None,
    executor: Executor | None,
    *,
    fresh: bool = False,
    job: Job | None = "rehearsal",
) -> RehearsalOutcome:
    """Run a share of the trials in a folder of its own, and leave them there to be merged.

    `job` is written into the folder; None for the folder of a cell of something larger.
    """
    runner = prepare_runner(study, modules)
    run = _how_to_run(runner, workers, executor)
    trials = shard.select(schedule_trials(runner.experiment))
    store = RehearsalStore(folder, runner.identity)
    create_folder(store.path)
    with lock_folder(store.path):
        if fresh:
            store.remove_rehearsal()
        store.begin()
        if job is not None:
            ShardFacts.of(job, shard, len(trials), modules).write(store.path)
        resumed = _run_missing(store, trials, run, progress)
        store.flush_folder()
    return RehearsalOutcome(store.dataset, len(trials), resumed)


def _run_missing(
    store: RehearsalStore,
    trials: list[ScheduledTrial],
    run: Callable[[list[ScheduledTrial]], Generator[tuple[ScheduledTrial, TrialRecord]]],
    progress: Progress | None,
) -> int:
    """Run the trials that are not finished, and keep each; return how many were finished before."""
    finished = set(store.finished_trials(trials))
    done = len(finished)
    if progress is not None:
        progress(done, len(trials))
    # Closed at once on an error here, so that no trial continues.
    with closing(run([trial for trial in trials if trial not in finished])) as records:
        for trial, record in records:
            store.write_trial(trial, record)
            done += 1
            if progress is not None:
                progress(done, len(trials))
    return len(finished)


def remove_rehearsal(folder: str | os.PathLike[str]) -> None:
    """Remove the rehearsal in a folder, whichever it is, and nothing else."""
    store = RehearsalStore(Path(folder), RehearsalIdentity("", "", {}, SCHEMA, core_version()))
    if store.holds_other_rehearsal():
        with lock_folder(store.path):
            store.remove_rehearsal()


def thread_count(workers: int | None) -> int:
    """Return how many trials run at the same time: by default as many as there are cores."""
    if workers is None:
        # only some systems can limit a process to some cores
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if workers < 1:
        raise InvalidInput(
            "workers", str(workers), "a whole number of 1 or more is required", "Omit it to use all cores."
        )
    return workers


def _remove_leftover_trials(store: RehearsalStore) -> None:
    """Remove trials that a process killed at the very end left next to its dataset, if possible."""
    with suppress(InvalidInput, OSError), lock_folder(store.path):
        store.remove_trials()


def _how_to_run(
    runner: TrialRunner, workers: int | None, executor: Executor | None
) -> Callable[[list[ScheduledTrial]], Generator[tuple[ScheduledTrial, TrialRecord]]]:
    """Return what runs trials and yields each when it is finished: threads here, or an executor."""
    refuse_workers(executor, workers)
    if executor is not None:
        return partial(_run_elsewhere, runner, executor)
    threads = thread_count(workers)
    if workers is None and runner.user_code.has_agents:
        # The interpreter runs one agent at a time; threads would only wait for each other.
        threads = 1
    return partial(_run_on_threads, runner, threads)


def _run_elsewhere(
    runner: TrialRunner, executor: Executor, trials: list[ScheduledTrial]
) -> Generator[tuple[ScheduledTrial, TrialRecord]]:
    tasks = ((runner.work, trial) for trial in trials)
    return run_tasks(executor, run_trial_anywhere, tasks, tasks_in_flight(executor))


def _run_on_threads(
    runner: TrialRunner, threads: int, trials: list[ScheduledTrial]
) -> Generator[tuple[ScheduledTrial, TrialRecord]]:
    stop = Event()
    pool = ThreadPoolExecutor(threads, thread_name_prefix="rehearse")
    try:
        # Twice as many as threads, so that none waits for the disk.
        yield from run_tasks(pool, runner.run, ((trial, stop) for trial in trials), 2 * threads)
    finally:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)
