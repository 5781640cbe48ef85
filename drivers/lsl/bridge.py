"""What becomes of the rows: samples with time stamps, and events in words; without LSL or a socket."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol

from drivers.telemetry import COLUMNS, PHASES, PLACE, WATCHDOGS, Mark, Row, word

FIRST = PLACE["phase"]  # the places before it are in the stream's name, or its time stamps
CHANNELS = COLUMNS[FIRST:]


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


class Bridge:
    """From rows to outlets. The outlets open with the first row, and anew if side or rate change."""

    def __init__(self, open_outlets: Callable[[Stream], Outlets]) -> None:
        self._open = open_outlets
        self._stream: Stream | None = None
        self._outlets: Outlets | None = None
        self._seen = _Seen()

    def take(self, rows: Iterable[Row], offset: float) -> None:
        """Hand rows on; `offset` is the clock of LSL less the monotonic clock, s."""
        samples: list[list[float]] = []
        stamps: list[float] = []
        for row in rows:
            stream = Stream(int(row[PLACE["side"]]), round(1.0 / row[PLACE["interval"]], 6))
            if stream != self._stream or self._outlets is None:
                self._flush(samples, stamps)
                self._stream, self._outlets = stream, self._open(stream)
                self._seen = _Seen()
            stamp = row[PLACE["time"]] + offset
            for event in self._events(row):
                self._outlets.push_event(event, stamp)
            samples.append(list(row[FIRST : len(COLUMNS)]))
            stamps.append(stamp)
        self._flush(samples, stamps)

    def mark(self, marks: Iterable[Mark], offset: float) -> None:
        """Hand markers on; those before the first row have nowhere to go."""
        for mark in marks:
            if self._outlets is not None:
                self._outlets.push_event(f"mark {mark.text}", mark.time + offset)

    def _flush(self, samples: list[list[float]], stamps: list[float]) -> None:
        if samples and self._outlets is not None:
            self._outlets.push_samples(samples[:], stamps[:])
        samples.clear()
        stamps.clear()

    def _events(self, row: Row) -> list[str]:
        """Return what is new in a row, in words."""
        events, sequence = [], row[PLACE["sequence"]]
        if sequence <= self._seen.sequence:
            self._seen = _Seen()
            events.append("session")
        seen, self._seen = (
            self._seen,
            _Seen(
                sequence,
                word(PHASES, row[PLACE["phase"]]),
                word(WATCHDOGS, row[PLACE["watchdog"]]),
                row[PLACE["marker"]],
                row[PLACE["missed"]],
            ),
        )
        now = self._seen
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
