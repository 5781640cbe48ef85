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
from telespring.cli.terminal import output_trouble, screen_console
from telespring.cli.units import FREQUENCY, LENGTH, STIFFNESS, TIME, number
from telespring.show.screens.refusal import refusal_screen

if TYPE_CHECKING:
    from telespring.study.robot_file import RobotRecord

__all__ = [
    "AllowUnusual",
    "Backward",
    "Delay",
    "LogRate",
    "Ping",
    "PositionScale",
    "Robot1",
    "Robot2",
    "Robots",
    "ShardOption",
    "Stiffness",
    "StudyFile",
    "TaskStudy",
    "TimeScale",
    "Workers",
    "print_json",
    "print_notes",
    "refusals",
    "robot_records",
]

StudyFile = Annotated[
    Path | None,
    typer.Argument(
        metavar="[STUDY.toml]", help="Robots, coupling and network. Default: the paper's two H-MANs."
    ),
]
Stiffness = Annotated[
    float | None,
    typer.Option("--stiffness", parser=number(STIFFNESS), metavar="N/m", help="Stiffness of the spring."),
]
Delay = Annotated[
    float | None,
    typer.Option(
        "--delay",
        parser=number(TIME),
        metavar="TIME",
        help="One-way delay, such as 80ms or 0.08 (s), both ways unless --backward is given.",
    ),
]
Backward = Annotated[
    float | None,
    typer.Option(
        "--backward",
        parser=number(TIME),
        metavar="TIME",
        help="One-way delay from robot 2 to robot 1, if it differs.",
    ),
]
Ping = Annotated[
    float | None,
    typer.Option(
        "--ping",
        parser=number(TIME),
        metavar="TIME",
        help="Smallest round trip, such as 80ms, instead of --delay: half of it each way.",
    ),
]
Robots = Annotated[
    list[str] | None,
    typer.Option(
        "--robot",
        metavar="ROBOT",
        help="Write it twice, for robots 1 and 2: mass,damping (kg, N·s/m) such as 1.2,6, axes separated "
        "by '/' such as 1.2,6/1.4,8; or a file written by `identify`; or hman1, hman2, the paper's.",
    ),
]
Robot1 = Annotated[
    str | None,
    typer.Option(
        "--robot1",
        metavar="ROBOT",
        help="Robot 1 only, written like --robot.",
    ),
]
Robot2 = Annotated[
    str | None,
    typer.Option("--robot2", metavar="ROBOT", help="Robot 2 only, written like --robot."),
]
AllowUnusual = Annotated[
    bool,
    typer.Option("--allow-unusual", help="Accept values that no laboratory has, such as a delay of 80 s."),
]

TaskStudy = Annotated[
    Path | None,
    typer.Option(help="Study whose task defines the target, for trials recorded without one."),
]
Workers = Annotated[
    int | None,
    typer.Option(help="Trials to run in parallel. Default: one per core, or 1 with agents in Python."),
]
ShardOption = Annotated[
    str | None,
    typer.Option(
        "--shard",
        metavar="I/N",
        help="Run only share I of N, such as 2/8, in a folder of its own inside --out. "
        "`telespring merge` puts all shares together.",
    ),
]
LogRate = Annotated[
    float | None,
    typer.Option(
        parser=number(FREQUENCY),
        metavar="Hz",
        help="Samples per second, for a log without times.",
        show_default=False,
    ),
]
TimeScale = Annotated[
    float,
    typer.Option(
        parser=number(TIME), metavar="TIME", help="One unit of the time column, such as 1ms or 0.001 (s)."
    ),
]
PositionScale = Annotated[
    float,
    typer.Option(
        parser=number(LENGTH),
        metavar="LENGTH",
        help="One unit of the position columns, such as 1mm or 0.001 (m).",
    ),
]


@contextmanager
def refusals(options: dict[str, str] | None = None, written: dict[str, str] | None = None) -> Iterator[None]:
    """Report refused input and unusable files in a few lines, and exit with status 2.

    `options` names the option that gave a field of the study: a refusal then names the option. `written` has
    the numbers of options that were written with a unit.
    """
    try:
        yield
    except InvalidInput as refused:
        refusal_screen(screen_console(stderr=True), _named_by_option(refused, options or {}, written or {}))
        raise typer.Exit(2) from None
    except OSError as error:
        if error.filename is None:
            # Only the output has no name.
            status = output_trouble(error)
            if status is None:
                raise
            raise typer.Exit(status) from None
        unusable = InvalidInput(
            "file",
            str(error.filename),
            f"a file that can be read or written is required ({error.strerror or error})",
            "Check the name, the folder and its permissions.",
        )
        refusal_screen(screen_console(stderr=True), unusable)
        raise typer.Exit(2) from None
    except KeyboardInterrupt:
        print("Stopped. No incomplete file was left behind.", file=sys.stderr)
        raise typer.Exit(130) from None


def _named_by_option(refused: InvalidInput, options: dict[str, str], written: dict[str, str]) -> InvalidInput:
    for field, option in options.items():
        if refused.field == field or refused.field.startswith((f"{field}.", f"{field}[")):
            renamed = refused.at(option)
            renamed.remedy = renamed.remedy.removesuffix(" See [robot] in the robot's text.")
            break
    else:
        renamed = refused
    text = written.get(renamed.field)
    if text is not None:
        # Who wrote a unit meant it: another is no remedy.
        renamed = renamed.at(renamed.field)
        renamed.value = f"{text} ({renamed.value})"
        _, if_meant, rest = renamed.remedy.partition("If it is meant")
        if if_meant:
            renamed.remedy = f"Check the number and its unit. {if_meant}{rest}"
    return renamed


def robot_records(*robots: str | Path | None) -> tuple[RobotRecord | None, RobotRecord | None]:
    """Read what identification recorded in robot files, or in the texts of robots."""
    if all(robot is None for robot in robots):
        return None, None
    from telespring.study.robot_file import robot_record

    one, other = (None if robot is None else robot_record(robot) for robot in robots)
    return one, other


def print_notes(console: Console, records: tuple[RobotRecord | None, RobotRecord | None]) -> None:
    """Print the warnings that identification recorded in the robot files, coupled axes among them."""
    from telespring.show.screens.robots import identification_notes

    for note in identification_notes(records):
        console.print(f"Warning: {note}", markup=False)


def print_json(value: Any) -> None:
    """Print the JSON answer of a command; letters that the output cannot encode are escaped."""
    escape_letters = not sys.stdout.encoding.lower().startswith("utf")
    typer.echo(json.dumps(value, indent=1, ensure_ascii=escape_letters, allow_nan=False))
