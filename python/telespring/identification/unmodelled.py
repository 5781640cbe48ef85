"""What the fitted model leaves out: inertia between axes, a lag that was ruled out, any other dependence.

Every effect is tested as one more column of the regression, beside all terms of the model, with the same
covariance. It counts where it is significant and shifts mass or damping by a good part of their intervals.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from telespring._types import FloatArray
from telespring.identification.filtering import STRIBECK_VELOCITIES
from telespring.identification.joint_fit import SEPARABLE, fit_axes, orthogonal_share
from telespring.identification.log_fit import LogFit, fit_with_column, is_significant
from telespring.identification.regression import Fit
from telespring.identification.results import Estimate
from telespring.identification.terms import ALWAYS, TERMS, term_column

__all__ = ["Effect", "Inertia", "estimate_inertias", "find_effects", "ruled_out_terms"]

#: An inertia between axes is estimated where this share of the other acceleration is orthogonal to the model.
_SEPARABLE_INERTIA = 0.1
#: A lag and inertia between axes may look more alike: fitted side by side, their errors show how well they
#: are separated. Below this share the errors themselves are unreliable.
_SEPARABLE_FROM_LAG = 0.02
#: A cross inertia below this share of the axes' own masses does not change the verdict.
_NEGLIGIBLE_INERTIA = 0.02
#: Probability of a false alarm per effect, of which a dozen are tested per axis.
_SIGNIFICANCE = 1e-4
#: An effect matters if mass or damping shift by so many half-widths and by this share of their values.
_MATTERS, _LEAST_SHIFT = 0.5, 1e-3


@dataclass(frozen=True)
class Inertia:
    """Force on one axis per acceleration of another.

    Attributes
    ----------
    estimate
        kg; None if the axes moved too much alike.
    matters
        Whether it differs from 0 at a significance level of 0.001, and exceeds 2 % of the axes' masses.
    may_be_lag
        Whether a lag of the force would look the same in this movement.
    """

    estimate: Estimate | None
    matters: bool = False
    may_be_lag: bool = False


@dataclass(frozen=True)
class Effect:
    """A dependence of the force that the model does not have.

    Attributes
    ----------
    name
        Of the effect.
    mass, damping
        kg and N·s/m, estimated together with the effect.
    lag
        s, where the effect is a lag of the force.
    """

    name: str
    mass: float
    damping: float
    lag: float | None = None


def estimate_inertias(fit: LogFit) -> list[Mapping[int, Inertia]]:
    """Estimate, for every axis, the inertias between it and the others, by the others' rows in the signals.

    All are estimated in one fit together with the lag of the force, unless the movement cannot separate them.
    """
    signals, used = fit.signals, fit.signals.used
    count = len(signals.force)
    regressors = [_fullest_regressor(fit, i) for i in range(count)]
    separable = [
        [
            k
            for k in range(count)
            if k != i
            and orthogonal_share(signals.acceleration[k][used], regressors[i][used]) > _SEPARABLE_INERTIA
        ]
        for i in range(count)
    ]
    may_be_lag = [
        any(
            orthogonal_share(
                signals.acceleration[k][used], np.column_stack([regressors[i], fit.joint.slope[i]])[used]
            )
            <= _SEPARABLE_FROM_LAG
            for k in separable[i]
        )
        for i in range(count)
    ]
    if not any(separable):
        return [{k: Inertia(None) for k in range(count) if k != i} for i in range(count)]
    own_slopes = [
        replace(fit.terms[i], coupled=tuple(others)).regressor_slope(signals, i)
        for i, others in enumerate(separable)
    ]
    wider = fit_axes(
        [
            np.column_stack([x, *(signals.acceleration[k] for k in others)])
            for x, others in zip(regressors, separable, strict=True)
        ],
        [
            _with_columns_before(slope, len(others), x.shape[1])
            for slope, others, x in zip(own_slopes, separable, regressors, strict=True)
        ],
        signals,
        method="ols" if fit.options.method == "paper" else fit.options.method,
        lag=fit.joint.lags[0].value if any(may_be_lag) or not fit.joint.lags[0].estimated else None,
        shared=fit.shared_lag,
    )
    found: list[Mapping[int, Inertia]] = []
    for i, (own, others) in enumerate(zip(wider.fits, separable, strict=True)):
        half, start = own.half_width(), regressors[i].shape[1]
        each: dict[int, Inertia] = {k: Inertia(None) for k in range(count) if k != i}
        for place, k in enumerate(others, start=start):
            value, error = float(own.estimate[place]), float(own.standard_error[place])
            interval = (value - float(half[place]), value + float(half[place]))
            negligible = _NEGLIGIBLE_INERTIA * math.sqrt(abs(own.estimate[0] * wider.fits[k].estimate[0]))
            matters = is_significant(own, column=place) and abs(value) > negligible
            each[k] = Inertia(Estimate(value, error, interval), matters, may_be_lag[i])
        found.append(each)
    return found


def _with_columns_before(slope: FloatArray, last: int, width: int) -> FloatArray:
    """Insert zeros before the last columns of a regressor's slope, for terms that were added to it."""
    own = slope.shape[1] - last
    return np.column_stack([slope[:, :own], np.zeros((len(slope), width - own)), slope[:, own:]])


