"""Comparison of simulated with published tracking errors, cell by cell, and scores of their agreement."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from telespring._json import finite_or_none
from telespring._types import FloatArray
from telespring.analysis import compare_pairs
from telespring.paper.published import PublishedRow

__all__ = ["Prediction", "Score", "null_prediction", "predict", "score"]


@dataclass(frozen=True)
class Score:
    """Agreement over some cells.

    Attributes
    ----------
    cells
        Number of cells.
    rms_error
        m; NaN if a cell has no simulated value.
    mean_error
        Simulated less published, m.
    rank_correlation, p_value
        Spearman's, between simulated and published; None if all simulated values are equal.
    """

    cells: int
    rms_error: float
    mean_error: float
    rank_correlation: float | None
    p_value: float | None

    def numbers(self) -> dict[str, Any]:
        """Agreement of simulated with published cells for JSON, errors in mm."""
        return {
            "cells": self.cells,
            "rms_error": finite_or_none(1e3 * self.rms_error),
            "mean_error": finite_or_none(1e3 * self.mean_error),
            "rank_correlation": self.rank_correlation,
            "rank_correlation_p": self.p_value,
        }


@dataclass(frozen=True)
class Prediction:
    """Simulated errors in all conditions of the table.

    Attributes
    ----------
    mean, standard_deviation
        (condition, robot), m; over the completed trials, NaN if there are too few.
    ended_early
        Number of trials of each condition that ended early.
    arrow
        (condition, robot), against TE2 in the unconnected mode, as in the paper.
    """

    mean: FloatArray
    standard_deviation: FloatArray
    ended_early: tuple[int, ...]
    arrow: tuple[tuple[str, str], ...]

    def arrows_agreeing(self, published: Sequence[PublishedRow]) -> list[tuple[bool | None, bool | None]]:
        """Whether each arrow is the published one; None for the baseline itself, which has none."""
        return [
            (arrow[0] == row.arrow[0], None if row.stiffness is None else arrow[1] == row.arrow[1])
            for arrow, row in zip(self.arrow, published, strict=True)
        ]


def predict(errors: FloatArray, published: Sequence[PublishedRow]) -> Prediction:
    """Summarise simulated errors (condition, trial, robot), m, as Table I does: means, deviations and arrows.

    An arrow is from the rank-sum test at p < 0.05 against TE2 in the first condition without a stiffness.
    """
    baseline = next(i for i, row in enumerate(published) if row.stiffness is None)
    names = {(i, robot): f"{i}/{robot}" for i in range(len(published)) for robot in (0, 1)}
    groups = {
        name: errors[i, :, robot][np.isfinite(errors[i, :, robot])] for (i, robot), name in names.items()
    }
    reference = names[baseline, 1]
    arrows = {
        comparison.first: comparison.arrow()
        for comparison in compare_pairs(
            [(name, reference) for name in names.values() if name != reference],
            groups,
        )
    }
    mean, deviation = np.full((len(published), 2), np.nan), np.full((len(published), 2), np.nan)
    for (i, robot), name in names.items():
        if len(groups[name]):
            mean[i, robot] = groups[name].mean()
        if len(groups[name]) > 1:
            deviation[i, robot] = groups[name].std(ddof=1)
    return Prediction(
        mean=mean,
        standard_deviation=deviation,
        ended_early=tuple((~np.isfinite(errors).all(axis=2)).sum(axis=1).tolist()),
        arrow=tuple((arrows[names[i, 0]], arrows.get(names[i, 1], "")) for i in range(len(published))),
    )


def score(simulated: FloatArray, published: FloatArray) -> Score:
    """Score simulated against published cells of any shape, m.

    Examples
    --------
    >>> agreement = score(np.array([0.03, 0.04, 0.05]), np.array([0.031, 0.038, 0.060]))
    >>> agreement.rank_correlation, round(1e3 * agreement.rms_error, 3)
    (1.0, 5.916)
    """
    from scipy.stats import spearmanr

    ours, theirs = np.ravel(simulated), np.ravel(published)
    correlation = p_value = None
    if np.isfinite(ours).all() and np.ptp(ours) > 0 and np.ptp(theirs) > 0:
        result = spearmanr(ours, theirs)
        correlation, p_value = float(result.statistic), float(result.pvalue)
        if math.isnan(correlation):
            correlation = p_value = None
    return Score(
        cells=ours.size,
        rms_error=float(np.sqrt(np.mean((ours - theirs) ** 2))),
        mean_error=float(np.mean(ours - theirs)),
        rank_correlation=correlation,
        p_value=p_value,
    )


def null_prediction(published: Sequence[PublishedRow], rows: Sequence[int]) -> FloatArray:
    """Predict the published errors of the unconnected mode for every one of these rows, (row, robot), m."""
    baseline = next(row for row in published if row.stiffness is None)
    return np.tile(baseline.mean, (len(rows), 1))
