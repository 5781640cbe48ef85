"""The report: one self-contained page from the numbers and drawings of its sections.

Every number on the page stands in a `<data>` element that names its key in `study.json`, so that no number
can be typed by hand and every one can be traced.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from telespring._core import __version__
from telespring.paper.section import Findings, Place, Section
from telespring.paper.sections import SECTIONS
from telespring.show.quantities import Style, digits_within, format_p_value, format_quantity, format_share

__all__ = ["MOST_BYTES", "look_up", "places_of", "render", "render_section"]

#: A report stays below this, to be sent by mail: files that a section carries are left out first.
MOST_BYTES = 3_000_000


def look_up(numbers: Mapping[str, Any], key: str) -> Any:
    """Return the value at a dotted key, as a template quotes it, such as ``summary.rows.3.delay``.

    Examples
    --------
    >>> look_up({"rows": [{"delay": 0.1}]}, "rows.0.delay")
    0.1
    """
    value: Any = numbers
    for part in key.split("."):
        value = value[int(part)] if isinstance(value, list) else value[part]
    return value


def render(study: Mapping[str, Any], findings: Mapping[str, Findings], date: str = "") -> str:
    """Render the whole page, HTML that loads nothing from elsewhere, from the findings of any sections.

    `date` is printed as it is; "" for none. Where the page would grow beyond `MOST_BYTES`, the files that its
    sections carry are left out, and the sections say how to get them.
    """
    page = _render(study, findings, date)
    if len(page.encode()) <= MOST_BYTES:
        return page
    left_out = {name: replace(own, files=dict.fromkeys(own.files, "")) for name, own in findings.items()}
    return _render(study, left_out, date)


def _render(study: Mapping[str, Any], findings: Mapping[str, Findings], date: str) -> str:
    """Render the whole page with all that its sections carry."""
    shown = [section for section in SECTIONS if _is_section_shown(section, findings)]
    return (
        _template_environment()
        .get_template("templates/report.html.jinja")
        .render(
            study=study,
            date=date,
            version=__version__,
            with_experiment=any(section.name == "experiment" for section in shown),
            sections=[(section, Markup(render_section(section, study, findings))) for section in shown],
            places=places_of(shown),
        )
    )


def render_section(section: Section, study: Mapping[str, Any], findings: Mapping[str, Findings]) -> str:
    """Render the template of one section, which sees no more than `Section` promises."""
    own = findings.get(section.name, Findings())
    numbers: dict[str, Any] = {"study": study, **own.numbers}
    for name in section.mentions:
        numbers |= findings.get(name, Findings()).numbers

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

    def p_value(key: str) -> Markup:
        value = look_up(numbers, key)
        text = format_p_value(value).removeprefix("= ")
        return Markup('<data value="{}" data-key="{}">{}</data>').format(json.dumps(value), key, text)

    ranges = study["operator_ranges"]
    return (
        _template_environment()
        .get_template(section.template)
        .render(
            section=section,
            of_the_paper=study["of_the_paper"],
            numbers=numbers,
            drawings={name: Markup(text) for name, text in own.drawings.items()},
            files=own.files,
            q=quantity,
            share=share,
            p_value=p_value,
            look_up=lambda key: look_up(numbers, key),
            digits_within=lambda key, interval: digits_within(
                look_up(numbers, key), look_up(numbers, interval)
            ),
            middle=" for the operators in the middle of their ranges" if ranges else "",
            two_axes=len(study["axes"]) > 1,
        )
    )


def places_of(sections: Sequence[Section]) -> list[Place]:
    """List the paper's figures, then its tables, that some sections of the page hold, by their numbers."""
    return sorted(
        (place for section in sections for place in section.holds),
        key=lambda place: (place.name.startswith("Table"), len(place.name), place.name),
    )


def _is_section_shown(section: Section, findings: Mapping[str, Findings]) -> bool:
    """Whether a section has something to show: what computes nothing always has."""
    own = findings.get(section.name, Findings())
    return section.find is None or bool(own.numbers or own.drawings or own.files)


@cache
def _template_environment() -> Environment:
    return Environment(
        loader=PackageLoader("telespring.paper", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
