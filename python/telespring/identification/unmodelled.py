"""Terms that the fitted model omits: friction, an offset, a lag of the force, inertia between axes.

Fitted alone, each of them looks like another: friction like damping and like the other axis' acceleration, a
lag like mass and, where the axes follow the same movement at different times, like coupled axes. They are
therefore estimated side by side, in one fit per axis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from telespring._types import FloatArray
from telespring.identification.filtering import Signals
from telespring.identification.regression import Fit, least_squares, robust_least_squares
from telespring.identification.results import Estimate

__all__ = ["Term", "UnmodelledTerms", "estimate_unmodelled_terms", "is_moving"]

#: A column can be separated from others if this share of its length is orthogonal to them: two columns of
#: unit length then have a condition number below 10.
_SEPARABLE = 0.2
#: A lag and inertia between axes may look more alike: fitted side by side, their errors show how well they
#: are separated. Below this share the errors themselves are unreliable.
_SEPARABLE_SIDE_BY_SIDE = 0.02
#: With friction, samples are excluded to which an axis at rest contributes more than this.
_REST_SHARE = 0.02
#: Probability of a false alarm, for each term.
_SIGNIFICANCE = 0.001
#: A lag is corrected in steps, each exact to first order; none is longer than this, s.
_LAG_STEPS, _LONGEST_LAG = 6, 0.2


@dataclass(frozen=True)
class Term:
    """A coefficient of a term that the fitted model omits.

    Attributes
    ----------
    value, standard_error, half_width
        In its own unit; the half-width is that of the 95 % confidence interval.
    significant
        Whether it differs from 0 at a significance level of 0.001.
    """

    value: float
    standard_error: float
    half_width: float
    significant: bool

    @property
    def estimate(self) -> Estimate:
        """Value, standard error and interval of an unmodelled term."""
        interval = (self.value - self.half_width, self.value + self.half_width)
        return Estimate(self.value, self.standard_error, interval)


@dataclass(frozen=True)
class UnmodelledTerms:
    """What one axis' force contains besides the fitted model.

    Attributes
    ----------
    friction
        "coulomb" and "offset", N, where they were not fitted and can be separated from the model.
    lag
        Lag of the force behind the position, s; None if it cannot be estimated.
    inertias
        kg, per other axis by its index; None if the axes moved too much alike.
    is_confounded
        Whether the movement cannot separate a lag from inertia between the axes.
    r_squared
        Share of the force's variance that the model explains with all of these terms.
    """

    friction: Mapping[str, Term]
    lag: Term | None
    inertias: Mapping[int, Term | None]
    is_confounded: bool
    r_squared: float


def estimate_unmodelled_terms(
    fit: Fit, regressor: FloatArray, signals: Signals, index: int, omitted: Sequence[str]
) -> UnmodelledTerms:
    """Estimate friction, lag and inertial coupling side by side on one axis.

    `fit` and `regressor` are those of the axis in row `index` of the signals; `omitted` lists which of
    "coulomb" and "offset" are not among the regressor's columns.
    """
    force, jerk = signals.force[index], signals.jerk[index]
    friction = {
        name: column
        for name, column in (("coulomb", signals.direction[index]), ("offset", np.ones_like(force)))
        if name in omitted and _orthogonal_share_of_column(column, regressor) > _SEPARABLE
    }
    base = np.column_stack([regressor, *friction.values()])
    others = [i for i in range(len(signals.force)) if i != index]
    accelerations = {
        i: signals.acceleration[i]
        for i in others
        if _orthogonal_share_of_column(signals.acceleration[i], base) > _SEPARABLE
    }
    is_lag_separable = _orthogonal_share_of_column(jerk, regressor) > _SEPARABLE
    candidates = [*([jerk] if is_lag_separable else []), *accelerations.values()]
    is_confounded = is_lag_separable and any(
        _orthogonal_share_of_column(column, np.column_stack([base, *candidates[:i], *candidates[i + 1 :]]))
        <= _SEPARABLE_SIDE_BY_SIDE
        for i, column in enumerate(candidates)
    )
    weights = _moving_sample_weights(fit, base, list(friction), signals, index, omitted)
    with_inertias = np.column_stack([base, *accelerations.values()])
    if is_confounded:
        lag, _, r_squared = _fit_terms_with_force_lag(base, jerk, signals.time, force, weights)
        terms, r_squared_coupled = _fit_all_terms(with_inertias, force, weights)
        r_squared = max(r_squared, r_squared_coupled)
    elif is_lag_separable:
        lag, terms, r_squared = _fit_terms_with_force_lag(with_inertias, jerk, signals.time, force, weights)
    else:
        lag = None
        terms, r_squared = _fit_all_terms(with_inertias, force, weights)
    inertias = dict(zip(accelerations, terms[base.shape[1] :], strict=True))
    return UnmodelledTerms(
        friction=dict(zip(friction, terms[regressor.shape[1] : base.shape[1]], strict=True)),
        lag=lag,
        inertias={i: inertias.get(i) for i in others},
        is_confounded=is_confounded,
        r_squared=r_squared,
    )


def is_moving(signals: Signals, index: int) -> FloatArray:
    """Return which samples of an axis contain hardly any rest."""
    return np.asarray(signals.rest[index] < _REST_SHARE)


def _moving_sample_weights(
    fit: Fit, base: FloatArray, friction: list[str], signals: Signals, index: int, omitted: Sequence[str]
) -> FloatArray:
    """Return the weights of the fit, without the samples near rest where the axis has friction."""
    force = signals.force[index]
    weights = np.ones_like(force) if fit.lags is None else fit.weights
    has_friction = "coulomb" not in omitted
    if "coulomb" in friction:
        terms, _ = _fit_all_terms(base, force, weights)
        has_friction = terms[fit.estimate.size].significant
        if has_friction and fit.lags is not None:
            # The fit without friction took other samples for outliers.
            weights = robust_least_squares(base, force).weights
    moving = is_moving(signals, index)
    if has_friction and moving.mean() > 0.3:
        # While an axis sticks, friction takes any value and looks like every other term.
        weights = weights * moving
    return weights


def _fit_all_terms(columns: FloatArray, force: FloatArray, weights: FloatArray) -> tuple[list[Term], float]:
    """Return the coefficients of all columns, and the share of the force's variance that they explain."""
    fit = least_squares(columns, force, weights)
    strictness = _significance_threshold(fit.degrees_of_freedom)
    terms = [
        Term(float(value), float(error), float(half), bool(abs(value) > strictness * half))
        for value, error, half in zip(fit.estimate, fit.standard_error, fit.half_width(), strict=True)
    ]
    variation = float((fit.weights * (force - force.mean()) ** 2).sum())
    squares = float((fit.weights * fit.residual**2).sum())
    return terms, 1.0 - squares / variation if variation > 0.0 else 0.0


