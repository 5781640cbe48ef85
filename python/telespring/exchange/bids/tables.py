"""Tables as BIDS wants them: tabs between the cells, "n/a" for what is not known."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["cell", "read_table", "write_json", "write_samples", "write_table"]

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
    """Read a table with a line of names."""
    lines = path.read_text(encoding="utf-8-sig").splitlines()
    rows = [line.split("\t") for line in lines if line.strip()]
    return (rows[0], rows[1:]) if rows else ([], [])


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
