"""Numbers, times and counts in words: for the screens and the report, and for the messages of every room."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from typing import Literal, TypeAlias

__all__ = ["Rounding", "exact_decimal", "format_count", "format_number", "format_time"]

Rounding: TypeAlias = Literal["nearest", "down", "up"]

_ROUNDING = {"nearest": ROUND_HALF_EVEN, "down": ROUND_FLOOR, "up": ROUND_CEILING}


def exact_decimal(value: float) -> Decimal:
    """Return a number as it is written: the shortest decimal that reads back as the same number."""
    # 0.029 s is 29 ms, not a bit less. Beyond the fourteenth digit stands what computing has rounded: 51
    # periods of 1 ms are not more than 51 ms.
    return Context(prec=14).plus(Decimal(repr(float(value))))


def format_number(value: float, digits: int = 4, *, rounding: Rounding = "nearest", shift: int = 0) -> str:
    """Write a number with significant digits and no zeros at its end.

    `rounding` is "down" for a limit that must stay above what is safe to use, "up" for one that must stay
    below. `shift` writes the number times ten to this power: 3 for a length in mm or a time in ms.

    Examples
    --------
    >>> format_number(0.16719, rounding="down", shift=3), format_number(0.3, rounding="down", shift=3)
    ('167.1', '300')
    >>> format_number(51 * 0.001, rounding="up", shift=3)
    '51'
    """
    shown = Context(prec=digits, rounding=_ROUNDING[rounding]).plus(exact_decimal(value).scaleb(shift))
    if shown == 0:
        return "0"  # also what is −0
    if shown.is_finite() and -5 < shown.adjusted() < 7:
        text = f"{shown:f}"
        return text.rstrip("0").rstrip(".") if "." in text else text
    return f"{float(shown):.{digits}g}"


def format_time(value: float, digits: int = 4, *, rounding: Rounding = "nearest") -> str:
    """Write a time or delay, given in s: in ms below 1 s; "no limit" where it is infinite.

    Examples
    --------
    >>> format_time(0.16719, rounding="down"), format_time(11392.6), format_time(float("inf"))
    ('167.1 ms', '11390 s', 'no limit')
    """
    if math.isinf(value):
        return "no limit"
    if abs(value) < 1.0:
        return f"{format_number(value, digits, rounding=rounding, shift=3)} ms"
    return f"{format_number(value, digits, rounding=rounding)} s"


def format_count(count: int, noun: str, plural: str = "") -> str:
    """Write how many of something there are; the plural is with an "s" unless given.

    Examples
    --------
    >>> format_count(1, "sample"), format_count(12000, "sample"), format_count(2, "axis", "axes")
    ('1 sample', '12000 samples', '2 axes')
    """
    return f"{count} {noun if count == 1 else plural or noun + 's'}"
