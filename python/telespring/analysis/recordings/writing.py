"""Write trials as a lab would record them, from a rehearsal or as an example to start from."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._errors import InvalidInput
from telespring._files import replacing, write_whole
from telespring.analysis.recordings.layout import AXES, INDEX, QUANTITIES, TARGET, TIME, columns_of
from telespring.analysis.recordings.reading import target_of
from telespring.analysis.trials import status_of
from telespring.study.conditions import condition_label

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["write_recorded", "write_template"]


def write_recorded(dataset: xr.Dataset, folder: str | os.PathLike[str]) -> Path:
    """Write trials as CSV files, one per trial, and the list of them.

    Parameters
    ----------
    dataset : xarray.Dataset
        Trials, as `telespring.analysis.take_trials` describes them.
    folder : path
        Where to; made where it is missing. It may not hold such a list already.

    Returns
    -------
    pathlib.Path
        The list, ``trials.csv``. It is written last, so that a folder with a list is whole. Reading it
        back gives the same numbers.

    Raises
    ------
    telespring.InvalidInput
        Where the folder holds a list already.
    OSError
        Where the folder cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from telespring.analysis import read_recorded
    >>> place = tempfile.mkdtemp()
    >>> trials = read_recorded(write_template(place + "/example"))
    >>> again = read_recorded(write_recorded(trials, place + "/copy"))
    >>> trials.identical(again)
    True
    """
    import pandas as pd

    place = Path(folder)
    index = place / INDEX
    if index.exists():
        raise InvalidInput(
            "folder", str(place), f"a folder without {INDEX} is needed", "Choose another, or remove that one."
        )
    shape = (dataset.sizes["condition"], dataset.sizes["trial"])
    status = status_of(dataset, shape)
    order = ("condition", "trial", "time", "robot", "axis")
    present = [
        name for name in QUANTITIES if name in dataset.variables and set(order) == set(dataset[name].dims)
    ]
    arrays = {name: np.asarray(dataset[name].transpose(*order)) for name in present}
    target = np.asarray(
        dataset["target"].transpose("condition", "trial", "time", "axis")
        if "condition" in dataset["target"].dims
        else dataset["target"].transpose("time", "axis")
    )
    time = np.asarray(dataset["time"])
    rows: list[dict[str, Any]] = []
    for i in range(shape[0]):
        stiffness, delay = float(dataset["stiffness"][i]), float(dataset["delay"][i])
        for j in range(shape[1]):
            if status[i, j] == "absent":
                continue
            finite = np.isfinite(arrays["position"][i, j]).all(axis=(-2, -1))
            # What a trial has up to its end; nothing after it was recorded.
            count = len(finite) - int(finite[::-1].argmax())
            columns = {TIME: time[:count]}
            goal = target if target.ndim == 2 else target[i, j]
            columns |= {name: goal[:count, axis] for axis, name in enumerate(TARGET)}
            for quantity in present:
                flat = arrays[quantity][i, j, :count].reshape(count, -1)
                columns |= {name: flat[:, k] for k, name in enumerate(columns_of(quantity))}
            name = f"{condition_label(stiffness, delay)}-{i + 1:02d}-{j + 1:03d}.csv"
            with replacing(place / name) as beside:
                pd.DataFrame(columns).to_csv(beside, index=False, lineterminator="\n")
            row: dict[str, Any] = {
                "file": name,
                "stiffness_N_per_m": "" if math.isnan(stiffness) else repr(stiffness),
                "delay_s": repr(delay),
                "trial": j + 1,
                "status": status[i, j],
            }
            if "ended_at" in dataset.variables:
                ended = float(dataset["ended_at"].transpose("condition", "trial")[i, j])
                row["ended_at_s"] = "" if math.isnan(ended) else repr(ended)
            if "seed" in dataset.variables:
                row["seed"] = int(dataset["seed"].transpose("condition", "trial")[i, j])
            if "discard" in dataset.attrs:
                row["discard_s"] = repr(float(dataset.attrs["discard"]))
            rows.append(row)
    if "study" in dataset.attrs:
        write_whole(place / "study.toml", dataset.attrs["study"])
    return write_whole(index, pd.DataFrame(rows).to_csv(index=False, lineterminator="\n"))


def write_template(folder: str | os.PathLike[str]) -> Path:
    """Write an example of recorded trials, to be replaced by a lab's own.

    Parameters
    ----------
    folder : path
        Where to; made where it is missing.

    Returns
    -------
    pathlib.Path
        The list of the trials. Two conditions of three trials of the paper's task, 6 s at 100 Hz; robot 1
        lags behind the target by about 60 ms, robot 2 by about 120 ms.

    Raises
    ------
    telespring.InvalidInput
        Where the folder holds a list of trials already.
    OSError
        Where the folder cannot be written.
    """
    import xarray as xr

    time = np.arange(601) / 100.0
    task = {"kind": "figure-eight", "amplitude": [0.05, 0.1], "angular_frequency": 2.59}
    target = target_of(task, time)
    lags = np.array([[0.060, 0.120], [0.070, 0.110]])[:, None, :] + np.array([0.0, 0.004, 0.008])[:, None]
    position = np.stack(
        [[np.stack([target_of(task, time - lag) for lag in pair], axis=1) for pair in row] for row in lags]
    ).round(6)
    spring = position[..., ::-1, :] - position
    # Unconnected first, then the spring; adding 0 below turns −0 into 0.
    force = 36.0 * spring * np.array([0.0, 1.0])[:, None, None, None, None]
    per_sample = ("condition", "trial", "time", "robot", "axis")
    return write_recorded(
        xr.Dataset(
            {
                "position": (per_sample, position),
                "coupling_force": (per_sample, force.round(6) + 0.0),
                "target": (("time", "axis"), target.round(6)),
            },
            coords={
                "stiffness": ("condition", [np.nan, 36.0]),
                "delay": ("condition", [0.0, 0.167]),
                "time": ("time", time),
                "robot": ("robot", [1, 2]),
                "axis": ("axis", list(AXES)),
            },
            attrs={"discard": 1.0},
        ),
        folder,
    )
