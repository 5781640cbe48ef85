"""The calibration as a whole: design, both fits, and prediction of the held-out conditions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from telespring._json import finite_or_none
from telespring._types import FloatArray
from telespring.model import Study
from telespring.paper.calibration.comparison import Prediction, Score, null_prediction, predict, score
from telespring.paper.calibration.design import Sizes, explore
from telespring.paper.calibration.fit import Fit, fit
from telespring.paper.calibration.laboratory import RigSimulator
from telespring.paper.calibration.least_squares import LeastSquares, least_squares
from telespring.paper.calibration.likelihood import Likelihood
from telespring.paper.calibration.surrogate import CAP, Surrogate
from telespring.paper.calibration.unknowns import HIGH, VARIANTS
from telespring.paper.published import EXPERIMENT_STIFFNESSES, TABLE_I, TRIALS, PublishedRow

__all__ = ["Calibration", "SurrogateError", "calibrate"]

#: The stiffness whose conditions are fitted besides the unconnected mode, N/m.
_FITTED_STIFFNESS = max(EXPERIMENT_STIFFNESSES)
_SIZES: Sizes = (96, 64, 32)
_DESIGN_TRIALS = 2


class Simulator(Protocol):
    """A laboratory that runs conditions; see `RigSimulator.errors`."""

    def errors(
        self,
        conditions: Mapping[int, tuple[float | None, float]],
        trials: int,
        unknowns: FloatArray | None = None,
    ) -> FloatArray:
        """Tracking errors (condition, trial, robot), m."""
        ...


@dataclass(frozen=True)
class SurrogateError:
    """Cross-validated error of the surrogate, m.

    Attributes
    ----------
    points, trials
        Size of the design: points in the space of the unknowns, and trials of each condition.
    near
        Number of points where no error comes near the cap: the dyad is well inside stability.
    rms, median, largest
        Root mean square over the cells at those points, and median and maximum of a point's worst cell.
    """

    points: int
    trials: int
    near: int
    rms: float
    median: float
    largest: float


@dataclass(frozen=True)
class Calibration:
    """Result of a calibration.

    Attributes
    ----------
    published
        The table that it was fitted to and is compared with.
    fitted, held_out
        Indices of the fitted rows in it, and of all others.
    fits
        One per variant.
    alternative
        The optimum with the fitted cells weighted equally, the arm's inertia on top.
    predictions
        Of all rows, by the study as it is ("ideal") and at both optima.
    alternative_prediction
        At the alternative's optimum.
    scores
        By prediction, "least squares" and "as unconnected", over the held-out cells of TE1, TE2 and both.
    surrogate
        Its cross-validated error.
    trials
        Of each condition in the predictions.
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

    def residuals(self, which: str) -> FloatArray:
        """Return simulated minus published means of the fitted rows, (row, robot), m."""
        rows = list(self.fitted)
        return np.asarray(
            self.predictions[which].mean[rows] - np.array([self.published[i].mean for i in rows])
        )

    def numbers(self) -> dict[str, Any]:
        """Whole calibration for JSON: tracking errors in mm, everything else in SI units."""
        return {
            "fitted_conditions": [self.published[i].label for i in self.fitted],
            "held_out_conditions": [self.published[i].label for i in self.held_out],
            "trials": self.trials,
            "fits": {
                name: {
                    **fit.numbers(),
                    "residuals": [
                        {
                            "condition": self.published[i].label,
                            "te1": finite_or_none(1e3 * row[0]),
                            "te2": finite_or_none(1e3 * row[1]),
                        }
                        for i, row in zip(self.fitted, self.residuals(name), strict=True)
                    ],
                }
                for name, fit in self.fits.items()
            },
            "least_squares": {
                **self.alternative.numbers(),
                "cells": [
                    {
                        "condition": row.label,
                        **_simulated_cells(self.alternative_prediction, i),
                    }
                    for i, row in enumerate(self.published)
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
            "cells": self._cells_json(),
            "held_out": {
                name: {cells: score.numbers() for cells, score in scores.items()}
                for name, scores in self.scores.items()
            },
            "arrows": {name: self._arrow_counts(prediction) for name, prediction in self.predictions.items()},
        }

    def _cells_json(self) -> list[dict[str, Any]]:
        """List every condition with its published and simulated errors, mm."""
        cells = []
        for i, row in enumerate(self.published):
            entry: dict[str, Any] = {
                "condition": row.label,
                "stiffness": row.stiffness,
                "delay": row.delay if row.stiffness is not None else None,
                "fitted": i in self.fitted,
                "published": _cells_of_row(row.mean, row.standard_deviation, row.arrow),
            }
            for name, prediction in self.predictions.items():
                agrees = prediction.arrows_agreeing(self.published)[i]
                entry[name] = {
                    **_simulated_cells(prediction, i),
                    "ended_early": prediction.ended_early[i],
                    "te1_arrow_agrees": agrees[0],
                    "te2_arrow_agrees": agrees[1],
                }
            cells.append(entry)
        return cells

    def _arrow_counts(self, prediction: Prediction) -> dict[str, Any]:
        agreement = prediction.arrows_agreeing(self.published)
        held_out = [agrees for i in self.held_out for agrees in agreement[i] if agrees is not None]
        all_cells = [agrees for pair in agreement for agrees in pair if agrees is not None]
        return {
            "agreeing": sum(all_cells),
            "of": len(all_cells),
            "agreeing_held_out": sum(held_out),
            "of_held_out": len(held_out),
            "disagreeing": [
                f"TE{robot + 1} {row.label}: published {row.arrow[robot] or 'none'}, "
                f"simulated {arrow[robot] or 'none'}"
                for row, arrow, agrees in zip(self.published, prediction.arrow, agreement, strict=True)
                for robot in (0, 1)
                if agrees[robot] is False
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
        Robots, agents and protocol. Its conditions are replaced by those of `published`, as printed.
    published
        Means and standard deviations of the tracking errors. Rows that are not fitted do not affect the fit.
    trials
        Trials of each condition, for the predictions and to confirm an optimum.
    sizes, design_trials
        Points of the design (even, plausible, around each optimum), and trials of each condition there.
    progress
        Called with the name of each step as it begins.
    simulator
        Replaces the study's own laboratory.

    Returns
    -------
    Calibration
        The same input gives the same output.

    Raises
    ------
    telespring.InvalidInput
        If the study has no laboratory like the paper's.
    """
    report = progress if progress is not None else lambda _: None
    rig = simulator if simulator is not None else RigSimulator(study)
    table = tuple(published)
    fitted = tuple(i for i, row in enumerate(table) if row.stiffness in (None, _FITTED_STIFFNESS))
    held_out = tuple(i for i in range(len(table)) if i not in fitted)
    conditions = {i: (row.stiffness, row.delay) for i, row in enumerate(table)}
    fitted_conditions = {i: conditions[i] for i in fitted}
    likelihood = Likelihood.of([table[i] for i in fitted])

    def design_run(points: FloatArray) -> FloatArray:
        return np.array(
            [_trial_means(rig.errors(fitted_conditions, design_trials, point * HIGH)) for point in points]
        ).reshape(len(points), len(fitted), 2)

    def confirm(point: FloatArray) -> FloatArray:
        return _trial_means(rig.errors(fitted_conditions, trials, point * HIGH))

    report("design of the calibration")
    surrogate = explore(design_run, likelihood, sizes)
    fits: dict[str, Fit] = {}
    for variant in VARIANTS:
        report(f"fit, the arm's inertia {variant}{' Table III' if variant == 'inside' else ''}")
        fits[variant] = fit(surrogate, likelihood, variant, confirm)
    report("the same cells by least squares")
    alternative = least_squares(
        lambda point: design_run(point[None])[0], confirm, likelihood, fits["on top"].point
    )
    report("prediction of the conditions held out")
    predictions = {"ideal": predict(rig.errors(conditions, trials), table)}
    for name, fitted_variant in fits.items():
        predictions[name] = predict(rig.errors(conditions, trials, fitted_variant.point * HIGH), table)
    alternative_prediction = predict(rig.errors(conditions, trials, alternative.point * HIGH), table)
    scores = _score_held_out(table, list(held_out), {**predictions, "least squares": alternative_prediction})
    return Calibration(
        published=table,
        fitted=fitted,
        held_out=held_out,
        fits=fits,
        alternative=alternative,
        predictions=predictions,
        alternative_prediction=alternative_prediction,
        scores=scores,
        surrogate=_surrogate_error(surrogate, design_trials),
        trials=trials,
    )


def _score_held_out(
    table: tuple[PublishedRow, ...], rows: list[int], predictions: dict[str, Prediction]
) -> dict[str, dict[str, Score]]:
    measured = np.array([table[i].mean for i in rows])
    candidates = {name: prediction.mean[rows] for name, prediction in predictions.items()}
    candidates["as unconnected"] = null_prediction(table, rows)
    return {
        name: {
            "te1": score(mean[:, 0], measured[:, 0]),
            "te2": score(mean[:, 1], measured[:, 1]),
            "both": score(mean, measured),
        }
        for name, mean in candidates.items()
    }


def _trial_means(errors: FloatArray) -> FloatArray:
    """Average simulated errors over trials; one that ended early makes its condition's mean NaN."""
    return np.asarray(errors.mean(axis=1))


def _surrogate_error(surrogate: Surrogate, trials: int) -> SurrogateError:
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


def _simulated_cells(prediction: Prediction, condition: int) -> dict[str, Any]:
    (mean1, mean2), (sd1, sd2) = (
        values[condition].tolist() for values in (prediction.mean, prediction.standard_deviation)
    )
    return _cells_of_row((mean1, mean2), (sd1, sd2), prediction.arrow[condition])


def _cells_of_row(
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
