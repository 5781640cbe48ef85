"""What the fitted model leaves out: friction, an offset, a lag of the force, inertia between axes.

Each of them looks like another where it is fitted alone: friction like damping and like the other axis'
acceleration, a lag like mass and, where the axes follow the same movement at different times, like coupled
axes. They are therefore estimated side by side, in one fit per axis.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from telespring._types import FloatArray
from telespring.identification import regression
from telespring.identification.filtering import Signals

if TYPE_CHECKING:
    from telespring.identification.estimation import AxisIdentification, Estimate

__all__ = ["LeftOut", "Term", "examine", "friction_warnings", "lag_warnings", "sticking_warnings"]

#: A column is told apart from others if so much of its length is its own: two columns of unit length then
#: have a condition number below 10.
_OWN = 0.2
#: A lag and inertia between axes may look more alike: fitted side by side, their errors say how well they are
#: told apart. Below this share the errors themselves are not to be trusted.
_OWN_BESIDE = 0.02
#: With friction, samples are left out to which an axis at rest contributes more than this.
_STANDING = 0.02
#: In half-widths of the interval: samples near rest shift the mass by more than that where an axis sticks.
_STICKS = 1.5
#: Odds that what is not there is found: one in a thousand each.
_SIGNIFICANCE = 0.001
#: A lag is corrected in steps, each exact to first order; none is longer than this, s.
_STEPS, _LONGEST = 6, 0.2


@dataclass(frozen=True)
class Term:
    """A coefficient of something that the fitted model has not.

    Attributes
    ----------
    value, standard_error, half_width
        In its own unit; half of the 95 % confidence interval's width.
    significant
        Whether it differs from 0 at one in a thousand.
    """

    value: float
    standard_error: float
    half_width: float
    significant: bool


@dataclass(frozen=True)
class LeftOut:
    """What one axis' force shows beside the fitted model.

    Attributes
    ----------
    friction
        "coulomb" and "offset", N, as far as they were not fitted and can be told apart.
    shift
        By how much the force lags the position, s; None where that cannot be told.
    inertias
        kg, per other axis by its index; None where the axes moved too much alike to tell.
    confounded
        Whether the movement cannot tell a lag from inertia between the axes.
    r_squared
        Share of the force's variance that the model explains with all of these.
    """

    friction: Mapping[str, Term]
    shift: Term | None
    inertias: Mapping[int, Term | None]
    confounded: bool
    r_squared: float


def examine(
    fit: regression.Fit, regressor: FloatArray, signals: Signals, index: int, missing: Sequence[str]
) -> LeftOut:
    """Estimate side by side what the model of one axis leaves out.

    Parameters
    ----------
    fit, regressor
        The axis' fit and its columns.
    signals
        The signals; rows are axes.
    index
        The axis' row.
    missing
        Which of "coulomb" and "offset" are not among the columns.

    Returns
    -------
    LeftOut
        Friction, lag and inertias.
    """
    force = signals.force[index]
    friction = {
        name: column
        for name, column in (("coulomb", signals.direction[index]), ("offset", np.ones_like(force)))
        if name in missing and _own(column, regressor) > _OWN
    }
    base = np.column_stack([regressor, *friction.values()])
    jerk = signals.jerk[index]
    others = [i for i in range(len(signals.force)) if i != index]
    accelerations = {i: signals.acceleration[i] for i in others if _own(signals.acceleration[i], base) > _OWN}
    lagging = _own(jerk, regressor) > _OWN
    beside = [*([jerk] if lagging else []), *accelerations.values()]
    confounded = lagging and any(
        _own(column, np.column_stack([base, *(each for each in beside if each is not column)])) <= _OWN_BESIDE
        for column in beside
    )
    weights = np.ones_like(force) if fit.lags is None else fit.weights
    rubs = "coulomb" not in missing
    if "coulomb" in friction:
        with_friction = regression.weighted(base, force, weights)
        rubs = _terms(with_friction)[regressor.shape[1]].significant
        if rubs and fit.lags is not None:
            # Where friction was left out, other samples than the outliers lie far off.
            weights = regression.robust_least_squares(base, force).weights
    moving = _moving(signals, index)
    if rubs and moving.mean() > 0.3:
        # While an axis sticks its friction is any force, and looks like everything else.
        weights = weights * moving
    if not confounded:
        found = _Side(signals.time, force, weights, base, accelerations, jerk if lagging else None)
        shift, terms, r_squared = found.solve()
    else:
        shift, _, r_squared = _Side(signals.time, force, weights, base, {}, jerk).solve()
        _, terms, other = _Side(signals.time, force, weights, base, accelerations, None).solve()
        r_squared = max(r_squared, other)
    inertias = {
        i: terms[base.shape[1] + list(accelerations).index(i)] if i in accelerations else None for i in others
    }
    first = regressor.shape[1]
    return LeftOut(
        friction={name: terms[first + i] for i, name in enumerate(friction)},
        shift=shift,
        inertias=inertias,
        confounded=confounded,
        r_squared=r_squared,
    )


@dataclass(frozen=True)
class _Side:
    """One fit of the model and of what it leaves out."""

    time: FloatArray
    force: FloatArray
    weights: FloatArray
    base: FloatArray
    accelerations: Mapping[int, FloatArray]
    jerk: FloatArray | None

    def solve(self) -> tuple[Term | None, list[Term], float]:
        """Give the lag, the terms of all columns but the jerk, and the share that is explained."""
        from scipy.interpolate import CubicSpline

        columns = np.column_stack([self.base, *self.accelerations.values()])
        if self.jerk is None:
            fit = regression.weighted(columns, self.force, self.weights)
            return None, _terms(fit), _explained(fit, self.force)
        columns = np.column_stack([columns, self.jerk])
        keep = np.ones(self.time.size, dtype=bool)
        force, total = self.force, 0.0
        spline = None
        for _ in range(_STEPS):
            fit = regression.weighted(columns[keep], force[keep], self.weights[keep])
            terms, explained = _terms(fit), _explained(fit, force[keep])
            mass = float(fit.estimate[0])
            if mass <= 0.0:
                return None, terms[:-1], explained
            # F(t − τ) has a part −τ m times the jerk, and −τ b times the acceleration.
            step, error = -terms[-1].value / mass, terms[-1].standard_error / mass
            shift = Term(total + step, error, terms[-1].half_width / mass, significant=False)
            if abs(step) < error or abs(total + step) > _LONGEST:
                break
            total += step
            spline = spline or CubicSpline(self.time, self.force)
            force = spline(self.time + total)
            keep = (self.time + total >= self.time[0]) & (self.time + total <= self.time[-1])
        return (
            replace(shift, significant=bool(abs(shift.value) > _strictness(fit) * shift.half_width)),
            terms[:-1],
            explained,
        )


def _moving(signals: Signals, index: int) -> FloatArray:
    return np.asarray(signals.standing[index] < _STANDING)


def _own(column: FloatArray, others: FloatArray) -> float:
    """Share of a column's length that no combination of the others makes up."""
    length = float(np.linalg.norm(column))
    if length == 0.0:
        return 0.0
    size = np.linalg.norm(others, axis=0)
    unit = others / np.where(size > 0.0, size, 1.0)
    rest = column - unit @ np.linalg.lstsq(unit, column, rcond=None)[0]
    return float(np.linalg.norm(rest)) / length


