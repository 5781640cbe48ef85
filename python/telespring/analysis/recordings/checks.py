"""The files of recorded trials, one by one: the list, and a file per trial; refused where they mislead."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.analysis.recordings.layout import (
    INDEX_OPTIONAL,
    INDEX_REQUIRED,
    QUANTITIES,
    STATUSES,
    TARGET,
    TIME,
    columns_of,
)

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["TrialFile", "number_of", "read_index", "read_trial", "refuse", "whole_number_of"]

_LAYOUT = "docs/recorded-trials.md shows the layout, `telespring analyse --template DIR` writes an example."

#: A gap this many times longer than a sample is not bridged by a straight line.
_LONGEST_GAP = 5.0
#: No planar robot reaches that far, m; a position given in mm does.
_FARTHEST = 5.0
#: No trial is sampled that slowly, s; a time given in ms seems to be.
_SLOWEST = 0.5
#: No coupling is that late, s; a delay given in ms is.
_LATEST = 10.0


@dataclass(frozen=True, eq=False)
class TrialFile:
    """One file: its place in the index, its times (s) and its columns by quantity."""

    file: str
    key: tuple[float, float]
    number: int
    row: Mapping[str, str]
    time: FloatArray
    series: dict[str, FloatArray]


def refuse(where: str, value: str, allowed: str, remedy: str = _LAYOUT) -> NoReturn:
    """Refuse a file or one of its values."""
    raise InvalidInput(where, value, allowed, remedy)


def _read_csv(path: Path, name: str, *, text: bool = False) -> pd.DataFrame:
    import pandas as pd

    try:
        if text:
            table = pd.read_csv(path, dtype=str, keep_default_na=False, encoding="utf-8-sig")
        else:
            # Exact reading of decimals was an option until pandas 3.1 made it the only way.
            exact = tuple(int(part) for part in pd.__version__.split(".")[:2]) >= (3, 1)
            precision: dict[str, Any] = {} if exact else {"float_precision": "round_trip"}
            table = pd.read_csv(path, encoding="utf-8-sig", **precision)
    except UnicodeDecodeError:
        refuse(name, "not UTF-8", "a text file in UTF-8 is needed", "Save it as CSV UTF-8.")
    except pd.errors.EmptyDataError:
        refuse(name, "empty", "a line of column names and a line per sample are needed")
    except pd.errors.ParserError as trouble:
        reason = str(trouble).removeprefix("Error tokenizing data. C error: ").strip()
        refuse(name, reason, "as many fields as there are column names are needed in every line")
    table.columns = [str(column).strip() for column in table.columns]
    if len(table.columns) == 1 and ";" in table.columns[0]:
        refuse(
            name,
            "separated by semicolons",
            "columns must be separated by commas, decimals by points",
            "Export it with commas between columns and a point before decimals.",
        )
    return table


def _near(name: str, columns: list[str]) -> str:
    """Say what stands there in place of a missing column."""
    stem = name.rsplit("_", 1)[0] if name not in ("file", "trial", "status") else name
    other = [column for column in columns if column.startswith(stem) or stem.startswith(column)]
    other = other or difflib.get_close_matches(name, columns, n=1)
    return f"missing; {other[0]} is there instead" if other else "missing"


def read_index(path: Path) -> list[dict[str, str]]:
    """Read the list of trials.

    Parameters
    ----------
    path
        The list.

    Returns
    -------
    list of dict
        A row per trial, by column, as text; conditions and numbers are checked, no trial is there twice.
    """
    table = _read_csv(path, path.name, text=True)
    columns = list(table.columns)
    for name in INDEX_REQUIRED:
        if name not in columns:
            refuse(f"{path.name}: {name}", _near(name, columns), f"the column {name} is needed")
    for name in columns:
        if name not in (*INDEX_REQUIRED, *INDEX_OPTIONAL) and difflib.get_close_matches(
            name, INDEX_OPTIONAL, n=1, cutoff=0.8
        ):
            refuse(
                f"{path.name}: {name}",
                "not known",
                f"the list may have {', '.join(INDEX_OPTIONAL)}",
                "Mend its name; other columns are not read.",
            )
    rows: list[dict[str, str]] = [
        {str(name): str(value).strip() for name, value in row.items()} for row in table.to_dict("records")
    ]
    if not rows:
        refuse(path.name, "no lines", "a line per trial is needed")
    seen: dict[str, dict[object, int]] = {"trial": {}, "file": {}}
    for line, row in enumerate(rows, start=2):
        where = f"{path.name}, line {line}"
        key = (*_condition(row, where), whole_number_of(row["trial"], f"{where}: trial"))
        # Unconnected trials have no stiffness, and NaN equals nothing.
        same = (-1.0 if math.isnan(key[0]) else key[0], *key[1:])
        for name, value in (("trial", same), ("file", row["file"])):
            if value in seen[name]:
                refuse(
                    f"{where}: {name}",
                    row[name],
                    f"every {name} may stand there once, and this one stands in line {seen[name][value]}",
                    "Number the trials of a condition differently, or take one line away.",
                )
            seen[name][value] = line
        row["status"] = _status(row.get("status", ""), f"{where}: status")
    return rows


def _status(text: str, where: str) -> str:
    """Read how a trial ended; a word that is not known would silently take it out of all tests."""
    word = " ".join(text.casefold().replace("_", " ").split())
    if word and word not in STATUSES:
        near = difflib.get_close_matches(word, STATUSES, n=1, cutoff=0.7)
        refuse(
            where,
            text,
            f"one of {', '.join(STATUSES)} is needed; empty is completed",
            f"Write {near[0]}."
            if near
            else "A trial that ran to its end is completed, any other is stopped.",
        )
    return word


def _condition(row: Mapping[str, str], where: str) -> tuple[float, float]:
    text = row["stiffness_N_per_m"]
    stiffness = math.nan if text == "" else number_of(text, f"{where}: stiffness_N_per_m")
    if stiffness <= 0.0:
        refuse(
            f"{where}: stiffness_N_per_m",
            text,
            "a stiffness above 0 N/m is needed",
            "Leave it empty in the unconnected mode.",
        )
    delay = 0.0 if row["delay_s"] == "" else number_of(row["delay_s"], f"{where}: delay_s")
    if not 0.0 <= delay <= _LATEST:
        refuse(
            f"{where}: delay_s",
            row["delay_s"],
            f"a one-way delay from 0 to {_LATEST:g} s is needed",
            "Write it in s; 167 ms is 0.167.",
        )
    return stiffness, delay


def number_of(text: str, where: str) -> float:
    """Read a finite number of the list, or refuse it at its place `where`."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        refuse(where, text or "empty", "a number is needed")
    return value


