"""The command `telespring connect`."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.live import Live
from rich.text import Text

from telespring._errors import InvalidInput
from telespring.cli.common import Stiffness, print_json
from telespring.cli.keyboard import Keyboard, keyboard
from telespring.cli.live_program import complain, leaving
from telespring.cli.terminal import screen_console
from telespring.cli.units import TIME, number
from telespring.connection import LiveSession, RunningProgram, find_program, outcome
from telespring.show.screens.live import KEYS, event_line, live_screen, marker_line, status_line
from telespring.show.screens.live_outcome import check_screen, live_outcome_screen
from telespring.show.screens.plain_letters import for_encoding

__all__ = ["connect_command"]

#: How often the screen is drawn, and lines of a file are written, s.
_SCREEN_INTERVAL = 0.1
_LINE_INTERVAL = 2.0
#: What the study of a site says instead.
_OF_THE_STUDY = {
    "strategy": "Leave it out: a site's study says it.",
    "stiffness": "Leave it out: a site's study says it.",
    "imposed-delay": 'Leave it out; a site\'s study says it: playout = {kind = "fixed", delay = …}.',
}
#: Where a demonstration is recorded.
_RECORDINGS = Path("out/connect")


def connect_command(
    demo: Annotated[
        bool,
        typer.Option("--demo", help="Both sites on this machine, simulated robots and people."),
    ] = False,
    site: Annotated[
        Path | None,
        typer.Option("--site", metavar="SITE.toml", help="One site of a real session (docs/connect.md)."),
    ] = None,
    check: Annotated[
        Path | None,
        typer.Option(
            "--check",
            metavar="SITE.toml",
            help="Try keys, device, loop timing and partner of a site, before anyone holds a handle.",
        ),
    ] = None,
    strategy: Annotated[
        str | None,
        typer.Option(metavar="guard|spring", help="What couples the robots of --demo. Default: guard."),
    ] = None,
    stiffness: Stiffness = None,
    delay: Annotated[
        float | None,
        typer.Option(
            parser=number(TIME), metavar="TIME", help="Of the path of --demo, one way. Default: 60ms."
        ),
    ] = None,
    jitter: Annotated[
        float | None,
        typer.Option(
            parser=number(TIME), metavar="TIME", help="The largest addition to the delay. Default: 6ms."
        ),
    ] = None,
    loss: Annotated[
        float | None,
        typer.Option(metavar="SHARE", help="The share of packets that are lost. Default: 0.02."),
    ] = None,
    imposed_delay: Annotated[
        float | None,
        typer.Option(
            parser=number(TIME),
            metavar="TIME",
            help="A delay imposed on the partner's motion in --demo; one below the path's is refused.",
        ),
    ] = None,
    participant: Annotated[
        str | None,
        typer.Option(metavar="CODE", help="Marks who takes part: a code such as P-07, never a name."),
    ] = None,
    condition: Annotated[str | None, typer.Option(metavar="TEXT", help="Marks the condition.")] = None,
    trial: Annotated[
        str | None,
        typer.Option(metavar="TEXT", help="Marks the trial: it lasts to the next one, or to the end."),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(
            parser=number(TIME),
            metavar="TIME",
            help="How long. Default: 20 for --demo; until somebody leaves.",
        ),
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Folder for recordings. Default: out/connect for --demo; else what the site file says.",
        ),
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units at the end, and nothing before.")
    ] = False,
) -> None:
    """Couple two robots, live: start the program of a site, watch it, and say what happened.

    Keys: p or space pause, r resume, c consent, w withdraw, s stop, x clear an emergency stop, m mark,
    Ctrl-C leave.
    Exit status: 0 after a session that ran and ended in order; 1 if it never ran, or a fault ended it.

    Example: telespring connect --demo
    """
    chosen = [demo, site is not None, check is not None]
    if sum(chosen) != 1:
        raise InvalidInput(
            "--demo, --site, --check", f"{sum(chosen)} of them", "exactly one is needed", "Start with --demo."
        )
    path = {
        "strategy": strategy,
        "stiffness": stiffness,
        "delay": delay,
        "jitter": jitter,
        "loss": loss,
        "imposed-delay": imposed_delay,
    }
    given = {name: value for name, value in path.items() if value is not None}
    if given and not demo:
        name = next(iter(given))
        remedy = _OF_THE_STUDY.get(name, "Leave it out.")
        raise InvalidInput(f"--{name}", str(given[name]), "this belongs to --demo only", remedy)
    marks = {"participant": participant, "condition": condition, "trial": trial}
    recorded = {"record": record, **marks}
    program = find_program()
    if check is not None:
        for name, left in recorded.items():
            if left is not None:
                raise InvalidInput(f"--{name}", str(left), "a check records nothing", "Leave it out.")
        raise typer.Exit(_check(program, check, seconds, as_json=as_json))
    if seconds is not None:
        given["seconds"] = seconds
    arguments = ["demo"] if site is None else ["run", str(site)]
    arguments.append("--console")
    folder = record if record is not None or site is not None else _RECORDINGS
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        arguments += ["--record", str(folder)]
    for name, value in given.items():
        arguments += [f"--{name}", str(value) if isinstance(value, str) else repr(float(value))]
    # in one word, so that a text may begin with a dash
    arguments += [f"--{name}={text}" for name, text in marks.items() if text is not None]
    title = _title(given) if site is None else f"Site {site.name}"
    raise typer.Exit(_run(program, arguments, title, as_json=as_json))


def _title(given: dict[str, Any]) -> str:
    """Say what a demonstration shows where it is not the usual."""
    said = ", ".join(
        f"{name} {value:g}" if name != "strategy" else str(value) for name, value in given.items()
    )
    return f"Demonstration on this machine{f' ({said})' if said else ''}"


def _check(program: Path, site: Path, seconds: float | None, *, as_json: bool) -> int:
    length = [] if seconds is None else ["--seconds", repr(float(seconds))]
    if not as_json:
        print(f"Checking {site.name}: loop, device and partner, without any force …", file=sys.stderr)
    done = subprocess.run(
        [program, "check", str(site), *length],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=False,
        text=True,
    )
    complain(done.stderr.splitlines(), done.returncode)
    try:
        report = json.loads(done.stdout)
    except ValueError:
        return done.returncode or 1
    if as_json:
        print_json(report)
    else:
        check_screen(screen_console(), report)
    return done.returncode


def _run(program: Path, arguments: Sequence[str], title: str, *, as_json: bool) -> int:
    console = screen_console()
    is_live = console.is_terminal and not as_json
    session = LiveSession()
    with (
        RunningProgram(program, arguments) as running,
        leaving(running),
        keyboard(wants_keys=is_live) as keys,
    ):
        if is_live:
            _watch_live(console, running, session, keys, title)
        else:
            _watch_plainly(console, running, session, keys, is_quiet=as_json)
        status = running.wait()
        complaints = running.complaints
    complain(complaints, status)
    if not session.is_over:
        return status or 1
    if as_json:
        print_json(outcome(session, status))
    else:
        live_outcome_screen(console, session)
    return status


def _follow(running: RunningProgram, session: LiveSession, keys: Keyboard) -> None:
    """Take what the program says, and pass on what the person wants."""
    lines, is_typed = running.read(_SCREEN_INTERVAL, keys.file)
    now = time.monotonic()
    for line in lines:
        session.take(line, now)
    if is_typed:
        for order in keys.orders():
            running.order(order)


def _watch_live(
    console: Console, running: RunningProgram, session: LiveSession, keys: Keyboard, title: str
) -> None:
    with Live(console=console, auto_refresh=False, transient=True, redirect_stderr=False) as live:
        drawn = 0.0
        while not running.is_over:
            _follow(running, session, keys)
            now = time.monotonic()
            if now - drawn >= _SCREEN_INTERVAL:
                drawn = now
                typed = keys.typed()
                hint = KEYS if typed is None else marker_line(typed)
                screen = live_screen(session, title, now, console.size.height, hint)
                live.update(for_encoding(screen, console.encoding), refresh=True)


def _watch_plainly(
    console: Console, running: RunningProgram, session: LiveSession, keys: Keyboard, *, is_quiet: bool
) -> None:
    told: dict[int, float] = {}
    while not running.is_over:
        before = session.told
        _follow(running, session, keys)
        if is_quiet:
            continue
        for event in session.since(before):
            _print_line(console, event_line(event, is_alone=len(session.sides) < 2))
        for side in session.sides.values():
            if side.told - told.get(side.number, -_LINE_INTERVAL) >= _LINE_INTERVAL:
                told[side.number] = side.told
                _print_line(console, status_line(side))
        sys.stdout.flush()


def _print_line(console: Console, line: Text) -> None:
    """Print a line whole: who reads it counts lines, not columns."""
    console.print(for_encoding(line, console.encoding), soft_wrap=True)
