"""A replayed session as one screen of text."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.text import Text

from telespring.show.quantities import format_count, format_number, format_time
from telespring.show.screens.layout import fitting_table
from telespring.show.strategies import name_strategy

if TYPE_CHECKING:
    from telespring.model import Study
    from telespring.replays import Replay, SideNumbers, SideReplay

__all__ = ["replay_screen"]

_OPEN_LOOP = (
    "The motions are the recorded ones: nobody reacted to the replayed force. It is what this motion would "
    "have met, not what it would have led to."
)

_NO_DEVICE = (
    "The energy account takes the commanded force as the one that acted: what a device would have made of it "
    "(a lag, a limit of its own) is not replayed."
)
_MEASURED = " The device of {} measured it in the session."


def replay_screen(found: Replay, name: str) -> RenderableType:
    """Lay a replay out for the terminal: is it the recorded session, and what do other settings change."""
    recorded, replayed = _settings(found.recorded_study), _settings(found.study)
    heading = f"{name}: {recorded}" if found.is_own else f"{name}: {recorded}, replayed as {replayed}"
    parts: list[RenderableType] = [Text(heading, style="bold")]
    parts += [_reproduction(side) for side in found.sides]
    rows = []
    for side in found.sides:
        rows.append(_row(f"site {side.side} recorded", side.recorded_numbers, side.differs_at is None))
        if not found.is_own:
            rows.append(_row(f"site {side.side} replayed", side.numbers, True))
    headings = (
        "",
        "force RMS\nN",
        "largest\nN",
        "age mean\nms",
        "99 %\nms",
        "held",
        "limited",
        "withheld",
        "given out\nJ",
        "account least\nJ",
    )
    parts.append(fitting_table("", headings, rows, right=range(1, len(headings)), optional=(7, 9)))
    if not found.is_own:
        apart = ", ".join(
            f"{_number(side.force_difference_rms)} N at site {side.side}" for side in found.sides
        )
        parts.append(Text(f"Replayed and recorded force differ by {apart} (RMS)."))
        parts.append(Text(_OPEN_LOOP, style="yellow"))
        measured = [f"site {side.side}" for side in found.sides if side.recording.has_measured_force]
        known = _MEASURED.format(" and ".join(measured)) if measured else ""
        parts.append(Text(_NO_DEVICE + known, style="yellow"))
    parts.append(Text(_partner(found)))
    return Group(*parts)


def _reproduction(side: SideReplay) -> Text:
    packets = format_count(len(side.recording.arrival_time), "packet")
    ticks = format_count(int(side.is_coupled.sum()), "tick")
    what = f"Site {side.side}, {ticks} and {packets}"
    if side.differs_at is None:
        return Text(f"{what}: the session's own settings give the recorded forces, bit for bit.")
    return Text(
        f"{what}: from {format_time(side.differs_at, 4)} on the session's own settings give other forces "
        "than were recorded. Does the recording miss ticks, or was it written by another release?",
        style="yellow",
    )


def _partner(found: Replay) -> str:
    if found.partner == "replayed":
        renewed = sum(side.replayed.renewed for side in found.sides)
        packets = sum(len(side.recording.arrival_time) for side in found.sides)
        return (
            f"Both sides were replayed: {renewed} of {packets} packets have the content that their replayed "
            "sender gives them."
        )
    return "One side was replayed: the partner's packets are as recorded."


def _row(label: str, numbers: SideNumbers, is_sure: bool) -> tuple[str | Text, ...]:
    return (
        Text(label if is_sure else f"{label} (see above)"),
        _number(numbers.force_rms),
        _number(numbers.force_largest),
        _number(1e3 * numbers.age_mean),
        _number(1e3 * numbers.age_quantile_99),
        _percent(numbers.held_share),
        _percent(numbers.limited_share),
        _percent(numbers.withheld_share),
        _number(numbers.given_out),
        _number(numbers.least_account),
    )


def _number(value: float) -> str:
    return format_number(value, 3) if math.isfinite(value) else "–"


def _percent(share: float) -> str:
    return f"{format_number(100.0 * share, 3)} %" if math.isfinite(share) else "–"


def _settings(study: Study) -> str:
    return f"{name_strategy(study.session.label)} at {format_number(study.stiffness)} N/m"
