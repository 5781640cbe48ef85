"""The trials of a rehearsal as work that any thread, process or machine can do."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from threading import Event, Lock

from telespring._core import Experiment, Laboratory, Recording, Study
from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.rehearsal.encoding import REPORTS, SIDE_REPORTS, compress_signal, stored_signals
from telespring.rehearsal.identity import SCHEMA, RehearsalIdentity, core_version
from telespring.rehearsal.schedule import ScheduledTrial
from telespring.rehearsal.traces import read_traces
from telespring.rehearsal.trial_file import TrialRecord
from telespring.rehearsal.user_code import RehearsalStopped, UserCode, UserCodeError, load_user_code
from telespring.study.conditions import condition_labels

__all__ = [
    "RehearsalWork",
    "TrialRunner",
    "prepare_runner",
    "require_experiment",
    "require_same_work",
    "run_trial_anywhere",
    "runner_of",
]


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


@dataclass(frozen=True)
class RehearsalWork:
    """What a worker needs to know of a rehearsal, small enough to be sent with every trial.

    Attributes
    ----------
    study
        The study.
    modules
        Folder in which agents, targets and traces are looked up first; None for that of the process.
    fingerprint
        Of the rehearsal, which a worker compares with its own.
    """

    study: Study
    modules: str | None
    fingerprint: str


@dataclass(frozen=True)
class TrialRunner:
    """A rehearsal with everything loaded: runs one trial after the other, on any thread.

    Attributes
    ----------
    study, experiment, laboratory, user_code
        What is rehearsed, where, and by whom.
    identity
        Of the rehearsal.
    modules
        Folder in which agents, targets and traces were looked up first.
    """

    study: Study
    experiment: Experiment
    laboratory: Laboratory
    user_code: UserCode
    identity: RehearsalIdentity
    modules: Path | None

    @property
    def work(self) -> RehearsalWork:
        """The same for a worker elsewhere."""
        modules = None if self.modules is None else str(self.modules.resolve())
        return RehearsalWork(self.study, modules, self.identity.fingerprint)

    @cached_property
    def target(self) -> FloatArray | None:
        """A target written in Python at every tick, m; None if it is the laboratory's."""
        return self.user_code.target_positions(self.experiment.tick_count, self.experiment.sample_period)

    def record(
        self, trial: ScheduledTrial, stop: Event | None = None, *, record_rate: float | None = None
    ) -> Recording:
        """Run one trial; RehearsalStopped once `stop` is set.

        `record_rate` (Hz) is that of the protocol unless it is given; the motion is the same at every rate.
        """
        experiment, stopped = self.experiment, Event() if stop is None else stop

        def raise_if_stopped() -> None:
            if stopped.is_set():
                raise RehearsalStopped

        condition = experiment.conditions[trial.condition]
        try:
            return self.laboratory.run(
                condition.stiffness,
                condition.delay,
                trial.seed,
                experiment.duration,
                experiment.record_rate if record_rate is None else record_rate,
                agents=self.user_code.create_agents(trial.seed, stopped),
                target=self.target,
                coupling_damping=experiment.coupling_damping,
                interrupt_check=raise_if_stopped,
            )
        except UserCodeError as error:
            label = condition_labels(experiment.conditions)[trial.condition]
            raise UserCodeError(
                error.field,
                error.value,
                f"{error.allowed}, in trial {trial.trial + 1} of {label}",
                f"{error.remedy} Finished trials are kept; they are valid as long as its file is unchanged.",
            ) from error

    def run(self, trial: ScheduledTrial, stop: Event | None = None) -> tuple[ScheduledTrial, TrialRecord]:
        """Run one trial, and return it as it is stored."""
        recording = self.record(trial, stop)
        count, rows = len(self.experiment.sample_times), len(recording.time)
        assert rows <= count
        return trial, TrialRecord(
            fingerprint=self.identity.fingerprint,
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
                for signal in stored_signals(self.study.session)
            },
        )

    def recorded_target(self) -> FloatArray:
        """Return the target at the recorded instants, m."""
        if self.target is not None:
            return self.target[:: self.experiment.tick_stride]
        return self.laboratory.target(self.experiment.duration, self.experiment.record_rate)


def prepare_runner(study: Study, modules: Path | None) -> TrialRunner:
    """Load all that the trials of a study need; InvalidInput if it cannot be rehearsed."""
    experiment = require_experiment(study)
    user_code = load_user_code(experiment, modules)
    traces = read_traces(experiment, modules)
    provenance = user_code.provenance() | traces.provenance()
    return TrialRunner(
        study,
        experiment,
        traces.laboratory(experiment),
        user_code,
        RehearsalIdentity(study.name, study.to_toml(), provenance, SCHEMA, core_version()),
        modules,
    )


def require_same_work(own: str, expected: str) -> None:
    """Refuse to work where another build or other files would give other numbers: compare fingerprints."""
    if own != expected:
        raise InvalidInput(
            "executor",
            core_version(),
            "every worker needs the same build of telespring and the same files beside the study",
            "Install the same wheel everywhere, and start the workers again after a file has changed.",
        )


#: A worker may have several threads, and user code is loaded by one at a time.
_LOADING = Lock()


@lru_cache(maxsize=8)
def _runner_of(work: RehearsalWork) -> TrialRunner:
    runner = prepare_runner(work.study, None if work.modules is None else Path(work.modules))
    require_same_work(runner.identity.fingerprint, work.fingerprint)
    return runner


def runner_of(work: RehearsalWork) -> TrialRunner:
    """Return the runner of some work in this process, which keeps the last few."""
    with _LOADING:
        return _runner_of(work)


def run_trial_anywhere(work: RehearsalWork, trial: ScheduledTrial) -> tuple[ScheduledTrial, TrialRecord]:
    """Run one trial in the process of a worker, and return it as it is stored."""
    return runner_of(work).run(trial)