def _fit_terms_with_force_lag(
    columns: FloatArray, jerk: FloatArray, time: FloatArray, force: FloatArray, weights: FloatArray
) -> tuple[Term | None, list[Term], float]:
    """Estimate the lag of the force from its share of the jerk, and the coefficients of the other columns.

    A negative mass gives no lag.
    """
    from scipy.interpolate import CubicSpline

    with_jerk = np.column_stack([columns, jerk])
    keep = np.ones(time.size, dtype=bool)
    shifted, total = force, 0.0
    spline = None
    for _ in range(_LAG_STEPS):
        terms, r_squared = _fit_all_terms(with_jerk[keep], shifted[keep], weights[keep])
        fitted = int(keep.sum())
        mass = terms[0].value
        if mass <= 0.0:
            return None, terms[:-1], r_squared
        # F(t − τ) contains −τ m times the jerk, and −τ b times the acceleration.
        step, error = -terms[-1].value / mass, terms[-1].standard_error / mass
        lag = Term(total + step, error, terms[-1].half_width / mass, significant=False)
        if abs(step) < error or abs(total + step) > _LONGEST_LAG:
            break
        total += step
        spline = spline or CubicSpline(time, force)
        shifted = spline(time + total)
        keep = (time + total >= time[0]) & (time + total <= time[-1])
    strictness = _significance_threshold(fitted - with_jerk.shape[1])
    significant = bool(abs(lag.value) > strictness * lag.half_width)
    return replace(lag, significant=significant), terms[:-1], r_squared


def _significance_threshold(degrees_of_freedom: int) -> float:
    """Return how many half-widths of its 95 % interval a term must exceed to be significant."""
    from scipy import stats

    strict, usual = (stats.t.ppf(share, degrees_of_freedom) for share in (1.0 - 0.5 * _SIGNIFICANCE, 0.975))
    return float(strict / usual)


def _orthogonal_share_of_column(column: FloatArray, others: FloatArray) -> float:
    """Return the share of a column's length that is orthogonal to all other columns."""
    length = float(np.linalg.norm(column))
    if length == 0.0:
        return 0.0
    size = np.linalg.norm(others, axis=0)
    unit = others / np.where(size > 0.0, size, 1.0)
    remainder = column - unit @ np.linalg.lstsq(unit, column, rcond=None)[0]
    return float(np.linalg.norm(remainder)) / length
