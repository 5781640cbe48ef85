"""Write trials as CSV in the layout of recorded trials: an experiment, or an example for a lab."""

from __future__ import annotations

import math
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._files import replacing, write_whole
from telespring.analysis.identifiers import trial_dyads, trial_files, trial_numbers
from telespring.analysis.layout import PER_SAMPLE, check_layout, trial_statuses
from telespring.analysis.recordings.layout import (
    AXES,
    INDEX,
    QUANTITIES,
    STUDY,
    TARGET,
    TIME,
    recorded_columns,
)
from telespring.model import Study
from telespring.study.conditions import condition_label
from telespring.study.target import target_positions

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["write_recorded", "write_template"]


def write_recorded(dataset: xr.Dataset, folder: str | os.PathLike[str]) -> Path:
    """Write trials as CSV files, one per trial, and the list of them.

    Parameters
    ----------
    dataset : xarray.Dataset
        Trials in the layout that `telespring.analysis.Trials.from_dataset` describes.
    folder : path
        Destination; created if missing. It must not contain a list of trials yet. The files are named as
        before, where their names are known.

    Returns
    -------
    pathlib.Path
        The list, ``trials.csv``. It is written last, so a folder with a list is complete. Reading it back
        gives the same numbers.

    Raises
    ------
    telespring.InvalidInput
        If the folder already contains a list of trials, or a trial's file.
    OSError
        If the folder cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from telespring.analysis import read_recorded
    >>> place = tempfile.mkdtemp()
    >>> trials = read_recorded(write_template(place + "/example"))
    >>> copy = read_recorded(write_recorded(trials, place + "/copy"))
    >>> trials.identical(copy)
    True
    """
    import pandas as pd

    place = Path(folder)
    index = place / INDEX
    if index.exists():
        raise InvalidInput(
            "folder",
            str(place),
            f"a folder without {INDEX} is required",
            "Choose another folder, or remove that file.",
        )
    dataset = check_layout(dataset)
    study = place / STUDY
    text = str(dataset.attrs.get("study", ""))
    if text and study.exists() and study.read_bytes() != text.encode():
        raise InvalidInput(
            "folder",
            str(place),
            f"a folder without another {STUDY} is required: the trials bring theirs",
            "Choose another folder, or rename that file.",
        )
    status = trial_statuses(dataset)
    numbers, dyads = trial_numbers(dataset, status), trial_dyads(dataset, status)
    _check_trial_numbers(dataset, numbers, dyads, status)
    columns = _trial_file_columns(dataset)
    files = _file_names(dataset, status)
    for file in files.values():
        if (place / file).exists():
            raise InvalidInput(
                "folder",
                str(place),
                f"a folder without {file} is required, so that no recording is replaced",
                "Choose another folder, or remove that file.",
            )
    has_position = dataset["position"].notnull().all(["robot", "axis"])
    rows: list[dict[str, Any]] = []
    for i, j in np.argwhere(status != "absent").tolist():
        trial = dataset.isel(condition=i, trial=j)
        stiffness, delay = float(trial["stiffness"]), float(trial["delay"])
        file = files[i, j]
        # Nothing was recorded after the end of a trial.
        recorded = np.flatnonzero(has_position.isel(condition=i, trial=j))
        samples = columns.isel(condition=i, trial=j, time=slice(recorded[-1] + 1 if len(recorded) else None))
        with replacing(place / file) as beside:
            samples.to_dataframe()[list(columns)].to_csv(beside, index_label=TIME, lineterminator="\n")
        row: dict[str, Any] = {
            "file": file,
            "stiffness_N_per_m": stiffness,
            "delay_s": delay,
            "trial": int(numbers[i, j]),
            "status": status[i, j],
        }
        if dyads is not None:
            row["dyad"] = dyads[i, j]
        if "ended_at" in trial.variables:
            row["ended_at_s"] = float(trial["ended_at"])
        if "seed" in trial.variables and trial["seed"].dtype.kind in "iu":
            # As a float, after a join, a seed has lost digits.
            row["seed"] = int(trial["seed"])
        if "discard" in trial.attrs:
            row["discard_s"] = float(trial.attrs["discard"])
        rows.append(row)
    if "study" in dataset.attrs:
        write_whole(place / STUDY, dataset.attrs["study"])
    return write_whole(index, pd.DataFrame(rows).to_csv(index=False, lineterminator="\n"))


