"""What the numbers of a calibration say, in sentences; each is written from the numbers alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from telespring._types import FloatArray
from telespring.paper.calibration.comparison import Prediction, Score
from telespring.paper.calibration.fit import Fit
from telespring.paper.calibration.least_squares import LeastSquares
from telespring.paper.calibration.likelihood import Likelihood
from telespring.paper.calibration.unknowns import UNKNOWNS
from telespring.paper.published import PublishedRow

__all__ = ["signed", "statements"]

#: From here on two unknowns count as hard to tell apart.
_CORRELATED = 0.7

_WORDS = {
    "arm_mass": "arm mass",
    "arm_damping": "arm damping",
    "coulomb": "Coulomb friction",
    "spot_velocity": "spot velocity",
}
_TITLES = {"inside": "inertia inside Table III", "on top": "inertia on top of Table III"}


def statements(
    table: Sequence[PublishedRow],
    fitted: Sequence[int],
    held_out: Sequence[int],
    fits: Mapping[str, Fit],
    alternative: LeastSquares,
    predictions: Mapping[str, Prediction],
    scores: Mapping[str, Mapping[str, Score]],
) -> list[str]:
    """Say how good the fit is, what the unknowns are worth, and what does not agree and why.

    Parameters
    ----------
    table
        The published rows.
    fitted, held_out
        Their places.
    fits
        Per variant.
    alternative
        By least squares.
    predictions, scores
        By laboratory.

    Returns
    -------
    list of str
        Sentences.
    """
    seen = ", ".join(table[i].label for i in fitted)
    said = [
        (
            f"The conditions are run at the stiffness and delay that the table prints, not at the unrounded "
            f"multiples of K and Δ. The fit sees {seen}; the other {len(held_out)} are predicted."
        )
    ]
    for name, found in fits.items():
        said += _of_fit(name, found, table, fitted)
    said += _of_variants(fits, alternative, scores)
    # one model need not be described twice
    same = len({tuple(np.round(found.point, 2)) for found in fits.values()}) == 1
    titles = {"inside": "either variant"} if same and "inside" in fits else dict(_TITLES)
    for name, title in titles.items():
        said += _of_held_out(name, title, scores)
        said += _of_shape(title, predictions[name], table)
    said += _of_growth(predictions, table)
    said += _of_scatter(predictions, table)
    return said


def _of_fit(name: str, found: Fit, table: Sequence[PublishedRow], fitted: Sequence[int]) -> list[str]:
    sampling = Likelihood.of([table[i] for i in fitted]).sampling_variance ** 0.5
    common, difference = found.misfit
    said = [
        f"With {_TITLES[name]} the fit is {_listed(found.values)}. It misses the mean of TE1 and TE2 of a "
        f"condition by {_mm(common)} (root mean square) and half their difference by {_mm(difference)}; the "
        f"sampling error of either is {_mm(sampling)}. "
        + (
            "The model does not hold to within that error."
            if max(common, difference) > 2 * sampling
            else "The model holds to within twice that error."
        )
    ]
    if name == "inside":
        said.append(
            "With the arm's inertia inside Table III the moving mass is Table III's, whatever part of it is "
            "the arm's: the arm mass has no effect on any cell and is not an unknown."
        )
    at_zero = [_WORDS[key] for key, value in found.values.items() if value < 1e-3 * _high(key)]
    if at_zero:
        said.append(
            f"With {_TITLES[name]} the best {' and '.join(at_zero)} is none: the deviance only rises from "
            "there."
        )
    unbounded = [
        f"{_WORDS[key]} ({_interval(found, key)}"
        + (", the whole range that was searched)" if each.open_below and each.open_above else ")")
        for key, each in found.profiles.items()
        if each.open_below or each.open_above
    ]
    if unbounded:
        said.append(
            f"With {_TITLES[name]} the 95 % profile interval reaches an end of the searched range for "
            f"{', '.join(unbounded)}."
        )
    close = [
        f"{_WORDS[one]} and {_WORDS[two]} ({signed(found.correlation[i, j], 2)})"
        for i, one in enumerate(found.values)
        for j, two in enumerate(found.values)
        if i < j and abs(found.correlation[i, j]) >= _CORRELATED
    ]
    if close:
        said.append(f"With {_TITLES[name]} hard to tell apart, by their correlation: {'; '.join(close)}.")
    return said


def _of_variants(
    fits: Mapping[str, Fit], alternative: LeastSquares, scores: Mapping[str, Mapping[str, Score]]
) -> list[str]:
    if set(fits) != {"inside", "on top"}:
        return []
    gain = fits["inside"].deviance - fits["on top"].deviance
    mass = fits["on top"].values["arm_mass"]
    if mass < 1e-3 * _high("arm_mass"):
        interval = _interval(fits["on top"], "arm_mass")
        sentence = (
            "Let free, an arm mass on top of Table III goes to none under the chosen likelihood, where both "
            f"variants are one model; its interval is {interval}."
        )
    else:
        sentence = (
            f"An arm mass of {mass:.2f} kg on top of Table III lowers the deviance by {gain:.1f}, with one "
            f"unknown more; {fits['on top'].threshold:.1f} would be significant at 95 %."
        )
    return [sentence, *_of_likelihood(fits["on top"], alternative, scores)]


def _of_likelihood(
    found: Fit, alternative: LeastSquares, scores: Mapping[str, Mapping[str, Score]]
) -> list[str]:
    """Say that the likelihood was chosen, what another gives, and what holds under both."""
    both = scores["least squares"]["both"]
    held_out = (
        f"the held-out cells are then missed by {_mm(both.rms_error)} (r.m.s.); rank correlation: "
        f"{_ranks(scores['least squares'])}, both together {_rank(both)}"
        if np.isfinite(both.rms_error)
        else "in held-out conditions trials then diverge, so that there is no score"
    )
    low, high = found.profiles["arm_mass"].interval
    masses = (found.values["arm_mass"], alternative.values["arm_mass"])
    same = abs(masses[0] - masses[1]) < 0.05 * _high("arm_mass")
    return [
        (
            "The likelihood is a choice: it takes the mean of a condition's two errors and half their "
            "difference apart, each with a misfit of its own, because one coupled motion is behind both. "
            "Plain least squares over the same fitted cells, with inertia on top, gives "
            f"{_listed(alternative.values)}, at {_mm(alternative.rms)} (r.m.s. over those cells) in the "
            f"place of {_mm(alternative.rms_of_fit)}; {held_out}."
        ),
        (
            f"Under either likelihood the arm mass on top is about {masses[0]:.2f} kg."
            if same
            else f"The arm mass on top depends on that choice, {masses[0]:.2f} kg or {masses[1]:.2f} kg: the "
            "fitted cells do not tell it"
            + (
                f", and its interval, {low:.2f} to {high:.2f} kg, holds both."
                if low <= masses[1] <= high
                else "."
            )
        ),
    ]


def _of_held_out(name: str, title: str, scores: Mapping[str, Mapping[str, Score]]) -> list[str]:
    ours, null = scores[name]["both"], scores["as unconnected"]["both"]
    if not np.isfinite(ours.rms_error):
        return [f"With {title} trials of the held-out conditions diverged: there is no score."]
    better = "nearer to" if ours.rms_error < null.rms_error else "farther from"
    return [
        (
            f"With {title} the {ours.cells} held-out cells are missed by {_mm(ours.rms_error)} (r.m.s., "
            f"mean {_signed(ours.mean_error)} mm), {better} the published ones than the prediction that "
            f"nothing changes from the unconnected mode ({_mm(null.rms_error)}). Rank correlation with the "
            f"published means: {_ranks(scores[name])}."
        ),
        _of_pooled_rank(title, ours, null),
    ]


def _of_pooled_rank(title: str, ours: Score, null: Score) -> str:
    """Compare with the null prediction, which ranks nothing but the two robots."""
    said = f"With {title}, over TE1 and TE2 together, the rank correlation is {_rank(ours)}; "
    said += f"that of the null prediction, which knows only that TE2 is the larger, is {_rank(null)}"
    if ours.rank_correlation is None or null.rank_correlation is None:
        return said + "."
    return said + (": higher." if null.rank_correlation > ours.rank_correlation else ": not higher.")


def _of_shape(title: str, found: Prediction, table: Sequence[PublishedRow]) -> list[str]:
    """Compare effects, not values: of the delay, of connecting, and the gap between both agents."""
    said: list[str] = []
    stronger = 0
    measured = np.array([row.mean for row in table])
    for stiffness in sorted({row.stiffness for row in table if row.stiffness is not None}, reverse=True):
        rows = [i for i, row in enumerate(table) if row.stiffness == stiffness]
        first, last = min(rows, key=lambda i: table[i].delay), max(rows, key=lambda i: table[i].delay)
        ours, theirs = (each[last] - each[first] for each in (found.mean, measured))
        if np.isfinite(ours).all() and (np.abs(ours - theirs) > 2e-3).any():
            said.append(
                f"With {title}, {stiffness:.0f} N/m: the longest delay changes TE1 and TE2 by "
                f"{_pair(ours)} in the model and by {_pair(theirs)} in the table."
            )
            stronger += int((ours > theirs).all())
    if stronger > 1 and stronger == len(said):
        said.append(
            f"With {title} the model overstates the delay's effect wherever it misses it: the unknowns act "
            "on each side alone, and none of them lets a delayed spring of known stiffness do less."
        )
    at_zero = [i for i, row in enumerate(table) if row.stiffness is not None and row.delay == 0.0]
    baseline = next((i for i, row in enumerate(table) if row.stiffness is None), None)
    if baseline is not None and at_zero:
        softest = min(at_zero, key=lambda i: table[i].stiffness or 0.0)
        stiffest = max(at_zero, key=lambda i: table[i].stiffness or 0.0)
        ours, theirs = (each[softest] - each[baseline] for each in (found.mean, measured))
        if np.isfinite(ours).all() and abs(ours[0] - theirs[0]) > 1e-3:
            said.append(
                f"With {title}, connecting the robots by {table[softest].stiffness:.0f} N/m without delay "
                f"changes TE1 by {_signed(ours[0])} mm in the model and by {_signed(theirs[0])} mm in "
                "the table"
                + (
                    ": nothing in the model lets the skilled agent gain from a partner who is worse."
                    if theirs[0] < 0
                    else "."
                )
            )
        gap, published_gap = (float(each[stiffest, 1] - each[stiffest, 0]) for each in (found.mean, measured))
        alone, published_alone = (
            float(each[baseline, 1] - each[baseline, 0]) for each in (found.mean, measured)
        )
        if np.isfinite(gap) and published_gap - gap > 1e-3:
            said.append(
                f"With {title}, TE2 less TE1 falls from {_plain(alone)} mm alone to {_plain(gap)} mm at "
                f"{table[stiffest].stiffness:.0f} N/m without delay, for a stiff spring makes both handles "
                f"move alike; in the table it goes from {_plain(published_alone)} to "
                f"{_plain(published_gap)} mm: as if the real spring coupled the handles less than its "
                "stiffness says."
            )
    agree = found.arrows_agreeing(table)
    wrong = [
        f"TE{robot + 1} {row.label}"
        for row, one in zip(table, agree, strict=True)
        for robot in (0, 1)
        if one[robot] is False
    ]
    count = sum(one is not None for pair in agree for one in pair)
    said.append(
        f"With {title}, {count - len(wrong)} of {count} arrows agree"
        + (f"; not those of {', '.join(wrong)}." if wrong else ".")
    )
    return said


def _of_growth(predictions: Mapping[str, Prediction], table: Sequence[PublishedRow]) -> list[str]:
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
            f"In the study's own laboratory the handles run away in {', '.join(grown)}; nothing like it "
            "was published. More damping or friction in the real arms and robots is one possible "
            "explanation; less delay or stiffness than was set, or agents who act otherwise than modelled, "
            "are others, and nothing here tells them apart."
        )
    ]


def _of_scatter(predictions: Mapping[str, Prediction], table: Sequence[PublishedRow]) -> list[str]:
    baseline = next((i for i, row in enumerate(table) if row.stiffness is None), None)
    if baseline is None:
        return []
    ours = ", ".join(
        f"{1e3 * each.standard_deviation[baseline, 0]:.1f} mm ({name})" for name, each in predictions.items()
    )
    theirs = 1e3 * table[baseline].standard_deviation[0]
    return [
        (
            f"Alone, TE1 scatters by {theirs:.1f} mm between the published trials and by {ours} between "
            "simulated ones: the real skilled agent was not as exact a copy of itself, and no unknown here "
            "stands for that."
        )
    ]


def _listed(values: Mapping[str, float]) -> str:
    units = {each.name: each.unit for each in UNKNOWNS}
    return ", ".join(f"{_WORDS[key]} {value:.2f} {units[key]}" for key, value in values.items())


def _interval(found: Fit, key: str) -> str:
    low, high = found.profiles[key].interval
    return f"{low:.2f} to {high:.2f} {next(each.unit for each in UNKNOWNS if each.name == key)}"


def _high(key: str) -> float:
    return next(each.high for each in UNKNOWNS if each.name == key)


def _mm(length: float) -> str:
    return f"{1e3 * length:.2f} mm" if length < 1e-3 else f"{1e3 * length:.1f} mm"


def _pair(change: FloatArray) -> str:
    return f"{_signed(change[0])} and {_signed(change[1])} mm"


def signed(value: float, digits: int) -> str:
    """Write a number with its sign, a minus as it is printed; what rounds to zero has none.

    Examples
    --------
    >>> signed(-1.26, 1), signed(0.5, 1), signed(-0.04, 1)
    ('−1.3', '+0.5', '0.0')
    """
    text = f"{value:+.{digits}f}"
    return (text if float(text) else text[1:]).replace("-", "−")


def _signed(length: float) -> str:
    return signed(1e3 * length, 1)


def _plain(length: float) -> str:
    return _signed(length).removeprefix("+")


def _ranks(scores: Mapping[str, Score]) -> str:
    return ", ".join(f"{key.upper()} {_rank(scores[key])}" for key in ("te1", "te2"))


def _rank(found: Score) -> str:
    if found.rank_correlation is None or found.p_value is None:
        return "none"
    p = f"p = {found.p_value:.3f}" if found.p_value >= 0.001 else "p < 0.001"
    return f"{signed(found.rank_correlation, 2)} ({p})"
