"""Quantities of the report as a person reads them: milliseconds, millimetres, significant digits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import ROUND_FLOOR, ROUND_HALF_EVEN, Decimal, localcontext
from typing import Literal

__all__ = ["Style", "digits_within", "format_quantity", "format_share", "signed"]

Style = Literal["nearest", "limit", "given", "hundredths"]

#: Units that a person reads, by the SI unit in `study.json`: the shown unit and its factor.
_SHOWN = {
    "s": ("ms", 1e3),
    "m": ("mm", 1e3),
    "m/N": ("mm/N", 1e3),
    "seconds": ("s", 1.0),
    "rad": ("°", 180.0 / math.pi),
}


def format_quantity(
    value: float | None, unit: str = "1", digits: int = 4, *, style: Style = "nearest", bare: bool = False
) -> str:
    """Write a quantity as a person reads it: milliseconds, millimetres, significant digits.

    Parameters
    ----------
    value
        In SI units; None for one that is unbounded or missing.
    unit
        Its SI unit; "1" for a pure number, "seconds" for a time that is not shown in milliseconds, such as a
        trial's length.
    digits
        Significant digits.
    style
        "nearest" rounds to the nearest; "limit" rounds down, so that a displayed limit lies within the
        exact one; "given" omits trailing zeros, as a person writes a value; "hundredths" always has two
        decimals, as in a table's columns.
    bare
        Without the unit, which is then shown elsewhere, such as in the heading of a table's column.

    Examples
    --------
    >>> format_quantity(0.16718632, "s")
    '167.2 ms'
    >>> format_quantity(0.16718632, "s", style="limit")
    '167.1 ms'
    >>> format_quantity(0.8334, "kg", 6, style="given")
    '0.8334 kg'
    >>> format_quantity(29.111, "s")
    '29.11 s'
    >>> format_quantity(None, "s")
    'no limit'
    """
    if value is None:
        return "no limit"
    # A delay is shown in milliseconds, the length of a trial in seconds.
    shown, factor = (unit, 1.0) if unit == "s" and abs(value) >= 10.0 else _SHOWN.get(unit, (unit, 1.0))
    # In decimals, so that 0.029 s is 29 ms and not slightly less, which would be rounded down.
    scaled = Decimal(repr(float(value))) * Decimal(factor)
    with localcontext(rounding=ROUND_FLOOR if style == "limit" else ROUND_HALF_EVEN):
        if style == "hundredths":
            text = f"{scaled:.2f}"
        elif scaled != 0 and not Decimal("1e-3") <= abs(scaled) < 1_000_000:
            mantissa, exponent = f"{scaled:.{min(digits, 2) - 1}e}".split("e")
            text = f"{mantissa}·10{_superscript(int(exponent))}"
        elif scaled == scaled.to_integral_value():
            text = f"{abs(scaled) if scaled == 0 else scaled:.0f}"
        else:
            decimals = max(0, digits - 1 - scaled.adjusted())
            text = f"{scaled:.{decimals}f}"
            if style == "given" and "." in text:
                text = text.rstrip("0").rstrip(".")
    text = text.replace("-", "−")
    if bare or shown == "1":
        return text
    return f"{text}{'' if shown == '°' else ' '}{shown}"


def digits_within(value: float | None, interval: Sequence[float | None] | None) -> int:
    """Compute how many significant digits show two digits of an interval's width: at least 3, at most 10.

    Examples
    --------
    >>> digits_within(10.1168, (10.1142, 10.1193))
    6
    >>> digits_within(10.1, (8.0, 12.0))
    3
    """
    ends = [end for end in interval or () if end is not None]
    width = max(ends) - min(ends) if len(ends) == 2 else 0.0
    if not value or not width:
        return 4
    return min(10, max(3, math.floor(math.log10(abs(value))) - math.floor(math.log10(width)) + 2))


def format_share(share: float, draws: int) -> str:
    """Write a probability that was estimated from draws; none and all become bounds.

    Examples
    --------
    >>> [format_share(share, 5000) for share in (0.0, 0.5, 0.9998, 1.0)]
    ['< 0.0002', '0.5000', '0.9998', '> 0.9998']
    """
    decimals = max(1, math.ceil(math.log10(draws)))
    if share <= 0.0:
        return f"< {1.0 / draws:.{decimals}f}"
    if share >= 1.0:
        return f"> {1.0 - 1.0 / draws:.{decimals}f}"
    return f"{share:.{decimals}f}"


def signed(value: float, digits: int) -> str:
    """Write a number with its sign, with a typographic minus; what rounds to zero has none.

    Examples
    --------
    >>> signed(-1.26, 1), signed(0.5, 1), signed(-0.04, 1)
    ('−1.3', '+0.5', '0.0')
    """
    text = f"{value:+.{digits}f}"
    return (text if float(text) else text[1:]).replace("-", "−")


def _superscript(exponent: int) -> str:
    return str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
