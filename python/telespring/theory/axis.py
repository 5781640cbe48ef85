"""One axis of a dyad as the scalar criteria take it: operators added to the robots."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from telespring.model import Dyad
from telespring.theory import criteria

__all__ = ["Axis", "axes_of", "free_axis", "holds"]


class _Keywords(TypedDict):
    kh1: float
    kh2: float
    c: float


@dataclass(frozen=True)
class Axis:
    """One axis of a dyad, with the questions that the report and the commands ask of it.

    Attributes
    ----------
    name
        The axis' name.
    index
        Its place in the dyad, counted from 0.
    masses
        Mass of robot and operator on side 1 and 2, kg.
    dampings
        Viscous damping of robot and operator on side 1 and 2, N·s/m.
    ground_stiffnesses
        Stiffness of the operators to the ground, N/m; 0 for a free handle.
    coupling_damping
        The damper beside the spring, N·s/m.
    """

    name: str
    index: int
    masses: tuple[float, float]
    dampings: tuple[float, float]
    ground_stiffnesses: tuple[float, float] = (0.0, 0.0)
    coupling_damping: float = 0.0

    @property
    def parameters(self) -> tuple[float, float, float, float]:
        """m1, b1, m2, b2 in kg and N·s/m."""
        return self.masses[0], self.dampings[0], self.masses[1], self.dampings[1]

    @property
    def keywords(self) -> _Keywords:
        """The keywords of the scalar criteria: operator stiffness and coupling damping."""
        return {
            "kh1": self.ground_stiffnesses[0],
            "kh2": self.ground_stiffnesses[1],
            "c": self.coupling_damping,
        }

    @property
    def is_plain(self) -> bool:
        """True for free handles without a coupling damper: all that the paper's formulas cover."""
        return self.ground_stiffnesses == (0.0, 0.0) and self.coupling_damping == 0.0

    def critical_stiffness(self, method: Literal["exact", "paper"] = "exact") -> float:
        """Give the stiffness below which no constant delay destabilises, N/m."""
        if method == "paper":
            return float(criteria.critical_stiffness(*self.parameters, method="paper"))
        return float(criteria.critical_stiffness(*self.parameters, method=method, **self.keywords))

    def maximum_delay(self, stiffness: ArrayLike) -> NDArray[np.float64]:
        """Give the smallest one-way delay at which stability is lost, s; infinite where none is."""
        return np.asarray(criteria.maximum_delay(*self.parameters, stiffness, **self.keywords), dtype=float)

    def maximum_stiffness(self, delay: float) -> float:
        """Give the stiffness below which every one is stable at this mean one-way delay, N/m."""
        return float(criteria.maximum_stiffness(*self.parameters, delay, **self.keywords))

    def minimum_damping(self, stiffness: float, delay: float) -> float:
        """Give the damping to add to both robots so that this much and any more is stable, N·s/m."""
        return float(criteria.minimum_damping(*self.parameters, stiffness, delay, **self.keywords))

    def stable_delays(self, stiffness: float, horizon: float) -> list[tuple[float, float]]:
        """List all intervals of stable one-way delays up to `horizon`, s."""
        found = criteria.stable_delays(*self.parameters, stiffness, horizon, **self.keywords)
        return [(float(start), float(end)) for start, end in found]

    def crossings(self, stiffness: float) -> list[dict[str, Any]]:
        """List every crossing of the imaginary axis: delay (s), frequency (rad/s), direction."""
        found = criteria.crossings(*self.parameters, stiffness, **self.keywords)
        return [
            {
                "delay": record.delay,
                "frequency": record.frequency,
                "direction": record.direction,
            }
            for record in found
        ]

    def is_stable(self, stiffness: float, delay: float) -> bool:
        """Tell whether this mean one-way delay (s) lies in a stable interval."""
        horizon = max(1.001 * delay, delay + 1e-6)
        return any(holds(interval, delay) for interval in self.stable_delays(stiffness, horizon))


def holds(interval: tuple[float, float], delay: float) -> bool:
    """Tell whether a stable interval holds this delay: its ends are crossings, but for a start at 0."""
    start, end = interval
    return (start < delay or start == 0.0) and delay < end


def axes_of(dyad: Dyad) -> list[Axis]:
    """List every axis of `dyad`, operators added to the robots."""
    robots, operators = dyad.robots, dyad.operators
    return [
        Axis(
            name=str(name),
            index=i,
            masses=(
                float(robots[0].mass[i] + operators[0].mass[i]),
                float(robots[1].mass[i] + operators[1].mass[i]),
            ),
            dampings=(
                float(robots[0].damping[i] + operators[0].damping[i]),
                float(robots[1].damping[i] + operators[1].damping[i]),
            ),
            ground_stiffnesses=(float(operators[0].stiffness[i]), float(operators[1].stiffness[i])),
            coupling_damping=float(dyad.coupling_damping),
        )
        for i, name in enumerate(dyad.axes)
    ]


def free_axis(m1: float, b1: float, m2: float, b2: float) -> Axis:
    """Make a nameless axis with free handles, from masses (kg) and dampings (N·s/m)."""
    return Axis(name="x", index=0, masses=(m1, m2), dampings=(b1, b2))


def finite_or_none(value: float) -> float | None:
    """Give `value`, or None where it is infinite: JSON has no infinity."""
    return float(value) if math.isfinite(value) else None
