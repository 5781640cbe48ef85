"""Read a table in a text file: pandas reads the numbers, and lines of another length are refused."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._tables.text_layout import MISSING, Heading, TextLayout, find_heading, find_layout
from telespring._tables.text_lines import TextLines, text_lines
from telespring._types import FloatArray

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["TextTable", "numbers_from_texts", "read_text_table"]

#: Whole numbers of so many digits with a fraction do not fit a double to the microsecond.
_LONG_DECIMAL = re.compile(r"\d{9,}[.,]\d+")
_EXPONENT_D = re.compile(r"(?<=[\d.,])[dD](?=[+-]?\d)")


@dataclass(frozen=True, eq=False)
class TextTable:
    """The rows of a text file.

    Attributes
    ----------
    names
        Names of the columns; "1", "2", … if the file has none.
    has_names
        Whether the file has a line of names.
    units
        The line of units below the names; empty if there is none.
    columns
        The columns by their position, from 0: numbers where all fields are numbers, otherwise texts.
    lines
        Number of each row's line in the file, from 1.
    separator, decimal
        How the file separates columns (" " for any white space) and writes decimals.
    """

    names: tuple[str, ...]
    has_names: bool
    units: tuple[str, ...]
    columns: pd.DataFrame
    lines: NDArray[np.int_]
    separator: str
    decimal: str

    def __len__(self) -> int:
        """Count the rows."""
        return len(self.lines)

    def numbers(self, column: int) -> FloatArray:
        """Return a column as numbers; what is not a number becomes NaN."""
        return numbers_from_texts(self.columns[column], self.decimal)


def read_text_table(path: Path, file: str, *, as_texts: bool = False) -> TextTable:
    """Read a table in a text file.

    The separator, the decimal mark, and whether a line of names, of units, comments (`#`, `%`, `//`) or other
    lines stand above the numbers, are found from the lines themselves. Exponents may be written with D. A
    separator at the end of lines is no column. `file` names the file in messages; `as_texts` keeps every
    field as it is written. InvalidInput where the file is no text, is empty, or has a line of another length
    than the names; OSError where it cannot be read.
    """
    lines = text_lines(path, file)
    if not lines.table:
        raise InvalidInput(
            file,
            "empty",
            "a line of column names and a line per sample are required",
            "Check that the recording was saved.",
        )
    layout = find_layout(lines)
    heading = find_heading(lines, layout)
    rows, numbers, names = _match_fields(file, lines, heading, layout)
    width = len(names) if names is not None else (layout.count(rows[0]) if rows else 0)
    return TextTable(
        names=tuple(names) if names is not None else tuple(str(i + 1) for i in range(width)),
        has_names=names is not None,
        units=tuple(heading.units),
        columns=_parse_rows(rows, width, layout, as_texts=as_texts),
        lines=numbers,
        separator=layout.separator,
        decimal=layout.decimal,
    )


def numbers_from_texts(values: pd.Series[Any], decimal: str = ".") -> FloatArray:
    """Return texts as numbers, with this decimal mark and exponents of E or D; other texts become NaN."""
    import pandas as pd

    if values.dtype.kind in "biuf":
        return values.to_numpy(dtype=float, na_value=np.nan)
    if not pd.api.types.is_string_dtype(values.dtype) and values.dtype != object:
        return np.asarray(pd.to_numeric(values, errors="coerce"), dtype=float)
    texts = values.astype("str").str.strip().str.replace("\u2212", "-", regex=False)
    texts = texts.str.replace(_EXPONENT_D, "e", regex=True)
    if decimal == ",":
        texts = texts.str.replace(",", ".", regex=False)
    return pd.to_numeric(texts, errors="coerce").to_numpy(dtype=float, na_value=np.nan)


def _match_fields(
    file: str, lines: TextLines, heading: Heading, layout: TextLayout
) -> tuple[list[str], NDArray[np.int_], list[str] | None]:
    """Return the rows, each with one field per name, their lines, and the names.

    InvalidInput for a row of another length.
    """
    names, rows, numbers = heading.names, lines.table[heading.first :], lines.numbers[heading.first :]
    counts = layout.counts(rows)
    usual = int(np.bincount(counts).argmax()) if rows else 0
    if names is not None:
        # A separator at the end of the names, but not of the rows.
        while len(names) > 1 and not names[-1] and usual == len(names) - 1:
            names = names[:-1]
    width = len(names) if names is not None else usual
    for place in np.flatnonzero(counts != width).tolist():
        text, count = rows[place], int(counts[place])
        while count > width and text.rstrip(" ").endswith(layout.separator):
            text, count = text.rstrip(" ")[:-1], count - 1
        if count != width:
            raise _refuse_ragged_line(f"{file}, line {numbers[place]}", place, counts, width, heading, layout)
        rows[place] = text
    # A recorder that starts again may write its names again.
    if names is not None and heading.line is not None:
        # Names in a comment are no line of the table.
        named = np.flatnonzero(lines.numbers[: heading.first] == heading.line)
        first = lines.table[int(named[0])] if named.size else None
        if first in rows:
            numbers = numbers[[row != first for row in rows]]
            rows = [row for row in rows if row != first]
    return rows, numbers, names


def _refuse_ragged_line(
    line: str,
    place: int,
    counts: NDArray[np.int_],
    width: int,
    heading: Heading,
    layout: TextLayout,
) -> InvalidInput:
    count = int(counts[place])
    if layout.separator == "," and count == 2 * width:
        remedy = "If decimals are written with commas, separate the columns with semicolons."
    elif heading.names is not None and (counts == count).all():
        remedy = "Give every column a name, also one of row numbers (in R: row.names = FALSE)."
    elif place == len(counts) - 1 and count < width:
        remedy = "The last line seems to be cut off: remove it."
    else:
        remedy = "Correct this line, or remove it."
    reference = (
        f"as many as names in line {heading.line}" if heading.names is not None else "as in other lines"
    )
    return InvalidInput(
        line,
        f"{count} fields",
        f"a table is required, and every line must have {width} fields, {reference}",
        remedy,
    )


def _parse_rows(texts: Sequence[str], width: int, layout: TextLayout, *, as_texts: bool) -> pd.DataFrame:
    import pandas as pd

    if not texts:
        return pd.DataFrame({i: pd.Series(dtype=str if as_texts else float) for i in range(width)})
    options: dict[str, Any] = {}
    if as_texts:
        options = {"dtype": str, "keep_default_na": False, "na_filter": False}
    else:
        beginning = layout.split(texts[0])
        options["dtype"] = {i: str for i, field in enumerate(beginning) if _LONG_DECIMAL.fullmatch(field)}
        options["na_values"] = sorted(MISSING - {"", "inf", "+inf", "-inf", "infinity", "-infinity"})
        # Since pandas 3.1 decimals are always read exactly, and the option is gone.
        if tuple(int(part) for part in pd.__version__.split(".")[:2]) < (3, 1):
            options["float_precision"] = "round_trip"
    blank = layout.separator == " "
    # Quoted decimal commas between commas are read as texts.
    decimal = "." if layout.decimal == layout.separator else layout.decimal
    table: pd.DataFrame = pd.read_csv(
        # Bytes, not text: a stream of text takes four times the memory, and is encoded again in pieces.
        io.BytesIO("\n".join([text.strip() for text in texts] if blank else texts).encode()),
        header=None,
        names=list(range(width)),
        index_col=False,
        sep=r"\s+" if blank else layout.separator,
        decimal=decimal,
        quoting=csv.QUOTE_MINIMAL if layout.is_quoted else csv.QUOTE_NONE,
        skipinitialspace=True,
        skip_blank_lines=False,
        low_memory=False,
        **options,
    )
    return table
