"""One log fitted: which terms its axes have, whether they share the force's lag, and the estimates."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from telespring._errors import InvalidInput
from telespring._quantities import format_number
from telespring._types import FloatArray
from telespring.identification.covariance import NORMAL_HALF_WIDTH
from telespring.identification.filtering import STRIBECK_VELOCITIES, Signals, filter_stretches
from telespring.identification.joint_fit import SEPARABLE, JointFit, fit_axes, orthogonal_share
from telespring.identification.regression import Fit, least_squares
from telespring.identification.results import Method
from telespring.identification.stretches import Stretch
from telespring.identification.terms import NEAR_REST, AxisTerms, ModelTerms, term_column

__all__ = ["FitOptions", "LogFit", "fit_log", "fit_with_column", "is_significant", "single_frequency"]

#: Probability of a false alarm, for each term that is tested.
SIGNIFICANCE = 0.001
#: A term is added where it shifts mass or damping by more than this share of the interval's half-width.
_MATTERS = 0.25
#: The lag is not estimated where the model explains less of the force on every axis.
_LAG_R_SQUARED = 0.8


@dataclass(frozen=True)
class FitOptions:
    """How a log is fitted.

    Attributes
    ----------
    model
        Which terms are asked for, ruled out or left to the log.
    method, iterations
        "robust", "ols" or "paper", and the number of reweightings of the last.
    lag
        Lag of the force, s; None to estimate it.
    """

    model: ModelTerms
    method: Method = "robust"
    iterations: int = 1
    lag: float | None = None


@dataclass(frozen=True)
class LogFit:
    """The fit of one log.

    Attributes
    ----------
    signals
        The filtered samples; rows are axes.
    terms
        The terms of each axis.
    joint
        The regressions.
    added
        Names of the terms that the log added, per axis.
    shared_lag
        False where the axes disagree about the lag of the force.
    options
        How it was fitted.
    """

    signals: Signals
    terms: tuple[AxisTerms, ...]
    joint: JointFit
    added: tuple[tuple[str, ...], ...]
    shared_lag: bool
    options: FitOptions

    def regressor(self, axis: int) -> FloatArray:
        """Build the regressor of an axis, in SI units."""
        return self.terms[axis].regressor(self.signals, axis)

    def columns(self, axis: int) -> FloatArray:
        """Build the regressor of an axis with the force's slope, if its lag is estimated."""
        regressor = self.regressor(axis)
        if not self.joint.lags[axis].estimated:
            return regressor
        return np.column_stack([regressor, -self.joint.slope[axis]])

    def half_widths(self, axis: int) -> FloatArray:
        """Return the half-widths of mass (kg) and damping (N·s/m)."""
        return self.joint.fits[axis].half_width()[:2]


def fit_log(
    stretches: Sequence[Stretch],
    cutoff: float,
    names: Sequence[str],
    options: FitOptions,
    terms: Sequence[AxisTerms] | None = None,
) -> LogFit:
    """Fit a log at a cut-off (Hz).

    `terms` fixes the terms of every axis; otherwise those that the options leave to the log are tested and,
    if they are significant and matter, added one by one.
    """
    signals = filter_stretches(stretches, cutoff)
    initial = options.model.initial()
    start = (
        tuple(AxisTerms(initial, radius=options.model.radius) for _ in names)
        if terms is None
        else tuple(terms)
    )
    for i, name in enumerate(names):
        _refuse_dependent_columns(name, start[i], signals, i, options)
    fit = _fit_terms(signals, start, options)
    if terms is not None or options.method == "paper":
        return _with_added_names(_widened_by_reversals(fit), initial)
    with_rest = tuple(_add_friction_near_rest(fit, i) for i in range(len(names)))
    if with_rest != fit.terms:
        fit = _fit_terms(signals, with_rest, options)
    for _ in range(len(options.model.candidates())):
        grown = tuple(_add_best_term(fit, i) for i in range(len(names)))
        if grown == fit.terms:
            break
        fit = _fit_terms(signals, grown, options)
    return _with_added_names(_widened_by_reversals(fit), initial)


def _widened_by_reversals(fit: LogFit) -> LogFit:
    """Widen the intervals by what the term of late reversals changes.

    A log does not show how friction changes its sign: at once, as the model without this term has it, or
    later. The estimates with and without it differ by an error that no residual tells.
    """
    if not any("reversal" in terms.names for terms in fit.terms):
        return fit
    at_once = tuple(
        replace(terms, names=tuple(name for name in terms.names if name != "reversal")) for terms in fit.terms
    )
    other = _fit_terms(fit.signals, at_once, fit.options)
    fits = []
    for terms, own, alternative in zip(fit.terms, fit.joint.fits, other.joint.fits, strict=True):
        change = np.zeros(own.estimate.size)
        change[:2] = own.estimate[:2] - alternative.estimate[:2]
        is_open = "reversal" in terms.names
        wider = own.covariance + (np.outer(change, change) / NORMAL_HALF_WIDTH**2 if is_open else 0.0)
        fits.append(replace(own, covariance=wider))
    return replace(fit, joint=replace(fit.joint, fits=tuple(fits)))


