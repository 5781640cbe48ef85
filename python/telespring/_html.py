"""Results as tables of numbers, for notebooks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

__all__ = ["table"]


def table(title: str, attributes: Mapping[str, Any]) -> str:
    """Return the attributes as an HTML table, a row each; rows of mappings become a table of their own."""
    rows = "".join(
        f"<tr><th>{escape(name)}</th><td>{_cell(value)}</td></tr>" for name, value in attributes.items()
    )
    return f"<table><caption>{escape(title)}</caption>{rows}</table>"


def _cell(value: Any) -> str:
    if isinstance(value, Mapping):
        rows = "".join(
            f"<tr><th>{escape(str(key))}</th><td>{_cell(item)}</td></tr>" for key, item in value.items()
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
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    body = "".join(
        "<tr>" + "".join(f"<td>{_cell(row[name]) if name in row else ''}</td>" for name in names) + "</tr>"
        for row in rows
    )
    return f"<table><tr>{head}</tr>{body}</table>"
