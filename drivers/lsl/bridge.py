"""What becomes of the rows: samples with time stamps, and events in words; without LSL or a socket."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Protocol

from drivers.telemetry import COLUMNS, PHASES, PLACE, WATCHDOGS, Mark, Row, word

FIRST = PLACE["phase"]  # the places before it are in the stream's name, or its time stamps
CHANNELS = COLUMNS[FIRST:]
MOST_EARLY = 64  # markers that wait for the first row


class Outlets(Protocol):
    """Where samples and events of one side go."""

    def push_samples(self, samples: list[list[float]], stamps: list[float]) -> None:
        """Take samples, a value per channel, with their times by the clock of LSL, s."""

    def push_event(self, event: str, stamp: float) -> None:
        """Take an event."""


@dataclass(frozen=True)
class Stream:
    """What the outlets of a stream need to be known by."""

    side: int  # the robot of the study, 1 or 2
    rate: float  # Hz

    @property
    def name(self) -> str:
        """The name of the stream of samples."""
        return f"telespring-{self.side}"


@dataclass
class _Seen:
    sequence: float = math.inf
    phase: str | None = None
    watchdog: str | None = None
    marker: float = math.nan
    missed: float = 0.0


@dataclass
class _Side:
    """A side, and what was seen of it."""

    stream: Stream
    outlets: Outlets
    seen: _Seen = field(default_factory=_Seen)
    samples: list[list[float]] = field(default_factory=list)
    stamps: list[float] = field(default_factory=list)

    def flush(self) -> None:
        if self.samples:
            self.outlets.push_samples(self.samples[:], self.stamps[:])
        self.samples.clear()
        self.stamps.clear()


class Bridge:
    """From rows to outlets. Those of a side open with its first row, and anew if its rate changes."""

    def __init__(self, open_outlets: Callable[[Stream], Outlets]) -> None:
        self._open = open_outlets
        self._sides: dict[int, _Side] = {}
        # the earliest markers, which a program sets before its first row
        self._early: list[Mark] = []

    def take(self, rows: Iterable[Row], offset: float) -> None:
        """Hand rows on; `offset` is the clock of LSL less the monotonic clock, s."""
        for row in rows:
            stream = Stream(int(row[PLACE["side"]]), round(1.0 / row[PLACE["interval"]], 6))
            side = self._sides.get(stream.side)
            if side is None or side.stream != stream:
                if side is not None:
                    side.flush()
                side = self._sides[stream.side] = _Side(stream, self._open(stream))
            stamp = row[PLACE["time"]] + offset
            for event in self._events(side, row):
                side.outlets.push_event(event, stamp)
            side.samples.append(list(row[FIRST : len(COLUMNS)]))
            side.stamps.append(stamp)
        for side in self._sides.values():
            side.flush()
        if self._sides:
            early, self._early = self._early, []
            self.mark(early, offset)

    def mark(self, marks: Iterable[Mark], offset: float) -> None:
        """Hand markers on to every side; those before the first row wait for it."""
        for mark in marks:
            if not self._sides and len(self._early) < MOST_EARLY:
                self._early.append(mark)
            for side in self._sides.values():
                side.outlets.push_event(f"mark {mark.text}", mark.time + offset)

    @staticmethod
    def _events(side: _Side, row: Row) -> list[str]:
        """Return what is new in a row, in words."""
        events, sequence = [], row[PLACE["sequence"]]
        if sequence <= side.seen.sequence:
            side.seen = _Seen()
            events.append("session")
        seen, side.seen = (
            side.seen,
            _Seen(
                sequence,
                word(PHASES, row[PLACE["phase"]]),
                word(WATCHDOGS, row[PLACE["watchdog"]]),
                row[PLACE["marker"]],
                row[PLACE["missed"]],
            ),
        )
        now = side.seen
        for name, before, after in (
            ("phase", seen.phase, now.phase),
            ("watchdog", seen.watchdog, now.watchdog),
        ):
            if after is not None and after != before:
                events.append(f"{name} {after}")
        if not math.isnan(now.marker) and now.marker != seen.marker:
            events.append(f"marker {now.marker:g}")
        if now.missed > seen.missed:
            events.append(f"missed {now.missed - seen.missed:g}")
        return events
