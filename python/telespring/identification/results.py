"""What an identification returns: estimates per axis with intervals, and how they were made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._html import table
from telespring._types import FloatArray
from telespring.identification.filtering import Signals
from telespring.identification.regression import Fit
from telespring.identification.warning_messages import Diagnostic, outside_intervals

__all__ = [
    "METHODS",
    "PARAMETERS",
    "AxisIdentification",
    "CrossInertia",
    "Estimate",
    "Identification",
    "Method",
]

Method: TypeAlias = Literal["robust", "ols", "paper"]

#: The parameters of an axis, in the order of tables.
PARAMETERS = (
    "mass",
    "damping",
    "stiffness",
    "coulomb",
    "offset",
    "drag",
    "stiction",
    "gravity_sine",
    "gravity_cosine",
)

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
        kg, N·s/m, N/m, N, or N·s²/m² for the drag.
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
    may_be_lag
        Whether a lag of the force would look the same in this movement.
    """

    axis: str
    other: str
    inertia: Estimate | None
    significant: bool
    may_be_lag: bool = False


@dataclass(frozen=True)
class AxisIdentification:
    """Estimates of one axis, and its regression.

    Attributes
    ----------
    axis
        Name of the axis.
    estimates
        By the names in `PARAMETERS`: mass and damping, and every other term of the model.
    added
        The terms that the log itself showed to be needed.
    correlation
        Correlation of the errors of mass and damping.
    condition_number
        Condition number of the regressor in SI units.
    r_squared
        Share of the force's variance that the model explains.
    relative_force_error
        Norm of the residual over norm of the force.
    time_shift
        Lag of the force behind the position, s, that the estimates allow for; without an error if it was
        given, and None if it cannot be estimated.
    stiction_velocity
        Velocity within which stiction decays to Coulomb friction, m/s; None if it is not in the model.
    signals_index
        Row of this axis in the signals.
    measured_force, estimated_force, residual
        N, at the times of the signals; the lag of the measured force is corrected.
    weights
        Weights of the samples, 1 for full weight.
    used
        Which samples the fit used: those that were measured.
    fit
        The regression; of several logs that of the first one.
    """

    axis: str
    estimates: Mapping[str, Estimate]
    added: tuple[str, ...]
    correlation: float
    condition_number: float
    r_squared: float
    relative_force_error: float
    time_shift: Estimate | None
    stiction_velocity: float | None
    signals_index: int
    measured_force: FloatArray
    estimated_force: FloatArray
    residual: FloatArray
    weights: FloatArray
    used: NDArray[np.bool_]
    fit: Fit

    @property
    def mass(self) -> Estimate:
        """Kg."""
        return self.estimates["mass"]

    @property
    def damping(self) -> Estimate:
        """N·s/m."""
        return self.estimates["damping"]

    @property
    def coulomb(self) -> Estimate | None:
        """Coulomb friction, N; None if not in the model."""
        return self.estimates.get("coulomb")

    @property
    def offset(self) -> Estimate | None:
        """Force in the middle of the movement, N; None if not in the model."""
        return self.estimates.get("offset")

    @property
    def stiffness(self) -> Estimate | None:
        """Stiffness of a spring between robot and ground, N/m; None if not in the model."""
        return self.estimates.get("stiffness")

    def half_width(self, parameter: str) -> float:
        """Half-width of a parameter's interval; 1 % of the value where the method gives no valid interval."""
        estimate = self.estimates[parameter]
        if self.fit.lags is None:
            return 0.01 * abs(estimate.value)
        return 0.5 * (estimate.interval[1] - estimate.interval[0])

    def is_present(self, parameter: str) -> bool:
        """Whether the interval of a term in the model excludes 0."""
        estimate = self.estimates.get(parameter)
        return estimate is not None and (estimate.interval[0] > 0.0 or estimate.interval[1] < 0.0)

    @property
    def outlier_share(self) -> float | None:
        """Share of the samples in the fit that it rejected as outliers; None for the paper's method."""
        if self.fit.lags is None:
            return None
        return float(np.mean(self.weights[self.used] < 0.5))

    def to_json(self) -> dict[str, Any]:
        """Return plain values in SI units; None for parameters that are not in the model."""
        values: dict[str, Any] = {"axis": self.axis}
        for name in PARAMETERS:
            estimate = self.estimates.get(name)
            values[name] = None if estimate is None else estimate.value
            values[f"{name}_interval"] = None if estimate is None else list(estimate.interval)
            values[f"{name}_sd"] = None if estimate is None else estimate.standard_error
        shift = self.time_shift
        is_estimated = shift is not None and shift.standard_error > 0.0
        return values | {
            "added": list(self.added),
            "stiction_velocity": self.stiction_velocity,
            "mass_damping_correlation": self.correlation,
            "condition_number": self.condition_number,
            "r_squared": self.r_squared,
            "relative_force_error": self.relative_force_error,
            "left_out": self.outlier_share,
            "time_shift": None if shift is None else shift.value,
            "time_shift_interval": list(shift.interval) if shift is not None and is_estimated else None,
        }


@dataclass(frozen=True, repr=False)
class Identification:
    """A robot identified from one log or several.

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
    logs
        Where several logs were taken together, what each of them gives alone.
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
    logs: tuple[Identification, ...] = ()

    @property
    def log_count(self) -> int:
        """Number of logs; the scatter between logs is in the intervals only if there are two or more."""
        return max(1, len(self.logs))

    @property
    def outside_intervals(self) -> str:
        """What the intervals do not include, as a sentence."""
        return outside_intervals(self.method, self.log_count)

    def __repr__(self) -> str:
        axes = ", ".join(
            f"{axis.axis}: {axis.mass.value:.4g} kg, {axis.damping.value:.4g} N·s/m" for axis in self.axes
        )
        return f"<Identification {axes}; {len(self.diagnostics)} warnings>"

    def _repr_html_(self) -> str:
        axes = [
            {
                "axis": axis.axis,
                **{
                    name: f"{each.value:.5g} ± {axis.half_width(name):.2g}"
                    for name, each in axis.estimates.items()
                },
            }
            for axis in self.axes
        ]
        return table("Identification", {"axes": axes, "warnings": list(self.warnings)})

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
            "logs": self.log_count,
            "outside_intervals": self.outside_intervals,
            "each_log": [[axis.to_json() for axis in log.axes] for log in self.logs],
        }
