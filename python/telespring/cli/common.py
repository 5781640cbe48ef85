"""What the commands share: their common options, the reading of their files, and how they refuse input."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from telespring._errors import InvalidInput
from telespring.model import Dyad, Study
from telespring.show.screens.refusal import refusal_screen

if TYPE_CHECKING:
    from telespring.study.editing import RobotRecord

__all__ = [
    "Backward",
    "Case",
    "Delay",
    "Robot1",
    "Robot2",
    "Stiffness",
    "StudyFile",
    "read_study",
    "refusals",
    "requested_case",
    "robot_records",
    "robot_warnings",
]

StudyFile = Annotated[
    Path | None,
    typer.Argument(
        metavar="[STUDY.toml]", help="Robots, coupling and network; the paper's two H-MANs unless given."
    ),
]
Stiffness = Annotated[float | None, typer.Option("--stiffness", help="Stiffness of the spring, N/m.")]
Delay = Annotated[
    float | None, typer.Option("--delay", help="One-way delay in s, each way unless --backward is given.")
]
Backward = Annotated[
    float | None,
    typer.Option("--backward", help="One-way delay in s from robot 2 to robot 1, where it differs."),
]
Robot1 = Annotated[
    Path | None,
    typer.Option("--robot1", metavar="FILE", help="A robot file, as `identify` writes it, for robot 1."),
]
Robot2 = Annotated[
    Path | None,
    typer.Option("--robot2", metavar="FILE", help="A robot file, as `identify` writes it, for robot 2."),
]


@contextmanager
def refusals() -> Iterator[None]:
    """Tell refused input and unusable files in a few lines, and leave with status 2."""
    try:
        yield
    except InvalidInput as refused:
        refusal_screen(
            Console(stderr=True, highlight=False),
            refused.field,
            refused.value,
            refused.allowed,
            refused.remedy,
        )
        raise typer.Exit(2) from None
    except OSError as trouble:
        where = trouble.filename or "file"
        refusal_screen(
            Console(stderr=True, highlight=False),
            "file",
            str(where),
            f"a file that can be read or written is needed ({trouble.strerror or trouble})",
            "Check the name, the folder and its permissions.",
        )
        raise typer.Exit(2) from None
    except KeyboardInterrupt:
        print("Stopped; nothing half-written was left behind.", file=sys.stderr)
        raise typer.Exit(130) from None


def read_study(study: Path | None, robot1: Path | None = None, robot2: Path | None = None) -> Study:
    """Read a study file, or take the paper's study where none is named; put robots of their own in."""
    read = Study.paper() if study is None else Study.read(study)
    for side, robot in ((1, robot1), (2, robot2)):
        if robot is not None:
            from telespring.study.editing import with_robot

            read = with_robot(read, side, robot)
    return read


def robot_records(robot1: Path | None, robot2: Path | None) -> tuple[RobotRecord | None, RobotRecord | None]:
    """Read what identification found besides the robots' parameters."""
    from telespring.study.editing import robot_record

    return (
        None if robot1 is None else robot_record(robot1),
        None if robot2 is None else robot_record(robot2),
    )


def robot_warnings(robot1: Path | None, robot2: Path | None) -> list[str]:
    """Tell what identification warned of; coupled axes are among it."""
    return [
        f"Beware: robot {i}, when it was identified: {warning}"
        for i, record in enumerate(robot_records(robot1, robot2), start=1)
        if record is not None
        for warning in record.warnings
    ]


@dataclass(frozen=True)
class Case:
    """A dyad, its name, the stiffness (N/m) and the delays there and back (s) asked about."""

    dyad: Dyad
    name: str
    stiffness: float
    delay: tuple[float, float]


def requested_case(
    study: Study, stiffness: float | None, delay: float | None, backward: float | None
) -> Case:
    """Take the study, with what the command line says in the place of what the file says."""
    forward, back = study.delay if delay is None else (delay, delay)
    return Case(
        dyad=study.dyad,
        name=study.name,
        stiffness=study.stiffness if stiffness is None else stiffness,
        delay=(forward, back if backward is None else backward),
    )
