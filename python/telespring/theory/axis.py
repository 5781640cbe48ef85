"""One axis of a dyad."""

from __future__ import annotations

from telespring.model import Dyad, DyadAxis

__all__ = ["axes_of", "holds"]


def holds(interval: tuple[float, float], delay: float) -> bool:
    """Return whether a stable interval contains this delay; its ends are crossings, except a start at 0."""
    start, end = interval
    return (start < delay or start == 0.0) and delay < end


def axes_of(dyad: Dyad) -> list[DyadAxis]:
    """List every axis of a dyad, operators added to the robots."""
    return [dyad.axis(name) for name in dyad.axes]
