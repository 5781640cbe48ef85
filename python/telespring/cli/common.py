"""What the commands share: options, reading of studies and robots, JSON output, and refusal of bad input."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from telespring._errors import InvalidInput
from telespring.model import Study
from telespring.show.screens.refusal import refusal_screen

if TYPE_CHECKING:
    from telespring.study.robot_file import RobotRecord

__all__ = [
    "Backward",
    "Delay",
    "Robot1",
    "Robot2",
    "Stiffness",
    "StudyFile",
    "print_json",
    "print_notes",
    "read_study",
    "refusals",
    "requested_delay",
    "robot_records",
]

StudyFile = Annotated[
    Path | None,
    typer.Argument(
        metavar="[STUDY.toml]", help="Robots, coupling and network. Default: the paper's two H-MANs."
    ),
]
Stiffness = Annotated[float | None, typer.Option("--stiffness", help="Stiffness of the spring, N/m.")]
Delay = Annotated[
    float | None, typer.Option("--delay", help="One-way delay in s, both ways unless --backward is given.")
]
Backward = Annotated[
    float | None,
    typer.Option("--backward", help="One-way delay in s from robot 2 to robot 1, if it differs."),
]
Robot1 = Annotated[
    Path | None,
    typer.Option("--robot1", metavar="FILE", help="Robot file for robot 1, written by `identify`."),
]
Robot2 = Annotated[
    Path | None,
    typer.Option("--robot2", metavar="FILE", help="Robot file for robot 2, written by `identify`."),
]


@contextmanager
def refusals() -> Iterator[None]:
    """Report refused input and unusable files in a few lines, and exit with status 2."""
    try:
        yield
    except InvalidInput as refused:
        refusal_screen(Console(stderr=True, highlight=False), refused)
        raise typer.Exit(2) from None
    except OSError as error:
        unusable = InvalidInput(
            "file",
            str(error.filename or "file"),
            f"a file that can be read or written is required ({error.strerror or error})",
            "Check the name, the folder and its permissions.",
        )
        refusal_screen(Console(stderr=True, highlight=False), unusable)
        raise typer.Exit(2) from None
    except KeyboardInterrupt:
        print("Stopped. No incomplete file was left behind.", file=sys.stderr)
        raise typer.Exit(130) from None


def read_study(study: Path | None, robot1: Path | None = None, robot2: Path | None = None) -> Study:
    """Read a command's study file, or take the paper's study, and put in robots from files of their own."""
    read = Study.paper() if study is None else Study.read(study)
    for side, robot in ((1, robot1), (2, robot2)):
        if robot is not None:
            read = read.with_robot(side, robot)
    return read


def robot_records(robot1: Path | None, robot2: Path | None) -> tuple[RobotRecord | None, RobotRecord | None]:
    """Read what identification recorded in the robot files."""
    if robot1 is robot2 is None:
        return None, None
    from telespring.study.robot_file import robot_record

    return (
        None if robot1 is None else robot_record(robot1),
        None if robot2 is None else robot_record(robot2),
    )


def requested_delay(study: Study, delay: float | None, backward: float | None) -> tuple[float, float]:
    """Return the one-way delays, s, forward and backward: of the command line, else of the study."""
    forward, back = study.delay if delay is None else (delay, delay)
    return forward, back if backward is None else backward


def print_notes(console: Console, records: tuple[RobotRecord | None, RobotRecord | None]) -> None:
    """Print the warnings that identification recorded in the robot files, coupled axes among them."""
    from telespring.show.screens.robots import identification_notes

    for note in identification_notes(records):
        console.print(f"Warning: {note}", markup=False)


def print_json(value: Any) -> None:
    """Print the JSON answer of a command; letters that the output cannot encode are escaped."""
    escape_letters = not sys.stdout.encoding.lower().startswith("utf")
    typer.echo(json.dumps(value, indent=1, ensure_ascii=escape_letters, allow_nan=False))
