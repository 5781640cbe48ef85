"""Results from fits: the estimates of one log, and of several logs together."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from telespring.identification.combination import Combined, combine_correlations, combine_estimates
from telespring.identification.filtering import join_signals
from telespring.identification.log_fit import LogFit
from telespring.identification.results import AxisIdentification, CrossInertia, Estimate, Identification
from telespring.identification.terms import NEAR_REST
from telespring.identification.unmodelled import Inertia
from telespring.identification.warning_messages import UNITS, Diagnostic, diagnostic

__all__ = ["combine_logs", "identification_of"]


def identification_of(
    fit: LogFit,
    names: Sequence[str],
    inertias: Sequence[Mapping[int, Inertia]],
    *,
    cutoff_rule: str,
    rate: float,
    samples: int,
) -> Identification:
    """Turn the fit of one log, and the inertias between its axes, into a result without diagnostics."""
    axes = tuple(_axis_of(fit, i, name) for i, name in enumerate(names))
    options = fit.options
    return Identification(
        axes=axes,
        signals=fit.signals,
        method=options.method,
        iterations=options.iterations if options.method == "paper" else None,
        cutoff=fit.signals.cutoff,
        cutoff_rule=cutoff_rule,
        rate=rate,
        samples=(samples, int(fit.signals.used.sum())),
        lags=axes[0].fit.lags,
        cross_inertias=_cross_inertias(names, inertias),
        diagnostics=(),
    )


def _axis_of(fit: LogFit, i: int, name: str) -> AxisIdentification:
    own, terms, force = fit.joint.fits[i], fit.terms[i], fit.joint.force[i]
    half, error = own.half_width(), own.standard_error
    estimates = {
        parameter: Estimate(float(value), float(e), (float(value - h), float(value + h)))
        for parameter, value, e, h in zip(
            ("mass", "damping", *terms.names), own.estimate, error, half, strict=False
        )
        if parameter not in NEAR_REST
    }
    kept = fit.signals.used
    measured, residual = force[kept], own.residual[kept]
    variation = float(((measured - measured.mean()) ** 2).sum())
    squares = float((residual**2).sum())
    lag = fit.joint.lags[i]
    is_known = lag.estimated or fit.options.lag is not None
    interval = (lag.value - lag.half_width, lag.value + lag.half_width)
    return AxisIdentification(
        axis=name,
        estimates=estimates,
        added=fit.added[i],
        correlation=float(own.covariance[0, 1] / (error[0] * error[1])) if error[0] * error[1] > 0.0 else 0.0,
        condition_number=float(np.linalg.cond(fit.regressor(i)[kept])),
        r_squared=1.0 - squares / variation if variation > 0.0 else 0.0,
        relative_force_error=math.sqrt(squares / float((measured**2).sum())) if measured.any() else math.inf,
        time_shift=Estimate(lag.value, lag.standard_error, interval) if is_known else None,
        stiction_velocity=terms.stiction_velocity if "stiction" in terms.names else None,
        signals_index=i,
        measured_force=force,
        estimated_force=force - own.residual,
        residual=own.residual,
        weights=own.weights,
        used=kept,
        fit=own,
    )


def _cross_inertias(
    names: Sequence[str], inertias: Sequence[Mapping[int, Inertia]]
) -> tuple[CrossInertia, ...]:
    return tuple(
        CrossInertia(name, names[other], inertia.estimate, inertia.matters, inertia.may_be_lag)
        for name, each in zip(names, inertias, strict=True)
        for other, inertia in each.items()
    )


def combine_logs(logs: Sequence[Identification], names: Sequence[str]) -> Identification:
    """Combine the identifications of several logs, which have these names, fitted with the same terms."""
    first = logs[0]
    axes, doubts = [], []
    for i in range(len(first.axes)):
        axis, found = _combine_axis([log.axes[i] for log in logs])
        axes.append(axis)
        doubts += found
        has_spring = any(
            doubt.code == "spring" and doubt.values["axis"] == axis.axis
            for log in logs
            for doubt in log.diagnostics
        )
        if has_spring and not axis.is_present("stiffness"):
            low, high = axis.estimates["stiffness"].interval
            doubts.append(diagnostic("unconfirmed spring", axis=axis.axis, low=low, high=high))
    return replace(
        first,
        axes=tuple(axes),
        signals=join_signals([log.signals for log in logs]),
        cutoff=min(log.cutoff for log in logs),
        samples=(sum(log.samples[0] for log in logs), sum(log.samples[1] for log in logs)),
        cross_inertias=_combined_inertias(logs),
        diagnostics=(*_distinct_diagnostics(logs, names), *doubts),
        logs=tuple(logs),
    )


def _combine_axis(each: Sequence[AxisIdentification]) -> tuple[AxisIdentification, list[Diagnostic]]:
    first = each[0]
    combined: dict[str, Combined] = {
        name: combine_estimates([axis.estimates[name] for axis in each]) for name in first.estimates
    }
    doubts = [
        diagnostic(
            "logs disagree",
            axis=first.axis,
            parameter=name,
            unit=UNITS[name],
            values=tuple(f"{axis.estimates[name].value:.4g}" for axis in each),
        )
        for name in ("mass", "damping")
        if combined[name].disagree and first.fit.lags is not None
    ]
    shifts = [axis.time_shift for axis in each if axis.time_shift is not None]
    joined: dict[str, Any] = {
        name: np.concatenate([getattr(axis, name) for axis in each])
        for name in ("measured_force", "estimated_force", "residual", "weights", "used")
    }
    measured, residual = joined["measured_force"][joined["used"]], joined["residual"][joined["used"]]
    squares, variation = float((residual**2).sum()), float(((measured - measured.mean()) ** 2).sum())
    whole = replace(
        first,
        estimates={name: parameter.estimate for name, parameter in combined.items()},
        correlation=combine_correlations(
            [axis.correlation for axis in each], combined["mass"], combined["damping"]
        ),
        condition_number=max(axis.condition_number for axis in each),
        r_squared=1.0 - squares / variation if variation > 0.0 else 0.0,
        relative_force_error=math.sqrt(squares / float((measured**2).sum())) if measured.any() else math.inf,
        time_shift=_combined_lag(shifts),
        **joined,
    )
    return whole, doubts


def _combined_lag(lags: Sequence[Estimate]) -> Estimate | None:
    """Combine the lag of the force over logs; where it was given, it is the same in all."""
    if not lags or any(lag.standard_error == 0.0 for lag in lags):
        return lags[0] if lags else None
    return lags[0] if len(lags) == 1 else combine_estimates(lags).estimate


def _combined_inertias(logs: Sequence[Identification]) -> tuple[CrossInertia, ...]:
    """Combine the inertias between the axes from the logs that can show them."""
    combined = []
    for each in zip(*(log.cross_inertias for log in logs), strict=True):
        estimates = [cross.inertia for cross in each if cross.inertia is not None]
        if not estimates:
            combined.append(each[0])
            continue
        inertia = estimates[0] if len(estimates) == 1 else combine_estimates(estimates).estimate
        combined.append(
            replace(each[0], inertia=inertia, significant=any(cross.significant for cross in each))
        )
    return tuple(combined)


def _distinct_diagnostics(logs: Sequence[Identification], names: Sequence[str]) -> list[Diagnostic]:
    """Return the diagnostics of all logs, one of each kind per axis or column, with the log that has it."""
    found: dict[tuple[object, ...], tuple[Diagnostic, list[str]]] = {}
    for name, log in zip(names, logs, strict=True):
        for doubt in log.diagnostics:
            place = doubt.values.get("axis", doubt.values.get("column"))
            key = (doubt.code, place, doubt.values.get("parameter"), doubt.values.get("log"))
            found.setdefault(key, (doubt, []))[1].append(name)
    return [replace(doubt, message=f"{_these(at)}: {doubt.message}") for doubt, at in found.values()]


def _these(names: Sequence[str]) -> str:
    """Name the log that a message is about, and count the others that have the same fault."""
    others = len(names) - 1
    if not others:
        return names[0]
    return f"{names[0]} (likewise {names[1]})" if others == 1 else f"{names[0]} (likewise {others} others)"
