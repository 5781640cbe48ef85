"""Warnings about a log or an estimate: what was measured, and the sentence that a user reads.

The checks compute and return these records; only this module words them. It belongs to this room because
`Identification.warnings`, `Identification.to_json` and robot files carry the sentences.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

__all__ = [
    "CloseToZero",
    "ConstantForce",
    "CoupledAxes",
    "CutoffDependence",
    "Diagnostic",
    "ForceLag",
    "HeldPosition",
    "IdenticalPositions",
    "ImplausibleMass",
    "ImplausibleMotion",
    "NegativeEstimates",
    "NoConvergence",
    "NoiseBias",
    "OmittedFriction",
    "Outliers",
    "PositionJumps",
    "SimilarMovements",
    "Sticking",
    "SuspectForceColumn",
    "UnevenTimes",
    "UnexplainedForce",
]

UNITS = {"mass": "kg", "damping": "N·s/m", "coulomb": "N", "offset": "N"}


@dataclass(frozen=True)
class Diagnostic:
    """A reason to doubt a log or an estimate, with its values in SI units; `str()` gives the sentence."""


# ---- about the log


@dataclass(frozen=True)
class SuspectForceColumn(Diagnostic):
    """The name of a force column suggests another quantity."""

    column: str
    scalars: tuple[str, ...]

    def __str__(self) -> str:
        hint = f" The file also holds {', '.join(self.scalars)}." if self.scalars else ""
        return (
            f"The force column {self.column} looks like a voltage, a current or a command. If it is one, "
            "give the newtons per unit with --force-scale. Otherwise mass and damping are wrong by that "
            f"factor.{hint}"
        )


@dataclass(frozen=True)
class UnevenTimes(Diagnostic):
    """Time stamps jitter; `jitter` is their standard deviation as a share of the sample period."""

    jitter: float

    def __str__(self) -> str:
        return (
            f"Time stamps are uneven, with a jitter of {100.0 * self.jitter:.2g} % of the sample period. The "
            "log was interpolated."
        )


@dataclass(frozen=True)
class IdenticalPositions(Diagnostic):
    """Two axes have the same positions."""

    def __str__(self) -> str:
        return "Two axes have identical positions. Is a column named twice?"


@dataclass(frozen=True)
class HeldPosition(Diagnostic):
    """A position was updated less often than it was logged."""

    column: str
    repeats: int
    step: float

    def __str__(self) -> str:
        period, age = 1e3 * self.repeats * self.step, 500.0 * (self.repeats - 1) * self.step
        return (
            f"The {self.column} repeats every value {self.repeats} times: it is updated every {period:.3g} "
            f"ms and is {age:.2g} ms old on average, which biases the mass. Keep only the first of every "
            f"{self.repeats} samples."
        )


@dataclass(frozen=True)
class PositionJumps(Diagnostic):
    """A position jumps between two samples; `size` and `time` are those of the largest jump."""

    column: str
    size: float
    time: float
    count: int

    def __str__(self) -> str:
        more = f", and {self.count - 1} more times" if self.count > 1 else ""
        return (
            f"The {self.column} jumps by {1e3 * self.size:.3g} mm between two samples at {self.time:.4g} s"
            f"{more}. Did the sensor slip?"
        )


@dataclass(frozen=True)
class ConstantForce(Diagnostic):
    """A force stays at one value, perhaps at the end of the sensor's range."""

    column: str
    force: float
    duration: float
    is_extreme: bool

    def __str__(self) -> str:
        value, duration = f"{self.force:.4g} N", f"{1e3 * self.duration:.4g} ms"
        if self.is_extreme:
            return f"The {self.column} stays at its extreme of {value} for {duration}. Was it saturated?"
        return f"The {self.column} stays at {value} for {duration}. Was the sensor stuck?"


# ---- about the model


