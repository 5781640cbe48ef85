"""Trials on executors of others: the same bytes, and only what a dead worker was running is run again."""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import telespring as ts
from held_trials import arm, begun_trials, held_agent, kill_the_held
from resuming import written
from short_rehearsal import study_text
from short_sweep import OVER, command, guarded, loaded
from telespring.rehearsal.schedule import schedule_trials
from telespring.rehearsal.work import prepare_runner, run_trial_anywhere
from telespring.sweeps.plan import plan_sweep
from telespring.sweeps.work import SweepWork, identify_sweep, measure_points


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


def test_law_a_worker_with_another_build_is_refused_in_a_sweep() -> None:
    plan = plan_sweep(ts.Study.paper(), {"coupling.stiffness": [30.0, 60.0]}, trials=False)
    work = SweepWork(plan, None, identify_sweep(plan, None).fingerprint)
    assert measure_points(work, (1,))[0] == (1,)
    with pytest.raises(ts.InvalidInput, match="same build"):
        measure_points(replace(work, fingerprint="of another build"), (1,))


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


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    """Return a client of a Dask cluster of two processes, which starts those anew that are killed."""
    distributed = pytest.importorskip(
        "distributed", reason="not tested with Dask: distributed is not installed"
    )
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@contextmanager
def one_worker_killed(client: Any, folder: Path) -> Iterator[Future[int]]:
    """Kill one worker of a cluster while it runs a trial of the block; its number is there afterwards."""
    client.wait_for_workers(2)
    arm(folder)
    with ThreadPoolExecutor(1) as watcher:
        killed = watcher.submit(kill_the_held, folder)
        yield killed
    assert killed.result() > 0


@pytest.mark.timeout(300)
@pytest.mark.filterwarnings("ignore")  # those of the cluster, about what happens to it
@pytest.mark.skipif(sys.platform == "win32", reason="workers are killed by a signal")
def test_law_of_a_killed_dask_worker_only_the_running_trials_run_again(client: Any, tmp_path: Path) -> None:
    text = study_text(trials=8, duration=1.5)
    study = written(tmp_path, ts.Study.from_toml(text).replace(agent1=held_agent(tmp_path)).to_toml())
    ts.rehearse(study, tmp_path / "alone", workers=1)
    trials = len(begun_trials(tmp_path))
    assert trials == 24
    with one_worker_killed(client, tmp_path) as killed:
        ts.rehearse(study, tmp_path / "cluster", executor=client.get_executor())
    processes: dict[str, list[int]] = {}
    for process, seed in begun_trials(tmp_path):
        processes.setdefault(seed, []).append(process)
    alone, cluster = (tmp_path / name / "rehearsal.nc" for name in ("alone", "cluster"))
    assert cluster.read_bytes() == alone.read_bytes()
    assert len(processes) == trials
    again = [ran for ran in processes.values() if len(ran) > 1]
    # The held trial, and the two before it if they had just ended and were not fetched; nothing else.
    assert all(ran[0] == killed.result() for ran in again)
    assert 1 <= len(again) <= 3


@pytest.mark.timeout(300)
@pytest.mark.filterwarnings("ignore")
@pytest.mark.skipif(sys.platform == "win32", reason="workers are killed by a signal")
def test_law_a_sweep_in_shares_and_on_a_cluster_with_a_killed_worker_is_that_of_one_machine(
    client: Any, tmp_path: Path
) -> None:
    """`telespring sweep --quick`: one run, two shares put together, and Dask while a worker dies."""
    study = written(tmp_path, guarded(agent1=held_agent(tmp_path)).to_toml())
    over = [f"{key}={','.join(map(str, values))}" for key, values in OVER.items()]
    asked: list[str | Path] = [
        "sweep",
        study,
        "--quick",
        *(word for text in over for word in ("--over", text)),
    ]
    alone, shared, cluster = (tmp_path / name for name in ("alone", "shared", "cluster"))
    calls: list[list[str | Path]] = [
        [*asked, "--out", alone],
        [*asked, "--out", shared, "--shard", "1/2"],
        [*asked, "--out", shared, "--shard", "2/2"],
        ["merge", shared],
    ]
    for call in calls:
        done = command(*call)
        assert done.exit_code == 0, done.output
    trials = 24
    assert len(begun_trials(tmp_path)) == 2 * trials
    with one_worker_killed(client, tmp_path):
        found = ts.sweep(study, cluster, over, quick=True, executor=client.get_executor())
    assert trials < len(begun_trials(tmp_path)) <= trials + 3
    assert found.identical(loaded(alone))
    assert loaded(shared).identical(loaded(alone))
    assert len({(folder / "sweep.nc").read_bytes() for folder in (alone, shared, cluster)}) == 1
