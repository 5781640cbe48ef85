"""A rehearsal from beginning to end: run all trials, keep each when it is finished, write the dataset."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, TypeAlias

from telespring._core import Experiment, Laboratory, Study
from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.rehearsal.encoding import REPORTS, SIDE_REPORTS, Signal, compress_signal, stored_signals
from telespring.rehearsal.identity import SCHEMA, RehearsalIdentity, core_version
from telespring.rehearsal.schedule import ScheduledTrial, schedule_trials
from telespring.rehearsal.store import RehearsalStore, create_folder, lock_folder
from telespring.rehearsal.traces import read_traces
from telespring.rehearsal.trial_file import TrialRecord
from telespring.rehearsal.user_code import RehearsalStopped, UserCode, UserCodeError, load_user_code
from telespring.study.conditions import condition_labels

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["RehearsalOutcome", "rehearse", "remove_rehearsal", "require_experiment", "run_protocol"]

Progress: TypeAlias = Callable[[int, int], None]


@dataclass(frozen=True)
class RehearsalOutcome:
    """The result of a rehearsal.

    Attributes
    ----------
    dataset
        The file of the dataset.
    trials
        Number of trials of the protocol.
    resumed
        Number of trials that had been finished before; all of them if the dataset existed already.
    """

    dataset: Path
    trials: int
    resumed: int


def rehearse(
    study: Study | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    progress: Progress | None = None,
    workers: int | None = None,
    *,
    fresh: bool = False,
) -> xr.Dataset:
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

    Returns
    -------
    xarray.Dataset
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

    outcome = run_protocol(study, folder, progress, workers, fresh=fresh)
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
) -> RehearsalOutcome:
    """Run a rehearsal as `rehearse` does, and leave the dataset on the disk.

    With `replace_others` a rehearsal of another study is removed instead of refused. `modules` is the folder
    in which agents and targets written in Python are looked up first; by default that of the study's file.
    """
    if not isinstance(study, Study):
        modules = Path(study).parent if modules is None else modules
        study = Study.read(study)
    experiment = require_experiment(study)
    threads = _rehearsal_thread_count(workers)
    user_code = load_user_code(experiment, modules)
    traces = read_traces(experiment, modules)
    laboratory = traces.laboratory(experiment)
    if workers is None and user_code.has_agents:
        # The interpreter runs one agent at a time; threads would only wait for each other.
        threads = 1
    provenance = user_code.provenance() | traces.provenance()
    identity = RehearsalIdentity(study.name, study.to_toml(), provenance, SCHEMA, core_version())
    trials = schedule_trials(experiment)
    store = RehearsalStore(Path(folder), identity)
    create_folder(store.path)
    fresh = fresh or (replace_others and store.holds_other_rehearsal())
    if not fresh and store.is_complete():
        _remove_leftover_trials(store)
        return RehearsalOutcome(store.dataset, len(trials), len(trials))

    target = user_code.target_positions(experiment.tick_count, experiment.sample_period)
    with lock_folder(store.path):
        if fresh:
            store.remove_rehearsal()
        elif store.is_complete():  # by another process, since the check above
            return RehearsalOutcome(store.dataset, len(trials), len(trials))
        store.begin()
        finished = set(store.finished_trials(trials))
        done = len(finished)
        if progress is not None:
            progress(done, len(trials))
        missing = [trial for trial in trials if trial not in finished]
        signals = stored_signals(study.session)
        records = _run_trials(
            experiment, laboratory, missing, user_code, target, signals, identity.fingerprint, threads
        )
        # Closed at once on an error here, so that no trial continues.
        with closing(records):
            for trial, record in records:
                store.write_trial(trial, record)
                done += 1
                if progress is not None:
                    progress(done, len(trials))
        from telespring.rehearsal.dataset import write_dataset

        recorded = _recorded_target(experiment, laboratory, target)
        write_dataset(store, identity, study, experiment, trials, recorded)
        store.flush_folder()
        store.remove_trials()
    return RehearsalOutcome(store.dataset, len(trials), len(finished))


def remove_rehearsal(folder: str | os.PathLike[str]) -> None:
    """Remove the rehearsal in a folder, whichever it is, and nothing else."""
    store = RehearsalStore(Path(folder), RehearsalIdentity("", "", {}, SCHEMA, core_version()))
    if store.holds_other_rehearsal():
        with lock_folder(store.path):
            store.remove_rehearsal()


def require_experiment(study: Study) -> Experiment:
    """Return the experiment of a study; InvalidInput if its robots cannot be rehearsed."""
    experiment = study.experiment
    if experiment is None:
        raise InvalidInput(
            "robot1.axes",
            ", ".join(study.dyad.axes),
            "a rehearsal needs robots with exactly two axes",
            "Describe both robots with the axes x and y.",
        )
    return experiment


def _recorded_target(experiment: Experiment, laboratory: Laboratory, target: FloatArray | None) -> FloatArray:
    """Return the target at the recorded instants, m; `target` is a Python one at every tick."""
    if target is not None:
        return target[:: experiment.tick_stride]
    return laboratory.target(experiment.duration, experiment.record_rate)


def _rehearsal_thread_count(workers: int | None) -> int:
    if workers is None:
        with suppress(AttributeError):  # only some systems can limit a process to some cores
            return len(os.sched_getaffinity(0))
        return os.cpu_count() or 1
    if workers < 1:
        raise InvalidInput(
            "workers", str(workers), "a whole number of 1 or more is required", "Omit it to use all cores."
        )
    return workers


def _remove_leftover_trials(store: RehearsalStore) -> None:
    """Remove trials that a process killed at the very end left next to its dataset, if possible."""
    with suppress(InvalidInput, OSError), lock_folder(store.path):
        store.remove_trials()


def _run_trials(
    experiment: Experiment,
    laboratory: Laboratory,
    trials: list[ScheduledTrial],
    user_code: UserCode,
    target: FloatArray | None,
    signals: tuple[Signal, ...],
    fingerprint: str,
    threads: int,
) -> Generator[tuple[ScheduledTrial, TrialRecord]]:
    """Run trials on several threads and yield each when it is finished."""
    stop = Event()

    def raise_if_stopped() -> None:
        if stop.is_set():
            raise RehearsalStopped

    labels = condition_labels(experiment.conditions)
    count = len(experiment.sample_times)

    def run_trial(trial: ScheduledTrial) -> tuple[ScheduledTrial, TrialRecord]:
        condition = experiment.conditions[trial.condition]
        try:
            recording = laboratory.run(
                condition.stiffness,
                condition.delay,
                trial.seed,
                experiment.duration,
                experiment.record_rate,
                agents=user_code.create_agents(trial.seed, stop),
                target=target,
                coupling_damping=experiment.coupling_damping,
                interrupt_check=raise_if_stopped,
            )
        except UserCodeError as error:
            raise UserCodeError(
                error.field,
                error.value,
                f"{error.allowed}, in trial {trial.trial + 1} of {labels[trial.condition]}",
                f"{error.remedy} Finished trials are kept; they are valid as long as its file is unchanged.",
            ) from error
        rows = len(recording.time)
        assert rows <= count
        return trial, TrialRecord(
            fingerprint=fingerprint,
            condition=trial.condition,
            trial=trial.trial,
            seed=trial.seed,
            status=recording.status,
            ended_at=recording.ended_at,
            rows=rows,
            reports={report.name: getattr(recording, report.name) for report in REPORTS}
            | {report.name: getattr(recording, report.name).tolist() for report in SIDE_REPORTS},
            chunks={
                signal.name: compress_signal(signal, getattr(recording, signal.name), count)
                for signal in signals
            },
        )

    waiting = iter(trials)
    running: set[Future[tuple[ScheduledTrial, TrialRecord]]] = set()
    pool = ThreadPoolExecutor(threads, thread_name_prefix="rehearse")
    try:
        while True:
            # Twice as many as threads, so that none waits for the disk; not more, because finished trials
            # that are not yet written take memory.
            while len(running) < 2 * threads and (trial := next(waiting, None)) is not None:
                running.add(pool.submit(run_trial, trial))
            if not running:
                return
            ended, running = wait(running, return_when=FIRST_COMPLETED)
            for future in ended:
                yield future.result()
    finally:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)
