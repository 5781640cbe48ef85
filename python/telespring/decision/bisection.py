"""The largest value at which something holds, found by bisection and itself tried."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["largest_usable"]

#: Halvings to a first value.
_MOST_HALVINGS = 30


def largest_usable(
    is_usable: Callable[[float], bool], most: float, *, least: float = 0.0, resolution: float = 1e-3
) -> float:
    """Return a value up to `most` that was found usable; 0 if none was.

    Nothing below `least` is tried. `resolution` is the share by which a larger one, at most, was found
    not to be.

    Examples
    --------
    >>> 1.998 < largest_usable(lambda value: value <= 2.0, 10.0) <= 2.0
    True
    """
    if most <= 0.0 or most < least:
        return 0.0
    if is_usable(most):
        return most
    high, low = most, 0.5 * most
    for _ in range(_MOST_HALVINGS):
        if low < least:
            return 0.0
        if is_usable(low):
            break
        high, low = low, 0.5 * low
    else:
        return 0.0
    while high - low > resolution * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_usable(middle) else (low, middle)
    return low
