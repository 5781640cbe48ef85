"""A summary of a rehearsal's dataset: how the trials of each condition ended."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from telespring._core import Arm, Condition, Experiment
from telespring.study.conditions import condition_labels

__all__ = ["ConditionSummary", "EarlyEnds", "RehearsalSummary", "summarise_dataset"]


@dataclass(frozen=True)
class EarlyEnds:
    """The trials of one condition that ended early for one reason.

    Attributes
    ----------
    status
        The reason, one of `telespring.rehearsal.encoding.STATUSES`.
    count
        How many trials ended so.
    first
        Time of the first such end in a trial, s.
    arm
        1 or 2: the arm that was out of reach in that trial; None for other reasons.
    """

    status: str
    count: int
    first: float
    arm: int | None


@dataclass(frozen=True)
class ConditionSummary:
    """How the trials of one condition ended.

    Attributes
    ----------
    label, condition
        Which condition it is.
    completed
        Number of trials that were completed.
    early_ends
        Those that were not, by reason.
    limited_share
        Mean share of the ticks, over trials and robots, at which the strategy changed the spring's force;
        None in the unconnected mode, or if no motion of a partner was ever in use.
    """

    label: str
    condition: Condition
    completed: int
    early_ends: tuple[EarlyEnds, ...]
    limited_share: float | None


@dataclass(frozen=True)
class RehearsalSummary:
    """How the trials of a rehearsal ended, with its name, the duration of a trial (s) and all conditions."""

    name: str
    duration: float
    conditions: tuple[ConditionSummary, ...]

    def count_early_ends(self) -> dict[str, int]:
        """Count the trials that ended early, by status."""
        counts: dict[str, int] = {}
        for condition in self.conditions:
            for ends in condition.early_ends:
                counts[ends.status] = counts.get(ends.status, 0) + ends.count
        return counts


def summarise_dataset(dataset: Path, experiment: Experiment) -> RehearsalSummary:
    """Summarise the dataset of an experiment's rehearsal."""
    import h5netcdf

    with h5netcdf.File(dataset, "r") as file:
        status = file.variables["status"]
        meanings = [word.replace("_", " ") for word in status.attrs["flag_meanings"].split()]
        outcomes = zip(
            condition_labels(experiment.conditions),
            experiment.conditions,
            status[...],
            file.variables["ended_at"][...],
            file.variables["position"],
            file.variables["limited_share"][...],
            strict=True,
        )
        return RehearsalSummary(
            name=str(file.attrs["name"]),
            duration=float(file.attrs["duration"]),
            conditions=tuple(
                ConditionSummary(
                    label=label,
                    condition=condition,
                    completed=int(np.count_nonzero(ended == 0)),
                    early_ends=tuple(
                        _early_ends_of_condition(
                            meanings[value], ended == value, ended_at, position, experiment.arms
                        )
                        for value in range(1, len(meanings))
                        if (ended == value).any()
                    ),
                    limited_share=float(np.mean(limited)) if np.isfinite(limited).all() else None,
                )
                for label, condition, ended, ended_at, position, limited in outcomes
            ),
        )


def _early_ends_of_condition(
    status: str, has_ended: Any, ended_at: Any, position: Any, arms: Sequence[Arm]
) -> EarlyEnds:
    first = int(np.argmin(np.where(has_ended, ended_at, np.inf)))
    arm = _arm_nearest_its_limit(position[first], arms) if status == "out of reach" else None
    return EarlyEnds(status, int(np.count_nonzero(has_ended)), float(ended_at[first]), arm)


def _arm_nearest_its_limit(position: Any, arms: Sequence[Arm]) -> int | None:
    """Return 1 or 2: the arm that is nearest to a limit of its reach at the end of a trial."""
    finite = position[np.isfinite(position).all(axis=(-2, -1))]
    room = []
    for robot, arm in enumerate(arms):
        if arm.link_length is None or arm.base is None or not len(finite):
            continue
        upper, lower = arm.link_length
        distance = float(np.hypot(*(finite[-1, robot] - np.asarray(arm.base))))
        room.append((min(upper + lower - distance, distance - abs(upper - lower)), robot + 1))
    return min(room)[1] if room else None
