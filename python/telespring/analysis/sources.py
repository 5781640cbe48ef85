"""Open the trials at a path: a rehearsal's netCDF file, or recorded trials as CSV."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from telespring._errors import InvalidInput
from telespring._files import spelt_otherwise
from telespring.analysis.recordings.layout import INDEX
from telespring.analysis.recordings.reading import read_recorded, recorded_files

if TYPE_CHECKING:
    import xarray as xr

    from telespring.model import Task

__all__ = ["files_of_trials", "open_trials"]

_REHEARSAL = "rehearsal.nc"
#: The library that reads a netCDF file, by how the file begins: netCDF 4 is HDF5; 1 and 2 are netCDF 3.
_ENGINES = {
    b"\x89HDF\r\n\x1a\n": "h5netcdf",
    b"CDF\x01": "scipy",
    b"CDF\x02": "scipy",
}


def open_trials(path: str | os.PathLike[str], task: Task | Mapping[str, Any] | None = None) -> xr.Dataset:
    """Open a rehearsal (its ``.nc`` file or its folder) or recorded trials (their folder or their list).

    `task`, a study's, gives the target of recorded trials without one. InvalidInput where the path has no
    trials.
    """
    place = Path(path)
    if place.is_dir():
        if (place / _REHEARSAL).is_file():
            place = place / _REHEARSAL
        elif spelt_otherwise(place / INDEX).is_file():
            return read_recorded(place, task)
        else:
            raise InvalidInput(
                "path",
                str(path),
                f"a folder with {_REHEARSAL} (from `telespring rehearse`) or {INDEX} (recorded) is required",
                "Name the folder that contains one of them, or the file itself.",
            )
    if place.suffix.lower() == ".csv":
        return read_recorded(place, task)
    # Opened first, so that a missing or unreadable file is reported as such.
    with place.open("rb") as file:
        start = file.read(max(len(signature) for signature in _ENGINES))
    engine = next((name for signature, name in _ENGINES.items() if start.startswith(signature)), None)
    if place.suffix.lower() != ".nc":
        raise InvalidInput(
            "path",
            str(path),
            f"a rehearsal's .nc file, {INDEX}, or a folder with one of them is required",
            "docs/recorded-trials.md shows how to record trials as CSV.",
        )
    import xarray as xr

    damaged = InvalidInput(
        "path",
        str(path),
        "a whole netCDF file is required, but this one is damaged",
        "Copy the file again, or run `telespring rehearse` with --fresh.",
    )
    if engine is None:
        raise damaged
    try:
        return xr.load_dataset(place, engine=engine)
    except (OSError, KeyError, RuntimeError, ValueError) as error:
        raise damaged from error


def files_of_trials(path: str | os.PathLike[str]) -> list[Path]:
    """List the files that `open_trials` reads at a path."""
    place = Path(path)
    if place.is_dir() and (place / _REHEARSAL).is_file():
        return [place / _REHEARSAL]
    return [place] if place.suffix.lower() == ".nc" else recorded_files(place)