def _strictness(fit: regression.Fit) -> float:
    """How many half-widths of its interval a term must reach to be significant."""
    from scipy import stats

    strict, usual = (
        float(stats.t.ppf(share, fit.degrees_of_freedom)) for share in (1.0 - 0.5 * _SIGNIFICANCE, 0.975)
    )
    return strict / usual


def _terms(fit: regression.Fit) -> list[Term]:
    strict = _strictness(fit)
    return [
        Term(float(value), float(error), float(half), bool(abs(value) > strict * half))
        for value, error, half in zip(fit.estimate, fit.standard_error, fit.half_width(), strict=True)
    ]


def _explained(fit: regression.Fit, force: FloatArray) -> float:
    variation = float((fit.weights * (force - force.mean()) ** 2).sum())
    return 1.0 - float((fit.weights * fit.residual**2).sum()) / variation if variation > 0.0 else 0.0


def friction_warnings(
    found: Sequence[AxisIdentification],
    left_out: Sequence[LeftOut],
    again: Callable[[int, Sequence[str]], AxisIdentification],
) -> list[str]:
    """Tell where friction or an offset was not fitted and mass or damping are wrong by it.

    Parameters
    ----------
    found, left_out
        What was identified, and what is there beside it, per axis.
    again
        Identifies one axis, by its index, with "coulomb" and "offset" as named.

    Returns
    -------
    list of str
        Sentences.
    """
    told = []
    for i, (axis, beside) in enumerate(zip(found, left_out, strict=True)):
        # Friction that drives is none.
        names = [
            name
            for name, term in beside.friction.items()
            if term.significant and (name == "offset" or term.value > 0.0)
        ]
        if not names:
            continue
        other = again(i, names)
        moved = [
            name
            for name in ("mass", "damping")
            if abs(axis.estimates[name].value - other.estimates[name].value) > _half_width(axis, name)
        ]
        if not moved:
            continue
        what = {"coulomb": "friction", "offset": "an offset"}
        options = " ".join(f"--{name}" for name in names)
        sizes = " and ".join(f"{what[name]} of {other.estimates[name].value:.3g} N" for name in names)
        units = {"mass": "kg", "damping": "N·s/m"}
        would = " and ".join(
            f"the {name} {other.estimates[name].value:.4g} instead of {axis.estimates[name].value:.4g} "
            f"{units[name]}"
            for name in moved
        )
        told.append(
            f"Axis {axis.axis}: {sizes} that {'was' if len(names) == 1 else 'were'} not fitted "
            f"{'makes' if len(names) == 1 else 'make'} {' and '.join(moved)} wrong. Identify again with "
            f"{options}: {would} would be found."
        )
    return told


