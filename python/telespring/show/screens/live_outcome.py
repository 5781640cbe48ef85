"""What `telespring connect` prints of a session that is over, and of a site that was checked."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from telespring.connection import Line, LiveSession, recording_path
from telespring.show.live_words import describe_cause, describe_event
from telespring.show.quantities import format_count, format_number
from telespring.show.screens.layout import fitting_table

__all__ = ["check_screen", "live_outcome_screen"]

#: Causes with which people leave a session.
_ORDERLY = {"stop-requested", "time-over", "partner-left"}


def live_outcome_screen(console: Console, session: LiveSession) -> None:
    """Print a table of both sides, what happened in a sentence each, and where the recordings are."""
    sites = session.sites
    headings = ["", *(f"side {site.get('side')}" for site in sites)]
    rows: list[list[str | Text]] = [
        [name, *(_cell(site, keys, scale, unit) for site in sites)] for name, keys, scale, unit in _ROWS
    ]
    console.print(fitting_table("Summary", headings, rows, right=range(1, len(headings))))
    for site in sites:
        console.print(Text(f"Side {site.get('side')}: {_sentence(site)}"))
    paths = [(site, path) for site in sites if (path := recording_path(site)) is not None]
    for site, path in paths:
        console.print(_recording(path, site["recording"]))
    if len(paths) > 1:
        # one line, so that it can be copied whole
        names = shlex.join(path for _, path in paths)
        line = Text(f"Both on one time base: telespring merge {names} --out session.mcap")
        console.print(line, soft_wrap=True)


_ROWS: tuple[tuple[str, tuple[str, ...], float, str], ...] = (
    ("round trip", ("round_trip", "latest"), 1e3, "ms"),
    ("age of the motion, mean", ("age", "mean"), 1e3, "ms"),
    ("  99 % within", ("age", "quantile_99"), 1e3, "ms"),
    ("packets lost", ("loss", "share"), 1e2, "%"),
    ("loop late, 99 % within", ("lateness", "quantile_99"), 1e3, "ms"),
    ("ticks missed", ("lateness", "overruns"), 1.0, ""),
    ("force changed", ("limited_share",), 1e2, "%"),
    ("  cut at a limit", ("cut_share",), 1e2, "%"),
    ("  softened", ("softened_share",), 1e2, "%"),
    ("interruptions", ("interruptions",), 1.0, ""),
    ("emergency stops", ("emergency_stops",), 1.0, ""),
    ("largest force", ("largest_force",), 1.0, "N"),
    ("energy account, least", ("energy", "least_balance"), 1e3, "mJ"),
    ("mean error (TE)", ("te",), 1e3, "mm"),
)


def _value(site: Line, keys: Sequence[str]) -> float | None:
    value: Any = site
    for key in keys:
        value = value.get(key) if isinstance(value, dict) else None
    return float(value) if isinstance(value, int | float) else None


def _cell(site: Line, keys: Sequence[str], scale: float, unit: str) -> str:
    value = _value(site, keys)
    return "–" if value is None else f"{format_number(scale * value, 3)} {unit}".rstrip()


def _sentence(site: Line) -> str:
    """Say how long a side was coupled, why it ended, and whether anything held the force back."""
    seconds = _value(site, ["seconds"]) or 0.0
    coupled = seconds * (_value(site, ["coupled_share"]) or 0.0)
    cause = str(site.get("cause") or "")
    ended = describe_cause(cause) if cause else "it was cut off"
    if site.get("disagreement"):
        ended += f" on: {site['disagreement']}"
    parts = [f"coupled for {coupled:.1f} of {seconds:.1f} s; then {ended}."]
    shares = {what: _value(site, [key]) for key, what in _HELD_BACK.items()}
    parts += [
        f"{what} in {format_number(1e2 * share, 2)} % of the ticks."
        for what, share in shares.items()
        if share
    ]
    if shares[_HELD_BACK["limited_share"]] is not None and not any(shares.values()):
        parts.append("Nothing held the spring's force back.")
    troubles = _troubles(site)
    if troubles:
        parts.append(f"It went wrong at times: {'; '.join(troubles)}.")
    missed = _value(site, ["lateness", "overruns"]) or 0.0
    if missed and "refused" in (site.get("real_time") or {}).values():
        parts.append("The loop had no real-time priority, and a busy machine kept it from its ticks.")
    return " ".join(parts)


#: What kept the force from being that of the spring, by its share of the ticks.
_HELD_BACK = {
    "limited_share": "The coupling held the spring's force back",
    "cut_share": "A limit of the force cut it",
    "softened_share": "A bad network softened it",
}
#: Events that somebody should know of, and causes of an interruption that people wanted.
_TROUBLES = {
    "clock-stepped",
    "delay-too-short",
    "emergency-stop",
    "impossible-force",
    "impossible-value",
    "interrupted",
    "network-pause",
    "partner-restarted",
    "path-lost",
    "path-refused",
    "path-withheld",
    "force-ramping-out",
    "recording-broken",
}
_WANTED = {"pause-ordered", "consent-withdrawn", "partner", "partner-paused"}


def _troubles(site: Line) -> list[str]:
    """Count what happened beside beginning and ending."""
    counts: dict[str, int] = {}
    for event in site.get("events", []):
        if event.get("event") in _TROUBLES and event.get("cause") not in _WANTED:
            text = describe_event({**event, "remedy": None})
            counts[text] = counts.get(text, 0) + 1
    if str(site.get("cause")) not in _ORDERLY and site.get("cause"):
        counts.setdefault(describe_cause(str(site["cause"])), 1)
    return [f"{text} ({format_count(count, 'time')})" for text, count in counts.items()]


def _recording(path: str, recording: object) -> Text:
    """Say where a recording is, and what is not in it."""
    facts = recording if isinstance(recording, dict) else {}
    troubles = []
    status = facts.get("status")
    if status not in (None, "complete"):
        cause = facts.get("cause")
        troubles.append(f"{_plain(status)}: {_plain(cause)}" if cause else _plain(status))
    missed = facts.get("missed")
    if isinstance(missed, int) and missed > 0:
        troubles.append(f"{format_count(missed, 'item')} missed")
    if not troubles:
        return Text(f"Recording: {path}")
    return Text(f"Recording: {path} ({'; '.join(troubles)})", style="yellow")


def _plain(word: object) -> str:
    """Return what the program says as text that harms no terminal."""
    return "".join(letter for letter in str(word) if letter.isprintable())[:200]


def check_screen(console: Console, report: Line) -> None:
    """Print what was tried of a site, what was found, and what to do about it."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("", no_wrap=True)
    table.add_column("", no_wrap=True)
    table.add_column("", overflow="fold")
    for item in report.get("items", []):
        verdict = str(item.get("verdict"))
        found = Text(str(item.get("found")))
        if item.get("remedy"):
            found.append(f"\n{item['remedy']}", style="dim")
        table.add_row(str(item.get("item")), Text(verdict, style=_VERDICTS.get(verdict, "bold red")), found)
    console.print(Text(f"Side {report.get('side')}", style="bold"))
    console.print(table)
    console.print(_CONCLUSIONS.get(str(report.get("verdict")), ""))


_VERDICTS = {"ok": "green", "warning": "yellow", "failed": "bold red"}
_CONCLUSIONS = {
    "ok": "This site is ready. No force was commanded.",
    "warning": "A session is possible; see the warnings first. No force was commanded.",
    "failed": "This site is not ready. No force was commanded.",
}
