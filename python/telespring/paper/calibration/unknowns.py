"""Unknowns of the calibration: four properties of the real arms and robots, alike on both sides and axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from telespring._types import FloatArray

__all__ = ["HIGH", "NAMES", "UNKNOWNS", "VARIANTS", "Unknown", "Variant", "free_unknowns"]

Variant: TypeAlias = Literal["inside", "on top"]

#: Whether Table III, identified through an arm, already includes the arm's inertia, or the arm adds to it.
VARIANTS: tuple[Variant, Variant] = ("inside", "on top")


@dataclass(frozen=True)
class Unknown:
    """One unknown of the calibration, between 0 and `high`."""

    name: str
    unit: str
    high: float
    meaning: str


#: Each alone, at its upper bound, raises the error in the unconnected mode far beyond the published one.
UNKNOWNS = (
    Unknown("arm_mass", "kg", 2.0, "mass that the arm adds to its handle"),
    Unknown("arm_damping", "N·s/m", 12.0, "viscous damping that the arm adds"),
    Unknown("coulomb", "N", 2.0, "Coulomb friction of robot and arm together"),
    Unknown("spot_velocity", "m/s", 1.2, "standard deviation of the velocity of agent 2's spots"),
)
NAMES = tuple(unknown.name for unknown in UNKNOWNS)
HIGH: FloatArray = np.array([unknown.high for unknown in UNKNOWNS])


def free_unknowns(variant: Variant) -> tuple[int, ...]:
    """Return the indices of the unknowns that the motion depends on.

    With the arm's inertia inside Table III the moving mass is that of Table III, whatever part is the arm's.
    """
    return (1, 2, 3) if variant == "inside" else (0, 1, 2, 3)
