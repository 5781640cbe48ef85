"""The command `telespring explore`."""

from __future__ import annotations

import tempfile
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

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
    refusals,
)
from telespring.cli.figure_file import check_not_an_input
from telespring.cli.question import StudyOptions
from telespring.cli.terminal import screen_console

__all__ = ["explore_command"]


def explore_command(
    study: StudyFile = None,
    stiffness: Stiffness = None,
    delay: Delay = None,
    backward: Backward = None,
    ping: Ping = None,
    robot: Robots = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    save: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.html",
            help="Write the page with this study instead of opening it: one file to keep, to send, "
            "or to put on any page host.",
        ),
    ] = None,
    allow_unusual: AllowUnusual = False,
) -> None:
    """Open a page on which stiffness, delay and robots can be changed, with the answer at once.

    The page needs no server and sends nothing: it computes in the browser.

    Options replace what the study file says. Without a file and robots, they are the paper's two H-MANs.

    Example: telespring explore --robot 1.2,6 --robot 2,9 --ping 80ms
    """
    from telespring._files import write_whole
    from telespring.app.page import page_with

    asked = StudyOptions(study)
    with refusals(asked.options, asked.written):
        asked.take_robots(robot, robot1, robot2)
        if save is not None:
            check_not_an_input("--save", save, asked.inputs)
        asked.allow_unusual(is_allowed=allow_unusual)
        asked.take("coupling", "stiffness", stiffness, "--stiffness")
        asked.take_ping(ping, delay, backward, check_unusual=not allow_unusual)
        # what it leaves open the page fills in, and says so
        page = page_with(asked.read())
        path = save if save is not None else Path(tempfile.mkdtemp(prefix="telespring-")) / "telespring.html"
        write_whole(path, page)
    console = screen_console()
    if save is not None:
        console.print(f"Page: {path}", markup=False)
    elif webbrowser.open(path.resolve().as_uri()):
        console.print(f"Opened {path} in the browser.", markup=False)
    else:
        console.print(f"No browser was found here. Open this file in one: {path}", markup=False)
