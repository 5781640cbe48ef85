"""Run all trials of a protocol, keep each as it is finished, and make one dataset of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, TypeAlias

from telespring._core import Study
from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.rehearsal.encoding import SIGNALS, pack
from telespring.rehearsal.identity import SCHEMA, Identity, version
from telespring.rehearsal.lock import locked
from telespring.rehearsal.schedule import Trial, sample_count, schedule, tick_count, tick_stride
from telespring.rehearsal.store import RehearsalFolder
from telespring.rehearsal.trial_file import Record
from telespring.rehearsal.user_code import ProgramFailed, Programs, Stopped, programs_of
from telespring.study.conditions import condition_labels

if TYPE_CHECKING:
    import xarray as xr

    from telespring._core import Experiment

__all__ = ["Outcome", "forget", "rehearse", "run_protocol"]

Progress: TypeAlias = Callable[[int, int], None]


@dataclass(frozen=True)
class Outcome:
    """What became of a rehearsal.

    Attributes
    ----------
    dataset
        The file with everything.
    trials
        How many trials the protocol has.
    found
        How many of them were finished before; all of them where the dataset was there already.
    """

    dataset: Path
    trials: int
    found: int


def rehearse(
    study: Study | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    progress: Progress | None = None,
    workers: int | None = None,
    *,
    fresh: bool = False,
) -> xr.Dataset:
    r"""Run a study's whole protocol on the virtual laboratory and return it as one dataset.

    Finished trials are kept in `folder`. Called again after it was stopped, by Ctrl-C, by an error or
    by the death of the process, it goes on from there; called again after the end, it returns the dataset.
    The same study gives the same dataset, however often it was stopped and on however many threads.

    Parameters
    ----------
    study : Study, str or path
        The study, or its file. Agents and targets in Python are looked up beside the file first, so
        that a study with such parts is better given as its file.
    folder : str or path
        Where to keep the trials and in the end the dataset, ``rehearsal.nc``. It is made where it is missing,
        and refused where it holds a rehearsal of another study.
    progress : callable, optional
        Called with the number of finished trials and the number of all trials, at the beginning and
        after each trial.
    workers : int, optional
        How many trials run at the same time: all cores, or one where an agent is written in Python,
        unless given.
    fresh : bool
        Remove whatever rehearsal is in the folder and start anew.

    Returns
    -------
    xarray.Dataset
        ``position`` (m), ``velocity`` (m/s), ``coupling_force`` and ``agent_force`` (N) over (condition,
        trial, time, robot, axis), NaN after an early end; ``target`` (m) over (time, axis); ``seed``,
        ``status``, ``ended_at`` (s) and ``order`` over (condition, trial); ``stiffness`` (N/m, NaN:
        unconnected) and ``delay`` (s) along condition. The study and all parameters are in its
        attributes. ``docs/rehearse.md`` describes all of it.

    Raises
    ------
    InvalidInput
        Where the study cannot be rehearsed, an agent or target in Python fails, or the folder holds
        something else or is in use.
    OSError
        Where a file cannot be read or written; what is finished stays.

    Examples
    --------
    >>> import tempfile
    >>> import telespring as ts
    >>> study = ts.Study.from_toml(
    ...     ts.Study.paper().to_toml().split("[protocol]")[0]
    ...     + "[protocol]\nstiffness = [35.6]\ndelay = [0.167]\ntrials = 2\nduration = 2.5\ndiscard = 0.5"
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
) -> Outcome:
    """Do what `rehearse` does, and leave the dataset on the disk.

    Parameters, errors and what is kept are those of `rehearse`. With `replace_others` a rehearsal of another
    study is removed instead of refused. `modules` is where agents and targets in Python are looked up first:
    the folder of the study's file unless given.

    Returns
    -------
    Outcome
        Where the dataset is.
    """
    if not isinstance(study, Study):
        modules = Path(study).parent if modules is None else modules
        study = Study.read(study)
    experiment = _experiment(study)
    threads = _workers(workers)
    programs = programs_of(experiment, modules)
    if workers is None and programs.agents != (None, None):
        # The interpreter runs one agent at a time; threads would only wait for each other.
        threads = 1
    identity = Identity(study.name, study.to_toml(), programs.provenance(), SCHEMA, version())
    trials = schedule(experiment)
    home = RehearsalFolder(Path(folder), identity)
    home.make()
    fresh = fresh or (replace_others and home.foreign())
    if not fresh and home.complete():
        _tidy_if_free(home)
        return Outcome(home.dataset, len(trials), len(trials))

    target = programs.positions(tick_count(experiment), experiment.sample_period)
    with locked(home.path):
        if fresh:
            home.empty()
        elif home.complete():  # by another process, since we looked
            return Outcome(home.dataset, len(trials), len(trials))
        home.begin()
        finished = set(home.finished(trials))
        done = len(finished)
        if progress is not None:
            progress(done, len(trials))
        missing = [trial for trial in trials if trial not in finished]
        results = _run(study, experiment, missing, programs, target, identity.fingerprint, threads)
        # closed at once when something goes wrong here, so that no trial runs on
        with closing(results):
            for trial, record in results:
                home.keep(trial, record)
                done += 1
                if progress is not None:
                    progress(done, len(trials))
        from telespring.rehearsal.dataset import write_dataset

        write_dataset(home, identity, study, experiment, trials, _kept_target(experiment, target))
        home.settle()
        home.tidy()
    return Outcome(home.dataset, len(trials), len(finished))


