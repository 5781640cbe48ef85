"""Open the trials that a path names, and write what their analysis found."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from telespring._errors import InvalidInput
from telespring._files import replacing, write_whole
from telespring.analysis.recordings.layout import INDEX
from telespring.analysis.recordings.reading import read_recorded
from telespring.analysis.table import table1_csv
from telespring.analysis.trials import Trials
from telespring.show.drawings import draw_errors, draw_trajectories

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["REHEARSAL", "open_trials", "write_analysis"]

#: Name of the dataset in the folder of a rehearsal.
REHEARSAL = "rehearsal.nc"


def open_trials(path: str | os.PathLike[str], task: Mapping[str, Any] | None = None) -> xr.Dataset:
    """Open a rehearsal or recorded trials.

    Parameters
    ----------
    path : path
        A rehearsal's ``.nc`` file or its folder, or recorded trials: their folder or their list.
    task : mapping, optional
        A study's task, for recorded trials without a target.

    Returns
    -------
    xarray.Dataset
        The trials, in memory.

    Raises
    ------
    telespring.InvalidInput
        Where the path leads to no trials.
    OSError
        Where it cannot be read.
    """
    place = Path(path)
    if place.is_dir():
        if (place / REHEARSAL).is_file():
            place = place / REHEARSAL
        elif (place / INDEX).is_file():
            return read_recorded(place, task)
        else:
            raise InvalidInput(
                "path",
                str(path),
                f"a folder with {REHEARSAL} (from `telespring rehearse`) or {INDEX} (recorded) is needed",
                "Name the folder that holds one of them, or the file itself.",
            )
    if place.suffix == ".csv":
        return read_recorded(place, task)
    # Opened first, so that a file that is absent or closed to us is named as such.
    with place.open("rb") as file:
        begin = file.read(8)
    if place.suffix != ".nc":
        raise InvalidInput(
            "path",
            str(path),
            f"a rehearsal's .nc file, {INDEX}, or a folder with one of them is needed",
            "docs/recorded-trials.md shows how to record trials as CSV.",
        )
    import xarray as xr

    damaged = InvalidInput(
        "path",
        str(path),
        "a whole netCDF file is needed, and this is none",
        "Rehearse again, or copy it again.",
    )
    if begin != b"\x89HDF\r\n\x1a\n":
        raise damaged
    try:
        return xr.load_dataset(place, engine="h5netcdf")
    except (OSError, KeyError, RuntimeError, ValueError) as trouble:
        raise damaged from trouble


def write_analysis(
    trials: Trials, numbers: Mapping[str, Any], folder: str | os.PathLike[str], *, figures: bool = True
) -> tuple[Path, ...]:
    """Write ``analysis.json``, ``table1.csv`` and Figs. 7 and 8 as SVG and PNG.

    Parameters
    ----------
    trials : Trials
        What was analysed.
    numbers : mapping
        What `telespring.analysis.analyse_trials` found.
    folder : path
        Made where it is missing.
    figures : bool
        Whether to draw.

    Returns
    -------
    tuple of pathlib.Path
        The files, each written whole.

    Raises
    ------
    OSError
        Where the folder cannot be written.
    """
    place = Path(folder)
    text = json.dumps(numbers, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    written = [
        write_whole(place / "analysis.json", text),
        write_whole(place / "table1.csv", table1_csv(numbers["table1"])),
    ]
    if figures:
        written += _write_figure(place / "trajectories", draw_trajectories(trials))
        written += _write_figure(place / "tracking-errors", draw_errors(numbers))
    return tuple(written)


def _write_figure(stem: Path, figure: Figure) -> list[Path]:
    from telespring.show.figures.style import styled

    paths = [stem.with_suffix(suffix) for suffix in (".svg", ".png")]
    for path in paths:
        with replacing(path) as beside, styled(**{"svg.hashsalt": stem.name}):
            figure.savefig(
                beside,
                dpi="figure" if path.suffix == ".svg" else 200.0,
                metadata={"Date": None} if path.suffix == ".svg" else None,
            )
    return paths
