"""What is known of a live session from the lines of its console."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

__all__ = ["Line", "LiveSession", "Side"]

#: A line of the console: an object with its ``type``.
Line: TypeAlias = Mapping[str, Any]

#: The latest events that are kept of a side; the summary has all.
_EVENTS = 200


@dataclass
class Side:
    """One side as it was told last.

    Attributes
    ----------
    number
        1 or 2: the robot of the study that it moves.
    status
        Its latest status; empty before the first.
    told
        When that came, s, by the clock of whoever takes the lines.
    """

    number: int
    status: Line = field(default_factory=dict)
    told: float = 0.0


class LiveSession:
    """A session as its console told it.

    Attributes
    ----------
    sides
        What was told last of each side, by its number.
    events
        The latest events, oldest first.
    told
        How many events were told in all.
    summary
        The summary, once the session is over.

    Examples
    --------
    >>> session = LiveSession()
    >>> session.take({"type": "status", "side": 1, "time": 0.1, "phase": "running"}, now=5.0)
    >>> session.sides[1].status["phase"], session.is_over
    ('running', False)
    >>> session.take({"type": "summary", "side": 1, "events": []}, now=6.0)
    >>> session.is_over, len(session.sites)
    (True, 1)
    """

    def __init__(self) -> None:
        self.sides: dict[int, Side] = {}
        self.events: deque[Line] = deque(maxlen=_EVENTS)
        self.told = 0
        self.summary: Line | None = None

    def take(self, line: Line, now: float) -> None:
        """Take a line that came at `now`, s. One of an unknown type says nothing."""
        match line.get("type"):
            case "status" if isinstance(line.get("side"), int):
                side = self.sides.setdefault(line["side"], Side(line["side"]))
                side.status, side.told = line, now
            case "event" if isinstance(line.get("event"), str):
                self.events.append(line)
                self.told += 1
            case "summary":
                self.summary = line

    def since(self, told: int) -> list[Line]:
        """Return the events after the first `told`, or those of them that are kept."""
        count = min(self.told - told, len(self.events))
        return list(self.events)[len(self.events) - count :]

    @property
    def is_over(self) -> bool:
        """Whether the summary has come."""
        return self.summary is not None

    @property
    def sites(self) -> list[Line]:
        """The summaries of the sides: one, or two of a demonstration; none before the end."""
        if self.summary is None:
            return []
        sites = self.summary.get("sites")
        return list(sites) if sites is not None else [self.summary]
