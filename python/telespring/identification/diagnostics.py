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
from dataclasses import replace

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification.axis_fit import AxisModel, axis_regressor, fit_axis
from telespring.identification.cutoff import filtered_noise, largest_cutoff
from telespring.identification.filtering import Signals, filter_signals
from telespring.identification.regression import least_squares
from telespring.identification.results import AxisIdentification, CrossInertia
from telespring.identification.stretches import Stretch
from telespring.identification.unmodelled import UnmodelledTerms, is_moving
from telespring.identification.warning_messages import UNITS, Diagnostic, diagnostic

__all__ = [
    "check_coupling",
    "check_cutoff",
    "check_estimate_signs",
    "check_force_lag",
    "check_omitted_friction",
    "check_plausibility",
    "check_sticking",
    "noise_bias",
]

#: In half-widths of the interval: a bias by noise above the first is a warning, above the second a refusal
#: unless it is below this share of the value.
_BIAS_WARNED, _BIAS_REFUSED, _BIAS_NEGLIGIBLE = 0.5, 3.0, 0.005
#: At half of the cut-off an estimate may change by so many half-widths of both intervals combined.
_CUTOFF_CHANGE = 2.0
#: In half-widths: where leaving out the samples near rest shifts the mass by more, the axis sticks.
_STICKING_SHIFT = 1.5
#: A robot held by a person moves no faster, m/s and m/s², and is no lighter or heavier, kg.
_FASTEST, _LARGEST_ACCELERATION, _LIGHTEST, _HEAVIEST = 4.0, 100.0, 0.05, 200.0
_LOWEST_R_SQUARED, _LARGEST_OUTLIER_SHARE = 0.8, 0.05
#: The lag is not trusted where the model, with all terms, explains less of the force.
_LAG_R_SQUARED = 0.99


def check_omitted_friction(
    axes: Sequence[AxisIdentification],
    unmodelled: Sequence[UnmodelledTerms],
    signals: Signals,
    model: AxisModel,
) -> list[Diagnostic]:
    """Find axes on which friction or an offset that was not fitted biases mass or damping."""
    warnings = []
    for axis, terms in zip(axes, unmodelled, strict=True):
        # Friction that drives the axis is not friction.
        names = [
            name
            for name, term in terms.friction.items()
            if term.significant and (name == "offset" or term.value > 0.0)
        ]
        if not names:
            continue
        fuller = replace(
            model, coulomb=model.coulomb or "coulomb" in names, offset=model.offset or "offset" in names
        )
        refit = fit_axis(axis.axis, axis.signals_index, signals, fuller)
        if any(
            abs(axis.estimates[name].value - refit.estimates[name].value) > axis.half_width(name)
            for name in ("mass", "damping")
        ):
            warnings.append(
                diagnostic(
                    "omitted " + " and ".join(name.replace("coulomb", "friction") for name in names),
                    axis=axis.axis,
                    fitted_mass=axis.mass.value,
                    fitted_damping=axis.damping.value,
                    **{name: estimate.value for name, estimate in refit.estimates.items()},
                )
            )
    return warnings


def check_sticking(
    axes: Sequence[AxisIdentification], signals: Signals, model: AxisModel
) -> list[Diagnostic]:
    """Find axes that stick at their reversals for so long that it biases the mass."""
    warnings = []
    for axis in axes:
        i = axis.signals_index
        moving = is_moving(signals, i)
        if axis.coulomb is None or axis.fit.lags is None or moving.mean() < 0.3:
            continue
        regressor = axis_regressor(signals, i, model)
        mass = float(least_squares(regressor, signals.force[i], axis.fit.weights * moving).estimate[0])
        if abs(mass - axis.mass.value) > _STICKING_SHIFT * axis.half_width("mass"):
            warnings.append(diagnostic("sticking", axis=axis.axis, mass=axis.mass.value, moving_mass=mass))
    return warnings


def check_force_lag(
    axes: Sequence[AxisIdentification],
    unmodelled: Sequence[UnmodelledTerms],
    cross_inertias: Sequence[CrossInertia],
) -> list[Diagnostic]:
    """Find axes on which the force lags the position, and whether coupled axes would look the same."""
    coupled = {cross.axis for cross in cross_inertias if cross.significant}
    lags: dict[str, tuple[float, float, bool]] = {}
    for axis, terms in zip(axes, unmodelled, strict=True):
        lag = terms.lag
        if lag is None or not lag.significant or terms.r_squared < _LAG_R_SQUARED:
            continue
        # A lag τ of the force shifts the mass by τ b (and the damping by less).
        mass_bias = abs(lag.value * axis.damping.value)
        if mass_bias > max(axis.half_width("mass"), 0.01 * abs(axis.mass.value)):
            lags[axis.axis] = (lag.value, mass_bias, terms.is_confounded and axis.axis in coupled)
    axes_disagree = len({np.sign(lag) for lag, _, _ in lags.values()}) > 1
    code = "force lag differs by axis" if axes_disagree else "force lag"
    return [
        diagnostic(
            "force lag or coupling" if may_be_coupling else code,
            axis=name,
            lag=abs(lag),
            direction="behind" if lag > 0.0 else "ahead of",
            force_delay=lag,
            mass_bias=mass_bias,
        )
        for name, (lag, mass_bias, may_be_coupling) in lags.items()
    ]


