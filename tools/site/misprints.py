"""The table of the paper's misprints, written from the reference file that the tests prove line by line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

__all__ = ["table", "write"]

_HEADER = "| where | printed | correct |\n|---|---|---|\n"


def _cell(text: Any) -> str:
    return str(text).replace("|", "\\|").replace("*", "\\*").replace("_", "\\_").replace("<", "&lt;")


def table() -> str:
    """Return the table in Markdown."""
    from telespring.references import read_reference

    return _HEADER + "".join(
        f"| {_cell(each['where'])} | {_cell(each['printed'])} | {_cell(each['correct'])} |\n"
        for each in read_reference("du2025")["misprint"]
    )


def write(target: Path) -> None:
    """Write the table, if it would change."""
    target.parent.mkdir(parents=True, exist_ok=True)
    if not target.exists() or target.read_text(encoding="utf-8") != table():
        target.write_text(table(), encoding="utf-8")
