"""LSL's outlets and its clock: the only file that touches pylsl."""

from __future__ import annotations

import time

import pylsl

from drivers.lsl.bridge import CHANNELS, Stream

TRIES = 200
BUFFER = 60  # s that an outlet keeps for a slow reader


def clock_offset() -> tuple[float, float]:
    """Return the clock of LSL less the monotonic clock, and the largest error of that, s.

    Each reading of LSL's clock lies between two of the monotonic one; the narrowest pair counts.
    """
    best = (0.0, float("inf"))
    for _ in range(TRIES):
        before = time.monotonic()
        reading = pylsl.local_clock()
        after = time.monotonic()
        half = (after - before) / 2.0
        if half < best[1]:
            best = (reading - (before + half), half)
    return best


class LslOutlets:
    """An outlet of samples, and one of events."""

    def __init__(self, stream: Stream, source: str) -> None:
        samples = pylsl.StreamInfo(
            stream.name, "Haptics", len(CHANNELS), stream.rate, pylsl.cf_double64, f"{source}-{stream.name}"
        )
        samples.set_channel_labels([name for name, _ in CHANNELS])
        samples.set_channel_units([unit or "none" for _, unit in CHANNELS])
        events = pylsl.StreamInfo(
            f"{stream.name}-events",
            "Markers",
            1,
            pylsl.IRREGULAR_RATE,
            pylsl.cf_string,
            f"{source}-{stream.name}-events",
        )
        self._samples = pylsl.StreamOutlet(samples, 0, BUFFER)
        self._events = pylsl.StreamOutlet(events, 0, BUFFER)

    def push_samples(self, samples: list[list[float]], stamps: list[float]) -> None:
        """Take samples with their time stamps."""
        self._samples.push_chunk(samples, stamps)

    def push_event(self, event: str, stamp: float) -> None:
        """Take an event."""
        self._events.push_sample([event], stamp)