def check_estimate_signs(axes: Sequence[AxisIdentification]) -> list[Diagnostic]:
    """Find estimates with a wrong or open sign, and fits that explain little or reject many samples."""
    warnings: list[Diagnostic] = []
    for axis in axes:
        intervals = {name: axis.estimates[name].interval for name in ("mass", "damping")}
        negative = tuple(name for name, (_, high) in intervals.items() if high <= 0.0)
        if negative:
            warnings.append(diagnostic("negative estimates", axis=axis.axis, parameters=negative))
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


def check_coupling(cross_inertias: Sequence[CrossInertia]) -> list[Diagnostic]:
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


def check_cutoff(
    axes: Sequence[AxisIdentification], log: Stretch, signals: Signals, model: AxisModel
) -> list[Diagnostic]:
    """Find estimates that depend on the cut-off, and refuse a cut-off that lets too much noise pass.

    That is where position noise biases an estimate by three half-widths of its interval or more.
    """
    return _check_noise_bias(axes, log, signals) or _check_half_cutoff(axes, log, signals, model)


def noise_bias(axis: AxisIdentification, signals: Signals, position: FloatArray, rate: float) -> FloatArray:
    """Estimate the bias of mass (kg) and damping (N·s/m) by noise of the unfiltered position, to first order.

    It is below 0 if they are estimated too small.
    """
    velocity, acceleration = filtered_noise(position, rate, signals.cutoff)
    regressor = np.stack(
        [signals.acceleration[axis.signals_index], signals.velocity[axis.signals_index]], axis=-1
    )
    noise = np.diag([acceleration, velocity])
    # The movement's power without the noise, but never less than a tenth of the measured power.
    measured = regressor.T @ regressor / len(regressor)
    clean = measured - noise
    if np.linalg.eigvalsh(clean)[0] <= 0.0 or (np.diag(clean) < 0.1 * np.diag(measured)).any():
        clean = np.diag(0.1 * np.diag(measured))
    estimate = np.array([axis.mass.value, axis.damping.value])
    # measured @ estimate equals the correlation with the force, which without noise is clean @ truth.
    return np.asarray(estimate - np.linalg.solve(clean, measured @ estimate))


def _check_noise_bias(axes: Sequence[AxisIdentification], log: Stretch, signals: Signals) -> list[Diagnostic]:
    warnings = []
    limit = min(largest_cutoff(row, log.rate) for row in log.position)
    for axis, position in zip(axes, log.position, strict=True):
        biases = noise_bias(axis, signals, position, log.rate)
        for name, bias in zip(("mass", "damping"), np.abs(biases).tolist(), strict=True):
            half = axis.half_width(name)
            if bias <= max(_BIAS_WARNED * half, 1e-12):
                continue
            if bias > _BIAS_REFUSED * half and bias > _BIAS_NEGLIGIBLE * abs(axis.estimates[name].value):
                raise InvalidInput(
                    f"cutoff (axis {axis.axis})",
                    f"{signals.cutoff:.4g} Hz",
                    f"at this cut-off position noise biases the {name} by about {bias:.2g} {UNITS[name]}, "
                    f"{bias / half:.0f} times the half-width of its interval",
                    f"Set at most {limit:.3g} Hz, omit --cutoff, or move the robot further and faster.",
                )
            warnings.append(
                diagnostic(
                    "noise bias",
                    axis=axis.axis,
                    parameter=name,
                    bias=bias,
                    unit=UNITS[name],
                    half_widths=bias / half,
                    cutoff=signals.cutoff,
                    largest_cutoff=limit,
                )
            )
    return warnings


def _check_half_cutoff(
    axes: Sequence[AxisIdentification], log: Stretch, signals: Signals, model: AxisModel
) -> list[Diagnostic]:
    """Compare with estimates at half of the cut-off: where the model holds, the filter changes nothing."""
    half = 0.5 * signals.cutoff
    if any(axis.fit.lags is None for axis in axes):
        return []
    try:
        lower = filter_signals(log.time, log.position, log.force, rate=log.rate, cutoff=half)
        others = [fit_axis(axis.axis, axis.signals_index, lower, model) for axis in axes]
    except InvalidInput:
        # The log is too short for it, or too little of the movement remains.
        return []
    warnings = []
    for axis, other in zip(axes, others, strict=True):
        for name in ("mass", "damping"):
            values = axis.estimates[name].value, other.estimates[name].value
            tolerance = _CUTOFF_CHANGE * np.hypot(axis.half_width(name), other.half_width(name))
            if abs(values[0] - values[1]) > max(tolerance, 0.01 * abs(values[0])):
                warnings.append(
                    diagnostic(
                        "cut-off dependence",
                        axis=axis.axis,
                        parameter=name,
                        unit=UNITS[name],
                        value=values[0],
                        cutoff=signals.cutoff,
                        other_value=values[1],
                        other_cutoff=half,
                    )
                )
    return warnings


def check_plausibility(axes: Sequence[AxisIdentification], signals: Signals) -> list[Diagnostic]:
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