@dataclass(frozen=True)
class OmittedFriction(Diagnostic):
    """Coulomb friction or an offset was not fitted and biases mass or damping.

    `terms` are the sizes of the omitted "coulomb" and "offset"; `refitted` gives, by parameter, the estimate
    without and with them.
    """

    axis: str
    terms: Mapping[str, float]
    refitted: Mapping[str, tuple[float, float]]

    def __str__(self) -> str:
        names = {"coulomb": "friction", "offset": "an offset"}
        sizes = " and ".join(f"{names[term]} of {size:.3g} N" for term, size in self.terms.items())
        options = " ".join(f"--{term}" for term in self.terms)
        changes = " and ".join(
            f"the {parameter} from {without:.4g} to {with_terms:.4g} {UNITS[parameter]}"
            for parameter, (without, with_terms) in self.refitted.items()
        )
        verb = "is" if len(self.terms) == 1 else "are"
        return f"Axis {self.axis}: {sizes} {verb} not in the model. Adding {options} changes {changes}."


@dataclass(frozen=True)
class Sticking(Diagnostic):
    """An axis sticks at its reversals, which biases its mass."""

    axis: str
    mass: float
    mass_while_moving: float

    def __str__(self) -> str:
        return (
            f"Axis {self.axis}: the axis sticks at its reversals, and the force during this time biases the "
            f"mass. Without the samples near rest it is {self.mass_while_moving:.4g} kg instead of "
            f"{self.mass:.4g} kg; the interval does not include this uncertainty. Move faster, so that the "
            "axis rests for a shorter time."
        )


@dataclass(frozen=True)
class ForceLag(Diagnostic):
    """The force lags the position, which biases the mass.

    `cause` is "clock" where one delay explains it, "clock or coupling" where coupled axes would look the
    same, and "differs by axis" where the axes lag in opposite directions.
    """

    axis: str
    lag: float
    mass_bias: float
    cause: Literal["clock", "clock or coupling", "differs by axis"]

    def __str__(self) -> str:
        remedy = {
            "clock": (
                "If the two sensors really are that far apart in time, correct it with "
                f"--force-delay {self.lag:.2g}."
            ),
            "clock or coupling": (
                "Axes coupled by inertia would look the same in this movement. Excite the axes with "
                "different movements to see which it is."
            ),
            "differs by axis": (
                "The axes disagree, so no single --force-delay corrects it. Identify each axis on its own "
                "with its own --force-delay, or look for another force on this axis."
            ),
        }[self.cause]
        verb = "lag" if self.lag > 0.0 else "lead"
        return (
            f"Axis {self.axis}: the force seems to {verb} the position by {1e3 * abs(self.lag):.2g} ms, "
            f"which biases the mass by about {self.mass_bias:.2g} kg. {remedy}"
        )


@dataclass(frozen=True)
class CoupledAxes(Diagnostic):
    """The force on one axis depends on the acceleration of another."""

    axis: str
    other: str
    inertia: float
    interval: tuple[float, float]

    def __str__(self) -> str:
        low, high = self.interval
        return (
            f"The axes are not independent: the force on {self.axis} includes {self.inertia:.3g} kg "
            f"({low:.3g} to {high:.3g} kg) times the acceleration on {self.other}. Verdicts for single axes "
            "do not hold for this robot as it was measured."
        )


@dataclass(frozen=True)
class SimilarMovements(Diagnostic):
    """The axes moved too much alike to tell whether they are coupled."""

    def __str__(self) -> str:
        return (
            "This log cannot show whether the axes are independent: they moved too much alike. Excite them "
            "with different movements, for example the same movement a quarter of a period later."
        )


# ---- about the estimates


@dataclass(frozen=True)
class NegativeEstimates(Diagnostic):
    """The whole interval of mass or damping is negative."""

    axis: str
    parameters: tuple[str, ...]

    def __str__(self) -> str:
        verb = "is" if len(self.parameters) == 1 else "are"
        return (
            f"Axis {self.axis}: {' and '.join(self.parameters)} {verb} negative. Force and position must be "
            "positive in the same direction; --force-scale -1 reverses the force."
        )


