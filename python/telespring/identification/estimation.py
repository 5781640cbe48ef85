"""Mass, damping and friction of each axis of a robot from a log of positions and forces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from telespring._arrays import as_number, as_numbers
from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification import regression
from telespring.identification.diagnostics import cutoff_warnings, implausible
from telespring.identification.filtering import (
    CUTOFF_RULE,
    Signals,
    choose_cutoff,
    filtered_signals,
    noise_deviation,
)
from telespring.identification.log_checks import even_times, shifted
from telespring.identification.unmodelled import (
    LeftOut,
    examine,
    friction_warnings,
    lag_warnings,
    sticking_warnings,
)

__all__ = [
    "AxisIdentification",
    "CrossInertia",
    "Estimate",
    "Identification",
    "Method",
    "identify",
]

Method: TypeAlias = Literal["robust", "ols", "paper"]

_METHODS = {
    "robust": "Hampel's M-estimate from Huber's, Newey-West covariance",
    "ols": "ordinary least squares, Newey-West covariance",
    "paper": "weights 1/(r² + ε) as printed; the intervals are those of weighted least squares",
}

#: An axis moves too little below this travel, m, and below so many times its noise's standard deviation.
_LEAST_TRAVEL, _TIMES_NOISE = 1e-3, 50.0
#: A cross inertia of less than this share of the axes' own masses leaves the verdict as it is.
_MATTERS = 0.02


@dataclass(frozen=True)
class Estimate:
    """One parameter of one axis.

    Attributes
    ----------
    value
        kg, N·s/m or N.
    standard_error
        In the same unit.
    interval
        95 % confidence interval.
    """

    value: float
    standard_error: float
    interval: tuple[float, float]


@dataclass(frozen=True)
class CrossInertia:
    """How much force one axis needs per acceleration of another.

    Attributes
    ----------
    axis, other
        The force's axis and the acceleration's.
    inertia
        kg; None where the axes moved too much alike to tell.
    significant
        True where it differs from 0 at one in a thousand and exceeds 2 % of the axes' own masses.
    """

    axis: str
    other: str
    inertia: Estimate | None
    significant: bool


@dataclass(frozen=True)
class AxisIdentification:
    """What was identified on one axis.

    Attributes
    ----------
    axis
        Its name.
    mass, damping
        kg and N·s/m.
    coulomb, offset
        Coulomb friction and offset of the force, N; None where not asked for.
    correlation
        Between the errors of mass and damping.
    condition_number
        Of the regressor [a, v, sign v, 1] in SI units.
    r_squared
        Share of the force's variance that the model explains.
    relative_force_error
        Norm of the residual over norm of the force.
    time_shift
        By how much the force seems to lag the position, s, with interval; None where that cannot be told.
    signals_index
        Row of this axis in the signals.
    estimated_force, residual
        N, at the times of the signals.
    weights
        1 where a sample counted fully.
    fit
        The regression itself.
    """

    axis: str
    mass: Estimate
    damping: Estimate
    coulomb: Estimate | None
    offset: Estimate | None
    correlation: float
    condition_number: float
    r_squared: float
    relative_force_error: float
    time_shift: Estimate | None
    signals_index: int
    estimated_force: FloatArray
    residual: FloatArray
    weights: FloatArray
    fit: regression.Fit

    @property
    def estimates(self) -> dict[str, Estimate]:
        """All parameters that were identified, by name."""
        named = {"mass": self.mass, "damping": self.damping, "coulomb": self.coulomb, "offset": self.offset}
        return {name: found for name, found in named.items() if found is not None}

    def to_json(self) -> dict[str, Any]:
        """Give plain values in SI units; None for what was not asked for."""
        found: dict[str, Any] = {"axis": self.axis}
        for name in ("mass", "damping", "coulomb", "offset"):
            estimate = self.estimates.get(name)
            found[name] = None if estimate is None else estimate.value
            found[f"{name}_interval"] = None if estimate is None else list(estimate.interval)
            found[f"{name}_sd"] = None if estimate is None else estimate.standard_error
        shift = self.time_shift
        return found | {
            "mass_damping_correlation": self.correlation,
            "condition_number": self.condition_number,
            "r_squared": self.r_squared,
            "relative_force_error": self.relative_force_error,
            "left_out": float(np.mean(self.weights < 0.5)) if self.fit.lags is not None else None,
            "time_shift": None if shift is None else shift.value,
            "time_shift_interval": None if shift is None else list(shift.interval),
        }


@dataclass(frozen=True)
class Identification:
    """A robot as its log shows it.

    Attributes
    ----------
    axes
        One entry per axis.
    signals
        The filtered signals that the regression saw; rows are axes.
    method, iterations
        "robust", "ols" or "paper", and the reweightings of the latter.
    cutoff, cutoff_rule
        Cut-off of the filter, Hz, and how it was found.
    rate
        Samples per second of the log, Hz.
    samples
        Samples in the log and in the regression.
    lags
        Bandwidth of the Newey-West covariance in samples of the regression; None for the paper's method.
    cross_inertias
        One per ordered pair of axes.
    warnings
        What a user must know before trusting the numbers, as sentences.
    """

    axes: tuple[AxisIdentification, ...]
    signals: Signals
    method: Method
    iterations: int | None
    cutoff: float
    cutoff_rule: str
    rate: float
    samples: tuple[int, int]
    lags: int | None
    cross_inertias: tuple[CrossInertia, ...]
    warnings: tuple[str, ...]

    @property
    def independent(self) -> bool | None:
        """False where axes are coupled by inertia, None where this could not be told."""
        if any(cross.significant for cross in self.cross_inertias):
            return False
        return None if any(cross.inertia is None for cross in self.cross_inertias) else True

    def axis(self, name: str) -> AxisIdentification:
        """Find an axis by its name."""
        return next(axis for axis in self.axes if axis.axis == name)

    def to_json(self) -> dict[str, Any]:
        """Give plain values in SI units."""
        return {
            "method": self.method,
            "method_in_words": _METHODS[self.method],
            "iterations": self.iterations,
            "cutoff": self.cutoff,
            "cutoff_rule": self.cutoff_rule,
            "sample_rate": self.rate,
            "samples": self.samples[0],
            "samples_used": self.samples[1],
            "lags": self.lags,
            "axes": [axis.to_json() for axis in self.axes],
            "axes_independent": self.independent,
            "cross_inertias": [
                {
                    "axis": cross.axis,
                    "other": cross.other,
                    "inertia": None if cross.inertia is None else cross.inertia.value,
                    "inertia_interval": None if cross.inertia is None else list(cross.inertia.interval),
                    "significant": cross.significant,
                }
                for cross in self.cross_inertias
            ],
            "warnings": list(self.warnings),
        }


def identify(
    time: ArrayLike,
    position: ArrayLike,
    force: ArrayLike,
    *,
    axes: Sequence[str] | None = None,
    coulomb: bool = False,
    offset: bool = False,
    cutoff: float | None = None,
    method: Method = "robust",
    iterations: int = 1,
    force_delay: float = 0.0,
) -> Identification:
    """Estimate mass, damping and friction per axis: F = m a + b v + F_c sign v + F_0.

    Velocity and acceleration come from the positions by a zero-phase filter that the force passes too, and
    by central differences. The samples are then thinned out to 2.5 per period of the cut-off frequency.

    Parameters
    ----------
    time : array_like
        s, shape (n,), increasing; jitter is interpolated away, gaps are refused.
    position : array_like
        m, shape (n,) or (n, axes).
    force : array_like
        What moves the robot, N, of the same shape. Measured at the handle it shows the robot alone,
        measured at the joints of an arm that moves the handle it shows the arm too.
    axes : sequence of str
        Names of the axes; "x", "y", … unless given.
    coulomb, offset : bool
        Whether Coulomb friction and an offset of the force are estimated too.
    cutoff : float
        Cut-off of the filter, Hz; chosen from the movement unless given (`Identification.cutoff_rule`).
    method : {"robust", "ols", "paper"}
        Hampel's M-estimate; ordinary least squares; or the paper's weighted least squares, whose intervals
        mean nothing (`telespring.identification.paper_reweightings`).
    iterations : int
        Reweightings of the paper's method; the paper prints one step and no number.
    force_delay : float
        By how much the force's samples are older than those of the position, s; the force is shifted
        back by it. A force that is τ late shifts the mass by about τ b.

    Returns
    -------
    Identification
        Estimates with 95 % intervals that account for correlated residuals, and how they were made.

    Raises
    ------
    telespring.InvalidInput
        Where the log cannot be used: gaps, too short, nothing moves, shapes that do not fit; or where noise
        of the position shifts mass or damping by several widths of their intervals at the given cut-off.

    Examples
    --------
    >>> import numpy as np
    >>> from telespring.identification import identify, paper_excitation
    >>> movement = paper_excitation()
    >>> t = np.arange(15000) / 1000.0
    >>> force = 0.8 * movement.acceleration(t) + 7.7 * movement.velocity(t)
    >>> noise = np.random.default_rng(1).normal(0.0, 0.05, t.size)
    >>> [x] = identify(t, movement.position(t), force + noise).axes
    >>> f"{x.mass.value:.2f} kg, {x.damping.value:.2f} N·s/m"
    '0.80 kg, 7.70 N·s/m'
    >>> low, high = x.mass.interval
    >>> low < 0.8 < high and high - low < 0.01
    True
    """
    positions, forces = _as_rows("position", position), _as_rows("force", force)
    times, positions, forces, rate, notes = even_times(as_numbers("time", time), positions, forces)
    names = _axis_names(axes, positions.shape[0])
    if force_delay:
        times, positions, forces = shifted(times, positions, forces, as_number("force_delay", force_delay))
    if method not in _METHODS:
        raise InvalidInput(
            "method",
            repr(method),
            'the methods are "robust", "ols" and "paper"',
            'Leave it away for "robust".',
        )
    if not 1 <= iterations <= 10_000:
        raise InvalidInput("iterations", str(iterations), "1 to 10000 reweightings are possible", "Give 1.")
    if iterations != 1 and method != "paper":
        raise InvalidInput(
            "iterations",
            str(iterations),
            f"only the paper's method counts its reweightings, and the method is {method!r}",
            'Leave it away, or choose the method "paper".',
        )
    for name, row in zip(names, positions, strict=True):
        _refuse_rest(name, row, rate)
    used = choose_cutoff(positions, rate) if cutoff is None else float(cutoff)
    signals = filtered_signals(times, positions, forces, rate=rate, cutoff=used)
    found = tuple(
        _identify_axis(name, i, signals, coulomb, offset, method, iterations) for i, name in enumerate(names)
    )
    missing = [name for name, asked in (("coulomb", coulomb), ("offset", offset)) if not asked]
    regressors = [_regressor(signals, i, coulomb, offset) for i in range(len(found))]
    left_out = [examine(axis.fit, regressors[i], signals, i, missing) for i, axis in enumerate(found)]
    found = tuple(
        replace(axis, time_shift=_shift_of(beside)) for axis, beside in zip(found, left_out, strict=True)
    )
    cross = _cross_inertias(found, left_out)
    doubts = [
        *cutoff_warnings(
            found,
            signals,
            positions,
            rate,
            lambda lower: [
                _identify_axis(name, i, lower, coulomb, offset, method, iterations)
                for i, name in enumerate(names)
            ],
            (times, forces),
        ),
        *implausible(found, signals),
    ]
    unmodelled = [
        *friction_warnings(
            found,
            left_out,
            lambda i, names: _identify_axis(
                found[i].axis,
                i,
                signals,
                coulomb or "coulomb" in names,
                offset or "offset" in names,
                method,
                iterations,
            ),
        ),
        *sticking_warnings(found, regressors, signals),
        *lag_warnings(found, left_out, {(each.axis, each.other) for each in cross if each.significant}),
    ]
    return Identification(
        axes=found,
        signals=signals,
        method=method,
        iterations=iterations if method == "paper" else None,
        cutoff=used,
        cutoff_rule=CUTOFF_RULE if cutoff is None else "as given",
        rate=rate,
        samples=(times.size, signals.time.size),
        lags=found[0].fit.lags,
        cross_inertias=cross,
        warnings=(*notes, *unmodelled, *_warnings(found, cross), *doubts),
    )


def _as_rows(name: str, values: ArrayLike) -> FloatArray:
    """Bring an array over (time,) or (time, axis) into rows of axes."""
    array = as_numbers(name, values)
    if array.ndim not in (1, 2) or array.size == 0:
        raise InvalidInput(
            name,
            f"an array of shape {array.shape}",
            "one value per sample, or one row per sample with one value per axis, is needed",
            "Time comes first.",
        )
    return np.ascontiguousarray(array.reshape(array.shape[0], -1).T)


def _axis_names(axes: Sequence[str] | None, count: int) -> list[str]:
    if axes is None:
        return ["x", "y", "z"][:count] if count <= 3 else [f"axis {i + 1}" for i in range(count)]
    names = [str(name) for name in axes]
    if len(names) != count or len(set(names)) != count:
        raise InvalidInput(
            "axes",
            repr(names),
            f"{count} different names are needed, one per axis",
            "Leave it away for x, y.",
        )
    return names


def _refuse_rest(name: str, position: FloatArray, rate: float) -> None:
    travelled = float(np.ptp(position))
    steps = np.unique(position).size
    if travelled == 0.0 or steps < 50:
        raise InvalidInput(
            f"position ({name})",
            f"{steps} different values over {1e3 * travelled:.3g} mm",
            "a position that moves through at least 50 steps of its sensor is needed",
            "Move the robot further, or look whether this is the right column and the sensor is connected.",
        )
    noise = noise_deviation(position, rate)
    if travelled < max(_LEAST_TRAVEL, _TIMES_NOISE * noise):
        raise InvalidInput(
            f"position ({name})",
            f"{1e3 * travelled:.3g} mm of travel, {1e3 * noise:.2g} mm of noise",
            f"this axis moves too little: at least {1e3 * _LEAST_TRAVEL:g} mm and {_TIMES_NOISE:g} times "
            "the noise are needed",
            "Move it further, name only the axes that move, or check the unit (--position-scale).",
        )


def _regressor(signals: Signals, index: int, coulomb: bool, offset: bool) -> FloatArray:
    columns = [signals.acceleration[index], signals.velocity[index]]
    if coulomb:
        columns.append(signals.direction[index])
    if offset:
        columns.append(np.ones_like(columns[0]))
    return np.stack(columns, axis=-1)


def _identify_axis(
    name: str,
    index: int,
    signals: Signals,
    coulomb: bool,
    offset: bool,
    method: Method,
    iterations: int,
) -> AxisIdentification:
    regressor, force = _regressor(signals, index, coulomb, offset), signals.force[index]
    alike = _scaled_condition(regressor)
    if not alike < 1e6:
        raise InvalidInput(
            f"position ({name})",
            f"condition number {alike:.3g}",
            "a movement is needed whose acceleration and velocity are not multiples of each other",
            "Excite it with several frequencies, as telespring.identification.paper_excitation does.",
        )
    if method == "paper":
        fit = regression.paper_least_squares(regressor, force, iterations)
    elif method == "ols":
        fit = regression.least_squares(regressor, force)
    else:
        fit = regression.robust_least_squares(regressor, force)
    half, error = fit.half_width(), fit.standard_error
    estimates = [
        Estimate(float(value), float(error[i]), (float(value - half[i]), float(value + half[i])))
        for i, value in enumerate(fit.estimate)
    ]
    variation = float(((force - force.mean()) ** 2).sum())
    squares = float((fit.residual**2).sum())
    return AxisIdentification(
        axis=name,
        mass=estimates[0],
        damping=estimates[1],
        coulomb=estimates[2] if coulomb else None,
        offset=estimates[-1] if offset else None,
        correlation=float(fit.covariance[0, 1] / (error[0] * error[1])) if error[0] * error[1] > 0.0 else 0.0,
        condition_number=float(np.linalg.cond(regressor)),
        r_squared=1.0 - squares / variation if variation > 0.0 else 0.0,
        relative_force_error=math.sqrt(squares / float((force**2).sum())) if force.any() else math.inf,
        time_shift=None,
        signals_index=index,
        estimated_force=force - fit.residual,
        residual=fit.residual,
        weights=fit.weights,
        fit=fit,
    )


def _scaled_condition(columns: FloatArray) -> float:
    """Condition number with columns of unit length: how alike they are, whatever their units."""
    size = np.linalg.norm(columns, axis=0)
    return float(np.linalg.cond(columns / np.where(size > 0.0, size, 1.0))) if size.all() else math.inf


def _cross_inertias(
    found: Sequence[AxisIdentification], left_out: Sequence[LeftOut]
) -> tuple[CrossInertia, ...]:
    crosses = []
    for mine, beside in zip(found, left_out, strict=True):
        for index, term in beside.inertias.items():
            other = found[index]
            if term is None:
                crosses.append(CrossInertia(mine.axis, other.axis, None, significant=False))
                continue
            size = math.sqrt(abs(mine.mass.value * other.mass.value))
            interval = (term.value - term.half_width, term.value + term.half_width)
            crosses.append(
                CrossInertia(
                    mine.axis,
                    other.axis,
                    Estimate(term.value, term.standard_error, interval),
                    significant=term.significant and abs(term.value) > _MATTERS * size,
                )
            )
    return tuple(crosses)


def _shift_of(beside: LeftOut) -> Estimate | None:
    shift = beside.shift
    if shift is None:
        return None
    interval = (shift.value - shift.half_width, shift.value + shift.half_width)
    return Estimate(shift.value, shift.standard_error, interval)


def _warnings(found: Sequence[AxisIdentification], cross: Sequence[CrossInertia]) -> list[str]:
    told = []
    for axis in found:
        uncertain = [name for name in ("mass", "damping") if axis.estimates[name].interval[0] <= 0.0]
        negative = [name for name in uncertain if axis.estimates[name].interval[1] <= 0.0]
        if negative:
            told.append(
                f"Axis {axis.axis}: {' and '.join(negative)} negative. "
                "Force and position must count the same direction; --force-scale -1 turns the force."
            )
        told += [
            f"Axis {axis.axis}: the {name} cannot be told from 0; excite the robot "
            f"{'with more acceleration' if name == 'mass' else 'at higher velocity'} or record longer."
            for name in uncertain
            if name not in negative
        ]
        if axis.r_squared < 0.8:
            told.append(
                f"Axis {axis.axis}: the model explains only {100.0 * max(0.0, axis.r_squared):.0f} % of the "
                "force. Are position and force of the same axis, and is friction or an offset missing?"
            )
        if axis.fit.lags is not None and float(np.mean(axis.weights < 0.5)) > 0.05:
            told.append(
                f"Axis {axis.axis}: {100.0 * float(np.mean(axis.weights < 0.5)):.0f} % of the samples were "
                "left out as outliers. Look at the residuals."
            )
        if not axis.fit.converged:
            told.append(f"Axis {axis.axis}: the robust fit did not come to rest; compare with --method ols.")
    for each in cross:
        if each.significant and each.inertia is not None:
            low, high = each.inertia.interval
            told.append(
                f"Axes are not independent: the force on {each.axis} takes {each.inertia.value:.3g} kg "
                f"({low:.3g} to {high:.3g}) of the acceleration on {each.other}. Verdicts axis by axis do "
                "not hold for this robot as it was measured."
            )
    if any(each.inertia is None for each in cross):
        told.append(
            "Whether the axes are independent cannot be told: they moved too much alike. Excite them with "
            "different movements, such as the same one a quarter of a period later."
        )
    return told