def _with_added_names(fit: LogFit, initial: Sequence[str]) -> LogFit:
    known = (*initial, *NEAR_REST)
    return replace(
        fit, added=tuple(tuple(name for name in axis.names if name not in known) for axis in fit.terms)
    )


def _fit_terms(signals: Signals, terms: tuple[AxisTerms, ...], options: FitOptions) -> LogFit:
    regressors = [axis.regressor(signals, i) for i, axis in enumerate(terms)]
    slopes = [axis.regressor_slope(signals, i) for i, axis in enumerate(terms)]
    settings: dict[str, Any] = {
        "method": options.method,
        "iterations": options.iterations,
        "lag": options.lag,
    }
    joint = fit_axes(regressors, slopes, signals, **settings)
    if (
        joint.lags[0].estimated
        and max(_explained_share(joint, i, signals) for i in range(len(terms))) < _LAG_R_SQUARED
    ):
        # Of a force that is mostly something else, a lag would be the one at which noise fits best.
        settings["lag"] = 0.0
        joint = fit_axes(regressors, slopes, signals, **settings)
    shared = True
    if len(terms) > 1 and joint.lags[0].estimated:
        separate = fit_axes(regressors, slopes, signals, **settings, shared=False)
        if _axes_disagree(joint, separate):
            joint, shared = separate, False
    return LogFit(signals, terms, joint, ((),) * len(terms), shared, options)


def _explained_share(joint: JointFit, axis: int, signals: Signals) -> float:
    """Return the share of the force's variance that an axis' model explains."""
    force, residual = joint.force[axis][signals.used], joint.fits[axis].residual[signals.used]
    variation = float(np.var(force))
    return 1.0 - float(np.mean(residual**2)) / variation if variation > 0.0 else 0.0


def _axes_disagree(joint: JointFit, separate: JointFit) -> bool:
    """Tell whether the axes' own lags differ significantly, and by enough to matter for a mass."""
    from scipy import stats

    lags = [lag for lag in separate.lags if lag.estimated]
    if len(lags) < 2:
        return False
    values = np.array([lag.value for lag in lags])
    # Half-widths, not standard errors: their quantile accounts for a wide bandwidth.
    errors = np.array([lag.half_width for lag in lags]) / NORMAL_HALF_WIDTH
    mean = np.average(values, weights=errors**-2.0)
    excess = float((((values - mean) / errors) ** 2).sum())
    if excess < stats.chi2.ppf(1.0 - SIGNIFICANCE, len(lags) - 1):
        return False
    return any(
        abs(one.estimate[0] - other.estimate[0]) > max(_MATTERS * other.half_width()[0], 1e-9)
        for one, other in zip(joint.fits, separate.fits, strict=True)
    )


def _refuse_dependent_columns(
    name: str, terms: AxisTerms, signals: Signals, axis: int, options: FitOptions
) -> None:
    """Refuse a movement that cannot tell the terms apart, such as one frequency: there a spring is a mass."""
    regressor = terms.regressor(signals, axis)[signals.used]
    size = np.linalg.norm(regressor, axis=0)
    condition = float(np.linalg.cond(regressor[:, :2] / np.where(size[:2] > 0.0, size[:2], 1.0)))
    if not condition < 1e6:
        raise InvalidInput(
            f"position ({name})",
            f"condition number {format_number(condition, 3)}",
            "a movement is required whose acceleration and velocity are not multiples of each other",
            "Excite it with several frequencies, as telespring.identification.paper_excitation does.",
        )
    if "stiffness" not in terms.names or options.method == "paper":
        return
    frequency = single_frequency(signals, terms, axis)
    if frequency is not None:
        mass_per_stiffness = format_number(1.0 / (2.0 * np.pi * frequency) ** 2, 2)
        raise InvalidInput(
            f"position ({name})",
            f"a movement at one frequency, {format_number(frequency, 3)} Hz",
            "a movement is required that tells the mass from a spring between robot and ground: at one "
            f"frequency each N/m of a spring takes {mass_per_stiffness} kg off the mass",
            "Excite it with several frequencies, as telespring.identification.paper_excitation does. Only if "
            "nothing pulls the handle to a place (no spring, cable, slope or gravity), rule a spring out "
            "with --no-stiffness.",
        )


