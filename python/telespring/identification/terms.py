"""The terms that a model of an axis may have besides mass and damping, as columns of its regressor."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from telespring._types import FloatArray
from telespring.identification.filtering import STRIBECK_VELOCITIES, Signals

__all__ = ["ALWAYS", "NEAR_REST", "TERMS", "TESTED", "AxisTerms", "ModelTerms", "term_column"]

#: What every robot can have: estimated unless it is ruled out, since a small one that no test finds would
#: still bias mass or damping by more than their intervals.
ALWAYS = ("stiffness", "coulomb", "offset")
#: What only some robots have: added where the log shows it.
TESTED = ("drag", "stiction", "gravity_sine", "gravity_cosine")
TERMS = (*ALWAYS, *TESTED)
#: Friction does not change its sign exactly when the velocity does: while an axis sticks, it takes any
#: value between its limits, and then it takes time to build up. "breakaway" is its mean value at rest, and
#: "reversal" the delay of its step times the step. Without them both look like a lag of the force, or mass.
NEAR_REST = ("breakaway", "reversal")


@dataclass(frozen=True)
class ModelTerms:
    """Which terms are asked for (True), ruled out (False) or left to the log (None), by name.

    Attributes
    ----------
    asked
        By the names in `TERMS`; what is missing is left to the log.
    radius
        Metres of travel per radian, where the axes turn; None where they slide.
    """

    asked: dict[str, bool | None] = field(default_factory=dict)
    radius: float | None = None

    def initial(self) -> tuple[str, ...]:
        """Return the terms that are fitted before anything is tested."""
        return tuple(
            name
            for name in TERMS
            if self.asked.get(name) or (self.asked.get(name) is None and name in ALWAYS)
        )

    def candidates(self) -> tuple[str, ...]:
        """Return the terms that a log may add."""
        return tuple(
            name
            for name in TESTED
            if self.asked.get(name) is None
            and (self.radius is not None or not name.startswith("gravity"))
            and (name != "stiction" or self.asked.get("coulomb") is not False)
        )


@dataclass(frozen=True)
class AxisTerms:
    """The terms of one axis' model, in the order of the regressor's columns after mass and damping.

    Friction brings those of `NEAR_REST` with it.

    Attributes
    ----------
    names
        Of the terms.
    stiction_index
        Which of `STRIBECK_VELOCITIES` the stiction has.
    radius
        Metres of travel per radian, where the axis turns.
    coupled
        Rows of the axes whose acceleration acts on this one; their inertias are the last columns.
    """

    names: tuple[str, ...]
    stiction_index: int = 0
    radius: float | None = None
    coupled: tuple[int, ...] = ()

    @property
    def stiction_velocity(self) -> float:
        """Velocity within which stiction decays, m/s."""
        return STRIBECK_VELOCITIES[self.stiction_index]

    def regressor(self, signals: Signals, axis: int) -> FloatArray:
        """Build the regressor of the axis in row `axis` of the signals, in SI units."""
        columns = [signals.acceleration[axis], signals.velocity[axis]]
        columns += [term_column(signals, axis, name, self) for name in self.names]
        columns += [signals.acceleration[other] for other in self.coupled]
        return np.stack(columns, axis=-1)

    def regressor_slope(self, signals: Signals, axis: int) -> FloatArray:
        """Return the derivative of the regressor by the time, without terms near rest and gravity."""
        velocity, acceleration = signals.velocity[axis], signals.acceleration[axis]
        slopes = {
            "stiffness": velocity,
            "coulomb": signals.reversal[axis],
            "drag": 2.0 * np.abs(velocity) * acceleration,
        }
        columns = [signals.jerk[axis], acceleration]
        columns += [slopes.get(name, np.zeros_like(velocity)) for name in self.names]
        columns += [signals.jerk[other] for other in self.coupled]
        return np.stack(columns, axis=-1)


def term_column(signals: Signals, axis: int, name: str, terms: AxisTerms) -> FloatArray:
    """Return the force of one term per unit of its parameter, for the axis in a row of the signals.

    The position counts from its mean: the offset is then the force in the middle of the movement.
    """
    position = signals.position[axis]
    angle = position / (terms.radius or 1.0)
    columns = {
        "stiffness": lambda: position - position[signals.used].mean(),
        "coulomb": lambda: signals.direction[axis],
        "offset": lambda: np.ones_like(position),
        "breakaway": lambda: signals.breakaway[axis],
        "reversal": lambda: signals.reversal[axis],
        "drag": lambda: signals.drag[axis],
        "stiction": lambda: signals.stiction[terms.stiction_index, axis],
        "gravity_sine": lambda: np.sin(angle),
        "gravity_cosine": lambda: np.cos(angle),
    }
    return np.asarray(columns[name]())
