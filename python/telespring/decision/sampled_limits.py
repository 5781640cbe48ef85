"""Delays that are stable with sampled controllers: found by search, and judged where they end."""

from __future__ import annotations

from collections.abc import Callable

from telespring.model import Dyad, Robot

__all__ = ["damped", "first_change", "last_stable"]

#: The delays on which the first change is sought before it is narrowed down.
_GRID = 16
_HALVINGS = 10


def first_change(is_stable: Callable[[float], bool], end: float) -> float:
    """Return the end of the stable values that begin at 0, at most `end`; 0 if not even 0 is stable.

    The value returned is itself stable, or 0. Values between the points of the grid are not examined.

    Examples
    --------
    >>> round(first_change(lambda value: value < 0.3, 1.0), 3)
    0.3
    >>> first_change(lambda value: True, 1.0), first_change(lambda value: False, 1.0)
    (1.0, 0.0)
    """
    if not is_stable(0.0):
        return 0.0
    points = [end * i / _GRID for i in range(_GRID + 1)]
    first = next((i for i, point in enumerate(points) if not is_stable(point)), None)
    if first is None:
        return end
    return last_stable(is_stable, points[first - 1], points[first], _HALVINGS)


def last_stable(is_stable: Callable[[float], bool], low: float, high: float, halvings: int) -> float:
    """Return the last stable value that bisection finds from `low`, stable, to `high`, unstable.

    Examples
    --------
    >>> last_stable(lambda value: value < 0.3, 0.0, 1.0, 4)
    0.25
    """
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_stable(middle) else (low, middle)
    return low


def damped(dyad: Dyad, damping: float) -> Dyad | None:
    """Return the dyad with this much more damping, N·s/m, on all axes; None if it is negative."""
    if any((robot.damping + damping < 0.0).any() for robot in dyad.robots):
        return None
    one, other = (Robot(robot.mass, robot.damping + damping, axes=dyad.axes) for robot in dyad.robots)
    return Dyad(one, other, dyad.operators, dyad.coupling_damping)
