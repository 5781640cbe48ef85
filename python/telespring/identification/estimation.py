"""Identification of a robot: mass, damping and friction of each axis from a log of positions and forces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from telespring._arrays import as_number, as_numbers
from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification import diagnostics
from telespring.identification.axis_fit import AxisModel, axis_regressor, fit_axis
from telespring.identification.cutoff import CUTOFF_RULE, choose_cutoff, noise_deviation
from telespring.identification.filtering import filter_signals
from telespring.identification.log_checks import check_log
from telespring.identification.resampling import even_stretches, shift_force
from telespring.identification.results import (
    METHODS,
    AxisIdentification,
    CrossInertia,
    Identification,
    Method,
)
from telespring.identification.unmodelled import UnmodelledTerms, estimate_unmodelled_terms

__all__ = ["identify"]

#: An axis must travel at least so far, m, and so many times the standard deviation of its noise.
_MINIMUM_TRAVEL, _TRAVEL_PER_NOISE = 1e-3, 50.0
#: A cross inertia below this share of the axes' own masses does not change the verdict.
_NEGLIGIBLE_INERTIA = 0.02


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

    Velocity and acceleration are central differences of the positions after a zero-phase filter, which also
    filters the force. The samples are then decimated to 2.5 per period of the cut-off frequency.

    Parameters
    ----------
    time : array_like
        s, shape (n,), increasing. Jittering time stamps are interpolated; gaps are refused.
    position : array_like
        m, shape (n,) or (n, axes).
    force : array_like
        The force that moves the robot, N, of the same shape. Measured at the handle it gives the robot
        alone; measured at the joints of an arm that moves the handle it gives robot and arm.
    axes : sequence of str
        Names of the axes; by default "x", "y", …
    coulomb, offset : bool
        Whether to estimate Coulomb friction and an offset of the force too.
    cutoff : float
        Cut-off of the filter, Hz; by default chosen from the movement (`Identification.cutoff_rule`).
    method : {"robust", "ols", "paper"}
        Hampel's M-estimate; ordinary least squares; or the paper's weighted least squares, whose intervals
        are not valid (`telespring.identification.paper_reweightings`).
    iterations : int
        Number of reweightings of the paper's method; the paper prints one step and no number.
    force_delay : float
        Lag of the force's samples behind those of the position, s; it is corrected before the fit. A lag τ
        of the force biases the mass by about τ b.

    Returns
    -------
    Identification
        Estimates with 95 % intervals that account for autocorrelated residuals, how they were made, and
        warnings.

    Raises
    ------
    telespring.InvalidInput
        If the log cannot be used: gaps, too short, nothing moves, shapes that do not match; or if
        position noise biases mass or damping by several half-widths of their intervals at the given cut-off.

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
    positions, forces = _log_signal_rows("position", position), _log_signal_rows("force", force)
    times = as_numbers("time", time)
    log_warnings = check_log(times, positions, forces)
    stretches, resampling_warnings = even_stretches(times, positions, forces)
    log = max(stretches, key=lambda stretch: stretch.time.size)
    if len(stretches) > 1:
        raise InvalidInput(
            "time",
            f"{len(stretches) - 1} long gaps",
            "a log without long gaps is required",
            f"Use its longest part without a gap: --start {log.time[0]:.6g} --end {log.time[-1]:.6g}.",
        )
    names = _identified_axis_names(axes, len(positions))
    if force_delay:
        log = shift_force(log, as_number("force_delay", force_delay))
    _refuse_unknown_method(method, iterations)
    for name, row in zip(names, log.position, strict=True):
        _refuse_short_travel(name, row, log.rate)
    model = AxisModel(coulomb, offset, method, iterations)
    used_cutoff = choose_cutoff(log.position, log.rate) if cutoff is None else float(cutoff)
    signals = filter_signals(log.time, log.position, log.force, rate=log.rate, cutoff=used_cutoff)
    fits = [fit_axis(name, i, signals, model) for i, name in enumerate(names)]
    unmodelled = [
        estimate_unmodelled_terms(axis.fit, axis_regressor(signals, i, model), signals, i, model.omitted)
        for i, axis in enumerate(fits)
    ]
    results = tuple(
        replace(axis, time_shift=None if terms.lag is None else terms.lag.estimate)
        for axis, terms in zip(fits, unmodelled, strict=True)
    )
    cross_inertias = _estimate_cross_inertias(results, unmodelled)
    return Identification(
        axes=results,
        signals=signals,
        method=method,
        iterations=iterations if method == "paper" else None,
        cutoff=used_cutoff,
        cutoff_rule=CUTOFF_RULE if cutoff is None else "as given",
        rate=log.rate,
        samples=(log.time.size, signals.time.size),
        lags=results[0].fit.lags,
        cross_inertias=cross_inertias,
        diagnostics=(
            *log_warnings,
            *resampling_warnings,
            *diagnostics.check_omitted_friction(results, unmodelled, signals, model),
            *diagnostics.check_sticking(results, signals, model),
            *diagnostics.check_force_lag(results, unmodelled, cross_inertias),
            *diagnostics.check_estimate_signs(results),
            *diagnostics.check_coupling(cross_inertias),
            *diagnostics.check_cutoff(results, log, signals, model),
            *diagnostics.check_plausibility(results, signals),
        ),
    )


def _log_signal_rows(name: str, values: ArrayLike) -> FloatArray:
    """Transpose an array over (time,) or (time, axis) to one row per axis."""
    array = as_numbers(name, values)
    if array.ndim not in (1, 2) or array.size == 0:
        raise InvalidInput(
            name,
            f"an array of shape {array.shape}",
            "one value per sample, or one row per sample with one value per axis, is required",
            "Put time first: one row per sample.",
        )
    return np.ascontiguousarray(array.reshape(array.shape[0], -1).T)


def _identified_axis_names(axes: Sequence[str] | None, count: int) -> list[str]:
    """Return the given axis names, checked, or x, y, z."""
    if axes is None:
        return ["x", "y", "z"][:count] if count <= 3 else [f"axis {i + 1}" for i in range(count)]
    names = [str(name) for name in axes]
    if len(names) != count or len(set(names)) != count:
        raise InvalidInput(
            "axes",
            repr(names),
            f"{count} different names are required, one per axis",
            "Omit them for x, y.",
        )
    return names


def _refuse_unknown_method(method: str, iterations: int) -> None:
    if method not in METHODS:
        raise InvalidInput(
            "method",
            repr(method),
            'the methods are "robust", "ols" and "paper"',
            'Omit it for "robust".',
        )
    if not 1 <= iterations <= 10_000:
        raise InvalidInput("iterations", str(iterations), "1 to 10000 reweightings are allowed", "Use 1.")
    if iterations != 1 and method != "paper":
        raise InvalidInput(
            "iterations",
            str(iterations),
            f"only the paper's method has reweightings, but the method is {method!r}",
            'Omit it, or choose the method "paper".',
        )


def _refuse_short_travel(name: str, position: FloatArray, rate: float) -> None:
    travel = float(np.ptp(position))
    levels = np.unique(position).size
    if travel == 0.0 or levels < 50:
        raise InvalidInput(
            f"position ({name})",
            f"{levels} different values over {1e3 * travel:.3g} mm",
            "a position that moves through at least 50 steps of its sensor is required",
            "Move the robot further, or check that this is the right column and the sensor is connected.",
        )
    noise = noise_deviation(position, rate)
    if travel < max(_MINIMUM_TRAVEL, _TRAVEL_PER_NOISE * noise):
        raise InvalidInput(
            f"position ({name})",
            f"{1e3 * travel:.3g} mm of travel, {1e3 * noise:.2g} mm of noise",
            f"this axis moves too little: at least {1e3 * _MINIMUM_TRAVEL:g} mm and {_TRAVEL_PER_NOISE:g} "
            "times the noise are required",
            "Move it further, name only the axes that move, or check the unit (--position-scale).",
        )


def _estimate_cross_inertias(
    axes: Sequence[AxisIdentification], unmodelled: Sequence[UnmodelledTerms]
) -> tuple[CrossInertia, ...]:
    cross_inertias = []
    for axis, terms in zip(axes, unmodelled, strict=True):
        for index, term in terms.inertias.items():
            other = axes[index]
            negligible = _NEGLIGIBLE_INERTIA * math.sqrt(abs(axis.mass.value * other.mass.value))
            cross_inertias.append(
                CrossInertia(
                    axis.axis,
                    other.axis,
                    None if term is None else term.estimate,
                    significant=term is not None and term.significant and abs(term.value) > negligible,
                )
            )
    return tuple(cross_inertias)
