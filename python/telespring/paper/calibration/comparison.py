"""Comparison of computed with published tracking errors, cell by cell."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from telespring._json import finite_or_none
from telespring._types import FloatArray
from telespring.analysis import compare_pairs
from telespring.paper.published import TRIALS, PublishedRow

__all__ = ["Prediction", "Score", "agreeing_arrows", "predict", "published_arrows", "score"]

_LEVEL = 0.05


@dataclass(frozen=True)
class Score:
    """Agreement over some cells.

    Attributes
    ----------
    cells
        Number of cells.
    rms_error
        m; infinite or NaN if a cell has no computed value.
    mean_error
        Computed less published, m.
    rank_correlation, p_value
        Spearman's, between computed and published; None if all computed values are equal.
    """

    cells: int
    rms_error: float
    mean_error: float
    rank_correlation: float | None
    p_value: float | None

    def numbers(self) -> dict[str, Any]:
        """Agreement of computed with published cells for JSON, errors in mm."""
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
        (condition, robot), from the trials, against TE2 in the unconnected mode, as in the paper.
    """

    mean: FloatArray
    standard_deviation: FloatArray
    ended_early: tuple[int, ...]
    arrow: tuple[tuple[str, str], ...]


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


def published_arrows(
    errors: FloatArray, published: Sequence[PublishedRow], trials: int = TRIALS
) -> tuple[tuple[str, str], ...]:
    """Return the arrows of these mean errors (condition, robot), m, if they spread as the published ones do.

    A computed mean has no spread of its own, so Welch's test takes the published standard deviations and
    number of trials, against the computed TE2 of the unconnected mode at p < 0.05. That makes all
    hypotheses, and the null, comparable.
    """
    from scipy.stats import ttest_ind_from_stats

    baseline = next(i for i, row in enumerate(published) if row.stiffness is None)
    reference = errors[baseline, 1], published[baseline].standard_deviation[1]

    def arrow(i: int, robot: int) -> str:
        value, deviation = errors[i, robot], published[i].standard_deviation[robot]
        if (i, robot) == (baseline, 1) or not (np.isfinite(value) and np.isfinite(reference[0])):
            return "↑" if np.isinf(value) and np.isfinite(reference[0]) else ""
        p = ttest_ind_from_stats(value, deviation, trials, *reference, trials, equal_var=False).pvalue
        if p >= _LEVEL:
            return ""
        return "↑" if value > reference[0] else "↓"

    return tuple((arrow(i, 0), arrow(i, 1)) for i in range(len(published)))


def agreeing_arrows(
    arrows: Sequence[tuple[str, str]], published: Sequence[PublishedRow]
) -> list[tuple[bool | None, bool | None]]:
    """Whether each arrow is the published one; None for the baseline itself, which has none."""
    return [
        (ours[0] == row.arrow[0], None if row.stiffness is None else ours[1] == row.arrow[1])
        for ours, row in zip(arrows, published, strict=True)
    ]


def score(computed: FloatArray, published: FloatArray) -> Score:
    """Score computed against published cells of any shape, m.

    Examples
    --------
    >>> agreement = score(np.array([0.03, 0.04, 0.05]), np.array([0.031, 0.038, 0.060]))
    >>> agreement.rank_correlation, round(1e3 * agreement.rms_error, 3)
    (1.0, 5.916)
    """
    from scipy.stats import spearmanr

    ours, theirs = np.ravel(computed), np.ravel(published)
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
