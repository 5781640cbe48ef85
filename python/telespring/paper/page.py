"""One self-contained page from the numbers of a study.

Every number in the page stands in a `<data>` element that names its key in `study.json`, so that no
number can be typed by hand and every one can be traced.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import ROUND_FLOOR, ROUND_HALF_EVEN, Decimal, localcontext
from typing import Any, Literal

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

__all__ = [
    "PLACES",
    "SECTIONS",
    "Section",
    "Style",
    "digits_within",
    "format_quantity",
    "format_share",
    "look_up",
    "render",
]

Style = Literal["nearest", "limit", "given", "hundredths"]


@dataclass(frozen=True)
class Section:
    """One section of the page: a file of `templates/report`, shown where its numbers are there.

    Attributes
    ----------
    template
        Name of the file, without its endings.
    title
        In the contents; empty for what stands before them.
    anchor
        Identifier of its heading.
    needs
        The key of `study.json`, or the name of the drawing, without which there is nothing to show.
    of_paper
        Which of the paper's figures and tables it holds.
    """

    template: str
    title: str
    anchor: str
    needs: str
    of_paper: str = ""


#: In the paper's order; what the paper does not have stands beside what it belongs to.
SECTIONS = (
    Section("summary", "", "summary", "summary"),
    Section("model", "The model", "model", "dyad", "Figs. 1 and 2"),
    Section("robots", "The robots, K and Δ", "robots", "table3", "Table III"),
    Section("map", "The stability map", "map", "stability_map"),
    Section("nyquist", "Nyquist loci", "figure3", "nyquist", "Fig. 3"),
    Section("frequency", "Frequency response", "figure4", "frequency_response", "Fig. 4"),
    Section("responses", "Responses in time", "figure5", "responses", "Fig. 5"),
    Section("laboratory", "The virtual laboratory", "laboratory", "laboratory", "Fig. 6"),
    Section("experiment", "The experiment", "experiment", "experiment", "Figs. 7 and 8, Table I"),
    Section("calibration", "What the real arms must have been", "calibration", "calibration"),
    Section("arms", "What the arms do to the boundary", "arms", "arms"),
    Section("number_sets", "Roots of two robots alike", "table2", "table2", "Table II"),
    Section(
        "identification", "Identification", "identification", "identification", "Figs. 9 and 10, Table III"
    ),
    Section("examples", "Where the paper's formulas fail", "examples", "examples"),
    Section("misprints", "The paper's misprints, with numbers", "misprints", "misprints"),
    Section("reading", "How to read this page", "reading", "study"),
)

#: Where each figure and table of the paper stands in the page, and the section that holds it.
PLACES = (
    ("Fig. 1", "figure-dyad", "model"),
    ("Fig. 2", "figure-loop", "model"),
    ("Fig. 3", "figure-nyquist", "nyquist"),
    ("Fig. 4", "figure-frequency", "frequency"),
    ("Fig. 5", "figure-responses", "responses"),
    ("Fig. 6", "figure-laboratory", "laboratory"),
    ("Fig. 7", "figure-trajectories", "experiment"),
    ("Fig. 8", "figure-tracking", "experiment"),
    ("Fig. 9", "figure-excitation", "identification"),
    ("Fig. 10", "figure-regression", "identification"),
    ("Table I", "table1", "experiment"),
    ("Table II", "number-sets", "number_sets"),
    ("Table III", "table3", "robots"),
)

#: Units that a person reads, by the SI unit in `study.json`: the shown unit and its factor.
_SHOWN = {
    "s": ("ms", 1e3),
    "m": ("mm", 1e3),
    "m/N": ("mm/N", 1e3),
    "seconds": ("s", 1.0),
    "rad": ("°", 180.0 / math.pi),
}


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


def format_quantity(
    value: float | None, unit: str = "1", digits: int = 4, *, style: Style = "nearest", bare: bool = False
) -> str:
    """Write a quantity as a person reads it: milliseconds, millimetres, significant digits.

    Parameters
    ----------
    value
        In SI units; None for an unbounded or missing one.
    unit
        Its SI unit; "1" for a pure number, "seconds" for a time that is not told in milliseconds, such as a
        trial's length.
    digits
        Significant digits.
    style
        "nearest" rounds to the nearest; "limit" rounds down, so that what is shown of a limit lies
        within it; "given" leaves away zeros at the end, as a person writes a value; "hundredths" has two
        decimals whatever the size, as a table's columns do.
    bare
        Without the unit, which the reader is then told elsewhere, such as above a table's column.

    Returns
    -------
    str
        Number and unit.

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
    # A delay is told in milliseconds, the length of a trial in seconds.
    shown, factor = (unit, 1.0) if unit == "s" and abs(value) >= 10.0 else _SHOWN.get(unit, (unit, 1.0))
    # In decimals, so that 0.029 s is 29 ms and not a bit less, which would be rounded down.
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
    """Find how many digits of an estimate its interval makes worth telling.

    Parameters
    ----------
    value
        The estimate; None where there is none.
    interval
        Its lower and upper end.

    Returns
    -------
    int
        Significant digits with which two of the interval's width are seen; at least 3, at most 10.

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
    """Write a probability that was counted, with what the number of draws can tell of none and of all.

    Parameters
    ----------
    share
        Between 0 and 1.
    draws
        How many were counted.

    Returns
    -------
    str
        With as many decimals as one of the draws has.

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
        loader=PackageLoader("telespring.paper", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )

    def quantity(
        key: str, unit: str = "1", digits: int = 4, style: Style = "nearest", bare: bool = False
    ) -> Markup:
        value = look_up(numbers, key)
        exact = "" if value is None else json.dumps(value)
        return Markup('<data value="{}" data-key="{}">{}</data>').format(
            exact, key, format_quantity(value, unit, digits, style=style, bare=bare)
        )

    def share(key: str, draws: str) -> Markup:
        value = look_up(numbers, key)
        text = format_share(value, look_up(numbers, draws))
        return Markup('<data value="{}" data-key="{}">{}</data>').format(json.dumps(value), key, text)

    shown = [each for each in SECTIONS if each.needs in numbers or each.needs in drawings]
    templates = {each.template for each in shown}
    return environment.get_template("templates/report.html.jinja").render(
        numbers=numbers,
        drawings={name: Markup(text) for name, text in drawings.items()},
        q=quantity,
        share=share,
        look_up=lambda key: look_up(numbers, key),
        digits_within=lambda key, interval: digits_within(look_up(numbers, key), look_up(numbers, interval)),
        parts=shown,
        places=[(name, anchor) for name, anchor, template in PLACES if template in templates],
    )
