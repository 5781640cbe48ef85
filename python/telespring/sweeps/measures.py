"""What a sweep keeps of a point and of a trial: numbers, in the order of its rows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from telespring._core import Experiment, Recording, Study, Verdicts, is_stable
from telespring._types import FloatArray, Tier
from telespring.decision.question import Question
from telespring.rehearsal.encoding import REPORTS, SIDE_REPORTS, STATUSES, Report
from telespring.rehearsal.traces import RecordedTraces
from telespring.sweeps.guard_law import guard_spare
from telespring.sweeps.plan import SweepPlan

__all__ = ["TIERS", "Variable", "point_row", "point_variables", "split_row", "trial_row", "trial_variables"]

#: What the network may do, from the strictest to the mildest.
TIERS: tuple[Tier, ...] = (
    "any network",
    "bounded varying delay",
    "age in a range",
    "any constant delay",
    "constant delay",
)


@dataclass(frozen=True)
class Variable:
    """Some numbers of a row, and the variable of the dataset that they become.

    Attributes
    ----------
    name, units, long_name
        Of the variable.
    dimensions, shape
        Beyond those of the points, or of the trials.
    """

    name: str
    units: str
    long_name: str
    dimensions: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()

    @property
    def size(self) -> int:
        """Numbers in a row."""
        return int(np.prod(self.shape, dtype=int))


def _of_trial(report: Report) -> Variable:
    return Variable(report.name, report.units, report.long_name)


def _of_robot(report: Report) -> Variable:
    return Variable(report.name, report.units, report.long_name, ("robot",), (2,))


#: Of a trial that was not completed the error and the forces are NaN.
_TRIAL = (
    Variable(
        "status", "1", f"how the trial ended: {', '.join(f'{i} {word}' for i, word in enumerate(STATUSES))}"
    ),
    Variable("ended_at", "s", "time at which the trial ended early; NaN if it was completed"),
    Variable(
        "guard_spare",
        "J",
        "what the guards of both sides could still have given out when it ended, by the law that they "
        "promise: what both accounts held at the start, the share of what the robots' damping took and the "
        "overdraft, less what the coupling gave out; NaN without a guard",
    ),
    *(_of_trial(report) for report in REPORTS),
    Variable("tracking_error", "m", "mean distance to the target (Eq. 15)", ("robot",), (2,)),
    Variable("interaction_force_rms", "N", "root mean square of the coupling force", ("robot",), (2,)),
    Variable("interaction_force_peak", "N", "largest coupling force", ("robot",), (2,)),
    *(_of_robot(report) for report in SIDE_REPORTS),
)


def trial_variables() -> tuple[Variable, ...]:
    """List what is kept of every trial."""
    return _TRIAL


def trial_row(
    recording: Recording, stride: int, stiffness: float | None, experiment: Experiment, study: Study
) -> FloatArray:
    """Measure a trial, of which every `stride`-th row is one of the protocol's samples."""
    sampled = slice(None, None, stride)
    force = np.hypot(*np.moveaxis(recording.coupling_force[sampled], -1, 0))
    error = np.hypot(*np.moveaxis(recording.position[sampled] - recording.target[sampled, None], -1, 0))
    # A millionth of a sample for rounding, as the analysis of trials has it.
    analysed = recording.time[sampled] >= experiment.discard - 1e-6 / experiment.record_rate
    measures = np.full((3, 2), np.nan)
    if recording.status == "completed":
        force, error = force[analysed], error[analysed]
        measures = np.stack([error.mean(axis=0), np.sqrt((force**2).mean(axis=0)), force.max(axis=0)])
    return np.concatenate(
        [
            [
                float(STATUSES.index(recording.status)),
                np.nan if recording.ended_at is None else recording.ended_at,
                guard_spare(recording, stiffness, experiment, study),
                *(getattr(recording, report.name) for report in REPORTS),
            ],
            measures.reshape(-1),
            *(getattr(recording, report.name) for report in SIDE_REPORTS),
        ]
    )


