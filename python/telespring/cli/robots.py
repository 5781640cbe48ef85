"""Robots on the command line: a file of `identify`, masses and dampings, or the paper's."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import typer

from telespring._errors import InvalidInput
from telespring.cli.units import DAMPING, MASS, read_number
from telespring.model import Robot, hman

__all__ = ["GivenRobot", "read_robot", "read_robots"]


class GivenRobot(NamedTuple):
    """A robot that the command line gives.

    Attributes
    ----------
    source
        The robot file, or the text of one.
    name
        What the title of a study calls it.
    option
        The option that gave it.
    label
        Its name beside its values; None if it has none.
    is_for_every_axis
        Whether one mass and one damping stand for as many axes as the other robot has.
    """

    source: Path | str
    name: str
    option: str
    label: str | None = None
    is_for_every_axis: bool = False


def read_robot(written: str, option: str) -> GivenRobot:
    r"""Read a robot as an option gives it.

    Examples
    --------
    >>> read_robot("1.2,6/1.4,8", "--robot").source
    '[robot]\nmass = [1.2, 1.4]\ndamping = [6.0, 8.0]\n'
    """
    paper = {"hman1": hman().robots[0], "hman2": hman().robots[1]}
    if written in paper:
        name = f"the paper's H-MAN {written[-1]}"
        return GivenRobot(_robot_text(paper[written]), name, option, label=name)
    if Path(written).suffix == ".toml" or Path(written).is_file():
        return GivenRobot(Path(written), Path(written).stem, option, label=Path(written).name)
    masses, dampings = [], []
    # Not the slash of a unit such as N*s/m.
    for axis in re.split(r"/(?=\s*[\d.+-])", written):
        mass, comma, damping = axis.partition(",")
        if not comma:
            raise InvalidInput(
                option,
                written,
                "a robot is a file, or mass,damping of each axis, the axes separated by '/'",
                _comma_for_another_mark(written)
                or "Write, for example, 1.2,6 for 1.2 kg and 6 N·s/m, or 1.2,6/1.4,8 for two axes.",
            )
        try:
            masses.append(read_number(mass, MASS))
            dampings.append(read_number(damping, DAMPING))
        except typer.BadParameter as refused:
            raise InvalidInput(
                option, written, "mass and damping of each axis are numbers", str(refused)
            ) from None
    # One number is for as many axes as the other robot has.
    mass_text, damping_text = (str(values if len(values) > 1 else values[0]) for values in (masses, dampings))
    text = f"[robot]\nmass = {mass_text}\ndamping = {damping_text}\n"
    name = " and ".join(f"{m:g} kg, {b:g} N·s/m" for m, b in zip(masses, dampings, strict=True))
    return GivenRobot(text, name, option, is_for_every_axis=len(masses) == 1)


def _comma_for_another_mark(written: str) -> str:
    """Ask whether 1.2:6 is a mass and a damping; empty if it is something else."""
    found = re.fullmatch(r"\s*([\d.]+)\s*[:;x ]\s*([\d.]+)\s*", written)
    return f"Did you mean {found[1]},{found[2]}? A comma stands between mass and damping." if found else ""


def _robot_text(robot: Robot) -> str:
    axes = ", ".join(f'"{axis}"' for axis in robot.axes)
    return f"[robot]\naxes = [{axes}]\nmass = {robot.mass.tolist()}\ndamping = {robot.damping.tolist()}\n"


def read_robots(
    both: list[str] | None, robot1: str | None, robot2: str | None, *, is_study_given: bool
) -> tuple[GivenRobot | None, GivenRobot | None]:
    """Read the robots that replace those of the study; without a study, both or none."""
    if both and (robot1 is not None or robot2 is not None):
        raise InvalidInput(
            "--robot", " ".join(both), "it gives both robots", "Leave out --robot1 and --robot2."
        )
    for written in both or ():
        read_robot(written, "--robot")
    if both and len(both) != 2:
        remedy = f"Write it twice: --robot {both[0]} --robot {both[0]} is two such robots."
        raise InvalidInput("--robot", " ".join(both), "two robots are required", remedy)
    first, second = (both[0], both[1]) if both else (robot1, robot2)
    named = ("--robot", "--robot") if both else ("--robot1", "--robot2")
    if not is_study_given and (first is None) != (second is None):
        missing, number = (named[1], 2) if second is None else (named[0], 1)
        raise InvalidInput(
            missing,
            "",
            "two robots are required",
            f"Give robot {number} too; {missing} hman{number} takes the paper's H-MAN {number}.",
        )
    one, other = (
        None if written is None else read_robot(written, option)
        for written, option in zip((first, second), named, strict=True)
    )
    return one, other