def whole_number_of(text: str, where: str) -> int:
    """Read a whole number from 0, or refuse it at its place `where`."""
    if not text.isdecimal():
        refuse(where, text or "empty", "a whole number from 0 is needed", "Count the trials of a condition.")
    return int(text)


def read_trial(folder: Path, row: Mapping[str, str]) -> TrialFile:
    """Read the file of one trial.

    Parameters
    ----------
    folder
        Where the list stands; the file's name counts from there.
    row
        The trial's row of the list.

    Returns
    -------
    TrialFile
        Its samples.
    """
    name = row["file"]
    table = _read_csv(folder / name, name)
    columns = list(table.columns)
    wanted = [TIME, *columns_of("position")]
    for quantity in list(QUANTITIES)[1:]:
        if any(column.startswith(f"{quantity}_") for column in columns):
            wanted += columns_of(quantity)
    if any(column.startswith("target_") for column in columns):
        wanted += TARGET
    for column in wanted:
        if column not in columns:
            refuse(f"{name}: {column}", _near(column, columns), f"the column {column} is needed")
    if table.empty:
        refuse(
            name,
            "a header only",
            "a line per sample is needed",
            "Leave this trial away in the list, or record it again.",
        )
    for column in wanted:
        values = table[column]
        if values.dtype.kind not in "fi" or not np.isfinite(np.asarray(values, dtype=float)).all():
            import pandas as pd

            numbers = np.asarray(pd.to_numeric(values, errors="coerce"), dtype=float)
            line = int(np.argmin(np.isfinite(numbers)))
            text = str(values.iloc[line])
            refuse(
                f"{name}, line {line + 2}: {column}",
                "empty" if text == "nan" else text,
                "a number is needed in every line",
                "Leave lines without samples away; a decimal needs a point.",
            )
    time = np.asarray(table[TIME], dtype=float)
    _check_time(name, time)
    series = {
        quantity: np.asarray(table[list(columns_of(quantity))], dtype=float).reshape(-1, 2, 2)
        for quantity in QUANTITIES
        if columns_of(quantity)[0] in wanted
    }
    if TARGET[0] in wanted:
        series["target"] = np.asarray(table[list(TARGET)], dtype=float)
    if row.get("status", "") in ("", "completed"):
        for quantity in ("position", "target"):
            farthest = float(np.median(np.abs(series[quantity]))) if quantity in series else 0.0
            if farthest > _FARTHEST:
                refuse(
                    f"{name}: {quantity}",
                    f"typically {farthest:.4g}",
                    f"positions in m are needed, and no robot reaches {_FARTHEST:g} m",
                    "Divide by 1000 if they are in mm.",
                )
    return TrialFile(name, _condition(row, name), int(row["trial"]), row, time, series)


def _check_time(name: str, time: FloatArray) -> None:
    if len(time) < 2:
        refuse(name, f"{len(time)} samples", "at least two are needed")
    steps = np.diff(time)
    if not np.all(steps > 0.0):
        line = int(np.argmax(steps <= 0.0)) + 3
        refuse(
            f"{name}, line {line}: {TIME}",
            f"{time[line - 2]:.10g} after {time[line - 3]:.10g}",
            "time must increase from line to line",
            "Sort the samples, and take away those written twice.",
        )
    step = float(np.median(steps))
    if step > _SLOWEST:
        refuse(
            f"{name}: {TIME}",
            f"a sample every {step:g} s",
            f"samples at most {_SLOWEST:g} s apart are needed",
            "Divide by 1000 if the times are in ms.",
        )
    if not -step <= time[0] <= max(1.0, step):
        refuse(
            f"{name}: {TIME}",
            f"begins at {time[0]:.10g} s",
            "time must count from the start of the trial, where the target starts",
            "Subtract the time at which the trial started.",
        )
    if steps.max() > _LONGEST_GAP * step:
        line = int(np.argmax(steps)) + 3
        refuse(
            f"{name}, line {line}: {TIME}",
            f"{steps.max():.4g} s without a sample",
            f"a gap of up to {_LONGEST_GAP:g} samples ({_LONGEST_GAP * step:.4g} s) can be bridged",
            "Leave this trial away, or end it before the gap.",
        )
