"""Read recorded trials from CSV: the list of trials, and one file per trial."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._files import spelt_otherwise
from telespring._tables import TextTable, read_text_table
from telespring._types import FloatArray
from telespring.analysis.recordings import checks
from telespring.analysis.recordings.assembly import RecordedTrial, TrialEntry, assemble_dataset
from telespring.analysis.recordings.layout import INDEX, QUANTITIES, STUDY, TARGET, TIME, recorded_columns

if TYPE_CHECKING:
    import xarray as xr

    from telespring.model import Task

__all__ = ["read_recorded"]

#: Columns of the list of trials that are numbers.
_NUMBERS = ("stiffness_N_per_m", "delay_s", "trial", "ended_at_s", "seed", "discard_s")


def read_recorded(path: str | os.PathLike[str], task: Task | Mapping[str, Any] | None = None) -> xr.Dataset:
    """Read recorded trials into the layout of a rehearsal.

    Parameters
    ----------
    path : path
        A folder that contains ``trials.csv``, or that file.
    task : telespring.Task or mapping, optional
        A study's task, which gives the target if the files have none.

    Returns
    -------
    xarray.Dataset
        In the layout of `telespring.analysis.Trials.from_dataset`: conditions in the order in which the
        list first names them, trials by their number. If all trials share their sample times, the samples
        are unchanged. Otherwise all trials are resampled to one grid by linear interpolation, and
        ``attrs["resampled_to"]`` is its period, s.

    Raises
    ------
    telespring.InvalidInput
        If a column is missing, a unit seems wrong, a trial is listed twice, time does not increase, or a
        value is not a number.
    OSError
        If a file cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> from telespring.analysis import write_template
    >>> index = write_template(tempfile.mkdtemp() + "/lab")
    >>> read_recorded(index).condition.values.tolist()
    ['UM', 'CM-36-167']
    """
    place = Path(path)
    index = spelt_otherwise(place / INDEX) if place.is_dir() else place
    entries = _read_list_of_trials(index)
    checks.check_trial_files(index.parent, {entry.place: entry.file for entry in entries})
    trials = [_read_recorded_trial(index.parent, entry) for entry in entries]
    study = spelt_otherwise(index.parent / STUDY)
    return assemble_dataset(trials, task, study.read_text(encoding="utf-8-sig") if study.is_file() else None)


def recorded_files(path: Path) -> list[Path]:
    """List the files of recorded trials: their list, the study beside it if there is one, and the trials."""
    index = spelt_otherwise(path / INDEX) if path.is_dir() else path
    study = spelt_otherwise(index.parent / STUDY)
    files = [spelt_otherwise(index.parent / entry.file) for entry in _read_list_of_trials(index)]
    return [index, *([study] if study.is_file() else []), *files]


def _read_list_of_trials(path: Path) -> list[TrialEntry]:
    """Read the list of trials; no trial and no file may be listed twice."""
    table = _read_recorded_csv(path, path.name, text=True)
    checks.check_index_columns(path.name, table.names)
    lines = table.lines.tolist()
    entries = [
        _parse_trial_entry(
            {column: str(text).strip() for column, text in zip(table.names, row, strict=True)},
            f"{path.name}, line {line}",
            table.decimal,
        )
        for line, row in zip(lines, table.columns.itertuples(index=False), strict=True)
    ]
    if not entries:
        checks.refuse(path.name, "no lines", "a line per trial is required")
    listed: dict[str, dict[object, int]] = {"trial": {}, "file": {}}
    for line, entry in zip(lines, entries, strict=True):
        keys = {"trial": (entry.stiffness, entry.delay, entry.dyad, entry.number), "file": entry.file}
        for column, key in keys.items():
            if key in listed[column]:
                checks.refuse(
                    f"{path.name}, line {line}: {column}",
                    str(entry.number if column == "trial" else entry.file),
                    f"every {column} may be listed only once, and line {listed[column][key]} lists this one",
                    "Give the trials of a condition (of a dyad in it, if there are several) different "
                    "numbers, or remove one of the lines.",
                )
            listed[column][key] = line
    if len({entry.discard for entry in entries}) > 1:
        values = sorted({str(entry.discard) for entry in entries})
        checks.refuse(f"{path.name}: discard_s", " and ".join(values), "one value for all trials is required")
    return entries


def _parse_trial_entry(texts: Mapping[str, str], field: str, decimal: str) -> TrialEntry:
    """Parse one line of the list of trials, whose decimals have this mark."""
    row = {
        column: text.replace(decimal, ".") if decimal != "." and column in _NUMBERS else text
        for column, text in texts.items()
    }
    ended_at: float | None = None
    if "ended_at_s" in row:
        text = row["ended_at_s"]
        ended_at = checks.parse_number(text, f"{field}: ended_at_s") if text else math.nan
    no_seed = f"Remove the column seed from {INDEX}: only simulated trials have seeds."
    return TrialEntry(
        file=row["file"],
        stiffness=checks.parse_condition_stiffness(row["stiffness_N_per_m"], f"{field}: stiffness_N_per_m"),
        delay=checks.parse_condition_delay(row["delay_s"], f"{field}: delay_s"),
        number=checks.parse_whole_number(
            row["trial"], f"{field}: trial", "Number the trials of a condition."
        ),
        status=checks.parse_trial_status(row.get("status", ""), f"{field}: status"),
        ended_at=ended_at,
        seed=checks.parse_whole_number(row["seed"], f"{field}: seed", no_seed) if "seed" in row else None,
        discard=checks.parse_number(row["discard_s"], f"{field}: discard_s") if "discard_s" in row else None,
        dyad=checks.parse_dyad(row, field),
        place=field,
    )


def _read_recorded_trial(folder: Path, entry: TrialEntry) -> RecordedTrial:
    """Read the samples of one trial from its file."""
    table = _read_recorded_csv(spelt_otherwise(folder / entry.file), entry.file)
    present = table.names
    quantities = [
        quantity
        for quantity in QUANTITIES
        if quantity == "position" or any(column.startswith(f"{quantity}_") for column in present)
    ]
    columns = [TIME, *(column for quantity in quantities for column in recorded_columns(quantity))]
    has_target = any(column.startswith("target_") for column in present)
    columns += TARGET if has_target else ()
    checks.check_required_columns(entry.file, present, columns)
    checks.check_recorded_samples(entry.file, table, columns)
    numbers = {column: table.numbers(present.index(column)) for column in columns}
    time = numbers[TIME]
    checks.check_recorded_times(entry.file, time, table.lines)

    def stack(names: Sequence[str]) -> FloatArray:
        return np.column_stack([numbers[name] for name in names])

    series = {quantity: stack(recorded_columns(quantity)).reshape(-1, 2, 2) for quantity in quantities}
    if has_target:
        series["target"] = stack(TARGET)
    if entry.status == "completed":
        for quantity in series.keys() & {"position", "target"}:
            checks.check_recorded_metres(entry.file, quantity, series[quantity])
    return RecordedTrial(entry, time, series)


def _read_recorded_csv(path: Path, name: str, *, text: bool = False) -> TextTable:
    """Read a CSV file of recorded trials with its numbers exact, or all as text."""
    table = read_text_table(path, name, as_texts=text)
    if not table.has_names:
        checks.refuse(name, "no column names", "a line of column names above the numbers is required")
    for column in table.names:
        if column and table.names.count(column) > 1:
            checks.refuse(f"{name}: {column}", "twice", "every column name may stand only once")
    checks.check_units_below_names(name, table)
    return table
