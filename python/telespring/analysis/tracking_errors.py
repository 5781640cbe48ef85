"""The tracking errors of an experiment as the tests take them: by group, without copies, with their dyads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.analysis.copies import find_copies
from telespring.analysis.dyads import dyad_means
from telespring.analysis.statistics import Comparison, compare_pairs
from telespring.analysis.trials import Trials

__all__ = ["TrackingErrors", "group_tracking_errors", "tracking_error_name"]


@dataclass(frozen=True, eq=False)
class TrackingErrors:
    """Tracking errors, m, per robot and condition, by `tracking_error_name`.

    Attributes
    ----------
    values
        Per group a value per trial; NaN for a trial that was not completed, and for a copy of another.
    dyads
        Per group the dyad of each trial; None if all trials count as independent, because the data name no
        dyads, or only one.
    copies
        (condition, trial, robot): what repeats an earlier trial of its condition.
    """

    values: dict[str, FloatArray]
    dyads: dict[str, NDArray[np.str_]] | None
    copies: NDArray[np.bool_]

    def compare(self, pairs: list[tuple[str, str]]) -> tuple[Comparison, ...]:
        """Compare pairs of groups as one family."""
        return compare_pairs(pairs, self.values, self.dyads)

    def independent_values(self, name: str) -> FloatArray:
        """Return what counts once in a group, m: the means of the dyads, or the values of the trials."""
        values = self.values[name]
        if self.dyads is None:
            return values[np.isfinite(values)]
        return np.array(list(dyad_means(values, self.dyads[name]).values()))

    def count_dyads(self, name: str) -> int | None:
        """Count the dyads with a value in a group; None if trials count."""
        return None if self.dyads is None else len(self.independent_values(name))


def tracking_error_name(robot: int, label: str) -> str:
    """Name the tracking errors of one robot in one condition, such as "TE2 CM-36-167"."""
    return f"TE{robot} {label}"


def group_tracking_errors(trials: Trials, errors: FloatArray) -> TrackingErrors:
    """Group tracking errors (condition, trial, robot), m, without copies of other trials."""
    copies = find_copies(trials, errors)
    distinct = np.where(copies, np.nan, errors)
    places = [
        (tracking_error_name(robot, label), i, robot)
        for i, label in enumerate(trials.labels)
        for robot in (1, 2)
    ]
    labels = trials.dyads
    several = labels is not None and len(np.unique(labels[trials.status != "absent"])) > 1
    return TrackingErrors(
        values={name: distinct[i, :, robot - 1] for name, i, robot in places},
        dyads={name: labels[i] for name, i, _ in places} if labels is not None and several else None,
        copies=copies,
    )
