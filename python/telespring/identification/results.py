"""What an identification returns: estimates per axis with intervals, and how they were made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification.filtering import Signals
from telespring.identification.regression import Fit
from telespring.identification.warning_messages import Diagnostic

__all__ = ["METHODS", "AxisIdentification", "CrossInertia", "Estimate", "Identification", "Method"]

Method: TypeAlias = Literal["robust", "ols", "paper"]

METHODS = {
    "robust": "Hampel's M-estimate from Huber's, Newey-West covariance",
    "ols": "ordinary least squares, Newey-West covariance",
    "paper": "weights 1/(r² + ε) as printed; the intervals are those of weighted least squares",
}


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
    """Inertial coupling: the force on one axis per acceleration of another.

    Attributes
    ----------
    axis, other
        The axis of the force and the axis of the acceleration.
    inertia
        kg; None if the axes moved too much alike to estimate it.
    significant
        True if it differs from 0 at a significance level of 0.001 and exceeds 2 % of the axes' masses.
    """

    axis: str
    other: str
    inertia: Estimate | None
    significant: bool


@dataclass(frozen=True)
class AxisIdentification:
    """Estimates of one axis, and its regression.

    Attributes
    ----------
    axis
        Name of the axis.
    mass, damping
        kg and N·s/m.
    coulomb, offset
        Coulomb friction and offset of the force, N; None if not in the model.
    correlation
        Correlation of the errors of mass and damping.
    condition_number
        Condition number of the regressor [a, v, sign v, 1] in SI units.
    r_squared
        Share of the force's variance that the model explains.
    relative_force_error
        Norm of the residual over norm of the force.
    time_shift
        Lag of the force behind the position, s; None if it cannot be estimated.
    signals_index
        Row of this axis in the signals.
    estimated_force, residual
        N, at the times of the signals.
    weights
        Weights of the samples, 1 for full weight.
    fit
        The regression.
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
    fit: Fit

    @property
    def estimates(self) -> dict[str, Estimate]:
        """The estimated parameters by name."""
        candidates = {
            "mass": self.mass,
            "damping": self.damping,
            "coulomb": self.coulomb,
            "offset": self.offset,
        }
        return {name: estimate for name, estimate in candidates.items() if estimate is not None}

    def half_width(self, parameter: str) -> float:
        """Half-width of a parameter's interval; 1 % of the value where the method gives no valid interval."""
        estimate = self.estimates[parameter]
        if self.fit.lags is None:
            return 0.01 * abs(estimate.value)
        return 0.5 * (estimate.interval[1] - estimate.interval[0])

    @property
    def outlier_share(self) -> float | None:
        """Share of the samples that the fit rejected as outliers; None for the paper's method."""
        return None if self.fit.lags is None else float(np.mean(self.weights < 0.5))

    def to_json(self) -> dict[str, Any]:
        """Return plain values in SI units; None for parameters that are not in the model."""
        values: dict[str, Any] = {"axis": self.axis}
        for name in ("mass", "damping", "coulomb", "offset"):
            estimate = self.estimates.get(name)
            values[name] = None if estimate is None else estimate.value
            values[f"{name}_interval"] = None if estimate is None else list(estimate.interval)
            values[f"{name}_sd"] = None if estimate is None else estimate.standard_error
        shift = self.time_shift
        return values | {
            "mass_damping_correlation": self.correlation,
            "condition_number": self.condition_number,
            "r_squared": self.r_squared,
            "relative_force_error": self.relative_force_error,
            "left_out": self.outlier_share,
            "time_shift": None if shift is None else shift.value,
            "time_shift_interval": None if shift is None else list(shift.interval),
        }


@dataclass(frozen=True)
class Identification:
    """A robot identified from a log.

    Attributes
    ----------
    axes
        One entry per axis.
    signals
        The filtered signals that the regression used; rows are axes.
    method, iterations
        "robust", "ols" or "paper", and the number of reweightings of the latter.
    cutoff, cutoff_rule
        Cut-off of the filter, Hz, and how it was chosen.
    rate
        Samples per second of the log, Hz.
    samples
        Number of samples in the log and in the regression.
    lags
        Bandwidth of the Newey-West covariance in samples of the regression; None for the paper's method.
    cross_inertias
        One per ordered pair of axes.
    diagnostics
        Reasons to doubt the estimates, with their values.
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
    diagnostics: tuple[Diagnostic, ...]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Messages of the diagnostics. Read them before you trust the numbers."""
        return tuple(warning.message for warning in self.diagnostics)

    @property
    def independent(self) -> bool | None:
        """False if axes are coupled by inertia, None if the log cannot show it."""
        if any(cross.significant for cross in self.cross_inertias):
            return False
        return None if any(cross.inertia is None for cross in self.cross_inertias) else True

    def axis(self, name: str) -> AxisIdentification:
        """Return the axis with this name."""
        for axis in self.axes:
            if axis.axis == name:
                return axis
        names = ", ".join(axis.axis for axis in self.axes)
        raise InvalidInput("axis", repr(name), f"the axes are {names}", "Use one of these names.")

    def to_json(self) -> dict[str, Any]:
        """Return plain values in SI units."""
        return {
            "method": self.method,
            "method_in_words": METHODS[self.method],
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
