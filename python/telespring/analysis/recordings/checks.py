"""Checks of recorded trials: columns, numbers, units, times and statuses; misleading values are refused."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._files import spelt_otherwise
from telespring._quantities import format_count, format_number, format_time
from telespring._types import FloatArray
from telespring.analysis.recordings.layout import (
    DYAD_COLUMNS,
    INDEX,
    INDEX_OPTIONAL,
    INDEX_REQUIRED,
    SI,
    STATUSES,
    TIME,
)

if TYPE_CHECKING:
    from telespring._tables import TextTable

_LAYOUT_HELP = "`telespring analyse --template DIR` writes an example of the layout."

#: A gap longer than this many samples is not interpolated.
_LONGEST_GAP = 5.0
#: No planar robot reaches that far, m; a position in mm would.
_LARGEST_POSITION = 5.0
#: Nobody samples a trial that slowly, s; a time in ms would look like it.
_LARGEST_STEP = 0.5
#: No coupling has that delay, s; a delay in ms would.
_LARGEST_DELAY = 10.0


def refuse(field: str, value: str, allowed: str, remedy: str = _LAYOUT_HELP) -> NoReturn:
    """Refuse a file of recorded trials, or one of its values."""
    raise InvalidInput(field, value, allowed, remedy)


def check_trial_files(folder: Path, files: Mapping[str, str]) -> None:
    """Refuse a list of trials in which a file, by the place of its line, is missing.

    The most similar file of the folder that the list does not name is suggested.
    """
    for place, file in files.items():
        if not file:
            refuse(
                f"{place}: file", "empty", "the name of a file is required", "Write it, or remove the line."
            )
        path = spelt_otherwise(folder / file)
        if path.is_file():
            continue
        if path.exists():
            refuse(f"{place}: file", file, "this is no file", "Write the name of the trial's file.")
        missing = [each for each in files.values() if not spelt_otherwise(folder / each).is_file()]
        unlisted = {each.name for each in folder.glob("*") if each.is_file()} - {INDEX, *files.values()}
        similar = difflib.get_close_matches(file, sorted(unlisted), n=1, cutoff=0.7)
        more = f", and {len(missing) - 1} more of the list are missing" if len(missing) > 1 else ""
        refuse(
            f"{place}: file",
            file,
            f"this file is not in the folder {folder.resolve()}{more}",
            f"Did you mean {similar[0]}? Otherwise copy it there, or remove the line."
            if similar
            else "Copy it there, or remove the line.",
        )


def check_required_columns(file: str, columns: Sequence[str], required: Sequence[str]) -> None:
    """Refuse a recorded file that lacks a column; name the most similar one that it has."""
    for name in required:
        if name not in columns:
            # without the unit
            stem = name if name in ("file", "trial") else name.rsplit("_", 1)[0]
            similar = [column for column in columns if column.startswith(stem) or stem.startswith(column)]
            similar = similar or difflib.get_close_matches(name, columns, n=1)
            value = f"missing; {similar[0]} is there instead" if similar else "missing"
            refuse(f"{file}: {name}", value, f"the column {name} is required")


def check_units_below_names(file: str, table: TextTable) -> None:
    """Refuse a line of units that contradicts the names of its columns."""
    for column, unit in zip(table.names, table.units, strict=False):
        given = unit.strip("[](){}<> ")
        named = [SI[suffix] for suffix in SI if column.endswith(f"_{suffix}")]
        if given and named and given not in named:
            refuse(
                f"{file}: {column}",
                f"in {given}",
                f"the name says {named[0]}, and units are not converted",
                "Convert the numbers, or correct the line of units.",
            )


def check_index_columns(file: str, columns: Sequence[str]) -> None:
    """Refuse a list of trials that lacks a column or misspells an optional one."""
    check_required_columns(file, columns, INDEX_REQUIRED)
    for name in columns:
        if name not in (*INDEX_REQUIRED, *INDEX_OPTIONAL) and difflib.get_close_matches(
            name, INDEX_OPTIONAL, n=1, cutoff=0.8
        ):
            refuse(
                f"{file}: {name}",
                "unknown",
                f"the optional columns are {', '.join(INDEX_OPTIONAL)}",
                "Correct its name; other columns are not read.",
            )


def parse_trial_status(text: str, field: str) -> str:
    """Parse the status in the list of trials; an unknown word would silently exclude it from all tests."""
    status = " ".join(text.casefold().replace("_", " ").split())
    if status and status not in STATUSES:
        similar = difflib.get_close_matches(status, STATUSES, n=1, cutoff=0.7)
        refuse(
            field,
            text,
            f"one of {', '.join(STATUSES)} is required; empty means completed",
            f"Write {similar[0]}."
            if similar
            else "Write completed if the trial ran to its end, otherwise stopped.",
        )
    return status or "completed"


def parse_condition_stiffness(text: str, field: str) -> float | None:
    """Parse the stiffness in the list of trials, N/m; empty (None) in the unconnected mode."""
    stiffness = None if text == "" else parse_number(text, field)
    if stiffness is not None and stiffness <= 0.0:
        refuse(field, text, "a stiffness above 0 N/m is required", "Leave it empty in the unconnected mode.")
    return stiffness


def parse_condition_delay(text: str, field: str) -> float:
    """Parse the one-way delay in the list of trials, s; empty means 0."""
    delay = 0.0 if text == "" else parse_number(text, field)
    if not 0.0 <= delay <= _LARGEST_DELAY:
        refuse(
            field,
            text,
            f"a one-way delay from 0 to {_LARGEST_DELAY:g} s is required",
            "Write it in s; 167 ms is 0.167.",
        )
    return delay


def parse_dyad(row: Mapping[str, str], field: str) -> str | None:
    """Parse the label of the dyad (or participant) in the list of trials; None without such a column."""
    present = [column for column in DYAD_COLUMNS if column in row]
    if len(present) > 1:
        refuse(
            f"{field}: {present[1]}",
            f"beside {present[0]}",
            "only one of these columns may be there",
            "Keep the one whose trials are dependent: usually the dyad.",
        )
    if present and not row[present[0]]:
        refuse(
            f"{field}: {present[0]}",
            "empty",
            "a label in every line is required",
            "Label every trial, or remove the column.",
        )
    return row[present[0]] if present else None


def parse_number(text: str, field: str) -> float:
    """Parse a finite number of the list of trials."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        refuse(field, text or "empty", "a number is required")
    return value


