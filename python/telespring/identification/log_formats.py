"""Readers of log files, one per format: the columns of a CSV, Parquet or MATLAB file by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._tables import numbers_from_texts, read_text_table
from telespring._types import FloatArray
from telespring.identification.matlab_files import named_arrays, read_matlab_variables

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["LOG_SUFFIXES", "LogColumns", "read_log_columns"]


@dataclass(frozen=True, eq=False)
class LogColumns:
    """The columns of a log as the file stores them.

    Attributes
    ----------
    file
        How messages name the file.
    columns
        Arrays or pandas series of numbers, dates or texts, in the order of the file.
    has_names
        Whether the file names its columns; otherwise they are named "1", "2", …
    units
        What a line of units below the names says, by column.
    ambiguous
        Names of more than one column.
    decimal
        Decimal mark of texts.
    lines
        Number of each row's line in a text file.
    """

    file: str
    columns: Mapping[str, Any]
    has_names: bool = True
    units: Mapping[str, str] = field(default_factory=dict)
    ambiguous: frozenset[str] = frozenset()
    decimal: str = "."
    lines: NDArray[np.int_] | None = None

    def find(self, name: str) -> str | None:
        """Return the name of the column that a user gave by its name, or by its number from 1."""
        if name.strip() in self.columns:
            return name.strip()
        alike = [column for column in self.columns if column.casefold() == name.strip().casefold()]
        if len(alike) == 1:
            return alike[0]
        if name.isdecimal() and 1 <= int(name) <= len(self.columns):
            return list(self.columns)[int(name) - 1]
        return None

    def numbers(self, name: str) -> FloatArray:
        """Return a column as numbers; what is not a number becomes NaN."""
        import pandas as pd

        values = pd.Series(self.columns[name])
        return (
            np.full(len(values), np.nan)
            if values.dtype.kind in "Mm"
            else numbers_from_texts(values, self.decimal)
        )


def read_log_columns(path: Path) -> LogColumns:
    """Read all columns of a log."""
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise InvalidInput(
            "log",
            str(path),
            f"the file's name must end in {', '.join(LOG_SUFFIXES[:-1])} or {LOG_SUFFIXES[-1]}",
            "Export the log to CSV, with the column names in the first line.",
        )
    if not path.exists():
        raise FileNotFoundError(2, "No such file or directory", str(path))
    return reader(path)


def _read_text_log(path: Path) -> LogColumns:
    """Read a CSV file or another table in a text file."""
    table = read_text_table(path, path.name)
    given = [name or str(i + 1) for i, name in enumerate(table.names)]
    repeated = frozenset(name for name in given if given.count(name) > 1)
    # Columns of one name can be told apart by their numbers.
    names = [f"{name} (column {i + 1})" if name in repeated else name for i, name in enumerate(given)]
    log = LogColumns(
        path.name,
        {name: table.columns[i] for i, name in enumerate(names)},
        table.has_names,
        dict(zip(names, table.units, strict=False)),
        repeated,
        table.decimal,
        table.lines,
    )
    if len(table) and all(np.isnan(log.numbers(name)).all() for name in log.columns):
        raise InvalidInput(
            "log",
            f"{path}, no numbers",
            "a table is required: a line of column names, then a line of numbers per sample",
            "Check that this file is the log.",
        )
    return log


def _read_parquet_log(path: Path) -> LogColumns:
    """Read a Parquet file, with its index as columns; this needs pyarrow."""
    import pandas as pd

    try:
        table = pd.read_parquet(path)
    except ImportError:
        raise InvalidInput(
            "log",
            str(path),
            "Parquet files need pyarrow, which is not installed",
            "Install it with: pip install 'telespring[parquet]'. Or export the log to CSV.",
        ) from None
    except (ValueError, OSError) as error:
        raise _refuse_unreadable_log(path, error) from None
    if not (isinstance(table.index, pd.RangeIndex) and table.index.name is None):
        table = _with_index_as_columns(table)
    names = [str(name).strip() for name in table.columns]
    return LogColumns(path.name, {name: table.iloc[:, i] for i, name in enumerate(names)})


def _with_index_as_columns(table: pd.DataFrame) -> pd.DataFrame:
    """Put the index before the columns; an index of times without a name is the time."""
    import pandas as pd

    is_time = table.index.dtype.kind in "Mm" and "time" not in table.columns
    names = [
        name if name is not None else ("time" if is_time else "index" if i == 0 else f"index {i + 1}")
        for i, name in enumerate(table.index.names)
    ]
    index = table.index.to_frame(index=False).set_axis(names, axis=1)
    return pd.concat([index, table.reset_index(drop=True)], axis=1)


def _read_matlab_log(path: Path) -> LogColumns:
    """Read the arrays of a MATLAB file, and those in its structs and cells."""
    try:
        arrays, others = named_arrays(read_matlab_variables(path))
    except FileNotFoundError:
        raise
    except Exception as error:  # any error of the parser in a damaged file
        raise _refuse_unreadable_log(path, error) from None
    if not arrays:
        raise InvalidInput(
            "log",
            str(path),
            "arrays of numbers are required, and the file contains "
            + (f"only other things: {', '.join(others)}" if others else "nothing"),
            "Save time, position and force as arrays, or as fields of a struct; from Simulink, in the format "
            "Structure With Time.",
        )
    return LogColumns(path.name, arrays)


def _refuse_unreadable_log(path: Path, error: Exception) -> InvalidInput:
    reason = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
    return InvalidInput(
        "log",
        str(path),
        f"a table with one row per sample is required, but this file cannot be read as one ({reason})",
        "Check that it is a log, and that it is complete.",
    )


_READERS: dict[str, Callable[[Path], LogColumns]] = {
    ".csv": _read_text_log,
    ".txt": _read_text_log,
    ".tsv": _read_text_log,
    ".dat": _read_text_log,
    ".parquet": _read_parquet_log,
    ".mat": _read_matlab_log,
}
#: Endings of log files, in upper or lower case.
LOG_SUFFIXES = tuple(_READERS)
