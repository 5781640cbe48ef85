"""Quantities as people read them: millimetres, milliseconds, newtons, significant digits.

All that the package shows is written here, whether on a screen, in a sentence or in the report; what the jobs
themselves write in their warnings too, with `_quantities`. A limit is rounded to the safe side.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import ROUND_FLOOR, ROUND_HALF_EVEN, Decimal, localcontext
from typing import Literal, TypeAlias

from telespring._quantities import Rounding, exact_decimal, format_count, format_number, format_time

__all__ = [
    "Rounding",
    "Style",
    "digits_within",
    "format_count",
    "format_doubling_time",
    "format_error",
    "format_estimate",
    "format_in_column",
    "format_interval",
    "format_number",
    "format_p_value",
    "format_pair",
    "format_position",
    "format_probability",
    "format_quantity",
    "format_share",
    "format_signed",
    "format_stiffness",
    "format_time",
]

Style: TypeAlias = Literal["nearest", "limit", "given", "hundredths"]

#: Units that a person reads, by the SI unit in `study.json`: the shown unit and its factor.
_SHOWN = {
    "s": ("ms", 1e3),
    "m": ("mm", 1e3),
    "m/N": ("mm/N", 1e3),
    "seconds": ("s", 1.0),
    "rad": ("°", 180.0 / math.pi),
    "share": ("%", 100.0),
}


def format_doubling_time(rate: float) -> str:
    """Write the time in which a motion doubles or halves, from its rate of growth or decay, 1/s.

    Examples
    --------
    >>> format_doubling_time(1.0), format_doubling_time(-0.1), format_doubling_time(1 / 1129)
    ('693 ms', '6.93 s', '13 minutes')
    """
    time = math.log(2.0) / abs(rate)
    if time < 120.0:
        return format_time(time, 3)
    unit, name = (60.0, "minutes") if time < 7200.0 else (3600.0, "hours")
    return f"{format_number(time / unit, 2)} {name}"


def format_stiffness(value: float, *, rounding: Rounding = "down") -> str:
    """Write a stiffness that must not be exceeded, N/m; "no limit" where it is infinite.

    Examples
    --------
    >>> format_stiffness(35.615988), format_stiffness(float("inf"))
    ('35.61 N/m', 'no limit')
    """
    return "no limit" if math.isinf(value) else f"{format_number(value, rounding=rounding)} N/m"


def format_position(position: Sequence[float]) -> str:
    """Write a place in the plane, given in m, in whole mm.

    Examples
    --------
    >>> format_position((-0.0001, 0.12))
    '(0, 120) mm'
    """
    x, y = (round(1e3 * coordinate) for coordinate in position)
    return f"({x}, {y}) mm"


def format_pair(values: tuple[float, float], unit: str) -> str:
    """Write what robot 1 and robot 2 have, once if they have the same.

    Examples
    --------
    >>> format_pair((120.0, 120.0), "N/m"), format_pair((150.0, 100.0), "N/m")
    ('120 N/m', '150 and 100 N/m')
    """
    one, two = values
    return f"{one:g} {unit}" if one == two else f"{one:g} and {two:g} {unit}"


def format_signed(value: float, decimals: int) -> str:
    """Write a number with its sign and a typographic minus; what rounds to zero has no sign.

    Examples
    --------
    >>> format_signed(-1.26, 1), format_signed(0.5, 1), format_signed(-0.04, 1)
    ('−1.3', '+0.5', '0.0')
    """
    text = f"{value:+.{decimals}f}"
    return (text if float(text) else text[1:]).replace("-", "−")


def format_error(length: float) -> str:
    """Write a tracking error or its scatter, given in m: in mm with one decimal, two below 1 mm.

    Examples
    --------
    >>> format_error(0.01234), format_error(0.000321)
    ('12.3 mm', '0.32 mm')
    """
    return f"{1e3 * length:.2f} mm" if length < 1e-3 else f"{1e3 * length:.1f} mm"


def format_quantity(
    value: float | None, unit: str = "1", digits: int = 4, *, style: Style = "nearest", bare: bool = False
) -> str:
    """Write a quantity for the report: milliseconds, millimetres, significant digits.

    The value is in the SI unit `unit`, or None for an unbounded or missing one. The unit is "1" for a pure
    number, "share" for one shown in percent, and "seconds" for a time that is not shown in milliseconds, such
    as a trial's length. The style
    "nearest" rounds to the nearest; "limit" rounds down, so that what is shown of a limit lies within it;
    "given" drops zeros at the end, as a person writes a value; "hundredths" has two decimals whatever the
    size, as a table's columns do. A `bare` quantity is without its unit, which is then given above a table's
    column.

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
    scaled = exact_decimal(value) * Decimal(factor)
    with localcontext(rounding=ROUND_FLOOR if style == "limit" else ROUND_HALF_EVEN):
        if style == "hundredths":
            text = f"{scaled:.2f}"
        elif scaled != 0 and not Decimal("1e-3") <= abs(scaled) < 1_000_000:
            mantissa, exponent = f"{scaled:.{min(digits, 2) - 1}e}".split("e")
            text = f"{mantissa}·10{_superscript_exponent(int(exponent))}"
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


