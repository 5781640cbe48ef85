"""Trials on executors of others: the same bytes, and only what a dead worker was running is run again."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import telespring as ts
from resuming import written
from short_rehearsal import study_text
from short_sweep import OVER, guarded
from telespring.rehearsal.schedule import schedule_trials
from telespring.rehearsal.work import prepare_runner, run_trial_anywhere

#: Notes every trial that begins, so that those that run twice are seen.
COUNTED = """
import os

class Counted:
    def __init__(self, seed, log):
        self.seed = seed
        with open(log, "a") as file:
            file.write(f"{os.getpid()} {seed}\\n")

    def __call__(self, time, position, velocity, target):
        return 100.0 * (target[0] - position[0]), 100.0 * (target[1] - position[1])
"""


@contextmanager
def processes(count: int) -> Iterator[ProcessPoolExecutor]:
    with ProcessPoolExecutor(count, multiprocessing.get_context("spawn")) as pool:
        yield pool


class Polled:
    """An executor whose futures are of its own kind, as submitit's are."""

    def __init__(self) -> None:
        self.pool = ThreadPoolExecutor(2)

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> Any:
        future = self.pool.submit(function, *arguments)
        return type("Job", (), {"done": lambda _: future.done(), "result": lambda _: future.result()})()


def test_law_executors_give_the_bytes_of_threads(tmp_path: Path) -> None:
    study = ts.Study.from_toml(study_text())
    ts.rehearse(study, tmp_path / "threads", workers=2)
    expected = (tmp_path / "threads" / "rehearsal.nc").read_bytes()
    with processes(2) as pool:
        ts.rehearse(study, tmp_path / "processes", executor=pool)
        swept = ts.sweep(guarded(), tmp_path / "swept", OVER, quick=True, executor=pool)
    polled = Polled()
    ts.rehearse(study, tmp_path / "polled", executor=polled)
    polled.pool.shutdown()
    for name in ("processes", "polled"):
        assert (tmp_path / name / "rehearsal.nc").read_bytes() == expected
    assert swept.identical(ts.sweep(guarded(), tmp_path / "alone", OVER, quick=True))


def test_law_a_comparison_and_a_survey_run_on_an_executor(tmp_path: Path) -> None:
    short = {"stiffness": [71.2], "delay": [0.084], "trials": 2, "duration": 3.0, "discard": 1.0}
    study = ts.Study.paper().replace(protocol=short)
    with ThreadPoolExecutor(2) as pool:
        found = ts.compare(study, tmp_path / "pool", quick=True, executor=pool)
        survey = ts.survey_dyads(5000, cells=(2, 2), executor=pool)
    assert found.dataset.identical(ts.compare(study, tmp_path / "threads", quick=True).dataset)
    assert survey.identical(ts.survey_dyads(5000, cells=(2, 2)))


class Dying(Executor):
    """An executor whose process dies after some tasks."""

    def __init__(self, tasks: int) -> None:
        self.left = tasks

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        from concurrent.futures.process import BrokenProcessPool

        future: Future[Any] = Future()
        if self.left:
            self.left -= 1
            future.set_result(function(*arguments, **named))
        else:
            future.set_exception(BrokenProcessPool("a process died"))
        return future


def test_law_a_broken_executor_is_said_and_finished_trials_are_kept(tmp_path: Path) -> None:
    study = ts.Study.from_toml(study_text())
    with pytest.raises(ts.InvalidInput, match="workers must live"):
        ts.rehearse(study, tmp_path, executor=Dying(3))
    kept = len(list(tmp_path.rglob("*.trial")))
    assert kept == 3
    told: list[int] = []
    ts.rehearse(study, tmp_path, lambda done, _: told.append(done))
    assert told[0] == kept


def test_law_a_worker_with_another_build_or_other_files_is_refused() -> None:
    study = ts.Study.from_toml(study_text())
    runner = prepare_runner(study, None)
    trial = schedule_trials(runner.experiment)[0]
    assert run_trial_anywhere(runner.work, trial)[0] == trial
    with pytest.raises(ts.InvalidInput, match="same build"):
        run_trial_anywhere(replace(runner.work, fingerprint="of another build"), trial)


def test_law_workers_beside_an_executor_are_refused(tmp_path: Path) -> None:
    study = ts.Study.from_toml(study_text())
    with ThreadPoolExecutor(1) as pool:
        for run in (
            lambda: ts.rehearse(study, tmp_path, workers=2, executor=pool),
            lambda: ts.compare(study, tmp_path, workers=2, executor=pool),
            lambda: ts.sweep(study, tmp_path, OVER, workers=2, executor=pool),
        ):
            with pytest.raises(ts.InvalidInput, match="own workers"):
                run()


@pytest.mark.timeout(300)
@pytest.mark.filterwarnings("ignore")  # those of the cluster, about what happens to it
@pytest.mark.skipif(sys.platform == "win32", reason="workers are killed by a signal")
def test_law_of_a_killed_dask_worker_only_the_running_trials_run_again(tmp_path: Path) -> None:
    distributed = pytest.importorskip(
        "distributed", reason="not tested with Dask: distributed is not installed"
    )
    (tmp_path / "counted.py").write_text(COUNTED, encoding="utf-8")
    log = tmp_path / "log.txt"
    more = f'\n[agent1]\nkind = "python"\nclass = "counted:Counted"\noptions = {{log = "{log.as_posix()}"}}\n'
    study = written(tmp_path, study_text(more=more, trials=8, duration=1.5))
    ts.rehearse(study, tmp_path / "alone", workers=1)
    trials = len(log.read_text().splitlines())
    assert trials == 24
    log.unlink()

    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        pids = list(client.run(os.getpid).values())
        begun: dict[str, list[str]] = {}

        def kill_one(done: int, _total: int) -> None:
            if done == 6:
                # It runs a trial now, or will in a moment.
                time.sleep(0.2)
                os.kill(pids[0], signal.SIGKILL)

        ts.rehearse(study, tmp_path / "cluster", kill_one, executor=client.get_executor())
    for line in log.read_text().splitlines():
        process, seed = line.split()
        begun.setdefault(seed, []).append(process)
    assert (tmp_path / "cluster" / "rehearsal.nc").read_bytes() == (
        tmp_path / "alone" / "rehearsal.nc"
    ).read_bytes()
    again = {seed: processes for seed, processes in begun.items() if len(processes) > 1}
    assert len(begun) == trials
    # What ran on the killed worker, or had just ended there and was not fetched; nothing else.
    assert all(processes[0] == str(pids[0]) for processes in again.values())
    assert len(again) <= 4
    assert len({process for processes in begun.values() for process in processes}) >= 2


@pytest.mark.timeout(300)
@pytest.mark.filterwarnings("ignore")
def test_law_a_sweep_on_a_dask_cluster_with_a_killed_worker_is_that_of_one_machine(tmp_path: Path) -> None:
    distributed = pytest.importorskip(
        "distributed", reason="not tested with Dask: distributed is not installed"
    )
    expected = ts.sweep(guarded(), tmp_path / "alone", OVER, quick=True)
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        pid = next(iter(client.run(os.getpid).values()))

        def kill_one(done: int, _total: int) -> None:
            if done == 8:
                os.kill(pid, signal.SIGTERM if sys.platform == "win32" else signal.SIGKILL)

        found = ts.sweep(
            guarded(),
            tmp_path / "cluster",
            OVER,
            quick=True,
            executor=client.get_executor(),
            progress=kill_one,
        )
    assert found.identical(expected)
