"""The command `telespring probe`."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from telespring._errors import InvalidInput
from telespring._files import write_whole
from telespring.cli.common import print_json
from telespring.cli.live_program import complain, leaving
from telespring.cli.terminal import screen_console, show
from telespring.cli.units import TIME, number
from telespring.connection import RunningProgram, find_program
from telespring.model import Study

if TYPE_CHECKING:
    from telespring.traces import TraceAssessment

__all__ = ["probe_command"]

_WAITING = "waiting for the partner's probe"


def probe_command(
    site: Annotated[
        Path,
        typer.Argument(
            metavar="SITE.toml",
            help="The site file: it says where the partner is, and which study the two will run.",
        ),
    ],
    seconds: Annotated[
        float, typer.Option(parser=number(TIME), metavar="TIME", help="How long packets are sent.")
    ] = 60.0,
    trace: Annotated[
        Path | None,
        typer.Option(
            "--trace",
            metavar="FILE.json",
            help="Save the delays of all packets, both ways, as IRTT does, in a new file.",
        ),
    ] = None,
    out_study: Annotated[
        Path | None,
        typer.Option(
            "--out-study",
            metavar="STUDY.toml",
            help="With --trace: write a whole study of what is recommended, over this trace.",
        ),
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units instead of the tables.")
    ] = False,
) -> None:
    """Measure the path to the partner, and say which play-out and which stiffness it allows.

    Start it at both sites within a minute or so; which one is first does not matter. No robot is touched.

    Exit status: 0 if both ways are known, 1 if they are not.

    Example: telespring probe site-1.toml --trace path.json
    """
    if out_study is not None and trace is None:
        raise InvalidInput(
            "--out-study", str(out_study), "a study names the file of its trace", "Add --trace."
        )
    program = find_program()
    with tempfile.TemporaryDirectory() as folder:
        file = trace or Path(folder) / "path.json"
        arguments = ["probe", str(site), "--seconds", repr(seconds), "--trace", str(file), "--console"]
        found, status = _measure(program, arguments, is_quiet=as_json)
        if found is None:
            raise typer.Exit(status or 1)
        assessment = _assess(file, found)
        if out_study is not None and not isinstance(assessment, str):
            named = Path(os.path.relpath(file, out_study.parent)).as_posix()
            write_whole(out_study, assessment.recommended_study(named).to_toml())
    if as_json:
        from telespring.show.trace_json import trace_json

        why = assessment if isinstance(assessment, str) else None
        judged = None if isinstance(assessment, str) else trace_json(assessment)
        saved = None if trace is None else str(trace)
        print_json({**found, "trace": saved, "assessment": judged, "why_no_assessment": why})
    else:
        from telespring.show.screens.probe import probe_screen

        show(probe_screen(found, assessment, trace, out_study))
    raise typer.Exit(status)


def _measure(program: Path, arguments: list[str], *, is_quiet: bool) -> tuple[Mapping[str, Any] | None, int]:
    """Run the probe to its end, and return what it found and its exit status."""
    found: Mapping[str, Any] | None = None
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TimeRemainingColumn(),
        console=screen_console(stderr=True),
        transient=True,
        disable=is_quiet,
    )
    with RunningProgram(program, arguments) as running, leaving(running), bar:
        task = bar.add_task(_WAITING, total=None)
        while not running.is_over:
            lines, _ = running.read(0.2)
            for line in lines:
                match line.get("type"):
                    case "status":
                        stage = str(line.get("stage"))
                        is_waiting = stage == "waiting"
                        bar.update(
                            task,
                            description=_WAITING if is_waiting else stage,
                            total=None if is_waiting else line.get("packets"),
                            completed=line.get("sent", 0),
                        )
                    case "summary":
                        found = {key: value for key, value in line.items() if key not in {"type", "trace"}}
        status = running.wait()
        complaints = running.complaints
    complain(complaints, status)
    return found, status


def _assess(file: Path, found: Mapping[str, Any]) -> TraceAssessment | str:
    """Return what the trace allows, or why nothing can be said."""
    if not file.exists():
        return "One way is not known, so there is nothing to judge: let both sites run to the end."
    from telespring.traces import assess_trace, read_trace

    study = Study.from_toml(found["study"])
    to_partner, from_partner = read_trace(file), read_trace(file, backward=True)
    # forward is the way from robot 1 to robot 2
    ways = (to_partner, from_partner) if found["side"] == 1 else (from_partner, to_partner)
    try:
        # a path within one building has delays below 1 ms
        return assess_trace(ways, study, allow_unusual=True)
    except InvalidInput as refusal:
        return str(refusal)
