"""Readers of log files, one per format: the columns of a CSV, Parquet or MATLAB file by name."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["read_csv_log", "read_log_columns", "read_mat_log", "read_parquet_log"]


def read_log_columns(path: Path) -> dict[str, FloatArray]:
    """Read all columns of a log as numbers; what is not a number becomes NaN."""
    readers = {".csv": read_csv_log, ".parquet": read_parquet_log, ".mat": read_mat_log}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise InvalidInput(
            "log",
            str(path),
            "the file's name must end in .csv, .parquet or .mat",
            "Export the log to CSV, with the column names in the first line.",
        )
    if not path.exists():
        raise FileNotFoundError(2, "No such file or directory", str(path))
    return reader(path)


def read_csv_log(path: Path) -> dict[str, FloatArray]:
    """Read a CSV file with one line of column names and one line of numbers per sample."""
    import pandas as pd

    try:
        table = pd.read_csv(path, skipinitialspace=True, encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InvalidInput(
            "log", f"{path}, not UTF-8", "a text file in UTF-8 is required", "Save it as CSV UTF-8."
        ) from None
    except pd.errors.EmptyDataError:
        raise InvalidInput(
            "log",
            f"{path}, empty",
            "a line of column names and a line per sample are required",
            "Check that the recording was saved.",
        ) from None
    except pd.errors.ParserError as error:
        reason = str(error).removeprefix("Error tokenizing data. C error: ").strip()
        raise InvalidInput(
            "log",
            f"{path}, {reason[:1].lower()}{reason[1:]}",
            "a table is required: a line of column names, then a line per sample with as many fields",
            "Check that it is a log, and remove any lines above the column names.",
        ) from None
    except (ValueError, OSError) as error:
        raise _refuse_unreadable_log(path, error) from None
    names = [str(name) for name in table.columns]
    for separator, word in ((";", "semicolons"), ("\t", "tabs")):
        if len(names) == 1 and separator in names[0]:
            raise InvalidInput(
                "log",
                f"{path}, separated by {word}",
                "columns must be separated by commas, with a point before decimals",
                "Export it with commas between columns and a point before decimals.",
            )
    numbers = _log_table_as_numbers(table)
    if len(table) and numbers.isna().all(axis=None):
        raise InvalidInput(
            "log",
            f"{path}, no numbers",
            "a table is required: a line of column names, then a line of numbers per sample",
            "Check that this file is the log.",
        )
    if len(table) > 1 and numbers.iloc[0].isna().all() and numbers.iloc[1].notna().any():
        units = ", ".join(str(value) for value in table.iloc[0])
        raise InvalidInput(
            "log",
            f"{path}, no numbers in the second line ({units[:60]})",
            "numbers must follow the line of column names",
            "Remove that line; give units other than s, m and N with --time-scale, --position-scale and "
            "--force-scale.",
        )
    return _log_numbers_by_column(numbers)


def read_parquet_log(path: Path) -> dict[str, FloatArray]:
    """Read a Parquet file; this needs pyarrow."""
    import pandas as pd

    try:
        return _log_numbers_by_column(_log_table_as_numbers(pd.read_parquet(path)))
    except ImportError:
        raise InvalidInput(
            "log",
            str(path),
            "Parquet files need pyarrow, which is not installed",
            "Install it with: pip install 'telespring[parquet]'. Or export the log to CSV.",
        ) from None
    except (ValueError, OSError) as error:
        raise _refuse_unreadable_log(path, error) from None


def read_mat_log(path: Path) -> dict[str, FloatArray]:
    """Read the arrays of a MATLAB file up to version 7.2, and those in the fields of its structs."""
    from scipy import io

    try:
        content = io.loadmat(path, simplify_cells=True)
    except NotImplementedError:
        raise InvalidInput(
            "log",
            str(path),
            "MATLAB files up to version 7.2 can be read, and this one is newer",
            "Save it in MATLAB with save(..., '-v7').",
        ) from None
    except OSError:
        raise
    except Exception as error:  # any error of the parser in a damaged file
        raise _refuse_unreadable_log(path, error) from None
    columns: dict[str, FloatArray] = {}
    others = []
    for name, value in _flatten_mat_structs(content).items():
        array = np.asarray(value)
        if array.dtype.kind not in "biuf" or array.ndim > 2:
            others.append(name)
        elif array.ndim < 2:
            columns[name] = array.astype(float).ravel()
        else:
            tall = array if array.shape[0] > array.shape[1] else array.T
            columns |= {f"{name}[{i}]": tall[:, i].astype(float) for i in range(tall.shape[1])}
    if not columns:
        raise InvalidInput(
            "log",
            str(path),
            "arrays of numbers are required, and the file contains "
            + (f"only other things: {', '.join(others)}" if others else "nothing"),
            "Save time, position and force as arrays, or as fields of one struct.",
        )
    return columns


def _flatten_mat_structs(content: Mapping[str, Any]) -> dict[str, Any]:
    """Replace each struct by its fields, named `struct.field`."""
    values: dict[str, Any] = {}
    for name, value in content.items():
        if name.startswith("__"):
            continue
        if isinstance(value, dict):
            values |= {f"{name}.{field}": inner for field, inner in value.items()}
        else:
            values[name] = value
    return values


def _log_table_as_numbers(table: pd.DataFrame) -> pd.DataFrame:
    import pandas as pd

    numbers: pd.DataFrame = table.apply(pd.to_numeric, errors="coerce")
    return numbers


def _log_numbers_by_column(numbers: pd.DataFrame) -> dict[str, FloatArray]:
    return {str(name).strip(): numbers[name].to_numpy(dtype=float) for name in numbers.columns}


def _refuse_unreadable_log(path: Path, error: Exception) -> InvalidInput:
    reason = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
    return InvalidInput(
        "log",
        str(path),
        f"a table with one row per sample is required, but this file cannot be read as one ({reason})",
        "Check that it is a log, and that it is complete.",
    )
