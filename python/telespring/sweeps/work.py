"""The points and trials of a sweep as work that any thread, process or machine can do."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path
from threading import Lock

import numpy as np

from telespring._core import Study
from telespring._types import FloatArray
from telespring.rehearsal.identity import core_version
from telespring.rehearsal.traces import read_traces
from telespring.rehearsal.user_code import load_user_code
from telespring.rehearsal.work import TrialRunner, prepare_runner, require_same_work
from telespring.sweeps.guard_law import law_stride
from telespring.sweeps.measures import point_row, trial_row
from telespring.sweeps.plan import SweepPlan
from telespring.sweeps.store import SweepIdentity

__all__ = ["SweepWork", "identify_sweep", "measure_points", "measure_trials"]

#: Sections of a study that name files beside it.
_NAMING = ("network", "agent1", "agent2", "task")


@dataclass(frozen=True)
class SweepWork:
    """What a worker needs to know of a sweep.

    Attributes
    ----------
    plan
        What is computed.
    modules
        Folder in which agents, targets and traces are looked up first; None for that of the process.
    fingerprint
        Of the sweep, which a worker compares with its own.
    """

    plan: SweepPlan
    modules: str | None
    fingerprint: str

    @property
    def folder(self) -> Path | None:
        """The folder in which agents, targets and traces are looked up first."""
        return None if self.modules is None else Path(self.modules)


def identify_sweep(plan: SweepPlan, modules: Path | None) -> SweepIdentity:
    """Return all that the numbers of a sweep depend on."""
    studies = [plan.study]
    if any(each.key.partition(".")[0] in _NAMING for each in plan.over):
        studies += list(plan.values_by_themselves())
    programs: dict[str, dict[str, str]] = {}
    for study in studies:
        for place, file in _provenance(study, modules, has_trials=plan.trials > 0).items():
            programs[f"{place} {file['name']}"] = file
    return SweepIdentity(
        name=plan.study.name,
        study=plan.study.to_toml(),
        over=[(each.key, list(each.values)) for each in plan.over],
        draws=plan.draws,
        seed=plan.seed,
        conditions=plan.conditions,
        trials=plan.trials,
        programs=programs,
        version=core_version(),
    )


def _provenance(study: Study, modules: Path | None, *, has_trials: bool) -> dict[str, dict[str, str]]:
    found = read_traces(study, modules).provenance()
    if has_trials and study.experiment is not None:
        found |= load_user_code(study.experiment, modules).provenance()
    return found


#: A worker may have several threads, and user code is loaded by one at a time.
_LOADING = Lock()


@cache
def _check(work: SweepWork) -> None:
    """Refuse what `require_same_work` refuses, once for a sweep."""
    require_same_work(identify_sweep(work.plan, work.folder).fingerprint, work.fingerprint)


@lru_cache(maxsize=8)
def _runner_at(work: SweepWork, point: int) -> TrialRunner:
    runner = prepare_runner(work.plan.study_at(point), work.folder)
    if not work.plan.draws:
        return runner
    # The controllers go on counting on the identified robots: nobody knows the drawn ones.
    drawn = work.plan.drawn_at(point)
    return replace(runner, study=drawn, laboratory=runner.laboratory.with_robots(drawn.dyad))


def measure_points(work: SweepWork, points: tuple[int, ...]) -> tuple[tuple[int, ...], FloatArray]:
    """Judge some points: their numbers, and a row for each."""
    with _LOADING:
        _check(work)
    rows = []
    for point in points:
        study = work.plan.study_at(point)
        traces = read_traces(study, work.folder)
        rows.append(point_row(work.plan, study, work.plan.drawn_at(point), traces))
    return points, np.array(rows)


def measure_trials(work: SweepWork, units: tuple[int, ...]) -> tuple[tuple[int, ...], FloatArray]:
    """Run some trials: their numbers, and a row for each."""
    rows = []
    for unit in units:
        with _LOADING:
            _check(work)
            runner = _runner_at(work, work.plan.point_of(unit))
        experiment = runner.experiment
        scheduled = work.plan.scheduled(unit, experiment)
        stiffness = experiment.conditions[scheduled.condition].stiffness
        stride = experiment.tick_stride
        if runner.study.session.guard_settings is not None and stiffness is not None:
            stride = law_stride(experiment)
        finer = experiment.tick_stride // stride
        recording = runner.record(scheduled, record_rate=finer * experiment.record_rate)
        rows.append(trial_row(recording, finer, stiffness, experiment, runner.study))
    return units, np.array(rows)