def point_variables(plan: SweepPlan, axes: int) -> tuple[Variable, ...]:
    """List what is kept of every point."""
    condition, conditions = ("condition",), (plan.conditions,)
    tiers, by_tier = (*condition, "tier"), (*conditions, len(TIERS))
    robots, by_axis = ("robot", "axis"), (2, axes)
    return (
        Variable(
            "condition_stiffness",
            "N/m",
            "stiffness of the virtual spring; NaN: unconnected",
            condition,
            conditions,
        ),
        Variable("condition_delay", "s", "one-way delay, each way", condition, conditions),
        Variable(
            "stable",
            "1",
            "1 if the bare spring is stable at this stiffness and constant delay, otherwise 0",
            condition,
            conditions,
        ),
        Variable(
            "paper_critical_stiffness", "N/m", "the paper's critical stiffness (Eq. 5)", condition, conditions
        ),
        Variable("stiffness_bound", "N/m", "stiffness up to which the verdict holds", tiers, by_tier),
        Variable("satisfied", "1", "1 if the stiffness is within that bound, otherwise 0", tiers, by_tier),
        Variable("robot_mass", "kg", "mass of the robot", robots, by_axis),
        Variable("robot_damping", "N*s/m", "damping of the robot", robots, by_axis),
        Variable(
            "counted_damping",
            "N*s/m",
            "damping of the robot on which the controllers count: the lower end of its 95 % interval; NaN "
            "without trials",
            robots,
            by_axis,
        ),
    )


def point_row(plan: SweepPlan, known: Study, drawn: Study, traces: RecordedTraces) -> FloatArray:
    """Judge the bare spring at all conditions of a point.

    `known` is the study as its author has it, `drawn` the one with the robots that are truly there.
    """
    conditions: list[tuple[float | None, float | None]]
    counted: Any = np.full((2, len(known.dyad.axes)), np.nan)
    if plan.trials:
        experiment = known.experiment
        assert experiment is not None  # the plan has trials
        conditions = [(condition.stiffness, condition.delay) for condition in experiment.conditions]
        counted = traces.laboratory(experiment).least_damping
    else:
        conditions = [(known.stiffness, None)]
    judged = [
        None if k is None else Question.of_study(drawn, delay=delay, traces=traces.texts).judge(k)
        for k, delay in conditions
    ]
    mean = 0.5 * sum(known.delay) if not plan.trials else np.nan
    robots = drawn.dyad.robots
    parts = [
        [np.nan if k is None else k for k, _ in conditions],
        [mean if delay is None else delay for _, delay in conditions],
        [np.nan if each is None else float(is_stable(each)) for each in judged],
        [np.nan if each is None else each.paper.critical_stiffness for each in judged],
        [value for each in judged for value in _bounds(each)],
        [value for each in judged for value in _satisfied(each)],
        np.array([robot.mass for robot in robots]).reshape(-1),
        np.array([robot.damping for robot in robots]).reshape(-1),
        np.array(counted).reshape(-1),
    ]
    return np.concatenate([np.asarray(part, dtype=np.float64) for part in parts])


def _bounds(judged: Verdicts | None) -> list[float]:
    if judged is None:
        return [np.nan] * len(TIERS)
    bounds = [judged.tier(name).stiffness_bound for name in TIERS]
    return [np.nan if bound is None else bound for bound in bounds]


def _satisfied(judged: Verdicts | None) -> list[float]:
    if judged is None:
        return [np.nan] * len(TIERS)
    return [float(judged.tier(name).satisfied) for name in TIERS]


def split_row(values: FloatArray, variables: tuple[Variable, ...]) -> Iterator[tuple[Variable, FloatArray]]:
    """Yield each variable with its numbers, (row, …), of rows (row, number)."""
    start = 0
    for variable in variables:
        end = start + variable.size
        yield variable, values[:, start:end].reshape(-1, *variable.shape)
        start = end
