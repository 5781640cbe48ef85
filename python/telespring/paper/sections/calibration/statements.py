"""Sentences on the result of a calibration, written from its numbers alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from telespring._types import FloatArray
from telespring.paper.calibration.comparison import Prediction, Score
from telespring.paper.calibration.fit import Fit
from telespring.paper.calibration.least_squares import LeastSquares
from telespring.paper.calibration.likelihood import Likelihood
from telespring.paper.calibration.run import Calibration
from telespring.paper.calibration.unknowns import UNKNOWNS
from telespring.paper.published import PublishedRow
from telespring.show.quantities import format_error, format_signed

__all__ = ["calibration_statements"]

#: From here on two unknowns count as hard to tell apart.
_CORRELATED = 0.7

_NAMES = {
    "arm_mass": "arm mass",
    "arm_damping": "arm damping",
    "coulomb": "Coulomb friction",
    "spot_velocity": "spot velocity",
}
_TITLES = {"inside": "inertia inside Table III", "on top": "inertia on top of Table III"}


def calibration_statements(calibration: Calibration) -> list[str]:
    """Write sentences on the quality of the fits, on the unknowns, and on what disagrees and why."""
    table, fitted, held_out = calibration.published, calibration.fitted, calibration.held_out
    fits, predictions, scores = calibration.fits, calibration.predictions, calibration.scores
    used = ", ".join(table[i].label for i in fitted)
    sentences = [
        (
            f"The conditions are run at the printed stiffness and delay, not at the unrounded multiples of K "
            f"and Δ. Only {used} are fitted; the other {len(held_out)} conditions are predicted."
        )
    ]
    for name, fit in fits.items():
        sentences += _calibration_fit_sentences(name, fit, table, fitted)
    sentences += _calibration_variant_sentences(fits, calibration.alternative, scores)
    # one model need not be described twice
    same = len({tuple(np.round(fit.point, 2)) for fit in fits.values()}) == 1
    titles = {"inside": "either variant"} if same and "inside" in fits else dict(_TITLES)
    for name, title in titles.items():
        sentences += _held_out_cell_sentences(name, title, scores)
        sentences += _predicted_effect_sentences(title, predictions[name], table)
    sentences += _predicted_growth_sentences(predictions, table)
    sentences += _predicted_scatter_sentences(predictions, table)
    return sentences


def _calibration_fit_sentences(
    name: str, fit: Fit, table: Sequence[PublishedRow], fitted: Sequence[int]
) -> list[str]:
    sampling = Likelihood.of([table[i] for i in fitted]).sampling_variance ** 0.5
    common, difference = fit.misfit
    title = _TITLES[name]
    sentences = [
        f"With {title} the fit is {_list_calibrated_unknowns(fit.values)}. Its root-mean-square error is "
        f"{format_error(common)} in the mean of TE1 and TE2 of a condition and {format_error(difference)} in "
        f"half their difference; the sampling error of either is {format_error(sampling)}. "
        + (
            "The model does not fit to within that error."
            if max(common, difference) > 2 * sampling
            else "The model fits to within twice that error."
        )
    ]
    if name == "inside":
        sentences.append(
            "With the arm's inertia inside Table III the moving mass is that of Table III, whatever part of "
            "it is the arm's: the arm mass affects no cell and is not an unknown."
        )
    at_zero = [
        _NAMES[key] for key, value in fit.values.items() if value < 1e-3 * _upper_bound_of_unknown(key)
    ]
    if at_zero:
        sentences.append(
            f"With {title} the best fit has no {' and no '.join(at_zero)}: any raises the deviance."
        )
    unbounded = [
        f"{_NAMES[key]} ({_fitted_interval(fit, key)}"
        + (", the whole searched range)" if profile.open_below and profile.open_above else ")")
        for key, profile in fit.profiles.items()
        if profile.open_below or profile.open_above
    ]
    if unbounded:
        sentences.append(
            f"With {title} the 95 % profile interval reaches an end of the searched range for "
            f"{', '.join(unbounded)}."
        )
    correlated = [
        f"{_NAMES[one]} and {_NAMES[two]} ({format_signed(fit.correlation[i, j], 2)})"
        for i, one in enumerate(fit.values)
        for j, two in enumerate(fit.values)
        if i < j and abs(fit.correlation[i, j]) >= _CORRELATED
    ]
    if correlated:
        sentences.append(
            f"With {title} these unknowns are hard to tell apart, by their correlation: "
            f"{'; '.join(correlated)}."
        )
    return sentences


def _calibration_variant_sentences(
    fits: Mapping[str, Fit], alternative: LeastSquares, scores: Mapping[str, Mapping[str, Score]]
) -> list[str]:
    if set(fits) != {"inside", "on top"}:
        return []
    gain = fits["inside"].deviance - fits["on top"].deviance
    mass = fits["on top"].values["arm_mass"]
    if mass < 1e-3 * _upper_bound_of_unknown("arm_mass"):
        interval = _fitted_interval(fits["on top"], "arm_mass")
        sentence = (
            "With the arm mass free on top of Table III, the chosen likelihood puts it at zero, where both "
            f"variants are the same model; its interval is {interval}."
        )
    else:
        sentence = (
            f"An arm mass of {mass:.2f} kg on top of Table III lowers the deviance by {gain:.1f} with one "
            f"more unknown; {fits['on top'].threshold:.1f} would be significant at 95 %."
        )
    return [sentence, *_calibration_likelihood_sentences(fits["on top"], alternative, scores)]


def _calibration_likelihood_sentences(
    fit: Fit, alternative: LeastSquares, scores: Mapping[str, Mapping[str, Score]]
) -> list[str]:
    """Compare the chosen likelihood with plain least squares, and report what holds under both."""
    both = scores["least squares"]["both"]
    held_out = (
        f"its r.m.s. error over the held-out cells is {format_error(both.rms_error)}, with rank correlations "
        f"of {_both_rank_texts(scores['least squares'])}, both together {_rank_text(both)}"
        if np.isfinite(both.rms_error)
        else "trials of held-out conditions then diverge, so that there is no score"
    )
    low, high = fit.profiles["arm_mass"].interval
    masses = (fit.values["arm_mass"], alternative.values["arm_mass"])
    same = abs(masses[0] - masses[1]) < 0.05 * _upper_bound_of_unknown("arm_mass")
    return [
        (
            "The likelihood is a choice: it separates the mean of a condition's two errors from half their "
            "difference, each with its own misfit, because both errors come from one coupled motion. Plain "
            "least squares over the same fitted cells, with inertia on top, gives "
            f"{_list_calibrated_unknowns(alternative.values)}, with an r.m.s. error over those cells of "
            f"{format_error(alternative.rms)} instead of {format_error(alternative.rms_of_fit)}; {held_out}."
        ),
        (
            f"Under either likelihood the arm mass on top is about {masses[0]:.2f} kg."
            if same
            else f"The arm mass on top depends on that choice, {masses[0]:.2f} kg or {masses[1]:.2f} kg: the "
            "fitted cells do not determine it"
            + (
                f", and its interval, {low:.2f} to {high:.2f} kg, contains both."
                if low <= masses[1] <= high
                else "."
            )
        ),
    ]


def _held_out_cell_sentences(name: str, title: str, scores: Mapping[str, Mapping[str, Score]]) -> list[str]:
    ours, null = scores[name]["both"], scores["as unconnected"]["both"]
    if not np.isfinite(ours.rms_error):
        return [f"With {title} trials of the held-out conditions diverged: there is no score."]
    better = "smaller" if ours.rms_error < null.rms_error else "larger"
    return [
        (
            f"With {title} the r.m.s. error over the {ours.cells} held-out cells is "
            f"{format_error(ours.rms_error)} (mean {_signed_mm(ours.mean_error)} mm), {better} than that of "
            "the null prediction, that nothing changes from the unconnected mode "
            f"({format_error(null.rms_error)}). Rank correlation with the published means: "
            f"{_both_rank_texts(scores[name])}."
        ),
        _pooled_rank_sentence(title, ours, null),
    ]


def _pooled_rank_sentence(title: str, ours: Score, null: Score) -> str:
    """Compare with the null prediction, which ranks nothing but the two robots."""
    sentence = (
        f"With {title} the rank correlation over TE1 and TE2 together is {_rank_text(ours)}; that of the "
        f"null prediction, which knows only that TE2 is the larger, is {_rank_text(null)}"
    )
    if ours.rank_correlation is None or null.rank_correlation is None:
        return sentence + "."
    return sentence + (": higher." if null.rank_correlation > ours.rank_correlation else ": not higher.")


def _predicted_effect_sentences(
    title: str, prediction: Prediction, table: Sequence[PublishedRow]
) -> list[str]:
    """Compare predicted effects, not values: of the delay, of connecting, and the gap between both agents."""
    measured = np.array([row.mean for row in table])
    sentences = _predicted_delay_sentences(title, prediction, table, measured)
    at_zero = [i for i, row in enumerate(table) if row.stiffness is not None and row.delay == 0.0]
    baseline = next((i for i, row in enumerate(table) if row.stiffness is None), None)
    if baseline is not None and at_zero:
        softest = min(at_zero, key=lambda i: table[i].stiffness or 0.0)
        stiffest = max(at_zero, key=lambda i: table[i].stiffness or 0.0)
        ours, theirs = (mean[softest] - mean[baseline] for mean in (prediction.mean, measured))
        if np.isfinite(ours).all() and abs(ours[0] - theirs[0]) > 1e-3:
            sentences.append(
                f"With {title}, connecting the robots by {table[softest].stiffness:.0f} N/m without delay "
                f"changes TE1 by {_signed_mm(ours[0])} mm in the model and by {_signed_mm(theirs[0])} mm in "
                "the table"
                + (
                    ": nothing in the model lets the skilled agent gain from a less skilled partner."
                    if theirs[0] < 0
                    else "."
                )
            )
        gap, published_gap = (
            float(mean[stiffest, 1] - mean[stiffest, 0]) for mean in (prediction.mean, measured)
        )
        alone, published_alone = (
            float(mean[baseline, 1] - mean[baseline, 0]) for mean in (prediction.mean, measured)
        )
        if np.isfinite(gap) and published_gap - gap > 1e-3:
            sentences.append(
                f"With {title}, TE2 minus TE1 falls from {_size_mm(alone)} mm unconnected to {_size_mm(gap)} "
                f"mm at {table[stiffest].stiffness:.0f} N/m without delay, because a stiff spring makes both "
                f"handles move alike; in the table it goes from {_size_mm(published_alone)} to "
                f"{_size_mm(published_gap)} mm, as if the real spring coupled the handles less than its "
                "stiffness implies."
            )
    agreement = prediction.arrows_agreeing(table)
    wrong = [
        f"TE{robot + 1} {row.label}"
        for row, agrees in zip(table, agreement, strict=True)
        for robot in (0, 1)
        if agrees[robot] is False
    ]
    count = sum(agrees is not None for pair in agreement for agrees in pair)
    sentences.append(
        f"With {title} {count - len(wrong)} of {count} arrows agree"
        + (f"; these do not: {', '.join(wrong)}." if wrong else ".")
    )
    return sentences


def _predicted_delay_sentences(
    title: str, prediction: Prediction, table: Sequence[PublishedRow], measured: FloatArray
) -> list[str]:
    sentences: list[str] = []
    stronger = 0
    for stiffness in sorted({row.stiffness for row in table if row.stiffness is not None}, reverse=True):
        rows = [i for i, row in enumerate(table) if row.stiffness == stiffness]
        first, last = min(rows, key=lambda i: table[i].delay), max(rows, key=lambda i: table[i].delay)
        ours, theirs = (mean[last] - mean[first] for mean in (prediction.mean, measured))
        if np.isfinite(ours).all() and (np.abs(ours - theirs) > 2e-3).any():
            sentences.append(
                f"With {title}, at {stiffness:.0f} N/m, the longest delay changes TE1 and TE2 by "
                f"{_pair_of_error_changes(ours)} in the model and by "
                f"{_pair_of_error_changes(theirs)} in the table."
            )
            stronger += int((ours > theirs).all())
    if stronger > 1 and stronger == len(sentences):
        sentences.append(
            f"With {title} the model overstates every effect of the delay that it misses: the unknowns act "
            "on each side alone, and none of them weakens a delayed spring of known stiffness."
        )
    return sentences


def _predicted_growth_sentences(
    predictions: Mapping[str, Prediction], table: Sequence[PublishedRow]
) -> list[str]:
    ideal = predictions["ideal"]
    grown = [
        f"{row.label} ({1e3 * max(ideal.mean[i]):.0f} mm)"
        if np.isfinite(ideal.mean[i]).all()
        else f"{row.label} (ended early)"
        for i, row in enumerate(table)
        if not np.isfinite(ideal.mean[i]).all() or max(ideal.mean[i]) > 2.5 * max(row.mean)
    ]
    if not grown:
        return []
    return [
        (
            f"In the study's own laboratory the motion grows far too large in {', '.join(grown)}; the "
            "paper reports nothing similar. More damping or friction in the real arms and robots is one "
            "possible explanation; others are less delay or stiffness than was set, or agents who behave "
            "differently from the model. These data cannot tell them apart."
        )
    ]


def _predicted_scatter_sentences(
    predictions: Mapping[str, Prediction], table: Sequence[PublishedRow]
) -> list[str]:
    baseline = next((i for i, row in enumerate(table) if row.stiffness is None), None)
    if baseline is None:
        return []
    ours = ", ".join(
        f"{1e3 * prediction.standard_deviation[baseline, 0]:.1f} mm ({name})"
        for name, prediction in predictions.items()
    )
    theirs = 1e3 * table[baseline].standard_deviation[0]
    return [
        (
            f"In the unconnected mode TE1 has a standard deviation of {theirs:.1f} mm over the published "
            f"trials and of {ours} over the simulated ones: the real skilled agent is less "
            "repeatable, and no unknown of the fit represents that."
        )
    ]


def _list_calibrated_unknowns(values: Mapping[str, float]) -> str:
    units = {unknown.name: unknown.unit for unknown in UNKNOWNS}
    return ", ".join(f"{_NAMES[key]} {value:.2f} {units[key]}" for key, value in values.items())


def _fitted_interval(fit: Fit, key: str) -> str:
    low, high = fit.profiles[key].interval
    return f"{low:.2f} to {high:.2f} {next(unknown.unit for unknown in UNKNOWNS if unknown.name == key)}"


def _upper_bound_of_unknown(key: str) -> float:
    return next(unknown.high for unknown in UNKNOWNS if unknown.name == key)


def _pair_of_error_changes(change: FloatArray) -> str:
    return f"{_signed_mm(change[0])} and {_signed_mm(change[1])} mm"


def _signed_mm(length: float) -> str:
    return format_signed(1e3 * length, 1)


def _size_mm(length: float) -> str:
    return _signed_mm(length).removeprefix("+")


def _both_rank_texts(scores: Mapping[str, Score]) -> str:
    return ", ".join(f"{key.upper()} {_rank_text(scores[key])}" for key in ("te1", "te2"))


def _rank_text(score: Score) -> str:
    if score.rank_correlation is None or score.p_value is None:
        return "none"
    p = f"p = {score.p_value:.3f}" if score.p_value >= 0.001 else "p < 0.001"
    return f"{format_signed(score.rank_correlation, 2)} ({p})"
