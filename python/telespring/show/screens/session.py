"""What a live session shows, as one screen: the recording, both robots, the trials, what happened."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from telespring.show.quantities import format_count, format_number, format_time
from telespring.show.screens.analysis import analysis_screen
from telespring.show.screens.layout import fitting_table

__all__ = ["merge_screen", "session_screen"]

#: No more events are shown; all are in the JSON.
_MOST_EVENTS = 20
_UNKNOWN = "–"

Row = tuple[str, Callable[[Mapping[str, Any]], str]]


def session_screen(found: Mapping[str, Any], title: str) -> RenderableType:
    """Lay the analysis of a live session out for the terminal."""
    parts: list[RenderableType] = [Text(title, style="bold"), *(Text(line) for line in _facts(found))]
    parts += [Text(warning, style="yellow") for warning in found["warnings"]]
    parts.append(Text(""))
    parts.append(_robots_table(found["session"]))
    if found["trials"]:
        parts += [Text(""), _trials_table(found["trials"])]
    if found["experiment"] is not None:
        parts += [Text(""), analysis_screen(found["experiment"], "Conditions")]
    parts += [Text(""), *_events(found["events"])]
    return Group(*parts)


def merge_screen(found: Mapping[str, Any], out: str) -> RenderableType:
    """Say what was merged, how exact the common time is, and where it is."""
    lines = [*_facts(found), f"Written: {out}", f"  telespring analyse {out}"]
    warnings = [Text(warning, style="yellow") for warning in found["warnings"]]
    return Group(*(Text(line) for line in lines[:-2]), *warnings, *(Text(line) for line in lines[-2:]))


def _facts(found: Mapping[str, Any]) -> list[str]:
    recording, clock = found["recording"], found["clock"]
    sides = [str(site["side"]) for site in recording["sites"]]
    sites = f"Site {sides[0]}" if len(sides) == 1 else f"Sites {' and '.join(sides)}"
    period = format_time(recording["sample_period"], 3)
    lines = [
        f"{sites}: {format_time(recording['duration'], 3)}, a tick every {period}, {recording['status']}."
    ]
    if clock is not None:
        drift = "" if clock["drift"] is None else f"; the clocks drift by {_micro(clock['drift'])} µs/s"
        lines.append(f"Common time: known to {format_time(clock['uncertainty'], 2, rounding='up')}{drift}.")
    return lines


def _robots_table(session: Mapping[str, Any]) -> RenderableType:
    rows = [
        (name, *(write({**session[robot], **session["network"][robot]}) for robot in ("robot1", "robot2")))
        for name, write in _ROWS
    ]
    title = f"While the spring acted, {format_time(session['analysed'], 3)}. Times: median / 99 % / largest"
    known = [row for row in rows if any(cell != _UNKNOWN for cell in row[1:])]
    return fitting_table(title, ("", "robot 1", "robot 2"), known, right=(1, 2))


def _micro(value: float) -> str:
    return format_number(value, 3, shift=6)


def _number(name: str, shift: int, digits: int = 3) -> Callable[[Mapping[str, Any]], str]:
    def write(values: Mapping[str, Any]) -> str:
        value = values.get(name)
        return _UNKNOWN if value is None else format_number(value, digits, shift=shift)

    return write


def _quantiles(name: str) -> Callable[[Mapping[str, Any]], str]:
    """Write the quantiles of a time in ms, to a hundredth."""

    def write(values: Mapping[str, Any]) -> str:
        found = values.get(name)
        if found is None:
            return _UNKNOWN
        shown = (round(1e5 * found[key]) * 1e-5 for key in ("median", "quantile_99", "largest"))
        return " / ".join(format_number(value, 3, shift=3) for value in shown)

    return write


def _loss(values: Mapping[str, Any]) -> str:
    share = values["loss"]["share"]
    return _UNKNOWN if share is None else format_number(share, 3, shift=2)


_ROWS: Sequence[Row] = (
    ("recorded by", lambda values: "its site" if values["source"] == "recorded" else values["source"]),
    ("tracking error, mm", _number("tracking_error", 3)),
    ("lag behind the target, ms", _number("lag", 3, 2)),
    ("spring's force, rms, N", _number("interaction_force_rms", 0)),
    ("  largest, N", _number("interaction_force_peak", 0)),
    ("stiffness in use, mean, N/m", _number("stiffness_mean", 0)),
    ("  least, N/m", _number("stiffness_least", 0)),
    ("limited by the strategy, % of ticks", _number("limited_share", 2)),
    ("account, least, mJ", _number("account_least", 3)),
    ("given out to the handle, mJ", _number("given_out", 3)),
    ("age of the motion in use, ms", _quantiles("age")),
    ("an old motion held, % of ticks", _number("held_share", 2)),
    ("round trip, ms", _quantiles("round_trip")),
    ("packets to it lost, %", _loss),
    ("latency: device, ms", _quantiles("latency_device")),
    ("latency: loop, ms", _quantiles("latency_loop")),
    ("latency: network, ms", _quantiles("latency_network")),
    ("latency: play-out, ms", _quantiles("latency_playout")),
    ("loop late by, ms", _quantiles("lateness")),
)


def _trials_table(trials: Sequence[Mapping[str, Any]]) -> RenderableType:
    rows = [
        (
            Text(_line(trial["label"])),
            Text(_line(trial["condition"])),
            format_number(trial["begin"], 4),
            format_number(trial["duration"], 3),
            trial["status"],
            *(
                _number(name, shift)(trial[robot])
                for name, shift in _TRIAL_COLUMNS
                for robot in ("robot1", "robot2")
            ),
        )
        for trial in trials
    ]
    headings = (
        "Trial",
        "condition",
        "begin\ns",
        "lasts\ns",
        "ended",
        "TE1\nmm",
        "TE2\nmm",
        "force 1\nN",
        "force 2\nN",
        "limited 1\n%",
        "limited 2\n%",
        "age 1\nms",
        "age 2\nms",
    )
    return fitting_table("Trials", headings, rows, right=(2, 3, *range(5, 13)), optional=range(9, 13))


_TRIAL_COLUMNS = (("tracking_error", 3), ("interaction_force_rms", 0), ("limited_share", 2), ("age_mean", 3))


def _events(events: Sequence[Mapping[str, Any]]) -> list[RenderableType]:
    if not events:
        return [Text("Nothing happened.")]
    shown = list(events) if len(events) <= _MOST_EVENTS else [*events[: _MOST_EVENTS - 5], *events[-5:]]
    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("s", justify="right", no_wrap=True)
    table.add_column("site", no_wrap=True)
    table.add_column("event", no_wrap=True)
    table.add_column("why", overflow="fold")
    for event in shown:
        words = (Text(_line(word)) for word in (event["event"], event["cause"] or ""))
        table.add_row(format_number(event["time"], 5), str(event["side"]), *words)
    found: list[RenderableType] = [Text("What happened", style="bold"), table]
    if len(shown) < len(events):
        found.append(Text(f"{format_count(len(events) - len(shown), 'event')} in between: see --json."))
    return found


def _line(text: str) -> str:
    """Return a text of the file as one short line of plain letters: a partner may have caused it."""
    return "".join(letter if letter.isprintable() else "?" for letter in text)[:60]