def _fullest_regressor(fit: LogFit, axis: int) -> FloatArray:
    """Return an axis' regressor with spring, friction and offset even where they are ruled out.

    An inertia must not stand for a term that was left out by request.
    """
    signals, used = fit.signals, fit.signals.used
    terms = replace(fit.terms[axis], coupled=())
    regressor = terms.regressor(signals, axis)
    for name in ALWAYS:
        column = term_column(signals, axis, name, terms)
        if name not in terms.names and orthogonal_share(column[used], regressor[used]) > SEPARABLE:
            regressor = np.column_stack([regressor, column])
    return regressor


def find_effects(fit: LogFit, axis: int, names: Sequence[str]) -> list[Effect]:
    """Find what the force on one axis also depends on, the most significant first."""
    found: list[tuple[float, Effect]] = []
    for name, column in _effect_columns(fit, axis, names).items():
        wider = fit_with_column(fit, axis, column)
        if wider is None or not is_significant(wider, _SIGNIFICANCE):
            continue
        if _shifts(fit, axis, wider, _MATTERS):
            mass, damping = wider.estimate[:2].tolist()
            lag = None
            if name == "lag":
                # F(t − τ) contains −τ times the force's slope.
                lag = (fit.options.lag or 0.0) + float(wider.estimate[-1])
            strength = abs(float(wider.estimate[-1])) / float(wider.standard_error[-1])
            found.append((strength, Effect(name, mass, damping, lag)))
    return [effect for _, effect in sorted(found, key=lambda pair: -pair[0])]


def ruled_out_terms(fit: LogFit, axis: int) -> list[tuple[str, Fit]]:
    """Return the terms that were ruled out although this axis has them, each with the fit that has it too."""
    found = []
    for name in TERMS:
        if fit.options.model.asked.get(name) is not False:
            continue
        # Of stiction with several velocities the first that matters tells.
        for index in range(len(STRIBECK_VELOCITIES) if name == "stiction" else 1):
            terms = replace(fit.terms[axis], stiction_index=index)
            wider = fit_with_column(fit, axis, term_column(fit.signals, axis, name, terms))
            if wider is None or not is_significant(wider):
                continue
            is_drive = name in ("coulomb", "drag", "stiction") and wider.estimate[-1] < 0.0
            if not is_drive and _shifts(fit, axis, wider, 1.0):
                found.append((name, wider))
                break
    return found


def _shifts(fit: LogFit, axis: int, wider: Fit, half_widths: float) -> bool:
    """Tell whether a wider model shifts mass or damping by so many half-widths of their intervals."""
    estimate = fit.joint.fits[axis].estimate[:2]
    shift = np.abs(wider.estimate[:2] - estimate)
    least = np.maximum(half_widths * fit.half_widths(axis), _LEAST_SHIFT * np.abs(estimate))
    return bool((shift > least).any())


def _effect_columns(fit: LogFit, axis: int, names: Sequence[str]) -> dict[str, FloatArray]:
    """Return what the force might also depend on: position, velocity, their products and signs."""
    signals = fit.signals
    x = signals.position[axis] - signals.position[axis][signals.used].mean()
    v, a, sign = signals.velocity[axis], signals.acceleration[axis], signals.direction[axis]
    columns = {
        "the square of the position": x**2,
        "the cube of the position": x**3,
        "the square of the velocity": v**2,
        "the cube of the velocity": v**3,
        "position times velocity": x * v,
        "position times acceleration": x * a,
        "position and direction": x * sign,
        "the direction times the acceleration": sign * a,
    }
    for i, other in enumerate(names):
        if i != axis:
            columns[f"the velocity of axis {other}"] = signals.velocity[i]
            columns[f"the position of axis {other}"] = signals.position[i] - signals.position[i].mean()
    if not fit.joint.lags[axis].estimated:
        columns["lag"] = -fit.joint.slope[axis]
    return columns
