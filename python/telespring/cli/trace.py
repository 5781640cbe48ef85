"""The command `telespring trace`."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from telespring._errors import InvalidInput
from telespring._files import write_whole
from telespring.cli.common import AllowUnusual, Robot1, Robot2, Robots, print_json
from telespring.cli.figure_file import check_figure_name, check_not_an_input, save_figure
from telespring.cli.question import StudyOptions
from telespring.cli.terminal import screen_console, show
from telespring.cli.units import TIME, number

__all__ = ["trace_command"]


def trace_command(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="A table with the columns time, delay and, if lost packets have rows, lost, units in the "
            "names (time_s, delay_ms); the JSON that irtt writes; or the log of ping -D.",
        ),
    ],
    round_trip: Annotated[
        bool,
        typer.Option("--round-trip", help="The delays are round trips: each way takes half of them."),
    ] = False,
    study: Annotated[
        Path | None,
        typer.Option(
            "--study", metavar="STUDY.toml", help="Robots, operators and controllers. Default: the paper's."
        ),
    ] = None,
    robot: Robots = None,
    robot1: Robot1 = None,
    robot2: Robot2 = None,
    longest_loss: Annotated[
        float | None,
        typer.Option(
            parser=number(TIME),
            metavar="TIME",
            help="Where lost packets have no rows: packets missing in a step of up to this are lost, a "
            "longer step is a pause of the sender; 0 if every step is.",
            show_default="1 s, or 10 periods",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="TRACE.csv",
            help="Write the trace as judged: one way, lost packets with rows; a study plays it.",
        ),
    ] = None,
    out_study: Annotated[
        Path | None,
        typer.Option(
            "--out-study",
            metavar="STUDY.toml",
            help="Write a whole study of what is recommended, which decide and rehearse take as it is.",
        ),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Write a figure: delay over time, its distribution with the fits, stiffness over the "
            "play-out delay; .svg, .png or .pdf.",
        ),
    ] = None,
    allow_unusual: AllowUnusual = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units instead of the table.")
    ] = False,
) -> None:
    """Find the play-out delay and the stiffness that a recorded trace of a network allows.

    A session is played over the trace. The ages of the motion in use say which verdicts hold.

    Example: telespring trace ping.log --robot hman1 --robot hman2 --out-study study.toml
    """
    from telespring.show.screens.questions import describe_robots
    from telespring.show.screens.trace import study_lines, taken_delays, trace_screen, written_lines
    from telespring.show.trace_json import trace_json
    from telespring.traces import assess_trace
    from telespring.traces.reading import read_recording

    asked = StudyOptions(study)
    asked.take_robots(robot, robot1, robot2)
    inputs = [file, *asked.inputs]
    if figure is not None:
        check_not_an_input("--figure", check_figure_name(figure), inputs)
    if out is not None:
        check_not_an_input("--out", out, inputs)
    if out_study is not None:
        check_not_an_input("--out-study", out_study, inputs if out is None else [*inputs, out])
    if longest_loss is not None and not 0.0 <= longest_loss < float("inf"):
        raise InvalidInput(
            "--longest-loss", f"{longest_loss:g}", "a time of at least 0, in s", "Give 0 or more."
        )
    asked.allow_unusual(is_allowed=allow_unusual)
    read = asked.read()
    recording = read_recording(file, round_trip=round_trip)
    if isinstance(recording.traces, tuple) and out is not None:
        raise InvalidInput(
            "--out",
            str(out),
            "a table has one way, and this file has both",
            "Leave it out: a study plays the file of IRTT itself.",
        )
    found = assess_trace(
        recording.traces,
        read,
        longest_loss=longest_loss,
        records=asked.records(),
        allow_unusual=allow_unusual,
    )
    if out_study is not None and found.is_completed and out is None:
        raise InvalidInput(
            "--out-study",
            str(out_study),
            "lost packets have no rows in the file of the trace, so that a study cannot play it",
            "Add --out TRACE.csv: it has them, and the study names it.",
        )
    if out is not None:
        write_whole(out, found.ways[0].trace.to_csv())
    is_round_trip = recording.is_halved and out is None
    if out_study is not None:
        # a study names files relative to its own folder
        played = Path(os.path.relpath(out or file, out_study.parent)).as_posix()
        write_whole(out_study, found.recommended_study(played, round_trip=is_round_trip).to_toml())
    if as_json:
        print_json(trace_json(found))
    else:
        can_rehearse = found.study.experiment is not None
        if out_study is not None:
            lines = written_lines(str(out_study), can_rehearse=can_rehearse)
        else:
            is_completed = found.is_completed and out is None
            named = None if is_completed else (out or file).name
            lines = study_lines(
                found.settings(named, round_trip=is_round_trip),
                is_completed=is_completed,
                can_rehearse=can_rehearse,
            )
        heading = asked.heading(read)
        robots = (
            [heading]
            if heading
            else describe_robots(found.question.dyad, asked.robot_names(read), found.question.robot_springs)
        )
        show(trace_screen(found, file.name, taken_delays(recording), robots, lines))
        if out is not None:
            screen_console().print(f"Trace: {out}", markup=False)
    if figure is not None:
        from telespring.show.drawings.trace import draw_trace

        save_figure(draw_trace(found), figure)
        if not as_json:
            screen_console().print(f"Figure: {figure}", markup=False)
