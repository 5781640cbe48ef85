"""A sweep from beginning to end: judge every point, run every trial, keep each, write the dataset."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from telespring._core import Study
from telespring.rehearsal.executors import Executor, refuse_workers, run_tasks, tasks_in_flight
from telespring.rehearsal.run import Progress, thread_count
from telespring.rehearsal.shards import Shard, ShardFacts, ShardLike, read_shard
from telespring.rehearsal.store import create_folder, lock_folder
from telespring.sweeps.assembly import has_sweep, read_sweep, require_zarr, write_sweep
from telespring.sweeps.measures import point_variables, trial_variables
from telespring.sweeps.plan import SweepPlan, plan_sweep
from telespring.sweeps.rows import RowFile
from telespring.sweeps.store import SweepStore
from telespring.sweeps.work import SweepWork, identify_sweep, measure_points, measure_trials

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Counter", "SweepOutcome", "finish_sweep", "row_widths", "run_sweep", "sweep", "sweep_store"]

#: Points that one task judges; a trial is a task of its own, so that a dead worker costs no more than that.
_POINTS_PER_TASK = 16


@dataclass(frozen=True)
class SweepOutcome:
    """The result of a sweep.

    Attributes
    ----------
    plan
        What was computed.
    dataset
        Its file, or its folder in Zarr; of a share what it would be.
    done
        Points and trials of the sweep, or of the share.
    resumed
        How many of them had been finished before.
    """

    plan: SweepPlan
    dataset: Path
    done: int
    resumed: int


@overload
def sweep(
    study: Study | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    over: Mapping[str, Any] | Sequence[str] | None = None,
    *,
    draws: int = 0,
    seed: int = 1,
    trials: bool = True,
    quick: bool = False,
    progress: Progress | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    shard: None = None,
    fresh: bool = False,
    as_zarr: bool = False,
) -> xr.Dataset: ...


@overload
def sweep(
    study: Study | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    over: Mapping[str, Any] | Sequence[str] | None = None,
    *,
    draws: int = 0,
    seed: int = 1,
    trials: bool = True,
    quick: bool = False,
    progress: Progress | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    shard: ShardLike,
    fresh: bool = False,
    as_zarr: bool = False,
) -> None: ...


def sweep(
    study: Study | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    over: Mapping[str, Any] | Sequence[str] | None = None,
    *,
    draws: int = 0,
    seed: int = 1,
    trials: bool = True,
    quick: bool = False,
    progress: Progress | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    shard: ShardLike | None = None,
    fresh: bool = False,
    as_zarr: bool = False,
) -> xr.Dataset | None:
    r"""Judge and rehearse a study at all combinations of some of its values.

    At every point the stability of the bare spring is judged, and the protocol is run on the virtual
    laboratory; of a trial numbers are kept, no signals. Trials of the same number have the same random
    numbers at every point. If a sweep is interrupted, call the function again to resume it. Shares,
    executors and a single machine give the same dataset, byte for byte.

    Parameters
    ----------
    study : Study, str or path
        The study, or its file.
    folder : str or path
        Folder for the dataset, ``sweep.nc``. It is created if it is missing, and refused if it contains
        another sweep.
    over : mapping or sequence of str
        Keys of the study with their values, such as ``{"network.loss": [0.0, 0.1]}`` or
        ``["network.loss=0:0.2:11"]``. ``stiffness`` and ``delay`` are those of the coupling or the network
        and of the protocol together.
    draws : int
        Draws of both robots from their uncertainty at every combination; 0 takes them as they are.
    seed : int
        Of the draws.
    trials : bool
        Whether trials are run; otherwise each point is only judged.
    quick : bool
        The first, middle and last value of each key only, with at most two trials and three draws.
    progress : callable, optional
        Called with the number of finished points and trials, and of all.
    workers : int, optional
        Number of trials that run at the same time; by default all cores.
    executor : concurrent.futures.Executor or the like, optional
        Runs the trials instead of threads of this process: anything whose ``submit`` returns a future.
    shard : pair of int or str, optional
        Run only this share, such as ``(2, 8)`` or "2/8", in a folder of its own inside `folder`.
        `telespring.merge_shards` makes the dataset of all shares.
    fresh : bool
        Remove the sweep in the folder, whichever it is, and start over.
    as_zarr : bool
        Write ``sweep.zarr`` instead of ``sweep.nc``, for results that do not fit into memory.

    Returns
    -------
    xarray.Dataset
        None of a share. Otherwise over the keys, ``draw``, ``condition``, ``trial`` and ``robot``;
        ``docs/scale.md`` lists the variables.

    Raises
    ------
    InvalidInput
        If the study cannot have a value, or the folder is in use or holds something else.
    OSError
        If a file cannot be read or written; what is finished is kept.

    Examples
    --------
    >>> import tempfile
    >>> import telespring as ts
    >>> found = ts.sweep(
    ...     ts.Study.paper(),
    ...     tempfile.mkdtemp(),
    ...     {"stiffness": [30.0, 60.0], "delay": [0.1, 0.4]},
    ...     trials=False,
    ... )
    >>> found.stable.squeeze("condition").values.tolist()
    [[1.0, 1.0], [1.0, 0.0]]
    """
    modules = None
    if not isinstance(study, Study):
        modules = Path(study).parent
        study = Study.read(study)
    plan = plan_sweep(study, over, draws=draws, seed=seed, trials=trials, quick=quick)
    share = read_shard(shard)
    outcome = run_sweep(
        plan,
        folder,
        progress,
        workers,
        executor=executor,
        shard=share,
        fresh=fresh,
        as_zarr=as_zarr,
        modules=modules,
    )
    if share is not None:
        return None
    return read_sweep(outcome.dataset, as_zarr=as_zarr)


def sweep_store(folder: Path, plan: SweepPlan, modules: Path | None) -> SweepStore:
    """Return the store of a sweep in a folder."""
    return SweepStore(folder, identify_sweep(plan, modules), row_widths(plan))


def row_widths(plan: SweepPlan) -> tuple[int, int]:
    """Return how many numbers are kept of a point, and of a trial."""
    of_point = point_variables(plan, len(plan.study.dyad.axes))
    return sum(each.size for each in of_point), sum(each.size for each in trial_variables())


def run_sweep(
    plan: SweepPlan,
    folder: str | os.PathLike[str],
    progress: Progress | None = None,
    workers: int | None = None,
    *,
    executor: Executor | None = None,
    shard: Shard | None = None,
    fresh: bool = False,
    as_zarr: bool = False,
    modules: Path | None = None,
) -> SweepOutcome:
    """Run a sweep as `sweep` does, and leave the dataset on the disk."""
    refuse_workers(executor, workers)
    threads = 1 if workers is None and _has_user_code(plan) else thread_count(workers)
    if as_zarr:
        require_zarr()
    path = Path(folder)
    create_folder(path)
    store = sweep_store(path if shard is None else shard.folder(path), plan, modules)
    create_folder(store.path)
    dataset = store.zarr if as_zarr else store.dataset
    share = Shard(1, 1) if shard is None else shard
    points, units = share.select(range(plan.points)), share.select(range(plan.units))
    total = len(points) + len(units)
    if shard is None and not fresh and store.is_complete(as_zarr=as_zarr):
        return SweepOutcome(plan, dataset, total, total)
    with lock_folder(store.path):
        if fresh:
            store.remove_sweep()
        # by another process since the check above, or in the other format
        elif shard is None and has_sweep(store, plan, as_zarr=as_zarr):
            return SweepOutcome(plan, dataset, total, total)
        store.begin()
        if shard is not None:
            ShardFacts.of("sweep", shard, total, modules).write(store.path)
        work = SweepWork(
            plan, None if modules is None else str(modules.resolve()), store.identity.fingerprint
        )
        counter = Counter(total, progress)
        with _pool(executor, threads) as pool:
            _run_missing(store.points, measure_points, work, points, _POINTS_PER_TASK, pool, counter)
            _run_missing(store.trials, measure_trials, work, units, 1, pool, counter)
        if shard is None:
            finish_sweep(store, plan, as_zarr=as_zarr)
    return SweepOutcome(plan, dataset, total, counter.resumed)


def finish_sweep(store: SweepStore, plan: SweepPlan, *, as_zarr: bool) -> None:
    """Write the dataset of a sweep whose rows are all there, and remove them."""
    write_sweep(store, plan, as_zarr=as_zarr)
    store.remove_rows()


class Counter:
    """Tells how much is finished."""

    def __init__(self, total: int, progress: Progress | None) -> None:
        self._total, self._progress = total, progress
        self._done = self.resumed = 0

    def resume(self, finished: int) -> None:
        """Count what had been finished before."""
        self.resumed += finished
        self.add(finished)

    def add(self, finished: int) -> None:
        """Count what has just been finished."""
        self._done += finished
        if self._progress is not None:
            self._progress(self._done, self._total)


def _run_missing(
    rows: RowFile,
    measure: Callable[..., Any],
    work: SweepWork,
    places: Sequence[int],
    size: int,
    pool: tuple[Executor, int],
    counter: Counter,
) -> None:
    """Measure what is not finished of some points or trials, and keep each."""
    kept = set(rows.begin().tolist())
    missing = [place for place in places if place not in kept]
    counter.resume(len(places) - len(missing))
    tasks = ((work, batch) for batch in _batches(missing, size))
    with closing(run_tasks(pool[0], measure, tasks, pool[1])) as results:
        for finished, values in results:
            rows.append(finished, values)
            counter.add(len(finished))


def _batches(items: Iterable[int], size: int) -> Iterator[tuple[int, ...]]:
    waiting = iter(items)
    while batch := tuple(islice(waiting, size)):
        yield batch


def _has_user_code(plan: SweepPlan) -> bool:
    """Return whether an agent is written in Python, of which the interpreter runs one at a time."""
    experiment = plan.study.experiment
    return experiment is not None and any(agent.class_ is not None for agent in experiment.agents)


@contextmanager
def _pool(executor: Executor | None, threads: int) -> Iterator[tuple[Executor, int]]:
    """Return what runs tasks, and how many it is given at a time."""
    if executor is not None:
        yield executor, tasks_in_flight(executor)
        return
    pool = ThreadPoolExecutor(threads, thread_name_prefix="sweep")
    try:
        # Twice as many as threads, so that none waits for the disk.
        yield pool, 2 * threads
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
