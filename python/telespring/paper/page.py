"""One self-contained page from the numbers of a study.

Every number in the page stands in a `<data>` element that names its key in `study.json`, so that no
number can be typed by hand and every one can be traced.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from telespring.show.quantities import Style, digits_within, format_quantity, format_share

__all__ = [
    "PLACES",
    "SECTIONS",
    "Section",
    "look_up",
    "render",
]


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
