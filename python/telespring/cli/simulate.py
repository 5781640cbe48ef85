"""The command `telespring simulate`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from telespring._core import check_usual
from telespring._errors import InvalidInput
from telespring._files import replacing, write_whole
from telespring.cli.common import (
    AllowUnusual,
    Backward,
    Delay,
    Ping,
    Robot1,
    Robot2,
    Robots,
    Stiffness,
    StudyFile,
    print_notes,
    refusals,
)
from telespring.cli.figure_file import check_not_an_input
from telespring.cli.question import StudyOptions
from telespring.cli.terminal import screen_console
from telespring.cli.units import FORCE, FREQUENCY, TIME, number
from telespring.model import Study

if TYPE_CHECKING:
    import xarray

__all__ = ["simulate_command"]


def simulate_command(
    study: StudyFile = None,
    stiffness: Stiffness = None,
    delay: Delay = None,
    backward: Backward = None,
    ping: Ping = None,
    robot: Robots = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    force: Annotated[
        list[float] | None,
        typer.Option(
            "--force",
            parser=number(FORCE),
            metavar="N",
            help="Step of force at t = 0: once per axis for robot 1, then for robot 2. Default: 1 and -1.",
        ),
    ] = None,
    duration: Annotated[
        float, typer.Option(parser=number(TIME), metavar="TIME", help="Time to simulate, s.")
    ] = 10.0,
    rate: Annotated[
        float, typer.Option(parser=number(FREQUENCY), metavar="Hz", help="Samples per second.")
    ] = 1000.0,
    out: Annotated[Path, typer.Option(help="File to write: .nc (netCDF) or .csv.", show_default=True)] = Path(
        "out/simulation.nc"
    ),
    allow_unusual: AllowUnusual = False,
) -> None:
    """Simulate the ideal dyad under a step of force.

    Controllers are continuous and the delay is constant. Positions and velocities are written to a file.
    """
    console = screen_console()
    asked = StudyOptions(study)
    with refusals(asked.options, asked.written):
        from telespring.show.screens.ages import not_simulated
        from telespring.show.screens.simulation import simulation_summary
        from telespring.theory.simulation import simulate

        if out.suffix.lower() not in {".nc", ".csv"}:
            raise InvalidInput(
                "out", str(out), "the file's name must end in .nc or .csv", "Choose one of them."
            )
        asked.take_robots(robot, robot1, robot2)
        check_not_an_input("--out", out, asked.inputs)
        asked.allow_unusual(is_allowed=allow_unusual)
        asked.take("coupling", "stiffness", stiffness, "--stiffness")
        asked.take_ping(ping, delay, backward, check_unusual=not allow_unusual)
        read = asked.read(Study.paper())
        asked.note_robots(read)
        stiffness, delays = read.stiffness, read.delay
        forces = _step_forces(force, len(read.dyad.axes))
        if not allow_unusual:
            check_usual("rate", "--rate", rate)
            for value in force or ():
                check_usual("force", "--force", value)
        asked.options |= {"duration": "--duration", "rate": "--rate"}
        motion = simulate(read.dyad, stiffness, delays, forces, duration, rate=rate)
        if out.suffix.lower() == ".csv":
            write_whole(out, motion_csv(motion))
        else:
            with replacing(out) as unfinished:
                motion.to_netcdf(unfinished, engine="h5netcdf")
        for line in simulation_summary(motion, read.dyad, asked.title(read), stiffness, delays, forces):
            console.print(line)
        left_out = not_simulated(read)
        for note in [*asked.notes, *([left_out] if left_out else [])]:
            console.print(note, markup=False)
        print_notes(console, asked.records())
        console.print(f"Written: {out}", markup=False)


def _step_forces(force: list[float] | None, axes: int) -> list[list[float]]:
    """Return the step of force, N, per robot and axis."""
    if not force:
        return [[1.0] * axes, [-1.0] * axes]
    if len(force) != 2 * axes or not all(math.isfinite(value) for value in force):
        raise InvalidInput(
            "force",
            " ".join(str(value) for value in force),
            f"one finite number per robot and axis is required, that is {2 * axes}",
            "Write --force once for each: robot 1 on every axis, then robot 2.",
        )
    return [force[:axes], force[axes:]]


def motion_csv(motion: xarray.Dataset) -> str:
    """Return a simulation as CSV text: time, then position and velocity of both robots, axis by axis."""
    table = motion[["position", "velocity"]].to_dataframe().unstack(["robot", "axis"], sort=False)
    names = [
        f"{quantity}_robot{robot}_{axis}_{unit}"
        for quantity, unit in (("position", "m"), ("velocity", "m_per_s"))
        for robot in motion["robot"].values
        for axis in motion["axis"].values
    ]
    return table.to_csv(header=names, index_label="time_s", lineterminator="\n", na_rep="nan")
