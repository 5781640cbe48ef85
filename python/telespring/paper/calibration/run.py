"""The whole calibration: design, both fits, prediction of the conditions held out, and what all that says."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from telespring._types import FloatArray
from telespring.model import Study
from telespring.paper.calibration.comparison import Prediction, Score, null_prediction, predict, score
from telespring.paper.calibration.design import Sizes, explore
from telespring.paper.calibration.fit import Fit, fit
from telespring.paper.calibration.laboratory import RigSimulator
from telespring.paper.calibration.least_squares import LeastSquares, least_squares
from telespring.paper.calibration.likelihood import Likelihood
from telespring.paper.calibration.statements import statements
from telespring.paper.calibration.surrogate import CAP, Surrogate
from telespring.paper.calibration.unknowns import HIGH, VARIANTS
from telespring.paper.published import TABLE_I, TRIALS, PublishedRow
from telespring.theory.axis import finite_or_none

__all__ = ["Calibration", "SurrogateError", "calibrate"]

#: The stiffness whose conditions are fitted beside the unconnected mode, N/m.
_FITTED_STIFFNESS = 142.0
_SIZES: Sizes = (96, 64, 32)
_DESIGN_TRIALS = 2


class Simulator(Protocol):
    """A laboratory in which conditions can be run; see `RigSimulator.errors`."""

    def errors(
        self,
        conditions: Mapping[int, tuple[float | None, float]],
        trials: int,
        unknowns: FloatArray | None = None,
    ) -> FloatArray:
        """Give tracking errors (condition, trial, robot), m."""
        ...


@dataclass(frozen=True)
class SurrogateError:
    """How far the surrogate is from the laboratory where it was built without it, m.

    Attributes
    ----------
    points, trials
        Size of the design: points in the space of the unknowns, trials of each condition.
    near
        Points where no error comes near the cap: the dyad is well inside stability.
    rms, median, largest
        Root mean square over cells at those points, median and largest of a point's worst cell.
    """

    points: int
    trials: int
    near: int
    rms: float
    median: float
    largest: float


@dataclass(frozen=True)
class Calibration:
    """What the calibration found.

    Attributes
    ----------
    published
        The table it was fitted to and is compared with.
    fitted, held_out
        Places of the fitted rows in it, and of all others.
    fits
        One per variant.
    alternative
        The optimum of another likelihood: the fitted cells weighed alike, the arm's inertia on top.
    predictions
        Of the study as it is ("ideal") and at both optima, over all rows.
    alternative_prediction
        At the alternative's optimum.
    scores
        By prediction, "least squares" and "as unconnected": over the held-out cells of TE1, of TE2, of both.
    surrogate
        Its cross-validated error.
    trials
        Of each condition in the predictions.
    statements
        What does not agree, and why, in words.
    """

    published: tuple[PublishedRow, ...]
    fitted: tuple[int, ...]
    held_out: tuple[int, ...]
    fits: dict[str, Fit]
    alternative: LeastSquares
    predictions: dict[str, Prediction]
    alternative_prediction: Prediction
    scores: dict[str, dict[str, Score]]
    surrogate: SurrogateError
    trials: int
    statements: tuple[str, ...]

    def residuals(self, which: str) -> FloatArray:
        """Give simulated less published means of the fitted rows, (row, robot), m."""
        rows = list(self.fitted)
        return np.asarray(
            self.predictions[which].mean[rows] - np.array([self.published[i].mean for i in rows])
        )

    def numbers(self) -> dict[str, Any]:
        """Give everything as plain values for JSON: tracking errors in mm, all else in SI units."""
        return {
            "fitted_conditions": [self.published[i].label for i in self.fitted],
            "held_out_conditions": [self.published[i].label for i in self.held_out],
            "trials": self.trials,
            "fits": {
                name: {
                    **found.numbers(),
                    "residuals": [
                        {
                            "condition": self.published[i].label,
                            "te1": finite_or_none(1e3 * row[0]),
                            "te2": finite_or_none(1e3 * row[1]),
                        }
                        for i, row in zip(self.fitted, self.residuals(name), strict=True)
                    ],
                }
                for name, found in self.fits.items()
            },
            "least_squares": {
                **self.alternative.numbers(),
                "cells": [
                    {
                        "condition": row.label,
                        **_side(
                            (float(mean[0]), float(mean[1])),
                            (float(deviation[0]), float(deviation[1])),
                            arrow,
                        ),
                    }
                    for row, mean, deviation, arrow in zip(
                        self.published,
                        self.alternative_prediction.mean,
                        self.alternative_prediction.standard_deviation,
                        self.alternative_prediction.arrow,
                        strict=True,
                    )
                ],
                "arrows": self._arrow_counts(self.alternative_prediction),
            },
            "surrogate": {
                "points": self.surrogate.points,
                "trials": self.surrogate.trials,
                "points_well_inside_stability": self.surrogate.near,
                "rms_error": 1e3 * self.surrogate.rms,
                "median_of_worst_cell": 1e3 * self.surrogate.median,
                "largest_error": 1e3 * self.surrogate.largest,
            },
            "cells": self._cells(),
            "held_out": {
                name: {which: one.numbers() for which, one in each.items()}
                for name, each in self.scores.items()
            },
            "arrows": {name: self._arrow_counts(each) for name, each in self.predictions.items()},
            "statements": list(self.statements),
        }

    def _cells(self) -> list[dict[str, Any]]:
        """One entry per condition: published and simulated side by side, mm."""
        out = []
        for i, row in enumerate(self.published):
            entry: dict[str, Any] = {
                "condition": row.label,
                "stiffness": row.stiffness,
                "delay": row.delay if row.stiffness is not None else None,
                "fitted": i in self.fitted,
                "published": _side(row.mean, row.standard_deviation, row.arrow),
            }
            for name, each in self.predictions.items():
                mean = (float(each.mean[i, 0]), float(each.mean[i, 1]))
                deviation = (float(each.standard_deviation[i, 0]), float(each.standard_deviation[i, 1]))
                agreeing = each.arrows_agreeing(self.published)[i]
                entry[name] = {
                    **_side(mean, deviation, each.arrow[i]),
                    "ended_early": each.ended_early[i],
                    "te1_arrow_agrees": agreeing[0],
                    "te2_arrow_agrees": agreeing[1],
                }
            out.append(entry)
        return out

    def _arrow_counts(self, prediction: Prediction) -> dict[str, Any]:
        found = prediction.arrows_agreeing(self.published)
        held = [one for i in self.held_out for one in found[i] if one is not None]
        every = [one for pair in found for one in pair if one is not None]
        return {
            "agreeing": sum(every),
            "of": len(every),
            "agreeing_held_out": sum(held),
            "of_held_out": len(held),
            "disagreeing": [
                f"TE{robot + 1} {row.label}: published {row.arrow[robot] or 'none'}, "
                f"simulated {one[robot] or 'none'}"
                for row, one, agree in zip(self.published, prediction.arrow, found, strict=True)
                for robot in (0, 1)
                if agree[robot] is False
            ],
        }


def calibrate(
    study: Study,
    published: Sequence[PublishedRow] = TABLE_I,
    *,
    trials: int = TRIALS,
    sizes: Sizes = _SIZES,
    design_trials: int = _DESIGN_TRIALS,
    progress: Callable[[str], None] | None = None,
    simulator: Simulator | None = None,
) -> Calibration:
    """Fit the unknowns to the unconnected mode and the stiffest spring, and predict the other conditions.

    Parameters
    ----------
    study
        Robots, agents and protocol; its conditions are not used, but those of `published` as printed:
        18, 36, 71 and 142 N/m, 0, 84, 167 and 334 ms.
    published
        Means and standard deviations of the tracking errors. Of the rows that are not fitted nothing
        enters the fit.
    trials
        Of each condition, for the predictions and for confirming an optimum.
    sizes, design_trials
        Points of the design (even, plausible, around each optimum) and trials of each condition there.
    progress
        Called with the name of each step as it begins.
    simulator
        What is run in the place of the study's own laboratory.

    Returns
    -------
    Calibration
        The same input gives the same output.

    Raises
    ------
    telespring.InvalidInput
        Where the study has no laboratory like the paper's.
    """
    tell = progress if progress is not None else lambda _: None
    rig = simulator if simulator is not None else RigSimulator(study)
    table = tuple(published)
    fitted = tuple(i for i, row in enumerate(table) if row.stiffness in (None, _FITTED_STIFFNESS))
    held_out = tuple(i for i in range(len(table)) if i not in fitted)
    conditions = {i: (row.stiffness, row.delay) for i, row in enumerate(table)}
    fitted_conditions = {i: conditions[i] for i in fitted}
    likelihood = Likelihood.of([table[i] for i in fitted])

    def design_run(points: FloatArray) -> FloatArray:
        return np.array(
            [_mean(rig.errors(fitted_conditions, design_trials, point * HIGH)) for point in points]
        ).reshape(len(points), len(fitted), 2)

    def confirm(point: FloatArray) -> FloatArray:
        return _mean(rig.errors(fitted_conditions, trials, point * HIGH))

    tell("design of the calibration")
    surrogate = explore(design_run, likelihood, sizes)
    fits: dict[str, Fit] = {}
    for variant in VARIANTS:
        tell(f"fit, the arm's inertia {variant}{' Table III' if variant == 'inside' else ''}")
        fits[variant] = fit(surrogate, likelihood, variant, confirm)
    tell("the same cells by least squares")
    alternative = least_squares(
        lambda point: design_run(point[None])[0], confirm, likelihood, fits["on top"].point
    )
    tell("prediction of the conditions held out")
    predictions = {"ideal": predict(rig.errors(conditions, trials), table)}
    for name, found in fits.items():
        predictions[name] = predict(rig.errors(conditions, trials, found.point * HIGH), table)
    other = predict(rig.errors(conditions, trials, alternative.point * HIGH), table)
    scores = _scores(table, list(held_out), {**predictions, "least squares": other})
    words = statements(table, fitted, held_out, fits, alternative, predictions, scores)
    return Calibration(
        table,
        fitted,
        held_out,
        fits,
        alternative,
        predictions,
        other,
        scores,
        _accuracy(surrogate, design_trials),
        trials,
        tuple(words),
    )


def _scores(
    table: tuple[PublishedRow, ...], rows: list[int], predictions: dict[str, Prediction]
) -> dict[str, dict[str, Score]]:
    measured = np.array([table[i].mean for i in rows])
    candidates = {name: each.mean[rows] for name, each in predictions.items()}
    candidates["as unconnected"] = null_prediction(table, rows)
    return {
        name: {
            "te1": score(each[:, 0], measured[:, 0]),
            "te2": score(each[:, 1], measured[:, 1]),
            "both": score(each, measured),
        }
        for name, each in candidates.items()
    }


def _mean(errors: FloatArray) -> FloatArray:
    """Average over trials; one that ended early makes its condition's mean not a number."""
    return np.asarray(errors.mean(axis=1))


def _accuracy(surrogate: Surrogate, trials: int) -> SurrogateError:
    near = surrogate.capped.max(axis=(1, 2)) < 0.8 * CAP
    error = np.abs(surrogate.cross_validated()[near])
    worst = error.max(axis=(1, 2))
    return SurrogateError(
        points=len(surrogate.points),
        trials=trials,
        near=int(near.sum()),
        rms=float(np.sqrt(np.mean(error**2))),
        median=float(np.median(worst)),
        largest=float(worst.max()),
    )


def _side(
    mean: tuple[float, float], deviation: tuple[float, float], arrow: tuple[str, str]
) -> dict[str, Any]:
    return {
        key: value
        for robot in (0, 1)
        for key, value in (
            (f"te{robot + 1}_mean", finite_or_none(1e3 * mean[robot])),
            (f"te{robot + 1}_sd", finite_or_none(1e3 * deviation[robot])),
            (f"te{robot + 1}_arrow", arrow[robot]),
        )
    }
