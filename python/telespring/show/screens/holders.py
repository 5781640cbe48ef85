"""What holds the handles, in a few words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from telespring.model import Dyad, Operator, OperatorRange
from telespring.show.quantities import format_number

__all__ = ["describe_holders"]

_PARTS = (("stiffness", "N/m"), ("damping", "N·s/m"), ("mass", "kg"))


def describe_holders(
    dyad: Dyad,
    ranges: tuple[OperatorRange, OperatorRange] | None,
    springs: tuple[Operator, Operator] | None = None,
) -> str:
    """Describe the operators of a dyad, or their ranges; empty if the handles are free.

    The robots' own springs to the ground, which the operators include, are no hands and are left out.

    Examples
    --------
    >>> import telespring as ts
    >>> hand = ts.OperatorRange(ts.Operator(stiffness=50.0), ts.Operator(stiffness=300.0))
    >>> describe_holders(ts.hman(), (hand, hand))
    'held by 50 to 300 N/m'
    >>> soft = ts.Dyad(*ts.hman().robots, (ts.Operator(stiffness=120.0, damping=2.0), None))
    >>> describe_holders(soft, None)
    'robot 1 held by 120 N/m and 2 N·s/m, robot 2 free'
    """
    ends = [(one, one) for one in dyad.operators] if ranges is None else [(r.low, r.high) for r in ranges]
    one, other = (
        _describe_operator(_without(low, spring), _without(high, spring), dyad.axes)
        for (low, high), spring in zip(ends, springs or (Operator(), Operator()), strict=True)
    )
    if one == other:
        return "" if one == "free" else one
    return f"robot 1 {one}, robot 2 {other}"


def _without(held: Operator, spring: Operator) -> Operator:
    # Rounding must not leave a spring below 0.
    return Operator(held.mass, held.damping, np.maximum(held.stiffness - spring.stiffness, 0.0))


def _describe_operator(low: Operator, high: Operator, axes: Sequence[str]) -> str:
    values = []
    for axis in range(len(axes)):
        parts = []
        for name, unit in _PARTS:
            start, end = (_on_axis(getattr(operator, name), axis) for operator in (low, high))
            if end > 0.0:
                spread = format_number(start, 6)
                spread += "" if start == end else f" to {format_number(end, 6)}"
                parts.append(f"{spread} {unit}")
        values.append(" and ".join(parts))
    if not any(values):
        return "free"
    if len(set(values)) == 1:
        return f"held by {values[0]}"
    return "held by " + ", ".join(
        f"{value or 'nothing'} on {axis}" for value, axis in zip(values, axes, strict=True)
    )


def _on_axis(values: object, axis: int) -> float:
    """Return the value on an axis; one value may stand for all."""
    flat = np.atleast_1d(np.asarray(values, dtype=float))
    return float(flat[axis if len(flat) > 1 else 0])
