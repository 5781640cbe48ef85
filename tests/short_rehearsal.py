"""A rehearsal of short trials, and the command that runs it."""

from __future__ import annotations

from pathlib import Path

import pytest
import xarray as xr
from typer.testing import CliRunner, Result

import telespring as ts
from resuming import interrupted_after
from telespring import cli

__all__ = ["ARM", "begin", "command", "loaded", "study_text"]


# Short trials of the paper's robots; 1500 N/m over 0.1 s is so unstable that it diverges within 2 s.
STUDY = """
name = "{name}"
robot1 = {{mass = [0.8334, 1.0649], damping = [7.7257, 10.1168]}}
robot2 = {{mass = [0.7776, 1.3407], damping = [7.4208, 9.3496]}}
coupling = {{stiffness = 35.6, damping = 1.0}}
network.delay = 0.05
{more}
[protocol]
conditions = [{{stiffness = 35.6, delay = 0.05}}, {{stiffness = 1500.0, delay = 0.1}}]
trials = {trials}
duration = {duration}
discard = 0.5
record_rate = 100.0
seed = 3
order = "shuffled"
"""


def study_text(name: str = "short", more: str = "", trials: int = 3, duration: float = 2.0) -> str:
    return STUDY.format(name=name, more=more, trials=trials, duration=duration)


def command(*arguments: str | Path) -> Result:
    return CliRunner(env={"COLUMNS": "100", "NO_COLOR": "1"}).invoke(
        cli.app, ["rehearse", *map(str, arguments)]
    )


def loaded(folder: Path) -> xr.Dataset:
    return xr.load_dataset(folder / "rehearsal.nc", engine="h5netcdf")


ARM = """
[arm{n}]
kind = "two-link"
base = [0.0, -0.45]
elbow = "right"
link_length = 0.325
link_mass = 0.0
link_centre = 0.0
link_inertia = 0.0
"""


def begin(study: ts.Study, folder: Path) -> Path:
    """Interrupt a rehearsal in which four of nine trials are finished, and return its folder."""
    with pytest.raises(KeyboardInterrupt):
        ts.rehearse(study, folder, interrupted_after(4), workers=2)
    assert len(list(folder.rglob("*.trial"))) == 4
    return folder
