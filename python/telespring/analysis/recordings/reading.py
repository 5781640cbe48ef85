"""Read recorded trials from CSV: the list of trials, and one file per trial."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._types import FloatArray
from telespring.analysis.recordings import checks
from telespring.analysis.recordings.assembly import RecordedTrial, TrialEntry, assemble_dataset
from telespring.analysis.recordings.layout import INDEX, QUANTITIES, STUDY, TARGET, TIME, recorded_columns

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from telespring.model import Task

__all__ = ["read_recorded"]


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
    index = place / INDEX if place.is_dir() else place
    trials = [_read_recorded_trial(index.parent, entry) for entry in _read_list_of_trials(index)]
    study = index.parent / STUDY
    return assemble_dataset(trials, task, study.read_text(encoding="utf-8") if study.is_file() else None)


def _read_list_of_trials(path: Path) -> list[TrialEntry]:
    """Read the list of trials; no trial and no file may be listed twice."""
    table = _read_recorded_csv(path, path.name, text=True)
    checks.check_index_columns(path.name, list(table.columns))
    entries = [
        _parse_trial_entry(
            {str(column): str(text).strip() for column, text in row.items()}, f"{path.name}, line {line}"
        )
        for line, row in enumerate(table.to_dict("records"), start=2)
    ]
    if not entries:
        checks.refuse(path.name, "no lines", "a line per trial is required")
    listed: dict[str, dict[object, int]] = {"trial": {}, "file": {}}
    for line, entry in enumerate(entries, start=2):
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


def _parse_trial_entry(row: Mapping[str, str], field: str) -> TrialEntry:
    """Parse one line of the list of trials."""
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
    )


def _read_recorded_trial(folder: Path, entry: TrialEntry) -> RecordedTrial:
    """Read the samples of one trial from its file."""
    table = _read_recorded_csv(folder / entry.file, entry.file)
    present = list(table.columns)
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
    time = np.asarray(table[TIME], dtype=float)
    checks.check_recorded_times(entry.file, time)
    series: dict[str, FloatArray] = {
        quantity: np.asarray(table[list(recorded_columns(quantity))], dtype=float).reshape(-1, 2, 2)
        for quantity in quantities
    }
    if has_target:
        series["target"] = np.asarray(table[list(TARGET)], dtype=float)
    if entry.status == "completed":
        for quantity in series.keys() & {"position", "target"}:
            checks.check_recorded_metres(entry.file, quantity, series[quantity])
    return RecordedTrial(entry, time, series)


def _read_recorded_csv(path: Path, name: str, *, text: bool = False) -> pd.DataFrame:
    """Read a CSV file of recorded trials with its numbers exact, or all as text."""
    import pandas as pd

    try:
        if text:
            table = pd.read_csv(path, dtype=str, keep_default_na=False, encoding="utf-8-sig")
        else:
            # Since pandas 3.1 decimals are always read exactly, and the option is gone.
            is_exact = tuple(int(part) for part in pd.__version__.split(".")[:2]) >= (3, 1)
            precision: dict[str, Any] = {} if is_exact else {"float_precision": "round_trip"}
            table = pd.read_csv(path, encoding="utf-8-sig", **precision)
    except UnicodeDecodeError:
        checks.refuse(name, "not UTF-8", "a text file in UTF-8 is required", "Save it as CSV UTF-8.")
    except pd.errors.EmptyDataError:
        checks.refuse(name, "empty", "a line of column names and a line per sample are required")
    except pd.errors.ParserError as error:
        reason = str(error).removeprefix("Error tokenizing data. C error: ").strip()
        checks.refuse(name, reason, "every line must have as many fields as there are column names")
    table.columns = [str(column).strip() for column in table.columns]
    if len(table.columns) == 1 and ";" in table.columns[0]:
        checks.refuse(
            name,
            "separated by semicolons",
            "columns must be separated by commas, and decimals written with a point",
            "Export it with commas between columns and decimal points.",
        )
    return table
