"""How well predictors foretell recorded motion: errors over a range of delays, and fitted Kalman noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias, cast

import numpy as np

from telespring._core import check_usual, fit_noise, predict_motion
from telespring._errors import InvalidInput
from telespring._types import FloatArray

if TYPE_CHECKING:
    from telespring._core import NoiseFit
    from telespring.analysis.trials import Trials

__all__ = ["HandMotion", "PredictorComparison", "PredictorErrors", "compare_predictors", "motions_of_trials"]

MotionModel: TypeAlias = Literal["constant-velocity", "constant-acceleration"]

#: One-way delays over which predictors are compared, s.
DELAYS = (0.02, 0.05, 0.084, 0.12, 0.167, 0.25, 0.334)
#: Time in which a filter settles before its errors count, s.
_SETTLING = 1.0
#: No more motions than these are used, spread evenly over the record.
_MOST = 60
_MODELS: tuple[MotionModel, ...] = ("constant-velocity", "constant-acceleration")
#: Process noises that are tried beside the fitted one: powers of ten of its factor.
_TRIED = (-6.0, -5.0, -4.0, -3.0, -2.0, -1.0, 1.0, 2.0)


class HandMotion(NamedTuple):
    """The recorded motion of one handle: times (n,) in s, positions (n, 2) in m, and what else is known.

    Without velocities (n, 2), those of the last two samples are used, as a device without a tachometer would.
    The target (n, 2) is that which both sides show.
    """

    name: str
    time: FloatArray
    position: FloatArray
    velocity: FloatArray | None = None
    target: FloatArray | None = None


@dataclass(frozen=True)
class PredictorErrors:
    """A predictor, as a study names it, and its errors.

    Attributes
    ----------
    label
        "hold", "linear", "kalman, constant velocity, fitted" and so on.
    predictor
        What `[session]` takes: a word, or a mapping with the settings of a Kalman filter.
    errors
        RMS distance between predicted and true position at each delay, m; NaN where no motion is long enough.
    """

    label: str
    predictor: str | Mapping[str, Any]
    errors: tuple[float, ...]


@dataclass(frozen=True)
class PredictorComparison:
    """How well predictors foretell motions over one delay.

    Attributes
    ----------
    delays
        One-way delays, s.
    predictors
        Every predictor with its errors: hold, linear, Kalman filters, and the shared target if one is known.
    fits
        The noise that maximises the likelihood, per model: the median over all motions.
    ends
        How the fits ended, per model: number of motions for each word.
    motions
        How many motions were compared, and how many there were.
    best
        The predictor with the smallest errors, by the mean logarithm over the delays.
    best_without_target
        The same among those that know no target.
    """

    delays: tuple[float, ...]
    predictors: tuple[PredictorErrors, ...]
    fits: Mapping[str, Mapping[str, float]]
    ends: Mapping[str, Mapping[str, int]]
    motions: tuple[int, int]
    best: PredictorErrors
    best_without_target: PredictorErrors

    def to_json(self) -> dict[str, Any]:
        """Return the comparison as plain values in SI units."""
        return {
            "schema": 1,
            "motions": {"compared": self.motions[0], "recorded": self.motions[1]},
            "delays": list(self.delays),
            "predictors": [
                {
                    "label": entry.label,
                    "predictor": entry.predictor
                    if isinstance(entry.predictor, str)
                    else dict(entry.predictor),
                    "rms": [None if np.isnan(error) else error for error in entry.errors],
                }
                for entry in self.predictors
            ],
            "fits": {model: {**fit, "ends": dict(self.ends[model])} for model, fit in self.fits.items()},
            "best": self.best.label,
            "best_without_target": self.best_without_target.label,
            "units": {"delays": "s", "rms": "m", "process": "m²/s³ or m²/s⁵", "position": "m"},
        }


def motions_of_trials(trials: Trials) -> list[HandMotion]:
    """Return the analysed samples of both handles of every completed trial.

    Parameters
    ----------
    trials : Trials
        Trials of an experiment, rehearsed or recorded.

    Returns
    -------
    list of HandMotion
        Two per completed trial.
    """
    motions = []
    for condition, trial in np.argwhere(trials.completed):
        window = trials.window[condition, trial]
        target = trials.trial_target(int(condition), int(trial))[window]
        for robot in range(trials.position.shape[3]):
            velocity = trials.velocity
            motions.append(
                HandMotion(
                    f"{trials.trial_name(int(condition), int(trial))}, robot {robot + 1}",
                    trials.time[window],
                    trials.position[condition, trial, window, robot],
                    None if velocity is None else velocity[condition, trial, window, robot],
                    target if np.isfinite(target).all() else None,
                )
            )
    return motions


def compare_predictors(
    motions: Sequence[HandMotion], delays: Sequence[float] = DELAYS
) -> PredictorComparison:
    """Fit the noise of Kalman filters to recorded motion, and compare all predictors over a range of delays.

    The noise of both models is fitted to every motion (`telespring.fit_noise`), and the median over all
    motions is used. That fit judges predictions over one sample. Process noises above and below it are
    therefore tried, too, and the one with the smallest errors over the delays stands beside the fitted one.

    Parameters
    ----------
    motions : sequence of HandMotion
        Recorded motions. Of more than 60, 60 spread evenly are used.
    delays : sequence of float
        How far ahead, s.

    Returns
    -------
    PredictorComparison
        Errors per predictor and delay, the fitted noise, and the best predictor.

    Raises
    ------
    telespring.InvalidInput
        If no motion is long enough for the shortest delay, a delay is not positive or one that no network
        has, or a motion cannot be fitted.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(0.0, 20.0, 0.005)
    >>> circle = HandMotion("circle", t, 0.05 * np.column_stack([np.cos(3 * t), np.sin(3 * t)]).round(4))
    >>> comparison = compare_predictors([circle], [0.1])
    >>> comparison.best.label
    'kalman, constant acceleration, fitted'
    >>> [round(1e3 * entry.errors[0], 1) for entry in comparison.predictors[:2]]  # mm: hold, linear
    [14.9, 2.4]
    """
    asked = tuple(float(delay) for delay in delays)
    for i, delay in enumerate(asked):
        if not delay > 0.0:
            raise InvalidInput(
                f"delays[{i}]",
                repr(delay),
                "a delay must be a positive number of seconds",
                "Leave out a delay of 0.",
            )
        check_usual("delay", f"delays[{i}]", delay)
    if not asked:
        raise InvalidInput(
            "delays", "[]", "at least one delay is required", "Leave it out for the usual ones."
        )
    used = [
        motions[i]
        for i in np.unique(np.linspace(0, len(motions) - 1, min(_MOST, len(motions))).round().astype(int))
    ]
    if not any(_span(motion) > _SETTLING + min(asked) for motion in used):
        longest = max((_span(motion) for motion in used), default=0.0)
        raise InvalidInput(
            "motions",
            f"{len(motions)}, the longest of {longest:.3g} s",
            f"a motion longer than {_SETTLING + min(asked):.3g} s is required: a filter settles for "
            f"{_SETTLING:g} s",
            "Record longer trials, or give shorter delays.",
        )
    entries = [_judged("hold", "hold", used, asked), _judged("linear", "linear", used, asked)]
    fits: dict[str, Mapping[str, float]] = {}
    ends: dict[str, Mapping[str, int]] = {}
    for model in _MODELS:
        each = [_fit(motion, model) for motion in used]
        process, position = (
            float(np.exp(np.median(np.log([getattr(fit, name) for fit in each]))))
            for name in ("process", "position")
        )
        fits[model] = {"process": process, "position": position}
        ends[model] = {end: sum(fit.end == end for fit in each) for end in sorted({fit.end for fit in each})}
        entries += _filters(model, process, position, used, asked)
    if all(motion.target is not None for motion in used):
        entries.append(_judged("shared target", "shared-target", used, asked))
    ranked = sorted(entries, key=_score)
    return PredictorComparison(
        asked,
        tuple(entries),
        fits,
        ends,
        (len(used), len(motions)),
        ranked[0],
        next(entry for entry in ranked if entry.predictor != "shared-target"),
    )


def _span(motion: HandMotion) -> float:
    return float(motion.time[-1] - motion.time[0]) if len(motion.time) else 0.0


def _fit(motion: HandMotion, model: MotionModel) -> NoiseFit:
    """Fit one motion; a refusal names it."""
    try:
        return fit_noise(motion.time, motion.position, model)
    except InvalidInput as refused:
        raise refused.at(f"{motion.name}: {refused.field}") from None


def _filters(
    model: MotionModel,
    process: float,
    position: float,
    motions: Sequence[HandMotion],
    delays: Sequence[float],
) -> list[PredictorErrors]:
    """Judge the filter with the fitted noise, and the best of others if it is better."""

    def judged(factor: float, suffix: str) -> PredictorErrors:
        settings = {
            "kind": "kalman",
            "model": model,
            "process": float(f"{process * factor:.3g}"),
            "position": float(f"{position:.3g}"),
        }
        return _judged(f"kalman, {model.replace('-', ' ')}, {suffix}", settings, motions, delays)

    fitted = judged(1.0, "fitted")
    tried = [judged(10.0**power, "for these delays") for power in _TRIED]
    best = min(tried, key=_score)
    return [fitted, best] if _score(best) < _score(fitted) - 0.01 else [fitted]


def _score(entry: PredictorErrors) -> float:
    """Return the mean logarithm of the errors: each delay counts the same, however large its errors are."""
    errors = np.array([error for error in entry.errors if not np.isnan(error)])
    return float(np.mean(np.log(np.maximum(errors, 1e-15))))


def _judged(
    label: str, predictor: str | Mapping[str, Any], motions: Sequence[HandMotion], delays: Sequence[float]
) -> PredictorErrors:
    """Compute the RMS errors of a predictor over all motions, at each delay."""
    errors = []
    for delay in delays:
        squares = [_squared_errors(motion, delay, predictor) for motion in motions]
        together = np.concatenate(squares)
        errors.append(float(np.sqrt(together.mean())) if together.size else float("nan"))
    return PredictorErrors(label, predictor, tuple(errors))


def _squared_errors(motion: HandMotion, delay: float, predictor: str | Mapping[str, Any]) -> FloatArray:
    """Return the squared distances between predicted and true positions, one delay after each sample, m²."""
    time, position = np.ascontiguousarray(motion.time), np.ascontiguousarray(motion.position)
    later = time + delay
    counts = (time >= time[0] + _SETTLING) & (later <= time[-1])
    if not counts.any():
        return np.empty(0)

    def at(values: FloatArray) -> FloatArray:
        return np.column_stack([np.interp(later, time, values[:, axis]) for axis in range(2)])

    velocity = _backward_differences(time, position) if motion.velocity is None else motion.velocity
    targets = None if motion.target is None else (motion.target, at(motion.target))
    predicted = predict_motion(
        time, position, velocity, delay, predictor, targets if predictor == "shared-target" else None
    )
    return cast("FloatArray", ((predicted - at(position))[counts] ** 2).sum(axis=1))


def _backward_differences(time: FloatArray, position: FloatArray) -> FloatArray:
    velocity = np.zeros_like(position)
    velocity[1:] = np.diff(position, axis=0) / np.diff(time)[:, None]
    return velocity