def single_frequency(signals: Signals, terms: AxisTerms, axis: int) -> float | None:
    """Return the frequency (Hz) of a movement that cannot tell a spring from a mass; None if it can."""
    used = signals.used
    others = [name for name in terms.names if name != "stiffness"]
    regressor = replace(terms, names=tuple(others)).regressor(signals, axis)[used]
    position = term_column(signals, axis, "stiffness", terms)[used]
    if orthogonal_share(position, regressor) >= SEPARABLE:
        return None
    ratio = float(np.linalg.norm(regressor[:, 0])) / max(float(np.linalg.norm(position)), 1e-300)
    return float(np.sqrt(ratio)) / (2.0 * np.pi)


def _add_friction_near_rest(fit: LogFit, axis: int) -> AxisTerms:
    """Return an axis' terms with those of friction near rest, where the axis has friction."""
    terms = fit.terms[axis]
    if "coulomb" not in terms.names or fit.options.model.asked.get("stiction") is False:
        return terms
    own, column = fit.joint.fits[axis], 2 + terms.names.index("coulomb")
    if own.estimate[column] <= 0.0 or not is_significant(own, column=column):
        return terms
    separable = [
        name
        for name in NEAR_REST
        if fit_with_column(fit, axis, term_column(fit.signals, axis, name, terms)) is not None
    ]
    return replace(terms, names=(*terms.names, *separable))


def _add_best_term(fit: LogFit, axis: int) -> AxisTerms:
    """Return an axis' terms with the most significant of those that it lacks and needs."""
    terms = fit.terms[axis]
    best, strength = terms, 1.0
    candidates = [name for name in fit.options.model.candidates() if name not in terms.names]
    tests = len(candidates) + len(STRIBECK_VELOCITIES)
    for name in candidates:
        found = _fit_with_term(fit, axis, name)
        if found is None:
            continue
        grown, wider = found
        ratio = _significance_ratio(wider, SIGNIFICANCE / tests)
        # A drag or a stiction that drives the axis is something else.
        is_gravity = name.startswith("gravity")
        if ratio > strength and (is_gravity or wider.estimate[-1] > 0.0):
            shift = np.abs(wider.estimate[:2] - fit.joint.fits[axis].estimate[:2])
            # An axis that is said to turn has gravity rather than a spring, whatever the mass.
            if is_gravity or (shift > _MATTERS * fit.half_widths(axis)).any():
                best, strength = grown, ratio
    return best


def _fit_with_term(fit: LogFit, axis: int, name: str) -> tuple[AxisTerms, Fit] | None:
    """Fit an axis with one more term; of the velocities of stiction the one with the least residual."""
    terms, signals = fit.terms[axis], fit.signals
    fastest = float(np.abs(signals.velocity[axis]).max())
    best, least = None, math.inf
    for index, velocity in enumerate(STRIBECK_VELOCITIES if name == "stiction" else (0.0,)):
        grown = replace(
            terms,
            names=(*terms.names, name),
            stiction_index=index if name == "stiction" else terms.stiction_index,
        )
        if velocity > 0.5 * fastest:
            continue
        wider = fit_with_column(fit, axis, term_column(signals, axis, name, grown))
        if wider is None:
            continue
        squares = float((wider.weights * wider.residual**2).sum())
        if squares < least:
            best, least = (grown, wider), squares
    return best


def fit_with_column(
    fit: LogFit, axis: int, column: FloatArray, weights: FloatArray | None = None
) -> Fit | None:
    """Fit an axis with one more column, the last; None where it cannot be told from the others."""
    columns, used = fit.columns(axis), fit.signals.used
    if orthogonal_share(column[used], columns[used]) < SEPARABLE:
        return None
    return least_squares(
        np.column_stack([columns, column]),
        fit.joint.force[axis],
        fit.joint.fits[axis].weights if weights is None else weights,
        fit.signals.stretch,
    )


def is_significant(fit: Fit, level: float = SIGNIFICANCE, column: int = -1) -> bool:
    """Tell whether a coefficient differs from 0 at a level of significance."""
    return _significance_ratio(fit, level, column) > 1.0


def significance_threshold(degrees_of_freedom: float, level: float = SIGNIFICANCE) -> float:
    """Return how many half-widths of its 95 % interval a coefficient must exceed to be significant."""
    from scipy import stats

    strict, usual = (stats.t.ppf(share, degrees_of_freedom) for share in (1.0 - 0.5 * level, 0.975))
    return float(strict / usual)


def _significance_ratio(fit: Fit, level: float, column: int = -1) -> float:
    threshold = significance_threshold(float(fit.degrees_of_freedom[column]), level)
    half = fit.half_width()[column] * threshold
    return float(abs(fit.estimate[column]) / half) if half > 0.0 else float("inf")
