"""From the recording of a live session to what a replay needs of it."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._core import Study
from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.replays.sites import PACKET_LENGTH, SiteRecording

if TYPE_CHECKING:
    from telespring.recording import SideRecording
    from telespring.recording.topics import TopicTable

__all__ = ["read_sites", "site_recording"]


def read_sites(path: str | os.PathLike[str]) -> list[SiteRecording]:
    """Read the recording of one side, or the merged one of both; InvalidInput if it is none."""
    from telespring.recording import read_recording

    recording = read_recording(path)
    if recording.streams:
        raise _refuse(
            recording.first,
            "an XDF file",
            "a replay needs the packets, which are in a recording (.mcap) only",
        )
    return [site_recording(side) for side in recording.sides.values()]


def site_recording(side: SideRecording) -> SiteRecording:
    """Return what a replay needs of one side of a recording."""
    if not side.study:
        raise _refuse(side, "no study.toml", "a replay needs the study of the session")
    ticks, arrivals = side.ticks, side.arrivals
    target_position, target_velocity = _pairs(ticks, "target.position"), _pairs(ticks, "target.velocity")
    offset = _column(ticks, "clock_offset")
    places, is_kept = _places(side)
    return SiteRecording(
        study=Study.from_toml(side.study),
        side=side.side,
        session=_session(side),
        silence=_number(side, "safety", "silence_ns", 1e-9),
        stall=_number(side, "safety", "stall_ns", 1e-9),
        largest_force=_number(side, "safety", "force"),
        time=np.asarray(_column(ticks, "time"), dtype=np.uint64),
        answered=np.where(_is_present(ticks, "asked_time"), _column(ticks, "asked_time"), 0).astype(
            np.uint64
        ),
        is_given=np.asarray(_column(ticks, "is_measured"), dtype=bool) & _is_present(ticks, "own.position.x"),
        position=_pairs(ticks, "own.position"),
        velocity=_pairs(ticks, "own.velocity"),
        acted=_pairs(ticks, "told_force"),
        target_position=target_position,
        target_velocity=target_velocity,
        share=_share(side),
        wanted=_pairs(ticks, "wanted_force"),
        force=_pairs(ticks, "commanded_force"),
        clock_offset=np.where(_is_present(ticks, "clock_offset"), 1e-9 * offset.astype(np.float64), np.nan),
        arrival_tick=places,
        arrival_time=np.asarray(_column(arrivals, "time"), dtype=np.uint64)[is_kept],
        datagram=_datagrams(arrivals)[is_kept],
        steepest_rise=_number(side, "safety", "rise"),
        has_measured_force=bool(_is_present(ticks, "measured_force.x").any()),
    )


def _share(side: SideRecording) -> FloatArray:
    """Return the share of the endpoint's force that the site let act, per axis, before its limits."""
    found = side.ticks.columns.get("share")
    if found is None:
        raise _refuse(side, "ticks without a share", "a recording of this release is required")
    scale = [
        0.0
        if side.metadata.get("safety", {}).get(f"lock_{axis}") == "true"
        else _number(side, "safety", "scale")
        for axis in ("x", "y")
    ]
    # multiplied as the site does
    return np.asarray(np.outer(np.asarray(found, dtype=np.float64), scale))


def _session(side: SideRecording) -> int:
    """Return the session id, which is written in hexadecimal digits."""
    try:
        return int(side.session, 0)
    except ValueError:
        raise _refuse(side, side.session[:40] or "no session", "the id of the session is required") from None


def _number(side: SideRecording, table: str, key: str, unit: float = 1.0) -> float:
    text = side.metadata.get(table, {}).get(key, "")
    try:
        return float(text) * unit
    except ValueError:
        raise _refuse(side, f"{table}.{key} = {text[:40]!r}", "a number is required") from None


def _refuse(side: SideRecording, value: str, allowed: str) -> InvalidInput:
    return InvalidInput(
        side.path.name,
        value,
        allowed,
        "Name a file that `telespring-link` recorded, or merge two again.",
    )


def _column(table: TopicTable, name: str) -> NDArray[Any]:
    found = table.columns.get(name)
    return np.zeros(len(table)) if found is None else np.asarray(found)


def _is_present(table: TopicTable, name: str) -> NDArray[np.bool_]:
    found = table.present.get(name)
    return np.zeros(len(table), dtype=bool) if found is None else np.asarray(found)


def _pairs(table: TopicTable, name: str) -> FloatArray:
    """Return a pair of numbers for each message, NaN where it is not there."""
    columns = []
    for axis in ("x", "y"):
        values = _column(table, f"{name}.{axis}").astype(np.float64)
        columns.append(np.where(_is_present(table, f"{name}.{axis}"), values, np.nan))
    return np.column_stack(columns)


def _places(side: SideRecording) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return the place of the tick in which each datagram came, and which datagrams are kept.

    Of a tick that is missing, they go to the next one. What came in the tick in which a recording was cut off
    is left out.
    """
    numbers = np.asarray(_column(side.ticks, "tick"), dtype=np.uint64)
    came = np.asarray(_column(side.arrivals, "tick"), dtype=np.uint64)
    places = np.searchsorted(numbers, came)
    is_kept = places < len(numbers)
    return places[is_kept].astype(np.int64), is_kept


def _datagrams(arrivals: TopicTable) -> NDArray[np.uint8]:
    """Return the bytes of all datagrams; shorter ones, which are no packets, are filled up with zeros."""
    found = arrivals.columns.get("datagram")
    rows = np.zeros((len(arrivals), PACKET_LENGTH), dtype=np.uint8)
    if found is None:
        return rows
    if found.dtype != object:
        width = min(found.shape[1], PACKET_LENGTH)
        rows[:, :width] = found[:, :width]
        return rows
    for row, raw in zip(rows, found, strict=True):
        kept = bytes(raw)[:PACKET_LENGTH]
        row[: len(kept)] = np.frombuffer(kept, dtype=np.uint8)
    return rows
