"""What one site of a live session recorded."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.recording.common_time import ClockEstimates
from telespring.recording.series import SiteSeries
from telespring.recording.signals import SIGNALS, TARGET, WORDS

if TYPE_CHECKING:
    from telespring.recording.topics import TopicTable

__all__ = ["SideRecording"]

#: Of a packet, as docs/wire.md has them: session, sequence, stamp, and position and velocity.
_PACKET = np.dtype(
    {
        "names": ["session", "sequence", "sent", "motion"],
        "formats": ["<u8", "<u8", "<u8", ("<f8", (4,))],
        "offsets": [8, 16, 24, 48],
        "itemsize": 112,
    }
)
#: Times beyond this are none that a clock has, ns.
_LATEST = 2**62
#: The clocks are compared at no more instants than this.
_MOST_ESTIMATES = 200_000


@dataclass(frozen=True, eq=False)
class SideRecording:
    """What the site of one robot recorded.

    Attributes
    ----------
    side
        The robot of the study, 1 or 2.
    path
        The file.
    ticks, arrivals, events
        The messages of the site, a column for each field as docs/recording.md names them (`own.position.x`).
        Times are ns of the site's own clock.
    metadata
        By name; "telespring" says what the recording is.
    study
        The study's text; "" if it is not in the file.
    summary
        The summary of the live program; None if the session did not end in order.
    status
        "complete", or "truncated": the file has no end, or chunks of it are damaged.
    lost_bytes, damaged_chunks
        What is in the file but cannot be read.
    """

    side: Literal[1, 2]
    path: Path
    ticks: TopicTable
    arrivals: TopicTable
    events: TopicTable
    metadata: dict[str, dict[str, str]]
    study: str
    summary: dict[str, Any] | None
    status: Literal["complete", "truncated"]
    lost_bytes: int
    damaged_chunks: int

    @property
    def session(self) -> str:
        """The id of this side's session, as in the events."""
        return self.metadata["telespring"].get("session", "")

    @property
    def wall_time_zero(self) -> int:
        """When the site's clock read 0, ns since 1970."""
        text = self.metadata["telespring"].get("wall_time_zero", "")
        return int(text) if text.lstrip("-").isdigit() and len(text) < 20 else 0

    @property
    def sample_period(self) -> float:
        """The time between two ticks, s: as the site had it, or else the median."""
        text = self.metadata.get("endpoint", {}).get("sample_period_ns", "")
        if text.isdigit() and 0 < int(text) < 10**10:
            return int(text) * 1e-9
        steps = np.diff(self.time)
        return float(np.median(steps)) * 1e-9 if len(steps) else 1e-3

    @cached_property
    def time(self) -> NDArray[np.int64]:
        """When the ticks began, ns on the site's own clock."""
        return np.asarray(self.ticks.columns["time"]).astype(np.int64)

    @property
    def missing_ticks(self) -> int:
        """Ticks whose number is between those of the recording, but which are not in it."""
        numbers = np.asarray(self.ticks.columns["tick"])
        return max(0, int(numbers[-1]) - int(numbers[0]) + 1 - len(numbers))

    @property
    def missed(self) -> int:
        """Items that the recorder counted as missed because it fell behind, and arrivals of a flood."""
        stated = self.metadata.get("end", {}).get("missed", "")
        if stated.isdigit() and len(stated) < 20:
            missed = int(stated)
        else:
            causes = self._column(self.events, "cause", "")[
                self._column(self.events, "event", "") == "recording-missed"
            ]
            missed = sum(int(cause) for cause in causes if str(cause).isdigit() and len(cause) < 20)
        unrecorded = self.ticks.columns.get("unrecorded_arrivals")
        return missed + (0 if unrecorded is None else int(unrecorded[-1]))

    @staticmethod
    def _column(table: TopicTable, name: str, default: Any) -> NDArray[Any]:
        found = table.columns.get(name)
        return np.full(len(table), default, dtype=object) if found is None else found

    @cached_property
    def packets(self) -> NDArray[np.void]:
        """The packets that were taken, in the order of arrival: session, sequence, sent (ns), motion."""
        datagrams = self.arrivals.columns.get("datagram")
        if datagrams is None:
            return np.zeros(0, dtype=_PACKET)
        taken = np.asarray(self.arrivals.columns["is_taken"], dtype=bool)
        if datagrams.dtype == object:
            whole = [
                raw for raw, is_taken in zip(datagrams, taken, strict=True) if is_taken and len(raw) == 112
            ]
            return np.frombuffer(b"".join(whole), dtype=_PACKET)
        if datagrams.shape[1] != _PACKET.itemsize:
            return np.zeros(0, dtype=_PACKET)
        return np.frombuffer(np.ascontiguousarray(datagrams[taken]).tobytes(), dtype=_PACKET)

    @cached_property
    def partner_sessions(self) -> tuple[str, ...]:
        """The ids of the partner's sessions whose packets came, as in the events."""
        return tuple(f"{number:#018x}" for number in np.unique(self.packets["session"]).tolist())

    def clock_estimates(self) -> ClockEstimates:
        """Return what the site knew of the partner's clock, at times that increase."""
        columns, present = self.ticks.columns, self.ticks.present
        names = ("clock_offset", "clock_offset_error")
        if not all(name in columns for name in names):
            nothing = np.zeros(0, dtype=np.int64)
            return ClockEstimates(nothing, nothing, nothing)
        offset, error = (np.asarray(columns[name]) for name in names)
        # A shared clock, or the offset of a session before this one, has no packets to prove it.
        is_usable = present["clock_offset"] & present["clock_offset_error"] & (error >= 0)
        is_usable &= (np.abs(offset) < _LATEST) & (error < _LATEST)
        places = np.flatnonzero(is_usable)
        places = places[:: len(places) // _MOST_ESTIMATES + 1]
        return ClockEstimates(self.time[places], offset[places], error[places])

    def series(self, time: NDArray[np.int64]) -> SiteSeries:
        """Return the signals at the ticks, whose times on a common clock (ns) are given."""
        signals: dict[str, NDArray[Any]] = {}
        for signal in (*SIGNALS, TARGET):
            if all(field in self.ticks.columns for field in signal.fields):
                values = [self._numbers(field) for field in signal.fields]
                signals[signal.name] = np.column_stack(values) if signal.has_axes else values[0]
        signals |= {word: self.ticks.columns[word] for word in WORDS if word in self.ticks.columns}
        return SiteSeries(self.side, time, signals)

    def _numbers(self, field: str) -> FloatArray:
        values = np.asarray(self.ticks.columns[field]).astype(np.float64)
        present = self.ticks.present[field]
        if not present.all():
            values[~present] = np.nan
        return values

    def partner_series(self, to_common: Any) -> SiteSeries | None:
        """Return the partner's motion as its packets tell it, when it was measured; None without any.

        `to_common` converts this site's times (ns) to the common clock.
        """
        packets, clock = self.packets, self.clock_estimates()
        if not len(packets) or not len(clock.time):
            return None
        # The newest session: the stamps of an earlier one are of another clock.
        packets = packets[packets["session"] == packets["session"][-1]]
        packets = packets[packets["sent"] < _LATEST]
        _, first = np.unique(packets["sequence"], return_index=True)
        packets = packets[first]
        sent = packets["sent"].astype(np.int64)
        offset = int(clock.offset[-1])
        # The offset drifts by microseconds a second: what it was at about that time is exact enough to look
        # it up.
        correction = np.interp(
            (sent - offset - clock.time[0]).astype(np.float64),
            (clock.time - clock.time[0]).astype(np.float64),
            (clock.offset - offset).astype(np.float64),
        )
        local = sent - offset - np.rint(correction).astype(np.int64)
        increasing = np.concatenate([[True], np.diff(np.maximum.accumulate(local)) > 0])
        motion = packets["motion"][increasing]
        return SiteSeries(
            3 - self.side,
            to_common(local[increasing]),
            {"position": motion[:, :2], "velocity": motion[:, 2:]},
        )
