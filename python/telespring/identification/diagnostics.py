"""Diagnostics of an identification: bias by noise, cut-off, friction, lag and coupling; implausible values.

Least squares takes velocity and acceleration as exact. Noise in them makes mass and damping too small, by the
noise's share of their power (attenuation, Fuller 1987 [1]_). The intervals, which depend on the residuals
only, do not show it: the larger the bias, the narrower they become.

References
----------
.. [1] W. A. Fuller, "Measurement Error Models", Wiley (1987), section 1.1.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from telespring._errors import InvalidInput
from telespring._quantities import format_number, format_time
from telespring._types import FloatArray
from telespring.identification.cutoff import filtered_noise, largest_cutoff
from telespring.identification.filtering import Signals
from telespring.identification.log_fit import LogFit, fit_log, is_significant, single_frequency
from telespring.identification.results import AxisIdentification, CrossInertia, Identification
from telespring.identification.stretches import Stretch
from telespring.identification.unmodelled import find_effects, ruled_out_terms
from telespring.identification.warning_messages import UNITS, Diagnostic, diagnostic

__all__ = ["check_fit", "noise_bias"]

#: In half-widths of the interval: a bias by noise above the first is a warning, above the second a refusal
#: unless it is below this share of the value.
_BIAS_WARNED, _BIAS_REFUSED, _BIAS_NEGLIGIBLE = 0.5, 3.0, 0.005
#: At half of the cut-off an estimate may change by so many half-widths of both intervals combined.
_CUTOFF_CHANGE = 2.0
#: A robot held by a person moves no faster, m/s and m/s², and is no lighter or heavier, kg.
_FASTEST, _LARGEST_ACCELERATION, _LIGHTEST, _HEAVIEST = 4.0, 100.0, 0.05, 200.0
_LOWEST_R_SQUARED, _LARGEST_OUTLIER_SHARE = 0.8, 0.05
#: A spring below this share of b²/(2m), the critical stiffness of two such robots, changes no verdict.
_NEGLIGIBLE_SPRING = 0.01
#: Coulomb friction below this share of the largest force changes nothing.
_NEGLIGIBLE_FRICTION = 0.005
#: Where the model explains less of the force, what else the force depends on is a question of its own.
_EFFECT_R_SQUARED = 0.9

#: A lag that exceeds this many standard errors is reported: a significance level of 0.01.
_SURE_OF_LAG = 2.576


def check_fit(
    found: Identification, fit: LogFit, stretches: Sequence[Stretch], names: Sequence[str]
) -> list[Diagnostic]:
    """Check the result of one log: what its model leaves out, and whether its estimates can be right."""
    axes = found.axes
    return [
        *_check_ruled_out(axes, fit),
        *_check_lag(axes, fit, found.cross_inertias),
        *_check_effects(axes, fit, names),
        *_check_springs(axes, fit),
        *_check_added_terms(axes),
        *_check_estimate_signs(axes),
        *_check_coupling(found.cross_inertias),
        *(_check_noise_bias(axes, fit, stretches) or _check_half_cutoff(axes, fit, stretches, names)),
        *_check_plausibility(axes, found.signals),
    ]


def _check_ruled_out(axes: Sequence[AxisIdentification], fit: LogFit) -> list[Diagnostic]:
    """Find terms that were ruled out although the log has them, so that mass or damping are wrong."""
    if fit.options.method == "paper":
        return []
    return [
        diagnostic(
            f"omitted {name}",
            axis=axis.axis,
            value=float(wider.estimate[-1]),
            mass=float(wider.estimate[0]),
            damping=float(wider.estimate[1]),
            fitted_mass=axis.mass.value,
            fitted_damping=axis.damping.value,
        )
        for i, axis in enumerate(axes)
        for name, wider in ruled_out_terms(fit, i)
    ]


def _check_lag(
    axes: Sequence[AxisIdentification], fit: LogFit, cross_inertias: Sequence[CrossInertia]
) -> list[Diagnostic]:
    """Find a lag, and lags that differ between axes, that cannot be known, or that coupled axes look like."""
    if fit.options.lag is not None:
        return []
    warnings = [
        diagnostic("unknown lag", axis=axis.axis, mass_per_ms=1e-3 * abs(axis.damping.value))
        for axis in axes
        if axis.time_shift is None
    ]
    shared = axes[0].time_shift
    if fit.shared_lag and shared is not None and abs(shared.value) > _SURE_OF_LAG * shared.standard_error:
        low, high = shared.interval
        warnings.append(
            diagnostic("late force", lag=shared.value, low=low, high=high)
            if shared.value > 0.0
            else diagnostic("late position", lag=-shared.value, low=-high, high=-low)
        )
    if not fit.shared_lag:
        warnings.append(
            diagnostic(
                "lags differ",
                names=tuple(axis.axis for axis in axes),
                lags=tuple(format_time(axis.time_shift.value, 2) for axis in axes if axis.time_shift),
            )
        )
    coupled = [cross.axis for cross in cross_inertias if cross.significant and cross.may_be_lag]
    warnings += [
        diagnostic("lag or coupling", axis=axis.axis, lag=axis.time_shift.value)
        for axis in axes
        if axis.axis in coupled and axis.time_shift is not None
    ]
    return warnings


def _check_effects(axes: Sequence[AxisIdentification], fit: LogFit, names: Sequence[str]) -> list[Diagnostic]:
    """Find what else the force depends on; of several effects on an axis the most significant counts."""
    warnings = []
    for i, axis in enumerate(axes):
        if fit.options.method == "paper" or axis.r_squared < _EFFECT_R_SQUARED:
            continue
        for effect in find_effects(fit, i, names)[:1]:
            values = {"axis": axis.axis, "mass": effect.mass, "damping": effect.damping}
            values |= {"fitted_mass": axis.mass.value, "fitted_damping": axis.damping.value}
            if effect.lag is None:
                warnings.append(diagnostic("omitted effect", effect=effect.name, **values))
            else:
                warnings.append(diagnostic("force lag", lag=effect.lag, **values))
    return warnings


def _check_springs(axes: Sequence[AxisIdentification], fit: LogFit) -> list[Diagnostic]:
    """Find springs between robot and ground that are stiff enough to change a verdict."""
    warnings = []
    for i, axis in enumerate(axes):
        spring = axis.stiffness
        if axis.fit.lags is None:
            continue
        if spring is None:
            frequency = single_frequency(fit.signals, fit.terms[i], i)
            if frequency is not None:
                taken = 1.0 / (2.0 * np.pi * frequency) ** 2
                warnings.append(diagnostic("untested spring", axis=axis.axis, mass_per_stiffness=taken))
            continue
        column = 2 + fit.terms[i].names.index("stiffness")
        if is_significant(axis.fit, column=column) and abs(spring.value) > negligible_spring(axis):
            code = "spring" if spring.value > 0.0 else "negative spring"
            low, high = spring.interval
            warnings.append(diagnostic(code, axis=axis.axis, stiffness=spring.value, low=low, high=high))
    return warnings


def negligible_spring(axis: AxisIdentification) -> float:
    """Return the stiffness of a spring to the ground, N/m, below which it changes no verdict."""
    mass = max(abs(axis.mass.value), 1e-12)
    return _NEGLIGIBLE_SPRING * axis.damping.value**2 / (2.0 * mass)


def _check_added_terms(axes: Sequence[AxisIdentification]) -> list[Diagnostic]:
    """Tell of drag, stiction and gravity: studies and verdicts have none of them."""
    warnings = []
    for axis in axes:
        for name in axis.added:
            if name == "gravity_cosine" and "gravity_sine" in axis.added:
                continue
            code = "gravity" if name.startswith("gravity") else name
            values = {"axis": axis.axis, "value": axis.estimates[name].value}
            if name == "stiction":
                values["velocity"] = axis.stiction_velocity
            warnings.append(diagnostic(code, **values))
    return warnings


def _check_estimate_signs(axes: Sequence[AxisIdentification]) -> list[Diagnostic]:
    """Find estimates with a wrong or open sign, and fits that explain little or reject many samples."""
    warnings: list[Diagnostic] = []
    for axis in axes:
        intervals = {name: axis.estimates[name].interval for name in ("mass", "damping")}
        negative = tuple(name for name, (_, high) in intervals.items() if high <= 0.0)
        if negative:
            warnings.append(diagnostic("negative estimates", axis=axis.axis, parameters=negative))
        if axis.coulomb is not None and axis.fit.lags is not None and axis.coulomb.interval[1] < 0.0:
            largest = float(np.abs(axis.measured_force).max())
            if not negative and abs(axis.coulomb.value) > _NEGLIGIBLE_FRICTION * largest:
                low, high = axis.coulomb.interval
                warnings.append(
                    diagnostic(
                        "negative friction", axis=axis.axis, coulomb=axis.coulomb.value, low=low, high=high
                    )
                )
        warnings += [
            diagnostic(f"{name} close to zero", axis=axis.axis)
            for name, (low, high) in intervals.items()
            if low <= 0.0 < high
        ]
        if axis.r_squared < _LOWEST_R_SQUARED:
            warnings.append(
                diagnostic("unexplained force", axis=axis.axis, r_squared=max(0.0, axis.r_squared))
            )
        outliers = axis.outlier_share
        if outliers is not None and outliers > _LARGEST_OUTLIER_SHARE:
            warnings.append(diagnostic("many outliers", axis=axis.axis, share=outliers))
        if not axis.fit.converged:
            warnings.append(diagnostic("no convergence", axis=axis.axis))
    return warnings


def _check_coupling(cross_inertias: Sequence[CrossInertia]) -> list[Diagnostic]:
    """Find axes that are coupled by inertia, or that moved too much alike to show it."""
    warnings: list[Diagnostic] = [
        diagnostic(
            "coupled axes",
            axis=cross.axis,
            other=cross.other,
            inertia=cross.inertia.value,
            low=cross.inertia.interval[0],
            high=cross.inertia.interval[1],
        )
        for cross in cross_inertias
        if cross.significant and cross.inertia is not None
    ]
    if any(cross.inertia is None for cross in cross_inertias):
        warnings.append(diagnostic("similar movements"))
    return warnings


def noise_bias(fit: LogFit, index: int, position: FloatArray, rate: float) -> FloatArray:
    """Estimate the bias of mass (kg) and damping (N·s/m) by noise of the unfiltered position, to first order.

    It is below 0 if they are estimated too small.
    """
    velocity, acceleration = filtered_noise(position, rate, fit.signals.cutoff)
    columns = fit.columns(index)[fit.signals.used]
    size = np.sqrt((columns**2).mean(axis=0))
    size = np.where(size > 0.0, size, 1.0)
    columns = columns / size
    noise = np.zeros((columns.shape[1], columns.shape[1]))
    noise[0, 0], noise[1, 1] = acceleration / size[0] ** 2, velocity / size[1] ** 2
    # The movement's power without the noise, but never less than a tenth of the measured power.
    measured = columns.T @ columns / len(columns)
    clean = measured - noise
    least = 0.1 * np.linalg.eigvalsh(measured)[0]
    if np.linalg.eigvalsh(clean)[0] < least or (np.diag(clean) < 0.1 * np.diag(measured)).any():
        clean = np.diag(0.1 * np.diag(measured))
    own = fit.joint.fits[index].estimate
    # The lag has been corrected: the force's slope takes no more part in the force.
    estimate = np.concatenate([own, np.zeros(columns.shape[1] - own.size)]) * size
    # measured @ estimate equals the correlation with the force, which without noise is clean @ truth.
    return np.asarray((estimate - np.linalg.solve(clean, measured @ estimate)) / size)[:2]


def _check_noise_bias(
    axes: Sequence[AxisIdentification], fit: LogFit, stretches: Sequence[Stretch]
) -> list[Diagnostic]:
    """Find a cut-off that lets much noise pass; refuse one at which it biases by three half-widths."""
    warnings = []
    log = max(stretches, key=lambda stretch: stretch.time.size)
    cutoff = fit.signals.cutoff
    limit = min(largest_cutoff(row, log.rate) for row in log.position)
    for i, (axis, position) in enumerate(zip(axes, log.position, strict=True)):
        biases = noise_bias(fit, i, position, log.rate)
        for name, bias in zip(("mass", "damping"), np.abs(biases).tolist(), strict=True):
            half = axis.half_width(name)
            if bias <= max(_BIAS_WARNED * half, 1e-12):
                continue
            if bias > _BIAS_REFUSED * half and bias > _BIAS_NEGLIGIBLE * abs(axis.estimates[name].value):
                raise InvalidInput(
                    f"cutoff (axis {axis.axis})",
                    f"{format_number(cutoff, 4)} Hz",
                    f"at this cut-off position noise biases the {name} by about "
                    f"{format_number(bias, 2)} {UNITS[name]}, {bias / half:.0f} times the half-width of "
                    "its interval",
                    f"Set at most {format_number(limit, 3)} Hz, omit --cutoff, or move the robot further and "
                    "faster.",
                )
            warnings.append(
                diagnostic(
                    "noise bias",
                    axis=axis.axis,
                    parameter=name,
                    bias=bias,
                    unit=UNITS[name],
                    half_widths=bias / half,
                    cutoff=cutoff,
                    largest_cutoff=limit,
                )
            )
    return warnings


def _check_half_cutoff(
    axes: Sequence[AxisIdentification], fit: LogFit, stretches: Sequence[Stretch], names: Sequence[str]
) -> list[Diagnostic]:
    """Compare with estimates at half of the cut-off: where the model holds, the filter changes nothing."""
    cutoff = fit.signals.cutoff
    if any(axis.fit.lags is None for axis in axes):
        return []
    try:
        lower = fit_log(stretches, 0.5 * cutoff, names, fit.options, fit.terms)
    except InvalidInput:
        # The log is too short for it, or too little of the movement remains.
        return []
    warnings = []
    for i, axis in enumerate(axes):
        for k, name in enumerate(("mass", "damping")):
            values = axis.estimates[name].value, float(lower.joint.fits[i].estimate[k])
            tolerance = _CUTOFF_CHANGE * np.hypot(axis.half_width(name), lower.half_widths(i)[k])
            if abs(values[0] - values[1]) > max(tolerance, 0.01 * abs(values[0])):
                warnings.append(
                    diagnostic(
                        "cut-off dependence",
                        axis=axis.axis,
                        parameter=name,
                        unit=UNITS[name],
                        value=values[0],
                        cutoff=cutoff,
                        other_value=values[1],
                        other_cutoff=0.5 * cutoff,
                    )
                )
    return warnings


def _check_plausibility(axes: Sequence[AxisIdentification], signals: Signals) -> list[Diagnostic]:
    """Find motion and masses that no robot held by a person has: the log probably has other units."""
    warnings: list[Diagnostic] = []
    for axis in axes:
        velocity = float(np.abs(signals.velocity[axis.signals_index]).max())
        acceleration = float(np.abs(signals.acceleration[axis.signals_index]).max())
        if velocity > _FASTEST or acceleration > _LARGEST_ACCELERATION:
            warnings.append(
                diagnostic("implausible motion", axis=axis.axis, velocity=velocity, acceleration=acceleration)
            )
        mass = abs(axis.mass.value)
        if not _LIGHTEST <= mass <= _HEAVIEST:
            code = "implausibly light" if mass < _LIGHTEST else "implausibly heavy"
            warnings.append(diagnostic(code, axis=axis.axis, mass=axis.mass.value))
    return warnings
