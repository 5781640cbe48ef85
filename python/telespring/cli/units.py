"""Numbers of the command line with their units: "80 ms", "1.2 kg", "71 N/m"; without a unit they are SI."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, NamedTuple, Self

import typer

if TYPE_CHECKING:
    from pint import UnitRegistry

__all__ = ["MASS", "Interval", "Unit", "WithUnit", "number", "read_interval", "read_number"]


class Unit(NamedTuple):
    """An SI unit, what it measures, and an example of another."""

    symbol: str
    kind: str
    example: str


TIME = Unit("s", "a time", "0.08 or 80ms")
MASS = Unit("kg", "a mass", "1.2 or 1200g")
LENGTH = Unit("m", "a length", "0.001 or 1mm")
DAMPING = Unit("N*s/m", "a damping", "6 or 6Ns/m")
STIFFNESS = Unit("N/m", "a stiffness", "71.2 or 0.0712N/mm")
FORCE = Unit("N", "a force", "1 or 1000mN")
FREQUENCY = Unit("Hz", "a frequency", "1000 or 1kHz")
RATE = Unit("1/s", "a rate", "2 or '2 1/s'")

#: The units that a laboratory writes; the registry of every unit takes half a second to load.
_DEFINITIONS = """
micro- = 1e-6 = µ- = μ- = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
kilo- = 1e3 = k-
mega- = 1e6 = M-
second = [time] = s = sec
minute = 60 * second = min
metre = [length] = m = meter
gram = [mass] = g
newton = 1000 * gram * metre / second ** 2 = N
newton_second = newton * second = Ns
hertz = 1 / second = Hz
"""

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?inf|nan)\s*(.*?)\s*", re.DOTALL)


#: How a product of units is written: N·s, N*s, N.s, N-s and N s; not the minus of an exponent, such as m^-1.
_PRODUCT = re.compile(
    r"\s*[·⋅∙•×*]\s*|(?<=[a-zµμ0-9])[.-](?=[a-zµμ])|(?<=[^\s/*^])\s+(?=[^\s/*^])", re.IGNORECASE
)

#: Where an exponent follows a unit directly: m-1 is m to the power of -1.
_EXPONENT = re.compile(r"(?<=[a-zµμ])(?=-?\d)", re.IGNORECASE)


@cache
def _registry() -> UnitRegistry[float]:
    import pint

    registry: UnitRegistry[float] = pint.UnitRegistry(None)
    registry.load_definitions(_DEFINITIONS.strip().splitlines())
    return registry


class WithUnit(float):
    """A number that was written with a unit, which a refusal repeats.

    Attributes
    ----------
    text
        As it was written.
    """

    text: str

    def __new__(cls, value: float, text: str) -> Self:
        """Make the number, in the SI unit, and keep its text."""
        number_ = super().__new__(cls, value)
        number_.text = text
        return number_


def read_number(text: str, unit: Unit) -> float:
    """Read a number with or without its unit, as a value in the SI unit.

    Raises
    ------
    typer.BadParameter
        If there is no number, or its unit is unknown or measures something else.

    Examples
    --------
    >>> [read_number(text, TIME) for text in ("0.08", "80ms", "80 ms")]
    [0.08, 0.08, 0.08]
    >>> read_number("0.0712 N/mm", STIFFNESS)
    71.2
    >>> [read_number(text, DAMPING) for text in ("7.7 N·s/m", "9 Ns/m")]
    [7.7, 9.0]
    """
    found = _NUMBER.fullmatch(text)
    if found is None or found[2].startswith(","):
        comma = " Write a decimal point, not a comma." if re.match(r"\s*[+-]?\d+,\d", text) else ""
        raise typer.BadParameter(f"{text!r} is not {unit.kind}: write, for example, {unit.example}.{comma}")
    value, written = float(found[1]), found[2]
    if not written:
        return value
    return WithUnit(_to_si(value, written, unit), text.strip())


def _to_si(value: float, written: str, unit: Unit) -> float:
    import pint

    registry = _registry()
    expected = registry.parse_units(unit.symbol)
    try:
        product = _PRODUCT.sub("*", written).replace("²", "**2")
        units = registry.parse_units(_EXPONENT.sub("**", product))
        # Through the reciprocal where the factor is below 1, which is then a whole number: 80 ms are 0.08 s.
        factor = registry.convert(1.0, units, expected)
    except pint.DimensionalityError:
        raise typer.BadParameter(
            f"{written!r} is not a unit of {unit.kind}: write, for example, {unit.example}."
        ) from None
    except Exception:
        # pint reports an unknown or unreadable unit by several kinds of exceptions.
        raise typer.BadParameter(
            f"{written!r} is not a unit that is known: write {unit.kind} in {unit.symbol}, "
            f"for example {unit.example}."
        ) from None
    inverse = 1.0 / factor
    if factor < 1.0 and math.isclose(inverse, round(inverse), rel_tol=1e-12):
        return value / round(inverse)
    return value * (round(factor) if math.isclose(factor, round(factor), rel_tol=1e-12) else factor)


def number(unit: Unit) -> Callable[[str], float]:
    """Return the parser of an option that is a number with a unit."""

    def parser(value: str | float) -> float:
        return value if isinstance(value, float) else read_number(str(value), unit)

    return parser


class Interval(NamedTuple):
    """A range of values, or one value twice."""

    low: float
    high: float


def read_interval(text: str, unit: Unit) -> Interval:
    """Read "50:300", "50:300 N/m" or one number; a unit at the end holds for both.

    Examples
    --------
    >>> read_interval("50:300 N/m", STIFFNESS), read_interval("120", STIFFNESS)
    (Interval(low=50.0, high=300.0), Interval(low=120.0, high=120.0))
    """
    low, colon, high = text.partition(":")
    if not colon:
        value = read_number(text, unit)
        return Interval(value, value)
    found = _NUMBER.fullmatch(high)
    end = read_number(high, unit)
    start = _NUMBER.fullmatch(low)
    if start is not None and not start[2] and found is not None:
        low = f"{low} {found[2]}"
    start_value = read_number(low, unit)
    if start_value > end:
        raise typer.BadParameter(f"{text!r} ends below its start: write the smaller number first.")
    return Interval(start_value, end)