def sticking_warnings(
    found: Sequence[AxisIdentification], regressors: Sequence[FloatArray], signals: Signals
) -> list[str]:
    """Tell where an axis sticks at its reversals for so long that its mass is wrong by it.

    Parameters
    ----------
    found
        What was identified, Coulomb friction included.
    regressors
        The columns of each axis' fit.
    signals
        What it was identified from.

    Returns
    -------
    list of str
        Sentences.
    """
    told = []
    for i, (axis, regressor) in enumerate(zip(found, regressors, strict=True)):
        moving = _moving(signals, i)
        if axis.coulomb is None or axis.fit.lags is None or moving.mean() < 0.3:
            continue
        other = regression.weighted(regressor, signals.force[i], axis.fit.weights * moving)
        mass, half = float(other.estimate[0]), _half_width(axis, "mass")
        if abs(mass - axis.mass.value) > _STICKS * half:
            told.append(
                f"Axis {axis.axis}: friction holds the axis at its reversals, and the force while it sticks "
                f"shifts the mass: without the samples near rest it is {mass:.4g} kg instead of "
                f"{axis.mass.value:.4g} kg. It is known no better than that, whatever the interval says. "
                "Move faster, so that the axis rests for a shorter time."
            )
    return told


def lag_warnings(
    found: Sequence[AxisIdentification], left_out: Sequence[LeftOut], coupled: set[tuple[str, str]]
) -> list[str]:
    """Tell where the force lags the position, and where that cannot be told from coupled axes.

    Parameters
    ----------
    found, left_out
        What was identified, and what is there beside it, per axis.
    coupled
        Which axes, by name, feel which others' acceleration.

    Returns
    -------
    list of str
        Sentences.
    """
    lagging = {}
    for axis, beside in zip(found, left_out, strict=True):
        shift = beside.shift
        if shift is None or not shift.significant or beside.r_squared < 0.99:
            continue
        # A lag τ of the force moves the mass by τ b (and the damping by less).
        error = abs(shift.value * axis.damping.value)
        if error > max(_half_width(axis, "mass"), 0.01 * abs(axis.mass.value)):
            lagging[axis.axis] = (shift.value, error, beside.confounded)
    contrary = (
        min((lag for lag, _, _ in lagging.values()), default=0.0)
        < 0.0
        < max((lag for lag, _, _ in lagging.values()), default=0.0)
    )
    told = []
    for name, (lag, error, confounded) in lagging.items():
        late = "later" if lag > 0.0 else "earlier"
        seems = (
            f"Axis {name}: the force seems {1e3 * abs(lag):.2g} ms {late} than the position, which shifts "
            f"the mass by about {error:.2g} kg. "
        )
        if confounded and any(axis == name for axis, _ in coupled):
            told.append(
                seems + "Axes that are coupled by inertia would look the same in this movement: excite the "
                "axes with different movements to tell which it is."
            )
        elif contrary:
            told.append(
                seems + "It is not so on every axis, so that no --force-delay mends it: give each axis' "
                "force its own time, or look for what else moves this axis."
            )
        else:
            told.append(
                seems + "If the sensors are that far apart, correct the time stamps "
                f"(--force-delay {lag:.2g})."
            )
    return told


def _half_width(axis: AxisIdentification, name: str) -> float:
    estimate: Estimate = axis.estimates[name]
    if axis.fit.lags is None:
        # The interval of the paper's method means nothing.
        return 0.01 * abs(estimate.value)
    return 0.5 * (estimate.interval[1] - estimate.interval[0])
