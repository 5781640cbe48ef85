"""The columns of a log that a user names: found, and checked for length, unit and quantity."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification.log_formats import LogColumns
from telespring.identification.warning_messages import Diagnostic, diagnostic

__all__ = [
    "check_column_lengths",
    "check_column_numbers",
    "find_column",
    "refuse_column_without_numbers",
    "suspect_force_columns",
    "words_among_numbers",
]

#: A force column whose name has one of these as a word is probably not a force.
_OTHER_QUANTITIES = {"v", "volt", "volts", "voltage", "vir", "u", "current", "amp", "amps", "mv", "ma", "pwm"}
#: SI units as a line of units below the names spells them, and what other units are worth.
_SPELLINGS = {
    "time": ("s", "sec", "second", "seconds"),
    "position": ("m", "meter", "metre", "meters", "metres"),
    "force": ("n", "newton", "newtons"),
}
#: A unit in brackets, or behind a stroke, at the end of a name: "x [mm]", "x / mm".
_UNIT_IN_NAME = re.compile(r"[\[(/]\s*(\w+)\s*[\])]?$")
_PREFIXES = {"k": 1e3, "c": 0.01, "m": 1e-3, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "n": 1e-9}


def find_column(log: LogColumns, option: str, name: str, scale: float) -> str:
    """Return the column that an option names; refuse one that is missing, of two, or in another unit."""
    if name.strip() in log.ambiguous:
        raise InvalidInput(
            f"--{option}",
            name,
            f"{log.file} has several columns of this name",
            "Choose it by its number, counted from 1.",
        )
    found = log.find(name)
    if found is None:
        longest = max((np.size(values) for values in log.columns.values()), default=0)
        available = ", ".join(
            other for other in log.columns if longest < 2 or np.size(log.columns[other]) > 1
        )
        if log.has_names:
            allowed, remedy = (
                f"the columns of {log.file} are: {available}",
                f"Name the {option} column with --{option}.",
            )
        else:
            allowed = f"{log.file} does not name its {len(log.columns)} columns"
            remedy = "Number them from 1, for example --time 1 --position 2,3 --force 4,5."
        if option == "time":
            remedy += " If the log has no times, give its sample rate with --rate."
        raise InvalidInput(f"--{option}", name, allowed, remedy)
    unit = log.units.get(found, "").strip("[](){}<> ")
    spellings = _SPELLINGS.get(option, ())
    in_name = _UNIT_IN_NAME.search(found)
    if not unit and in_name and in_name[1][1:].lower() in spellings and in_name[1][:1] in _PREFIXES:
        unit = in_name[1]
    if scale == 1.0 and unit and spellings and unit.lower() not in spellings:
        prefix = _PREFIXES.get(unit[:1]) if unit[1:].lower() in spellings else None
        value = f"{prefix:g}" if prefix else f"the {option} in SI units per {unit}"
        raise InvalidInput(
            f"--{option}",
            f"{found} in {unit}",
            f"the file says that it is not in {spellings[0] if option != 'force' else 'N'}",
            f"Give --{option}-scale {value}.",
        )
    return found


def check_column_lengths(log: LogColumns, names: Sequence[str]) -> None:
    """Refuse columns without samples, or of different lengths."""
    sizes = {name: np.size(log.columns[name]) for name in names}
    if 0 in sizes.values():
        raise InvalidInput(
            "log",
            log.file,
            "a log with one row per sample is required, but this one contains no samples",
            "Check that the recording was saved; the file has only its first line.",
        )
    first, length = next(iter(sizes.items()))
    for name, size in sizes.items():
        if size != length:
            raise InvalidInput(
                "log",
                f"{name}, {size} values",
                f"one value per sample is required, and {first} has {length}",
                "Name a column that was recorded with every sample.",
            )


def check_column_numbers(names: Sequence[str], values: FloatArray, option: str) -> None:
    """Refuse a column without a number."""
    for name, column in zip(names, values.T, strict=True):
        if column.size > 1 and np.isnan(column).all():
            raise refuse_column_without_numbers(option, name)


def words_among_numbers(log: LogColumns, names: Sequence[str]) -> list[Diagnostic]:
    """Find texts between the numbers of a column."""
    import pandas as pd

    found = []
    for name in names:
        column = pd.Series(log.columns[name])
        words = column[np.isnan(log.numbers(name)) & column.notna().to_numpy()].astype("str").str.strip()
        words = words[words != ""]
        if len(words) and column.dtype.kind not in "biufMm":
            found.append(
                diagnostic("words among numbers", column=name, count=len(words), word=words.iloc[0][:30])
            )
    return found


def suspect_force_columns(log: LogColumns, force: Sequence[str], scale: float) -> list[Diagnostic]:
    """Find a force column in other units that no scale converts, and scalars that may be the scale."""
    suspects = [name for name in force if set(name.lower().replace("[", "_").split("_")) & _OTHER_QUANTITIES]
    if scale != 1.0 or not suspects:
        return []
    scalars = ", ".join(name for name, values in log.columns.items() if np.size(values) == 1)
    return [diagnostic("suspect force column", column=suspects[0], scalars=scalars or "none")]


def refuse_column_without_numbers(option: str, name: str) -> InvalidInput:
    """Return the refusal of a column without a number."""
    return InvalidInput(
        f"--{option}",
        name,
        "a column of numbers is required, but this one contains none",
        "Name another column.",
    )
