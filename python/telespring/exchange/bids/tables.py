"""Tables as BIDS wants them: tabs between the cells, "n/a" for what is not known."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput

__all__ = ["append_rows", "cell", "read_json", "read_table", "write_json", "write_samples", "write_table"]

_UNKNOWN = "n/a"


def cell(value: object) -> str:
    r"""Write a value; what would break the table becomes a space.

    Examples
    --------
    >>> cell(float("nan")), cell(0.25), cell("two\twords")
    ('n/a', '0.25', 'two words')
    """
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return _UNKNOWN
    text = f"{value:.10g}" if isinstance(value, float) else " ".join(str(value).split())
    return text or _UNKNOWN


def write_table(path: Path, names: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table with a line of names."""
    lines = ["\t".join(names), *("\t".join(map(cell, row)) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def read_table(path: Path) -> tuple[list[str], list[list[str]]]:
    """Read a table with a line of names; InvalidInput if it is no text in UTF-8."""
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise InvalidInput(
            "folder", str(path), "a table in UTF-8 is required, as BIDS asks", "Save it as UTF-8."
        ) from None
    rows = [line.split("\t") for line in lines if line.strip()]
    return (rows[0], rows[1:]) if rows else ([], [])


def read_json(path: Path) -> dict[str, Any]:
    """Read a sidecar file; InvalidInput if it is none."""
    try:
        content = json.loads(path.read_text(encoding="utf-8-sig"))
    except ValueError:  # also what is no UTF-8
        content = None
    if not isinstance(content, dict):
        raise InvalidInput("folder", str(path), "a JSON object is required, as BIDS asks", "Mend the file.")
    return content


def append_rows(
    table: tuple[list[str], list[list[str]]], names: Sequence[str], rows: Iterable[Sequence[object]]
) -> tuple[list[str], list[list[str]]]:
    """Add rows to a table that may have other columns; what a row does not have is not known.

    Examples
    --------
    >>> append_rows((["file", "note"], [["a", "good"]]), ["file", "robot"], [["b", 2]])
    (['file', 'note', 'robot'], [['a', 'good', 'n/a'], ['b', 'n/a', '2']])
    """
    old_names, old_rows = table
    all_names = [*old_names, *(name for name in names if name not in old_names)]
    filled = [[*row, *[_UNKNOWN] * (len(all_names) - len(row))] for row in old_rows]
    for row in rows:
        known = dict(zip(names, map(cell, row), strict=True))
        filled.append([known.get(name, _UNKNOWN) for name in all_names])
    return all_names, filled


def write_samples(path: Path, columns: Sequence[NDArray[np.float64]]) -> None:
    """Write the samples of a motion file: no line of names, ten digits."""
    import pandas as pd

    frame = pd.DataFrame(np.column_stack(columns))
    frame.to_csv(
        path, sep="\t", header=False, index=False, na_rep=_UNKNOWN, float_format="%.10g", lineterminator="\n"
    )


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a sidecar file."""
    path.write_text(
        json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8"
    )