@dataclass(frozen=True)
class CloseToZero(Diagnostic):
    """The interval of mass or damping includes zero."""

    axis: str
    parameter: str

    def __str__(self) -> str:
        excitation = "with more acceleration" if self.parameter == "mass" else "at higher velocity"
        return (
            f"Axis {self.axis}: the {self.parameter} cannot be distinguished from 0. Excite the robot "
            f"{excitation} or record longer."
        )


@dataclass(frozen=True)
class UnexplainedForce(Diagnostic):
    """The model explains little of the force's variance."""

    axis: str
    r_squared: float

    def __str__(self) -> str:
        return (
            f"Axis {self.axis}: the model explains only {100.0 * max(0.0, self.r_squared):.0f} % of the "
            "force. Do position and force belong to the same axis? Is friction or an offset missing "
            "(--coulomb, --offset)?"
        )


@dataclass(frozen=True)
class Outliers(Diagnostic):
    """The robust fit rejected many samples; `share` is their share."""

    axis: str
    share: float

    def __str__(self) -> str:
        return (
            f"Axis {self.axis}: {100.0 * self.share:.0f} % of the samples were rejected as outliers. Look at "
            "the residuals (--figure)."
        )


@dataclass(frozen=True)
class NoConvergence(Diagnostic):
    """The iterations of the robust fit did not converge."""

    axis: str

    def __str__(self) -> str:
        return f"Axis {self.axis}: the robust fit did not converge. Compare it with --method ols."


@dataclass(frozen=True)
class NoiseBias(Diagnostic):
    """Position noise that passes the filter biases mass or damping."""

    axis: str
    parameter: str
    bias: float
    half_widths: float
    cutoff: float
    largest_cutoff: float

    def __str__(self) -> str:
        return (
            f"Axis {self.axis}: at a cut-off of {self.cutoff:.3g} Hz position noise makes the "
            f"{self.parameter} about {self.bias:.2g} {UNITS[self.parameter]} too small, which is "
            f"{self.half_widths:.1g} times the half-width of its interval. Set --cutoff to "
            f"{self.largest_cutoff:.3g} Hz or less."
        )


@dataclass(frozen=True)
class CutoffDependence(Diagnostic):
    """Mass or damping changes with the cut-off by more than the intervals allow."""

    axis: str
    parameter: str
    cutoffs: tuple[float, float]
    values: tuple[float, float]

    def __str__(self) -> str:
        unit = UNITS[self.parameter]
        first, second = (
            f"{value:.3g} {unit} at {cutoff:.3g} Hz"
            for value, cutoff in zip(self.values, self.cutoffs, strict=True)
        )
        return (
            f"Axis {self.axis}: the {self.parameter} depends on the cut-off: {first}, but {second}. The "
            "difference is larger than both intervals. Check whether the position jumps, whether friction "
            "is missing (--coulomb), and the residuals (--figure)."
        )


@dataclass(frozen=True)
class ImplausibleMotion(Diagnostic):
    """An axis moves faster than a robot held by a person; probably another unit."""

    axis: str
    velocity: float
    acceleration: float

    def __str__(self) -> str:
        return (
            f"Axis {self.axis} reaches {self.velocity:.3g} m/s and {self.acceleration:.3g} m/s², more than a "
            "robot held by a person. Is the time in s (--time-scale 60 for minutes) and the position in m "
            "(--position-scale 0.001 for mm, 0.01 for cm)?"
        )


@dataclass(frozen=True)
class ImplausibleMass(Diagnostic):
    """An axis is lighter or heavier than a robot held by a person; probably another unit."""

    axis: str
    mass: float
    is_light: bool

    def __str__(self) -> str:
        if self.is_light:
            return (
                f"Axis {self.axis}: {self.mass:.2g} kg is lighter than any robot held by a person. Are time, "
                "position and force in s, m and N (--time-scale, --position-scale, --force-scale)?"
            )
        return (
            f"Axis {self.axis}: {self.mass:.3g} kg is heavier than any robot held by a person. Are time, "
            "position and force in s, m and N (--force-scale 0.001 for mN)?"
        )
