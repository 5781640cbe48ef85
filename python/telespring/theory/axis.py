"""One axis of a dyad."""

from __future__ import annotations

from telespring._json import finite_or_none
from telespring.model import Dyad, DyadAxis

__all__ = ["Axis", "axes_of", "finite_or_none", "free_axis", "holds"]

Axis = DyadAxis


def holds(interval: tuple[float, float], delay: float) -> bool:
    """Return whether a stable interval contains this delay; its ends are crossings, except a start at 0."""
    start, end = interval
    return (start < delay or start == 0.0) and delay < end


def axes_of(dyad: Dyad) -> list[DyadAxis]:
    """List every axis of a dyad, operators added to the robots."""
    return [dyad.axis(name) for name in dyad.axes]


def free_axis(m1: float, b1: float, m2: float, b2: float) -> DyadAxis:
    """Build an axis with free handles from masses (kg) and dampings (N·s/m)."""
    return DyadAxis(m1, b1, m2, b2)
