"""What `telespring connect` prints of a session that is over, and of a site that was checked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from telespring.connection import Line, LiveSession
from telespring.connection.outcome import recording_path
from telespring.show.live_words import describe_cause, describe_event
from telespring.show.quantities import format_count, format_number
from telespring.show.screens.layout import fitting_table

__all__ = ["check_screen", "live_outcome_screen"]

#: Causes with which people leave a session.
_ORDERLY = {"stop-requested", "partner-left"}


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
    for site in sites:
        path = recording_path(site)
        if path is not None:
            console.print(Text(f"Recording: {path}"))


_ROWS: tuple[tuple[str, tuple[str, ...], float, str], ...] = (
    ("round trip", ("round_trip", "latest"), 1e3, "ms"),
    ("age of the motion, mean", ("age", "mean"), 1e3, "ms"),
    ("  99 % within", ("age", "quantile_99"), 1e3, "ms"),
    ("packets lost", ("loss", "share"), 1e2, "%"),
    ("loop late, 99 % within", ("lateness", "quantile_99"), 1e3, "ms"),
    ("ticks missed", ("lateness", "overruns"), 1.0, ""),
    ("force changed", ("limited_share",), 1e2, "%"),
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
    limited = _value(site, ["limited_share"])
    if limited:
        share = f"{format_number(1e2 * limited, 2)} %"
        parts.append(f"The coupling held the spring's force back in {share} of the ticks.")
    elif limited is not None:
        parts.append("Nothing held the spring's force back.")
    troubles = _troubles(site)
    if troubles:
        parts.append(f"It went wrong at times: {'; '.join(troubles)}.")
    missed = _value(site, ["lateness", "overruns"]) or 0.0
    if missed and "refused" in (site.get("real_time") or {}).values():
        parts.append("The loop had no real-time priority, and a busy machine kept it from its ticks.")
    return " ".join(parts)


def _troubles(site: Line) -> list[str]:
    """Count what the watchdog did beside beginning and ending."""
    counts: dict[str, int] = {}
    for event in site.get("events", []):
        is_trouble = event.get("event") in {"ramping-out", "path-lost", "impossible-force", "clock-stepped"}
        if is_trouble:
            text = describe_event(event)
            counts[text] = counts.get(text, 0) + 1
    if str(site.get("cause")) not in _ORDERLY and site.get("cause"):
        counts.setdefault(describe_cause(str(site["cause"])), 1)
    return [f"{text} ({format_count(count, 'time')})" for text, count in counts.items()]


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
