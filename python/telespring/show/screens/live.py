"""What `telespring connect` shows while a session runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from telespring.connection import Line, LiveSession, Side
from telespring.show.live_words import describe_event, describe_limits, describe_phase, describe_watchdog
from telespring.show.quantities import format_number, format_time

__all__ = ["KEYS", "event_line", "live_screen", "marker_line", "status_line"]

#: What the keys do, in the order in which they are shown.
KEYS = "p pause  r resume  c consent  w withdraw  s stop  x clear  m mark  Ctrl-C leave"

#: After this time without a word a side counts as silent, s.
_SILENT = 1.0
#: The most events on the screen.
_EVENTS = 8

_STYLES = {
    "running": "green",
    "ramping-in": "yellow",
    "ramping-out": "yellow",
    "leaving": "yellow",
    "paused": "yellow",
    "stopped": "bold red",
    "ended": "dim",
}


def live_screen(
    session: LiveSession, title: str, now: float, height: int, keys: str = KEYS
) -> RenderableType:
    """Lay out what is known of a session: its sides beside each other, and below them what happened."""
    sides = [session.sides[number] for number in sorted(session.sides)]
    parts: list[RenderableType] = [Text(title, style="bold")]
    if not sides:
        parts.append(Text("starting …", style="dim"))
    else:
        parts.append(_table(sides, now))
    room = max(1, min(_EVENTS, height - len(_ROWS) - 8))
    parts.append(Text(""))
    parts += [event_line(event, is_alone=len(sides) < 2) for event in list(session.events)[-room:]]
    parts.append(Text(keys, style="dim"))
    return Group(*parts)


def marker_line(typed: str) -> str:
    """Write the marker that is being typed, and how to go on, in place of the keys."""
    hint = "trial, condition, participant or note, and a text; Enter sets it, Esc leaves"
    return f"mark {typed}_\n{hint}"


def _table(sides: Sequence[Side], now: float) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("", no_wrap=True, style="dim")
    for side in sides:
        table.add_column(f"side {side.number}", ratio=1, overflow="fold")
    for name, write in _ROWS:
        cells = []
        for side in sides:
            is_silent = now - side.told > _SILENT and side.status.get("phase") != "ended"
            if name == "state" and is_silent:
                cells.append(Text(f"no word for {now - side.told:.0f} s", style="bold red"))
            else:
                cells.append(write(side.status))
        table.add_row(name, *cells)
    return table


def _state(status: Line) -> Text:
    phase = str(status.get("phase", ""))
    return Text(describe_phase(status), style=_STYLES.get(phase, "yellow"))


def _watchdog(status: Line) -> Text:
    if status.get("phase") not in {"running", "leaving", "ramping-in", "ramping-out"}:
        return Text("–")
    is_fine = status.get("watchdog") == "engaged"
    return Text(describe_watchdog(status), style="" if is_fine else "yellow")


def _limits(status: Line) -> Text:
    is_limited = bool(status.get("limits"))
    return Text(describe_limits(status), style="yellow" if is_limited else "")


def _limited(status: Line) -> Text:
    return Text(_share(_number(status, "limited_share"), "of the last second"))


def _force(status: Line) -> Text:
    return Text(_with_unit(_number(status, "force"), "N", decimals=2))


def _stiffness(status: Line) -> Text:
    used, wanted = _number(status, "stiffness_in_use"), _number(status, "stiffness")
    if wanted is None:
        return Text("–")
    return Text(f"{_decimal(used, 0)} of {format_number(wanted)} N/m")


def _round_trip(status: Line) -> Text:
    return Text(_milliseconds(_number(status, "round_trip")))


def _age(status: Line) -> Text:
    return Text(_milliseconds(_number(status, "age")))


def _loss(status: Line) -> Text:
    loss = _number(status, "loss")
    return Text(_share(loss, "of the last second"))


def _nothing(_: Line) -> Text:
    return Text("")


def _stage(stage: str) -> Callable[[Line], Text]:
    return lambda status: Text(_milliseconds(_number(status, "latency", stage)))


def _lateness(status: Line) -> Text:
    late, missed = _number(status, "lateness", "quantile_99"), _number(status, "overruns")
    text = f"{_milliseconds(late, 2)} (99 %)"
    if not missed:
        return Text(text)
    return Text(f"{text}, {missed:.0f} missed", style="yellow")


def _account(status: Line) -> Text:
    balance = _number(status, "balance")
    return Text("–" if balance is None else f"{_decimal(1e3 * balance, 1)} mJ")


def _error(status: Line) -> Text:
    te = _number(status, "te")
    return Text("–" if te is None else f"{_decimal(1e3 * te, 1)} mm")


_ROWS: tuple[tuple[str, Callable[[Line], Text]], ...] = (
    ("state", _state),
    ("force", _force),
    ("stiffness in use", _stiffness),
    ("watchdog", _watchdog),
    ("limits now", _limits),
    ("  share of ticks", _limited),
    ("energy account", _account),
    ("mean error (TE)", _error),
    ("round trip", _round_trip),
    ("age of the motion", _age),
    ("latency by stage", _nothing),
    ("  device", _stage("device")),
    ("  loop", _stage("loop")),
    ("  network", _stage("network")),
    ("  play-out", _stage("playout")),
    ("packets lost", _loss),
    ("loop late", _lateness),
)


def event_line(event: Line, *, is_alone: bool) -> Text:
    """Write what happened, and when; of two sides also at which."""
    when = event.get("time")
    time = f"{float(when):8.2f} s  " if isinstance(when, int | float) else ""
    side = "" if is_alone else f"side {event.get('side')}  "
    return Text(f"{time}{side}{describe_event(event)}")


def status_line(side: Side) -> Text:
    """Write the status of a side as one line, for a file or a pipe."""
    status = side.status
    when = _number(status, "time") or 0.0
    cells = [
        f"{when:8.2f} s  side {side.number}  {describe_phase(status)}",
        _force(status).plain,
        f"round trip {_round_trip(status).plain}",
        f"age {_age(status).plain}",
        f"lost {_share(_number(status, 'loss'))}",
    ]
    limits = describe_limits(status)
    return Text("; ".join(cells if limits == "–" else [*cells, limits]))


def _number(status: Line, *keys: str) -> float | None:
    value: Any = status
    for key in keys:
        value = value.get(key) if isinstance(value, dict) else None
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None


def _decimal(value: float | None, decimals: int) -> str:
    return "–" if value is None else f"{value:.{decimals}f}"


def _with_unit(value: float | None, unit: str, *, decimals: int) -> str:
    return "–" if value is None else f"{value:.{decimals}f} {unit}"


def _milliseconds(value: float | None, decimals: int = 1) -> str:
    # as many digits at every time, so that a number stands still on the screen
    if value is None:
        return "–"
    return f"{1e3 * value:.{decimals}f} ms" if abs(value) < 1.0 else format_time(value)


def _share(value: float | None, of: str = "") -> str:
    return "–" if value is None else f"{100.0 * value:.1f} %{f' {of}' if of else ''}"