def _file_names(dataset: xr.Dataset, status: NDArray[np.str_]) -> dict[tuple[int, int], str]:
    """Name the file of every trial as it was, where all of these names can be used in one folder again."""
    places = [(int(i), int(j)) for i, j in np.argwhere(status != "absent")]
    known = trial_files(dataset)
    if known is not None:
        names = {place: str(known[place]) for place in places}
        are_plain = all(
            re.fullmatch(r"\w[\w .+-]*\.csv", name, re.IGNORECASE) and name.casefold() != INDEX
            for name in names.values()
        )
        if are_plain and len({name.casefold() for name in names.values()}) == len(names):
            return names
    settings = list(zip(dataset["stiffness"].values.tolist(), dataset["delay"].values.tolist(), strict=True))
    return {(i, j): f"{condition_label(*settings[i])}-{i + 1:02d}-{j + 1:03d}.csv" for i, j in places}


def _check_trial_numbers(
    dataset: xr.Dataset, numbers: NDArray[Any], dyads: NDArray[np.str_] | None, status: NDArray[np.str_]
) -> None:
    """Refuse trials that the list could not tell apart: it has stiffness, delay, dyad and number."""
    remedy = "Number the trials: dataset.assign_coords(trial=range(1, dataset.sizes['trial'] + 1))."
    if numbers.dtype.kind not in "iu" or numbers.min() < 0:
        raise InvalidInput(
            "trial",
            str(numbers.flat[0]),
            "whole numbers of 0 or more are required in a list of trials",
            remedy,
        )
    listed = set()
    for i, j in np.argwhere(status != "absent").tolist():
        # Text, as NaN is not equal to itself.
        setting = str(float(dataset["stiffness"][i])), float(dataset["delay"][i])
        key = (*setting, "" if dyads is None else str(dyads[i, j]), int(numbers[i, j]))
        if key in listed:
            raise InvalidInput(
                "trial",
                str(numbers[i, j]),
                "every number may occur only once in a condition (once per dyad), and a list tells "
                "conditions apart by stiffness and delay",
                remedy,
            )
        listed.add(key)


def _trial_file_columns(dataset: xr.Dataset) -> xr.Dataset:
    """Flatten robots and axes into the columns of a trial's file, over (condition, trial, time)."""
    import xarray as xr

    columns = {name: dataset["target"].isel(axis=axis, drop=True) for axis, name in enumerate(TARGET)}
    for quantity in QUANTITIES:
        if quantity in dataset.variables:
            for place, name in enumerate(recorded_columns(quantity)):
                robot, axis = divmod(place, len(AXES))
                columns[name] = dataset[quantity].isel(robot=robot, axis=axis, drop=True)
    return xr.Dataset(columns, coords={"time": dataset["time"]})


def write_template(folder: str | os.PathLike[str]) -> Path:
    """Write an example of recorded trials, to be replaced by a lab's own.

    Parameters
    ----------
    folder : path
        Destination; created if missing.

    Returns
    -------
    pathlib.Path
        The list of the trials. Two conditions with three trials each of the paper's task, 6 s at 100 Hz;
        robot 1 lags behind the target by about 60 ms, robot 2 by about 120 ms.

    Raises
    ------
    telespring.InvalidInput
        If the folder already contains a list of trials.
    OSError
        If the folder cannot be written.
    """
    import xarray as xr

    time = np.arange(601) / 100.0
    experiment = Study.paper().experiment
    assert experiment is not None
    task = experiment.task
    target = target_positions(task, time)
    lags = np.array([[0.060, 0.120], [0.070, 0.110]])[:, None, :] + np.array([0.0, 0.004, 0.008])[:, None]
    position = np.stack(
        [
            [np.stack([target_positions(task, time - lag) for lag in trial], axis=1) for trial in condition]
            for condition in lags
        ]
    ).round(6)
    extension = position[..., ::-1, :] - position
    # Unconnected first, then the spring; adding 0 below turns −0 into 0.
    force = 36.0 * extension * np.array([0.0, 1.0])[:, None, None, None, None]
    return write_recorded(
        xr.Dataset(
            {
                "position": (PER_SAMPLE, position),
                "coupling_force": (PER_SAMPLE, force.round(6) + 0.0),
                "target": (("time", "axis"), target.round(6)),
            },
            coords={
                "stiffness": ("condition", [math.nan, 36.0]),
                "delay": ("condition", [0.0, 0.167]),
                "time": ("time", time),
                "robot": ("robot", [1, 2]),
                "axis": ("axis", list(AXES)),
            },
            attrs={"discard": 1.0},
        ),
        folder,
    )
