"""Logs in CSV, Parquet and MATLAB files."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Log", "read_log"]

_KINDS = (".csv", ".parquet", ".mat")
#: A force column whose name has one of these as a word is probably no force.
_NO_FORCE = {"v", "volt", "volts", "voltage", "vir", "u", "current", "amp", "amps", "mv", "ma", "pwm"}


@dataclass(frozen=True)
class Log:
    """Times, positions and forces as they stand in a file, scaled to SI units.

    Attributes
    ----------
    path
        The file.
    time
        s, shape (n,).
    position, force
        m and N, shape (n, axes).
    axes
        Names of the axes.
    columns
        Which columns were read, for the record: "time", and per axis "position x" and "force x".
    notes
        What a user should know, as sentences.
    """

    path: Path
    time: FloatArray
    position: FloatArray
    force: FloatArray
    axes: tuple[str, ...]
    columns: Mapping[str, str]
    notes: tuple[str, ...] = field(default=())


def read_log(
    path: str | os.PathLike[str],
    *,
    time: str = "time",
    position: Sequence[str] = ("position_x", "position_y"),
    force: Sequence[str] = ("force_x", "force_y"),
    axes: Sequence[str] | None = None,
    time_scale: float = 1.0,
    position_scale: float = 1.0,
    force_scale: float = 1.0,
    start: float | None = None,
    end: float | None = None,
) -> Log:
    """Read the named columns of a log.

    Parameters
    ----------
    path : path-like
        A file whose name ends in .csv (first line: names), .parquet (needs pyarrow) or .mat (MATLAB, up to
        version 7.2; a matrix's columns are named `name[0]`, `name[1]`, …, a struct's fields `name.field`).
    time : str
        Name of the time's column.
    position, force : sequence of str
        Names of the position's and the force's columns, one per axis, in the same order.
    axes : sequence of str
        Names of the axes; "x", "y", … unless given.
    time_scale, position_scale, force_scale : float
        What the file's numbers are multiplied by to become s, m and N, such as 0.001 for ms or mm, or the
        newtons per volt of a motor; force_scale -1 turns the force's sign.
    start, end : float
        Only samples from and up to these times are taken, s (after scaling).

    Returns
    -------
    Log
        The columns in SI units.

    Raises
    ------
    telespring.InvalidInput
        Where the file is of another kind, a column is missing or holds no numbers, or a scale is 0.
    OSError
        Where the file cannot be read.
    """
    where = Path(path)
    if len(position) != len(force) or not position:
        raise InvalidInput(
            "position, force",
            f"{len(position)} and {len(force)} columns",
            "as many forces as positions, one per axis, are needed",
            "Name both once per axis, in the same order.",
        )
    names = _axis_names(axes, position)
    for option, scale in (("time", time_scale), ("position", position_scale), ("force", force_scale)):
        if not np.isfinite(scale) or scale == 0.0:
            raise InvalidInput(
                f"{option}_scale",
                f"{scale:g}",
                "a scale must be a number other than 0",
                "Leave it away for 1.",
            )
    for option, limit in (("start", start), ("end", end)):
        if limit is not None and np.isnan(limit):
            raise InvalidInput(
                option, f"{limit:g}", "a time in s is needed", "Leave it away for the whole log."
            )
    table = _table(where)
    times = time_scale * _column(where, table, "time", time)
    positions = position_scale * np.column_stack(
        [_column(where, table, "position", name) for name in position]
    )
    forces = force_scale * np.column_stack([_column(where, table, "force", name) for name in force])
    keep = np.ones(times.size, dtype=bool)
    # A missing time must be told, not dropped.
    if start is not None:
        keep &= ~(times < start)
    if end is not None:
        keep &= ~(times > end)
    if not keep.any():
        raise InvalidInput(
            "start, end",
            f"{start} to {end} s",
            f"the log runs from {np.nanmin(times):g} to {np.nanmax(times):g} s",
            "Choose a piece inside it.",
        )
    return Log(
        path=where,
        time=times[keep],
        position=positions[keep],
        force=forces[keep],
        axes=names,
        columns={"time": time}
        | {f"position {axis}": name for axis, name in zip(names, position, strict=True)}
        | {f"force {axis}": name for axis, name in zip(names, force, strict=True)},
        notes=tuple(_notes(table, force, force_scale)),
    )


def _axis_names(axes: Sequence[str] | None, position: Sequence[str]) -> tuple[str, ...]:
    if axes:
        if len(axes) != len(position):
            raise InvalidInput(
                "axis",
                ", ".join(axes),
                f"one name per position is needed, that is {len(position)}",
                "Name each axis once, in the order of the positions.",
            )
        return tuple(axes)
    return ("x", "y", "z")[: len(position)] if len(position) <= 3 else tuple(map(str, range(len(position))))


def _table(path: Path) -> dict[str, FloatArray]:
    """Read every column of numbers by its name."""
    kind = path.suffix.lower()
    if kind not in _KINDS:
        raise InvalidInput(
            "log",
            str(path),
            "the file's name must end in .csv, .parquet or .mat",
            "Export the log to CSV, with the columns' names in its first line.",
        )
    if not path.exists():
        raise FileNotFoundError(2, "No such file or directory", str(path))
    if kind == ".mat":
        return _mat(path)
    import pandas as pd

    if kind == ".parquet":
        try:
            frame = pd.read_parquet(path)
        except ImportError:
            raise InvalidInput(
                "log",
                str(path),
                "Parquet files are read by pyarrow, which is not installed",
                "Install it with: pip install 'telespring[parquet]'. Or export the log to CSV.",
            ) from None
        except (ValueError, OSError) as trouble:
            raise _unreadable(path, trouble) from None
    else:
        frame = _csv(path)
    columns = {}
    for name in frame.columns:
        # What is no number becomes missing, and is refused with its place if it is used.
        columns[str(name).strip()] = pd.to_numeric(frame[name], errors="coerce").to_numpy(dtype=float)
    return columns


def _csv(path: Path) -> pd.DataFrame:
    import pandas as pd

    try:
        frame = pd.read_csv(path, skipinitialspace=True, encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InvalidInput(
            "log", f"{path}, not UTF-8", "a text file in UTF-8 is needed", "Save it as CSV UTF-8."
        ) from None
    except pd.errors.EmptyDataError:
        raise InvalidInput(
            "log",
            f"{path}, empty",
            "a line of column names and a line per sample are needed",
            "Check that the recording was saved.",
        ) from None
    except pd.errors.ParserError as trouble:
        reason = str(trouble).removeprefix("Error tokenizing data. C error: ").strip()
        raise InvalidInput(
            "log",
            f"{path}, {reason[:1].lower()}{reason[1:]}",
            "a table is needed: a line of column names, then a line per sample with as many fields",
            "Check that it is a log, and remove lines above the columns' names.",
        ) from None
    except (ValueError, OSError) as trouble:
        raise _unreadable(path, trouble) from None
    names = [str(name) for name in frame.columns]
    for separator, word in ((";", "semicolons"), ("\t", "tabs")):
        if len(names) == 1 and separator in names[0]:
            raise InvalidInput(
                "log",
                f"{path}, separated by {word}",
                "columns must be separated by commas, decimals by points",
                "Export it with commas between columns and a point before decimals.",
            )
    numbers = frame.apply(pd.to_numeric, errors="coerce")
    if len(frame) and numbers.isna().all(axis=None):
        raise InvalidInput(
            "log",
            f"{path}, no numbers",
            "a table is needed: a line of column names, then a line of numbers per sample",
            "Check that this file is the log.",
        )
    if len(frame) > 1 and numbers.iloc[0].isna().all() and numbers.iloc[1].notna().any():
        units = ", ".join(str(value) for value in frame.iloc[0])
        raise InvalidInput(
            "log",
            f"{path}, no numbers in the second line ({units[:60]})",
            "numbers must follow the line of column names",
            "Remove that line; give units other than s, m and N with --time-scale, --position-scale and "
            "--force-scale.",
        )
    return frame


def _unreadable(path: Path, trouble: Exception) -> InvalidInput:
    reason = str(trouble).strip().splitlines()[0] if str(trouble).strip() else type(trouble).__name__
    return InvalidInput(
        "log",
        str(path),
        f"a table with one row per sample is needed, and this file cannot be read as one ({reason})",
        "Check that it is a log, and whole.",
    )


def _mat(path: Path) -> dict[str, FloatArray]:
    from scipy import io

    try:
        content = io.loadmat(path)
    except NotImplementedError:
        raise InvalidInput(
            "log",
            str(path),
            "MATLAB files up to version 7.2 are read, and this is a newer one",
            "Save it in MATLAB with save(..., '-v7').",
        ) from None
    except OSError:
        raise
    except Exception as trouble:  # whatever its parser stumbles over in a broken file
        raise _unreadable(path, trouble) from None
    columns = {}
    others = []
    for name, value in _flat(content):
        array = np.asarray(value)
        if array.dtype.kind not in "biuf" or array.ndim != 2:
            others.append(name)
            continue
        if 1 in array.shape:
            columns[name] = array.astype(float).ravel()
        else:
            tall = array if array.shape[0] > array.shape[1] else array.T
            columns |= {f"{name}[{i}]": tall[:, i].astype(float) for i in range(tall.shape[1])}
    if not columns:
        raise InvalidInput(
            "log",
            str(path),
            "arrays of numbers are needed, and the file holds "
            + (f"other things only: {', '.join(others)}" if others else "nothing"),
            "Save time, position and force as arrays, or as fields of one struct.",
        )
    return columns


def _flat(content: Mapping[str, object]) -> list[tuple[str, object]]:
    """List what a MATLAB file holds, a struct by its fields."""
    found: list[tuple[str, object]] = []
    for name, value in content.items():
        if name.startswith("__"):
            continue
        array = np.asarray(value)
        if array.dtype.names and array.size == 1:
            found += [(f"{name}.{field}", array[field].flat[0]) for field in array.dtype.names]
        else:
            found.append((name, value))
    return found


def _column(path: Path, table: Mapping[str, FloatArray], option: str, name: str) -> FloatArray:
    column = table.get(name)
    if column is None:
        there = ", ".join(each for each, values in table.items() if values.size > 1) or "none"
        raise InvalidInput(
            f"--{option}",
            name,
            f"the columns of {path.name} are: {there}",
            f"Name the {option}'s column with --{option}.",
        )
    if column.size == 0:
        raise InvalidInput(
            "log",
            str(path),
            "a log with one row per sample is needed, and this one holds no samples",
            "Check that the recording was saved; its first line alone is there.",
        )
    if column.size > 1 and np.isnan(column).all():
        raise InvalidInput(
            f"--{option}",
            name,
            "a column of numbers is needed, and this one holds none",
            "Name another column.",
        )
    longest = max(values.size for values in table.values())
    if column.size != longest:
        raise InvalidInput(
            f"--{option}",
            f"{name}, {column.size} values",
            f"one value per sample is needed, and the log has {longest}",
            "Name a column that was recorded with every sample.",
        )
    return column


def _notes(table: Mapping[str, FloatArray], force: Sequence[str], scale: float) -> list[str]:
    if scale != 1.0:
        return []
    suspects = [name for name in force if set(name.lower().replace("[", "_").split("_")) & _NO_FORCE]
    if not suspects:
        return []
    gains = [name for name, values in table.items() if values.size == 1]
    hint = f" The file also holds {', '.join(gains)}." if gains else ""
    return [
        (
            f"The force's column {suspects[0]} looks like a voltage, a current or a command. If so, give the "
            "newtons per unit with --force-scale; mass and damping are wrong by that factor otherwise."
            f"{hint}"
        )
    ]