def _superscript_exponent(exponent: int) -> str:
    return str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def digits_within(value: float | None, interval: Sequence[float | None] | None) -> int:
    """Return how many digits of an estimate its interval supports: at least 3, at most 10.

    Two digits of the interval's width are then seen.

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
    """Write a probability estimated from draws, for the report: none and all to what the draws can show.

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


def format_probability(share: float, standard_error: float, draws: int) -> str:
    """Write a probability estimated from draws, for a screen: percent with its standard error.

    Examples
    --------
    >>> format_probability(0.9734, 0.0011, 20000), format_probability(1.0, 0.00005, 20000)
    ('97.34 % (± 0.11 %, 20000 draws)', 'above 99.995 % (20000 draws)')
    """
    if share in (0.0, 1.0):
        # What no draw (or every one) shows is known to one draw in so many at best.
        side, bound = ("below", 1.0 / draws) if share == 0.0 else ("above", 1.0 - 1.0 / draws)
        return f"{side} {100.0 * bound:.{math.ceil(math.log10(draws)) - 2}f} % ({draws} draws)"
    percent = 100.0 * standard_error
    decimals = max(0, 1 - math.floor(math.log10(percent)))
    return f"{100.0 * share:.{decimals}f} % (± {percent:.{decimals}f} %, {draws} draws)"


def format_p_value(p: float) -> str:
    """Format a p value with its sign of comparison, however it was found.

    Examples
    --------
    >>> format_p_value(0.0001), format_p_value(0.0002), format_p_value(0.01234)
    ('< 0.001', '< 0.001', '= 0.0123')
    """
    return "< 0.001" if p < 0.001 else f"= {p:.3g}"


def format_in_column(value: float, decimals: int, threshold: float) -> str:
    """Format a number with one decimal less from `threshold` on, and another from ten times that."""
    fewer = sum(abs(value) >= limit for limit in (threshold, 10.0 * threshold))
    return f"{value:.{max(0, decimals - fewer)}f}"


def format_estimate(value: float, standard_error: float, interval: tuple[float, float]) -> tuple[str, str]:
    """Format an estimate and its interval to two digits of the standard error, at most 6 decimals."""
    is_known = 0.0 < standard_error < math.inf
    digits = min(6, max(0, 1 - math.floor(math.log10(standard_error)))) if is_known else 6
    low, high = interval
    return f"{value:.{digits}f}", f"{low:.{digits}f} to {high:.{digits}f}"


def format_interval(low: float, high: float) -> str:
    """Format the midpoint of an interval ± its half-width, to two digits of the latter."""
    half = 0.5 * (high - low)
    digits = max(0, 1 - math.floor(math.log10(half))) if half > 0.0 else 4
    return f"{0.5 * (low + high):.{digits}f} ± {half:.{digits}f}"