def forget(folder: str | os.PathLike[str]) -> None:
    """Remove whatever rehearsal is in a folder, and nothing else.

    Raises
    ------
    InvalidInput
        Where another process is at work on it.
    OSError
        Where it cannot be removed.
    """
    home = RehearsalFolder(Path(folder), Identity("", "", {}, SCHEMA, version()))
    if home.foreign():
        with locked(home.path):
            home.empty()


def _experiment(study: Study) -> Experiment:
    experiment = study.experiment
    if experiment is None:
        axes = study.dyad.axes
        raise InvalidInput(
            "robot1.axes",
            ", ".join(axes),
            "a rehearsal needs robots with exactly two axes",
            "Describe both robots with the axes x and y.",
        )
    return experiment


def _kept_target(experiment: Experiment, target: FloatArray | None) -> FloatArray:
    """Return the target at the rows of a whole trial, (time, axis), m; `target` is that of a program."""
    if target is not None:
        return target[:: tick_stride(experiment)]
    return experiment.laboratory.target(experiment.duration, experiment.record_rate)


def _workers(workers: int | None) -> int:
    if workers is None:
        with suppress(AttributeError):  # only some systems can limit a process to some cores
            return len(os.sched_getaffinity(0))
        return os.cpu_count() or 1
    if workers < 1:
        raise InvalidInput(
            "workers", str(workers), "a whole number of 1 or more is needed", "Leave it away for all cores."
        )
    return workers


def _tidy_if_free(home: RehearsalFolder) -> None:
    """Remove trials that a process killed at the very end left beside its dataset, if nothing hinders."""
    with suppress(InvalidInput, OSError), locked(home.path):
        home.tidy()


def _run(
    study: Study,
    experiment: Experiment,
    trials: list[Trial],
    programs: Programs,
    target: FloatArray | None,
    fingerprint: str,
    threads: int,
) -> Generator[tuple[Trial, Record]]:
    """Run trials on so many threads and give each as it is finished."""
    stop = Event()

    def stop_wanted() -> None:
        if stop.is_set():
            raise Stopped

    labels = condition_labels(experiment.conditions)
    count = sample_count(experiment)

    def one(trial: Trial) -> tuple[Trial, Record]:
        stiffness, delay = experiment.conditions[trial.condition]
        try:
            recording = experiment.laboratory.run(
                stiffness,
                delay,
                trial.seed,
                experiment.duration,
                experiment.record_rate,
                agents=programs.forces(trial.seed, stop),
                target=target,
                coupling_damping=study.coupling.damping,
                watch=stop_wanted,
            )
        except ProgramFailed as failed:
            place = f"{failed.allowed}, in trial {trial.trial + 1} of {labels[trial.condition]}"
            raise ProgramFailed(
                failed.field,
                failed.value,
                place,
                f"{failed.remedy} Finished trials are kept; they count as long as its file stays as it is.",
            ) from failed
        rows = len(recording.time)
        assert rows <= count
        return trial, Record(
            fingerprint=fingerprint,
            condition=trial.condition,
            trial=trial.trial,
            seed=trial.seed,
            status=recording.status,
            ended_at=recording.ended_at,
            rows=rows,
            chunks={signal.name: pack(signal, recording[signal.name], count) for signal in SIGNALS},
        )

    waiting = iter(trials)
    running: set[Future[tuple[Trial, Record]]] = set()
    pool = ThreadPoolExecutor(threads, thread_name_prefix="rehearse")
    try:
        while True:
            # A few more than there are threads, so that none waits for the disk, and no more: what is
            # finished and not yet kept takes memory.
            while len(running) < 2 * threads and (trial := next(waiting, None)) is not None:
                running.add(pool.submit(one, trial))
            if not running:
                return
            ended, running = wait(running, return_when=FIRST_COMPLETED)
            for future in ended:
                yield future.result()
    finally:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)
