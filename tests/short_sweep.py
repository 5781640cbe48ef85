"""A sweep of short trials, its dataset, and the command that runs it."""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from typer.testing import CliRunner, Result

import telespring as ts
from telespring import cli

__all__ = ["OVER", "command", "guarded", "loaded"]

#: Two keys with two values each: four points, of three conditions with two trials.
OVER = {"network.loss": [0.0, 0.1], "stiffness": [30.0, 150.0]}


def guarded(**sections: object) -> ts.Study:
    """Return the paper's study with the guard and short trials, with errors of robot 1's parameters."""
    protocol = {"stiffness": [71.2], "delay": [0.0, 0.084], "trials": 2, "duration": 3.0, "discard": 1.0}
    uncertain = {"mass_sd": [0.01, 0.02], "damping_sd": [0.2, 0.3]}
    return ts.Study.paper().replace(
        protocol=protocol, session={"strategy": "guard"}, robot1=uncertain, **sections
    )


def command(*arguments: str | Path) -> Result:
    return CliRunner(env={"COLUMNS": "120", "NO_COLOR": "1"}).invoke(cli.app, [*map(str, arguments)])


def loaded(folder: Path) -> xr.Dataset:
    return xr.load_dataset(folder / "sweep.nc", engine="h5netcdf")