def parse_whole_number(text: str, field: str, remedy: str) -> int:
    """Parse a whole number of 0 or more of the list of trials; a table may write 1 as 1.0."""
    whole, point, zeros = text.partition(".")
    if not whole.isdecimal() or zeros.strip("0") or (point and not zeros):
        refuse(field, text or "empty", "a whole number of 0 or more is required", remedy)
    return int(whole)


def check_recorded_samples(file: str, table: TextTable, columns: Sequence[str]) -> None:
    """Refuse a trial without samples, or with a field that is not a finite number."""
    if not len(table):
        refuse(
            file,
            "only a header",
            "a line per sample is required",
            "Remove this trial from the list, or record it again.",
        )
    for column in columns:
        place = table.names.index(column)
        wrong = np.flatnonzero(~np.isfinite(table.numbers(place)))
        if not wrong.size:
            continue
        text = str(table.columns[place].iloc[int(wrong[0])])
        remedy = f"Remove such lines ({wrong.size} of {len(table)}): small gaps are bridged."
        if wrong.size == len(table):
            remedy = "The whole column is so: correct it, or remove it if it is optional."
        refuse(
            f"{file}, line {table.lines[wrong[0]]}: {column}",
            "empty" if text.strip() in ("", "nan", "NaN") else text,
            "a number is required in every line",
            remedy,
        )


def check_recorded_times(file: str, time: FloatArray, lines: NDArray[np.int_]) -> None:
    """Refuse sample times that do not increase, seem to be in ms, start late or leave a long gap.

    `lines` are the numbers of their lines in the file.
    """
    if len(time) < 2:
        refuse(file, format_count(len(time), "sample"), "at least two are required")
    steps = np.diff(time)
    if not np.all(steps > 0.0):
        later = int(np.argmax(steps <= 0.0)) + 1
        refuse(
            f"{file}, line {lines[later]}: {TIME}",
            f"{time[later]:.10g} after {time[later - 1]:.10g}",
            "time must increase from line to line",
            "Sort the samples, and remove duplicates.",
        )
    step = float(np.median(steps))
    if step > _LARGEST_STEP:
        refuse(
            f"{file}: {TIME}",
            f"a sample every {format_time(step, 6)}",
            f"samples at most {_LARGEST_STEP:g} s apart are required",
            "Divide by 1000 if the times are in ms.",
        )
    if not -step <= time[0] <= max(1.0, step):
        refuse(
            f"{file}: {TIME}",
            f"begins at {time[0]:.10g} s",
            "time must count from the start of the trial, where the target starts",
            "Subtract the time at which the trial started.",
        )
    if steps.max() > _LONGEST_GAP * step:
        refuse(
            f"{file}, line {lines[int(np.argmax(steps)) + 1]}: {TIME}",
            f"{format_time(steps.max())} without a sample",
            f"gaps of up to {_LONGEST_GAP:g} samples ({format_time(_LONGEST_GAP * step)}) are allowed",
            "Remove this trial, or end it before the gap.",
        )


def check_recorded_metres(file: str, quantity: str, values: FloatArray) -> None:
    """Refuse recorded positions that seem to be in mm."""
    typical = float(np.median(np.abs(values)))
    if typical > _LARGEST_POSITION:
        refuse(
            f"{file}: {quantity}",
            f"typically {format_number(typical, 2)}",
            f"positions in m are required, and no robot reaches {_LARGEST_POSITION:g} m",
            "Divide by 1000 if they are in mm.",
        )
