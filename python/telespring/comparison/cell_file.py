"""What was measured in one rehearsal, as a file: plain arrays, which are written and read fast."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from telespring._files import replacing

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["CELL_FILE", "read_cell_file", "write_cell_file"]

#: Its name in the folder of the rehearsal.
CELL_FILE = "measured.npz"
_DIMENSIONS = "dimensions"


def write_cell_file(path: Path, measured: xr.Dataset) -> None:
    """Write values and dimensions of all variables, complete or absent; units are given to them later."""
    arrays = {str(name): variable.values for name, variable in measured.variables.items()}
    words = {name: values.astype(str) for name, values in arrays.items() if values.dtype == object}
    dimensions = {str(name): list(variable.dims) for name, variable in measured.variables.items()}
    with replacing(path) as beside:
        arrays |= words | {_DIMENSIONS: np.array(json.dumps(dimensions))}
        np.savez(beside, allow_pickle=False, **arrays)


def read_cell_file(path: Path) -> xr.Dataset | None:
    """Read what `write_cell_file` wrote; None if it is absent or corrupt."""
    import xarray as xr

    try:
        with np.load(path, allow_pickle=False) as arrays:
            dimensions = json.loads(str(arrays[_DIMENSIONS]))
            return xr.Dataset({name: (dims, arrays[name]) for name, dims in dimensions.items()})
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):  # what a power cut left
        return None
