"""Results as tables of numbers, for notebooks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

__all__ = ["table"]


#: The SI unit of what a name ends with; a name that ends otherwise is a pure number, a word or a list.
_UNITS = {
    "stiffness": "N/m",
    "stiffness_bound": "N/m",
    "stiffness_limit": "N/m",
    "delay_limit": "s",
    "least_found": "N/m",
    "difference": "N/m",
    "any_passive_operator": "N/m",
    "damping": "N·s/m",
    "mass": "kg",
    "delay": "s",
    "delays": "s",
    "network": "s",
    "jitter": "s",
    "gap": "s",
    "period": "s",
    "time": "s",
    "sampling": "s",
    "computing": "s",
    "total": "s",
    "horizon": "s",
    "frequency": "rad/s",
    "abscissa": "1/s",
    "abscissa_equivalent": "1/s",
    "rate": "1/s",
}


def _with_unit(name: str, value: Any) -> str:
    """Name a number with its unit; a number of a robot, such as `mass1`, has that of the mass."""
    numbers = value if isinstance(value, Sequence) and not isinstance(value, str) else [value]
    if not numbers or not all(isinstance(number, float) for number in numbers):
        return name
    words = name.rstrip("12").split("_")
    ends = ("_".join(words[i:]) for i in range(len(words)))
    unit = next((_UNITS[end] for end in ends if end in _UNITS), "")
    return f"{name}, {unit}" if unit else name


def table(title: str, attributes: Mapping[str, Any]) -> str:
    """Return the attributes as an HTML table, a row each; rows of mappings are a table in it."""
    rows = "".join(
        f"<tr><th>{escape(_with_unit(name, value))}</th><td>{_cell(value)}</td></tr>"
        for name, value in attributes.items()
    )
    return f"<table><caption>{escape(title)}</caption>{rows}</table>"


def _cell(value: Any) -> str:
    if isinstance(value, Mapping):
        rows = "".join(
            f"<tr><th>{escape(_with_unit(str(key), item))}</th><td>{_cell(item)}</td></tr>"
            for key, item in value.items()
        )
        return f"<table>{rows}</table>"
    if isinstance(value, Sequence) and not isinstance(value, str):
        if value and all(isinstance(item, Mapping) for item in value):
            return _columns(value)
        if len(value) > 8:
            return f"{len(value)} values"
        return ", ".join(_cell(item) for item in value)
    return escape(f"{value:.6g}" if isinstance(value, float) else str(value))


def _columns(rows: Sequence[Mapping[str, Any]]) -> str:
    names = list(dict.fromkeys(name for row in rows for name in row))
    columns = {name: [row[name] for row in rows if row.get(name) is not None] for name in names}
    head = "".join(f"<th>{escape(_with_unit(name, values))}</th>" for name, values in columns.items())
    body = "".join(
        "<tr>" + "".join(f"<td>{_cell(row[name]) if name in row else ''}</td>" for name in names) + "</tr>"
        for row in rows
    )
    return f"<table><tr>{head}</tr>{body}</table>"
