"""Reads a recording of a live session: of one site, or merged of both."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from telespring._arrays import quoted_value
from telespring._errors import InvalidInput
from telespring.recording.mcap_file import McapFile, refuse_file
from telespring.recording.session import SessionRecording
from telespring.recording.side import SideRecording
from telespring.recording.topics import TopicTable, read_topics

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["FORMAT_VERSION", "is_recording", "read_recording"]

#: The version of the format that docs/recording.md describes.
FORMAT_VERSION = 1
_TOPIC = re.compile(r"/site([12])/(tick|arrival|event)")
#: Fields without which a message says nothing.
_NEEDED = {
    "tick": (
        "tick",
        "time",
        "phase",
        "own.position.x",
        "own.position.y",
        "commanded_force.x",
        "commanded_force.y",
    ),
    "arrival": ("tick", "time", "is_taken", "datagram"),
    "event": ("time", "event"),
}
_LATEST = 2**62


def is_recording(path: str | os.PathLike[str]) -> bool:
    """Whether a file is named as a recording of a live session is.

    Examples
    --------
    >>> is_recording("session.mcap"), is_recording("session.xdf"), is_recording("rehearsal.nc")
    (True, True, False)
    """
    return Path(path).suffix.lower() in {".mcap", ".xdf"}


def read_recording(path: str | os.PathLike[str]) -> SessionRecording:
    """Read the recording of a live session, of one site or of both, whole or cut off.

    Of a file whose end is missing, because the program was killed, everything in whole chunks is read; the
    result says up to when.

    Parameters
    ----------
    path : str or path
        A file that `telespring-link` recorded or that `merge_recordings` wrote (``.mcap``). docs/recording.md
        describes it. Or what LabRecorder recorded of the bridge to Lab Streaming Layer (``.xdf``, needs
        pyxdf; docs/formats.md).

    Returns
    -------
    SessionRecording
        The ticks, arrivals and events of each site, and the session as a dataset.

    Raises
    ------
    telespring.InvalidInput
        If the file is no recording of a live session, is empty, is of a newer version, or states sizes that
        no session has.
    OSError
        If the file cannot be read.

    Examples
    --------
    >>> import telespring as ts
    >>> recording = ts.read_recording("session.mcap")
    >>> recording.status, sorted(recording.sides)
    ('complete', [1, 2])
    >>> session = recording.dataset()
    >>> session["position"].dims
    ('time', 'robot', 'axis')
    """
    try:
        place = Path(path)
    except TypeError:
        raise InvalidInput(
            "path", quoted_value(path), "the name of a file is required", "Give it as text or as a Path."
        ) from None
    if place.suffix.lower() == ".xdf":
        from telespring.recording.xdf_file import read_xdf

        return read_xdf(place)
    file, tables = read_topics(place, lambda topic: _TOPIC.fullmatch(topic) is not None)
    sides = sorted({int(found[1]) for topic in tables if (found := _TOPIC.fullmatch(topic))})
    _check_version(file)
    if not sides or any(f"/site{side}/tick" not in tables for side in sides):
        raise refuse_file(
            file.name,
            "no tick",
            "a recording with at least one tick of its site is required",
            "The program was killed before it had written any." if not file.is_complete else "",
        )
    return SessionRecording({side: _side(file, tables, side) for side in sides})


def _check_version(file: McapFile) -> None:
    """Refuse what is no recording, and what this version does not know."""
    described = [
        metadata for name, metadata in file.metadata.items() if name.rpartition("/")[2] == "telespring"
    ]
    if not described:
        raise refuse_file(
            file.name,
            f"an MCAP file of {file.library[:60] or 'another program'}",
            "a recording of telespring-link is required",
        )
    for metadata in described:
        text = metadata.get("format_version", "")
        if not text.isdigit() or int(text[:9]) < 1:
            raise refuse_file(file.name, f"format version {text[:20]!r}", "a whole number from 1 is required")
        if int(text[:9]) > FORMAT_VERSION:
            raise refuse_file(
                file.name,
                f"format version {text[:9]}",
                f"a version up to {FORMAT_VERSION} is required",
                f"It was written by telespring {metadata.get('program_version', '')[:20]}: use that version.",
            )


def _side(file: McapFile, tables: dict[str, TopicTable], side: int) -> SideRecording:
    prefix = f"site{side}/"
    is_merged = any(name.startswith("site") for name in file.metadata)

    def own(records: dict[str, Any]) -> dict[str, Any]:
        """Choose the records of this side: a merged file has each under the name of its site."""
        if not is_merged:
            return records
        return {
            name.removeprefix(prefix): record for name, record in records.items() if name.startswith(prefix)
        }

    metadata = own(file.metadata)
    stated = metadata.get("telespring", {}).get("side")
    if stated != str(side):
        raise refuse_file(
            file.name, f"messages of site {side} of a recording of site {str(stated)[:10]}", "they must agree"
        )
    ticks = tables[f"/site{side}/tick"]
    found = {kind: tables.get(f"/site{side}/{kind}", _empty(kind)) for kind in ("arrival", "event")} | {
        "tick": ticks
    }
    for kind, table in found.items():
        missing = [field for field in _NEEDED[kind] if field not in table.columns]
        if missing:
            raise refuse_file(
                file.name,
                f"/site{side}/{kind} without {missing[0]}",
                f"{', '.join(_NEEDED[kind])} are required",
            )
    time = np.asarray(ticks.columns["time"])
    if time.dtype.kind not in "iu" or (time >= _LATEST).any() or (np.diff(time.astype(np.int64)) <= 0).any():
        raise refuse_file(
            file.name,
            "ticks whose times do not increase",
            "ticks in the order in which they were are required",
            "The file was changed: take the one that was recorded.",
        )
    attachments = own(file.attachments)
    is_damaged = bool(file.damaged_chunks) or not file.is_complete or "end" not in metadata
    status: Literal["complete", "truncated"] = "truncated" if is_damaged else "complete"
    return SideRecording(
        side=1 if side == 1 else 2,
        path=file.path,
        ticks=ticks,
        arrivals=found["arrival"],
        events=found["event"],
        metadata=metadata,
        study=attachments.get("study.toml", b"").decode("utf-8", "replace"),
        summary=_summary(attachments.get("summary.json")),
        status=status,
        lost_bytes=file.lost_bytes,
        damaged_chunks=file.damaged_chunks,
    )


def _summary(text: bytes | None) -> dict[str, Any] | None:
    if text is None:
        return None
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return value if isinstance(value, dict) else None


def _empty(kind: str) -> TopicTable:
    """Return the table of a topic without messages."""
    kinds: dict[str, Any] = {"event": object, "cause": object, "is_taken": bool, "datagram": object}
    columns: dict[str, NDArray[Any]] = {
        field: np.zeros(0, dtype=kinds.get(field, np.uint64)) for field in _NEEDED[kind]
    }
    present = {field: np.zeros(0, dtype=bool) for field in columns}
    nothing = np.zeros(0, dtype=np.uint64)
    return TopicTable(columns, present, nothing, nothing, nothing.astype(np.uint32))
