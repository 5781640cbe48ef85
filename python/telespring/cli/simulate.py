"""The command `telespring simulate`."""

from __future__ import annotations

import csv
import io
import math
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from telespring._errors import InvalidInput
from telespring._files import replacing, write_whole
from telespring.cli.common import (
    Backward,
    Delay,
    Robot1,
    Robot2,
    Stiffness,
    StudyFile,
    read_study,
    refusals,
    requested_case,
    robot_warnings,
)
from telespring.show.screens.simulation import simulation_summary
from telespring.theory import simulation

if TYPE_CHECKING:
    import xarray

__all__ = ["simulate_command"]


class Format(StrEnum):
    """How `simulate` writes its result."""

    netcdf = "nc"
    csv = "csv"


def simulate_command(
    study: StudyFile = None,
    stiffness: Stiffness = None,
    delay: Delay = None,
    backward: Backward = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    force: Annotated[
        list[float] | None,
        typer.Option(
            "--force",
            help="A step of force at t = 0, N; once per axis for robot 1, then for robot 2. "
            "1 and -1 unless given.",
        ),
    ] = None,
    duration: Annotated[float, typer.Option(help="Time to simulate, s.")] = 10.0,
    rate: Annotated[float, typer.Option(help="Outputs per second, Hz.")] = 1000.0,
    out: Annotated[Path, typer.Option(help="File to write, .nc (netCDF) or .csv.", show_default=True)] = Path(
        "out/simulation.nc"
    ),
) -> None:
    """Simulate the ideal dyad with constant delay and write positions and velocities."""
    console = Console(highlight=False)
    with refusals():
        if out.suffix not in {f".{each}" for each in Format}:
            raise InvalidInput(
                "out", str(out), "the file's name must end in .nc or .csv", "Choose one of them."
            )
        asked = requested_case(read_study(study, robot1, robot2), stiffness, delay, backward)
        axes = list(asked.dyad.axes)
        forces = _forces(force, len(axes))
        found = simulation.simulate(asked.dyad, asked.stiffness, asked.delay, forces, duration, rate=rate)
        if out.suffix == ".csv":
            write_whole(out, _csv(found, axes))
        else:
            with replacing(out) as beside:
                found.to_netcdf(beside, engine="h5netcdf")
        for line in simulation_summary(found, asked.dyad, asked.name, asked.stiffness, asked.delay, forces):
            console.print(line)
        for line in robot_warnings(robot1, robot2):
            console.print(line, markup=False)
        console.print(f"Written: {out}", markup=False)


def _forces(force: list[float] | None, axes: int) -> list[list[float]]:
    if not force:
        return [[1.0] * axes, [-1.0] * axes]
    if len(force) != 2 * axes or not all(math.isfinite(value) for value in force):
        raise InvalidInput(
            "force",
            " ".join(str(value) for value in force),
            f"one finite number per robot and axis is needed, that is {2 * axes}",
            "Write --force once for each: robot 1 on every axis, then robot 2.",
        )
    return [force[:axes], force[axes:]]


def _csv(found: xarray.Dataset, axes: list[str]) -> str:
    import numpy as np

    names, columns = ["time_s"], [np.asarray(found["time"])]
    for quantity, unit in (("position", "m"), ("velocity", "m_per_s")):
        values = np.asarray(found[quantity])
        for robot in range(2):
            for i, axis in enumerate(axes):
                names.append(f"{quantity}_robot{robot + 1}_{axis}_{unit}")
                columns.append(values[:, robot, i])
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([float(value) for value in row] for row in zip(*columns, strict=True))
    return text.getvalue()
