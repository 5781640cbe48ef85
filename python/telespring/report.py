"""One self-contained page from the numbers of a study.

Every number in the page stands in a `<data>` element that names its key in `study.json`, so that no
number can be typed by hand and every one can be traced.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

__all__ = ["format_quantity", "look_up", "render"]

#: Units that a person reads, by the SI unit in `study.json`: the shown unit and its factor.
_SHOWN = {"s": ("ms", 1e3), "m": ("mm", 1e3), "m/N": ("mm/N", 1e3), "rad": ("°", 180.0 / math.pi)}


def look_up(numbers: Mapping[str, Any], key: str) -> Any:
    """Find the value at a dotted key such as ``summary.rows.3.delay``.

    Parameters
    ----------
    numbers
        Nested dicts and lists.
    key
        Names and list indices, joined by dots.

    Returns
    -------
    object
        What stands there.

    Raises
    ------
    KeyError, IndexError
        Where nothing does.

    Examples
    --------
    >>> look_up({"rows": [{"delay": 0.1}]}, "rows.0.delay")
    0.1
    """
    value: Any = numbers
    for part in key.split("."):
        value = value[int(part)] if isinstance(value, list) else value[part]
    return value


def format_quantity(value: float | None, unit: str = "1", digits: int = 4) -> str:
    """Write a quantity as a person reads it: milliseconds, millimetres, significant digits.

    Parameters
    ----------
    value
        In SI units; None for an unbounded or missing one.
    unit
        Its SI unit; "1" for a pure number.
    digits
        Significant digits.

    Returns
    -------
    str
        Number and unit.

    Examples
    --------
    >>> format_quantity(0.16718632, "s")
    '167.2 ms'
    >>> format_quantity(None, "s")
    'no limit'
    """
    if value is None:
        return "no limit"
    shown, factor = _SHOWN.get(unit, (unit, 1.0))
    # Adding zero turns -0.0 into 0.0.
    scaled = value * factor + 0.0
    if scaled != 0.0 and not 1e-3 <= abs(scaled) < 1e6:
        mantissa, exponent = f"{scaled:.{min(digits, 2) - 1}e}".split("e")
        text = f"{mantissa}·10{_superscript(int(exponent))}"
    else:
        decimals = 0 if scaled == 0.0 else max(0, digits - 1 - math.floor(math.log10(abs(scaled))))
        text = f"{scaled:.{decimals}f}"
        if float(scaled).is_integer():
            text = f"{scaled:.0f}"
    text = text.replace("-", "−")
    if shown == "1":
        return text
    return f"{text}{'' if shown == '°' else ' '}{shown}"


def _superscript(exponent: int) -> str:
    return str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def render(numbers: Mapping[str, Any], drawings: Mapping[str, str]) -> str:
    """Write the page.

    Parameters
    ----------
    numbers
        The content of `study.json`.
    drawings
        Name to the text of one `<svg>` element.

    Returns
    -------
    str
        HTML that loads nothing from elsewhere.
    """
    environment = Environment(
        loader=PackageLoader("telespring"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )

    def quantity(key: str, unit: str = "1", digits: int = 4) -> Markup:
        value = look_up(numbers, key)
        exact = "" if value is None else json.dumps(value)
        return Markup('<data value="{}" data-key="{}">{}</data>').format(
            exact, key, format_quantity(value, unit, digits)
        )

    return environment.get_template("report.html.jinja").render(
        numbers=numbers,
        drawings={name: Markup(text) for name, text in drawings.items()},
        q=quantity,
    )
