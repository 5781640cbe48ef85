"""Reads an XDF file of Lab Streaming Layer: the streams that drivers/lsl sent, as the recording of a session.

XDF is what LabRecorder writes. The time stamps of each stream are of the clock of the machine that sent it.
The recorder measured every few seconds by how much its own clock differs from that: these offsets, of both
streams, put the two sites on one time base here. Times stay those of their own clocks.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.recording.common_time import CommonTime
from telespring.recording.session import SessionRecording
from telespring.recording.side import SideRecording
from telespring.recording.topics import TopicTable
from telespring.recording.xdf_clock import XdfStream, common_clock, stream_clock

__all__ = ["PHASES", "WATCHDOGS", "read_xdf"]

#: Words of the codes of docs/telemetry.md.
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
_WORDS = {"phase": PHASES, "watchdog": WATCHDOGS}
#: Channels of the stream and the fields of a tick that they are. The partner's motion is the predicted one.
_FIELDS = {
    "position x": "own.position.x",
    "position y": "own.position.y",
    "velocity x": "own.velocity.x",
    "velocity y": "own.velocity.y",
    "partner position x": "partner_predicted.position.x",
    "partner position y": "partner_predicted.position.y",
    "target position x": "target.position.x",
    "target position y": "target.position.y",
    "force x": "commanded_force.x",
    "force y": "commanded_force.y",
    "measured force x": "measured_force.x",
    "measured force y": "measured_force.y",
    "stiffness wanted": "stiffness_wanted",
    "stiffness in use": "stiffness",
    "limited": "is_limited",
    "balance": "energy_balance",
    "age": "age",
    "round trip": "round_trip",
    "lateness": "lateness",
    "device delay": "latency_device",
    "network delay": "latency_network",
    "play-out delay": "latency_playout",
}
_NEEDED = ("phase", "position x", "position y", "force x", "force y")
#: A time further from zero is none that a clock has, s.
_LATEST = 2e9
_MOST_EVENTS = 100_000
_LONGEST_TEXT = 256


def read_xdf(path: Path) -> SessionRecording:
    """Read the streams `telespring-1` and `telespring-2` of an XDF file, one or both, with their events.

    InvalidInput if there is none of them, or the file is damaged; OSError if it cannot be read.
    """
    streams = _load(path)
    sides: dict[int, SideRecording] = {}
    described: dict[int, XdfStream] = {}
    for number in (1, 2):
        stream = _choose(streams, f"telespring-{number}")
        if stream is None:
            continue
        described[number] = _describe(stream)
        events = _choose(streams, f"telespring-{number}-events")
        sides[number] = _side(path, 1 if number == 1 else 2, stream, events)
    if not sides:
        names = ", ".join(sorted({_text(stream, "name")[:40] for stream in streams})[:8])
        raise _refuse(
            path,
            f"the streams {names}" if names else "no stream",
            "the stream telespring-1 or telespring-2, with samples, is required",
            "Record what the bridge drivers/lsl offers.",
        )
    clock: CommonTime | None = None
    if len(sides) == 2:
        clock = common_clock(described[1].clock, described[2].clock)
        if clock is None and described[1].host != described[2].host:
            raise _refuse(
                path,
                "streams of two machines without clock offsets",
                "to put two sites on one time base, the recorder must have compared their clocks",
                "Record with LabRecorder, which does, for longer than 5 s.",
            )
    return SessionRecording(sides, clock=clock or _same_clock(sides), streams=described)


def _same_clock(sides: dict[int, SideRecording]) -> CommonTime | None:
    """Return the common time of two streams of one machine, whose clock is one."""
    if len(sides) < 2:
        return None
    knots = np.array([int(sides[2].time[0])], dtype=np.int64)
    return CommonTime(knots, 0, np.zeros(1), np.zeros(1), 0.0, is_linear=True, disagreement=0.0)


def _load(path: Path) -> list[dict[str, Any]]:
    try:
        import pyxdf
    except ImportError:
        raise InvalidInput(
            "path",
            path.name,
            "to read XDF files, the package pyxdf is required",
            "Install it: pip install 'telespring[xdf]'.",
        ) from None
    # Opened first, so that a missing or unreadable file is reported as such.
    with path.open("rb") as file:
        magic = file.read(4)
    if magic != b"XDF:":
        raise _refuse(path, "no XDF file", "a file that LabRecorder wrote is required", "Name another file.")
    try:
        streams, _ = pyxdf.load_xdf(
            str(path), synchronize_clocks=False, dejitter_timestamps=False, verbose=False
        )
    except Exception as error:
        # What a damaged file makes its parser raise is not documented.
        raise _refuse(
            path,
            f"a damaged file ({type(error).__name__})",
            "a whole XDF file is required",
            "Copy it again.",
        ) from None
    return list(streams)


def _text(stream: dict[str, Any], name: str) -> str:
    values = stream["info"].get(name) or [""]
    return str(values[0] or "")


def _choose(streams: list[dict[str, Any]], name: str) -> dict[str, Any] | None:
    """Return the stream of a name that has samples; of several the one with most."""
    found = [s for s in streams if _text(s, "name") == name and len(s["time_stamps"])]
    return max(found, key=lambda stream: len(stream["time_stamps"]), default=None)


def _describe(stream: dict[str, Any]) -> XdfStream:
    return XdfStream(
        name=_text(stream, "name"),
        host=_text(stream, "hostname"),
        samples=len(stream["time_stamps"]),
        clock=stream_clock(stream.get("clock_times", []), stream.get("clock_values", [])),
    )


def _side(
    path: Path, number: Literal[1, 2], stream: dict[str, Any], events: dict[str, Any] | None
) -> SideRecording:
    """Return the samples of a stream as the ticks of a site."""
    name = _text(stream, "name")
    labels = _labels(stream)
    values = np.asarray(stream["time_series"], dtype=np.float64)
    if values.ndim != 2 or values.shape[1] != len(labels) or not all(each in labels for each in _NEEDED):
        raise _refuse(
            path,
            f"{name} without {next((each for each in _NEEDED if each not in labels), 'its labels')}",
            f"channels labelled {', '.join(_NEEDED)} are required",
            "Record what the bridge drivers/lsl offers.",
        )
    stamps = np.asarray(stream["time_stamps"], dtype=np.float64)
    order = np.flatnonzero(np.isfinite(stamps) & (np.abs(stamps) < _LATEST))
    if order.size and (np.diff(stamps[order]) <= 0.0).any():
        raise _refuse(
            path,
            f"{name} with times that do not increase",
            "samples in the order of their times are required",
            "The stream was started anew on a machine whose clock was: record each session alone.",
        )
    if not order.size:
        raise _refuse(path, f"{name} without times", "samples with times are required", "Record again.")
    values, stamps = values[order], stamps[order]
    column = {label: values[:, i] for i, label in enumerate(labels)}
    time = np.rint(stamps * 1e9).astype(np.int64)
    columns: dict[str, NDArray[Any]] = {
        field: column[label] for label, field in _FIELDS.items() if label in column
    }
    is_measured = column.get("measured", np.ones(len(time))) != 0.0
    present = {field: np.isfinite(each) for field, each in columns.items()}
    for field in columns:
        if field.startswith("own."):
            present[field] &= is_measured
    for field, words in _WORDS.items():
        if field in column:
            columns[field] = _words(column[field], words)
            present[field] = np.isfinite(column[field])
    ticks, period = _tick_numbers(stamps, column.get("interval"))
    columns |= {"time": time, "tick": ticks}
    present |= {"time": np.ones(len(time), dtype=bool), "tick": np.ones(len(time), dtype=bool)}
    missed = column.get("missed", np.zeros(1))
    metadata = {
        "telespring": {"side": str(number), "session": "", "program_version": ""},
        "endpoint": {"sample_period_ns": str(round(period * 1e9))},
        "end": {"missed": str(int(np.nanmax(missed))) if np.isfinite(missed).any() else "0"},
    }
    return SideRecording(
        side=number,
        path=path,
        ticks=_table(columns, present),
        arrivals=_table({}, {}),
        events=_events(events),
        metadata=metadata,
        study="",
        summary=None,
        status="complete",
        lost_bytes=0,
        damaged_chunks=0,
    )


def _labels(stream: dict[str, Any]) -> list[str]:
    try:
        listed = stream["info"]["desc"][0]["channels"][0]["channel"]
        return [str(channel["label"][0]) for channel in listed]
    except (KeyError, IndexError, TypeError):
        return []


def _words(codes: FloatArray, words: tuple[str, ...]) -> NDArray[Any]:
    """Return the words of codes; one of a newer program is its number, an unknown one ""."""
    found = np.full(len(codes), "", dtype=object)
    for code in np.unique(codes[np.isfinite(codes)]).tolist():
        found[codes == code] = words[int(code)] if code in range(len(words)) else f"{code:g}"
    return found


def _tick_numbers(stamps: FloatArray, interval: FloatArray | None) -> tuple[NDArray[np.int64], float]:
    """Return a number for each sample, with gaps where some were left out, and the period, s."""
    steps = np.diff(stamps)
    known = np.zeros(0) if interval is None else interval[np.isfinite(interval) & (interval > 0.0)]
    period = float(np.median(known)) if known.size else float(np.median(steps)) if steps.size else 1e-3
    skipped = np.maximum(np.rint(steps / period), 1.0)
    return np.concatenate([[0], np.cumsum(skipped)]).astype(np.int64), period


def _events(stream: dict[str, Any] | None) -> TopicTable:
    """Return the events of a site: the first word is the event, the rest its cause."""
    pairs: list[tuple[int, str, str]] = []
    if stream is not None:
        for stamp, sample in zip(stream["time_stamps"], stream["time_series"], strict=False):
            if len(pairs) < _MOST_EVENTS and math.isfinite(stamp) and abs(stamp) < _LATEST:
                event, _, cause = str(sample[0])[:_LONGEST_TEXT].partition(" ")
                pairs.append((round(float(stamp) * 1e9), event, cause))
    columns: dict[str, NDArray[Any]] = {
        "time": np.array([time for time, _, _ in pairs], dtype=np.int64),
        "event": np.array([event for _, event, _ in pairs], dtype=object),
        "cause": np.array([cause for _, _, cause in pairs], dtype=object),
    }
    return _table(columns, {name: np.ones(len(pairs), dtype=bool) for name in columns})


def _table(columns: dict[str, NDArray[Any]], present: dict[str, NDArray[np.bool_]]) -> TopicTable:
    count = len(next(iter(columns.values()))) if columns else 0
    nothing = np.zeros(count, dtype=np.uint64)
    return TopicTable(columns, present, nothing, nothing, nothing.astype(np.uint32))


def _refuse(path: Path, value: str, allowed: str, remedy: str) -> InvalidInput:
    return InvalidInput(path.name, value, allowed, remedy)
