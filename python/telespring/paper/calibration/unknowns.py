"""What the ideal laboratory does not know of the real one: four numbers, the same on both sides and axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from telespring._types import FloatArray

__all__ = ["HIGH", "NAMES", "UNKNOWNS", "VARIANTS", "Unknown", "Variant", "free_of"]

Variant: TypeAlias = Literal["inside", "on top"]

#: Whether Table III, identified through an arm, already holds the arm's inertia, or the arm comes on top.
VARIANTS: tuple[Variant, Variant] = ("inside", "on top")


@dataclass(frozen=True)
class Unknown:
    """One unknown of the calibration, between 0 and `high`."""

    name: str
    unit: str
    high: float
    meaning: str


#: Each alone, at its upper end, carries the error in the unconnected mode far beyond what was published.
UNKNOWNS = (
    Unknown("arm_mass", "kg", 2.0, "mass that the arm adds to its handle"),
    Unknown("arm_damping", "N·s/m", 12.0, "viscous damping that the arm adds"),
    Unknown("coulomb", "N", 2.0, "Coulomb friction of robot and arm together"),
    Unknown("spot_velocity", "m/s", 1.2, "standard deviation of the velocity of agent 2's spots"),
)
NAMES = tuple(each.name for each in UNKNOWNS)
HIGH: FloatArray = np.array([each.high for each in UNKNOWNS])


def free_of(variant: Variant) -> tuple[int, ...]:
    """Give the places of the unknowns that the motion depends on.

    With the arm's inertia inside Table III the moving mass is Table III's, whatever part of it is the arm's.
    """
    return (1, 2, 3) if variant == "inside" else (0, 1, 2, 3)
