"""The telemetry stream (docs/telemetry.md): its rows, and the socket on which they come."""

from __future__ import annotations

import math
import socket
import struct
from typing import NamedTuple

VERSION = 1.0
ROW = struct.Struct("<40d")
MOST_ROWS = 1000  # datagrams that one look takes
LONGEST_MARK = 128  # characters of a marker
Row = tuple[float, ...]

# name and unit of each place; the rest is not used
COLUMNS = (
    ("version", ""),
    ("sequence", ""),
    ("side", ""),
    ("time", "s"),
    ("phase", ""),
    ("watchdog", ""),
    ("measured", ""),
    ("position x", "m"),
    ("position y", "m"),
    ("velocity x", "m/s"),
    ("velocity y", "m/s"),
    ("partner position x", "m"),
    ("partner position y", "m"),
    ("partner velocity x", "m/s"),
    ("partner velocity y", "m/s"),
    ("target position x", "m"),
    ("target position y", "m"),
    ("target velocity x", "m/s"),
    ("target velocity y", "m/s"),
    ("force x", "N"),
    ("force y", "N"),
    ("measured force x", "N"),
    ("measured force y", "N"),
    ("stiffness wanted", "N/m"),
    ("stiffness in use", "N/m"),
    ("limited", ""),
    ("balance", "J"),
    ("age", "s"),
    ("silence", "s"),
    ("round trip", "s"),
    ("clock error", "s"),
    ("lateness", "s"),
    ("device delay", "s"),
    ("network delay", "s"),
    ("play-out delay", "s"),
    ("interval", "s"),
    ("missed", ""),
    ("marker", ""),
)
PLACE = {name: place for place, (name, _) in enumerate(COLUMNS)}
PHASES = (
    "connecting",
    "homing",
    "aligning",
    "consenting",
    "ramping-in",
    "running",
    "ramping-out",
    "paused",
    "stopped",
    "ended",
)
WATCHDOGS = ("disengaged", "ramping-in", "engaged", "holding", "ramping-out")


def decode(datagram: bytes) -> Row | None:
    """Return the values of a row; None for another version, or one that does not say when and whose it is."""
    if len(datagram) != ROW.size:
        return None
    row: Row = ROW.unpack(datagram)
    stamp = (row[PLACE["sequence"]], row[PLACE["time"]], row[PLACE["interval"]])
    is_known = row[0] == VERSION and row[PLACE["side"]] in (1.0, 2.0) and all(map(math.isfinite, stamp))
    return row if is_known and row[PLACE["interval"]] > 0.0 else None


def word(words: tuple[str, ...], code: float) -> str | None:
    """Return the word of a code, the code itself for one of a newer program, None if it is not known."""
    if math.isnan(code):
        return None
    return words[int(code)] if code in range(len(words)) else f"{code:g}"


class Mark(NamedTuple):
    """A marker: when it was set, s, by the monotonic clock, and what it says."""

    time: float
    text: str  # its kind, then its label


def decode_mark(datagram: bytes) -> Mark | None:
    """Return the marker in a datagram; None if it is none."""
    try:
        word, time, text = datagram.decode("ascii").split(" ", 2)
        mark = Mark(float(time), text)
    except ValueError:
        return None
    return mark if word == "mark" and math.isfinite(mark.time) and len(datagram) <= LONGEST_MARK else None


class Source:
    """Where the rows and the markers come."""

    def __init__(self, listen: tuple[str, int]) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(listen)

    def rows(self, patience: float) -> tuple[list[Row], list[Mark]]:
        """Wait for `patience` s at most; return the rows and the markers that have come."""
        self._socket.settimeout(patience)
        rows, marks = [], []
        for _ in range(MOST_ROWS):
            try:
                datagram = self._socket.recv(1024)
            except (TimeoutError, BlockingIOError):
                break
            if (row := decode(datagram)) is not None:
                rows.append(row)
            elif (mark := decode_mark(datagram)) is not None:
                marks.append(mark)
            self._socket.setblocking(False)
        return rows, marks

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()
