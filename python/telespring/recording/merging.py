"""Merges the recordings of both sites of a session into one, on one time base."""

from __future__ import annotations

import heapq
import json
import os
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np

from telespring._errors import InvalidInput
from telespring._files import replacing
from telespring.recording.mcap_file import McapFile
from telespring.recording.merged_file import MergedFile
from telespring.recording.reading import read_recording
from telespring.recording.session import SessionRecording

if TYPE_CHECKING:
    from telespring.recording.side import SideRecording

__all__ = ["merge_recordings"]


def merge_recordings(
    first: str | os.PathLike[str], second: str | os.PathLike[str], out: str | os.PathLike[str] | None = None
) -> SessionRecording:
    """Put the recordings of both sites of one session on one time base, that of robot 1.

    Each site knows the other's clock with a bound on the error. The bounds of both sites over the whole
    session are intersected; what is left is the uncertainty of the common time (`clock` of the result). Where
    they contradict each other, `clock.disagreement` says by how much.

    Parameters
    ----------
    first, second : str or path
        The files of both sites, in any order.
    out : str or path, optional
        Where to write the merged recording, an MCAP file. It has every message of both files as it was; only
        the times at which the messages are shown (`log_time`) are those of the common clock.

    Returns
    -------
    SessionRecording
        Both sites, as `read_recording` of the merged file gives them.

    Raises
    ------
    telespring.InvalidInput
        If both are of one robot, of different studies, or of different sessions, or if no site knew the
        other's clock.
    OSError
        If a file cannot be read or written.

    Examples
    --------
    >>> import telespring as ts
    >>> try:
    ...     ts.merge_recordings("session.mcap", "session.mcap")
    ... except ts.InvalidInput as refused:
    ...     print(refused.remedy)
    A merged file has both sites already: analyse it as it is.
    """
    one, other = read_recording(first), read_recording(second)
    if one.streams or other.streams:
        raise InvalidInput(
            "recordings",
            "an XDF file",
            "two recordings of telespring-link (.mcap) are required",
            "Record both streams into one XDF file: its recorder compares their clocks.",
        )
    both = [*one.sides.values(), *other.sides.values()]
    _check_pair(both)
    merged = SessionRecording({side.side: side for side in both})
    # Refused here, before anything is written.
    merged.common_times(both[1].side, both[1].time[:1])
    merged.common_times(both[0].side, both[0].time[:1])
    if out is not None:
        target = Path(out)
        if target.suffix.lower() != ".mcap":
            raise InvalidInput(
                "out",
                str(out),
                "the name of an MCAP file is required",
                f"Write {target.with_suffix('.mcap')}.",
            )
        with replacing(target) as beside, beside.open("wb") as stream:
            _write(merged, stream)
    return merged


def _check_pair(sides: list[SideRecording]) -> None:
    """Refuse two recordings that are not those of both sites of one session."""
    if len(sides) != 2:
        counts = " and ".join(str(side.side) for side in sides)
        raise InvalidInput(
            "recordings",
            f"of the robots {counts}",
            "two files of one site each are required",
            "A merged file has both sites already: analyse it as it is.",
        )
    one, other = sides
    if one.side == other.side:
        raise InvalidInput(
            "recordings",
            f"both of robot {one.side}",
            "the files of robot 1 and of robot 2 are required",
            "Name the file of the other site.",
        )
    if one.study and other.study and one.study != other.study:
        named = [side.metadata["telespring"].get("study", "")[:60] or "unnamed" for side in sides]
        raise InvalidInput(
            "study",
            f"{_named(one, named[0])}, {_named(other, named[1])}, and their texts differ",
            "both sites of a session have the same study",
            "Name the two files of one session.",
        )
    for own, partner in ((one, other), (other, one)):
        heard = own.partner_sessions
        if heard and partner.session and partner.session not in heard:
            raise InvalidInput(
                "session",
                f"{_named(partner, partner.session[:20])}, but {own.path.name} heard {', '.join(heard[:3])}",
                "both files must be of one session",
                "Name the two files of one session: their names begin with about the same time.",
            )
    if not one.partner_sessions and not other.partner_sessions:
        raise InvalidInput(
            "session",
            f"{_named(one, one.session[:20])}, {_named(other, other.session[:20])}",
            "one of the sites must have heard the other",
            "Look at each recording alone: the sites never were in contact.",
        )


def _named(side: SideRecording, value: str) -> str:
    return f"{value} in {side.path.name}"


def _write(merged: SessionRecording, stream: IO[bytes]) -> None:
    """Write all messages of both files with the times of the common clock, chunk by chunk."""
    out = MergedFile(stream, "telespring merge")
    files = []
    for number, side in merged.sides.items():
        for name, content in side.metadata.items():
            out.add_metadata(f"site{number}/{name}", content)
        if side.study:
            out.add_attachment(f"site{number}/study.toml", "application/toml", side.study.encode())
        if side.summary is not None:
            out.add_attachment(
                f"site{number}/summary.json", "application/json", json.dumps(side.summary).encode()
            )
        files.append((side, McapFile(side.path)))
    if merged.clock is not None:
        out.add_metadata(
            "common time",
            {
                "uncertainty": repr(merged.clock.uncertainty),
                "drift": repr(merged.clock.drift),
                "disagreement": repr(merged.clock.disagreement * 1e-9),
            },
        )
    chunks = (_chunks(merged, side, file, out) for side, file in files)
    for _, _, write in heapq.merge(*chunks, key=lambda chunk: chunk[:2]):
        write()
    out.finish()


def _chunks(
    merged: SessionRecording, side: SideRecording, file: McapFile, out: MergedFile
) -> Iterator[tuple[int, int, Callable[[], None]]]:
    """Yield the chunks of a file: when they begin on the common clock, of which side, how to write them."""
    zero, shown_zero = side.wall_time_zero, merged.first.wall_time_zero
    numbers: dict[int, int] = {}
    for chunk in file.chunks():
        known = {number: found for number, found in chunk.messages.items() if number in file.channels}
        if not known:
            continue
        for number in known.keys() - numbers.keys():
            channel = file.channels[number]
            numbers[number] = out.add_channel(channel, file.schemas.get(channel.schema_id))
        channels = np.concatenate([np.full(len(each.starts), numbers[n]) for n, each in known.items()])
        starts, ends, logged = (
            np.concatenate([getattr(each, name) for each in known.values()]).astype(np.int64)
            for name in ("starts", "ends", "log_time")
        )
        common = np.maximum(merged.common_times(side.side, logged - zero) + shown_zero, 0)
        # In the order in which they were written, which a replay needs.
        order = np.argsort(starts, kind="stable")
        write = partial(
            out.add_messages, chunk.data, starts[order], ends[order], channels[order], common[order]
        )
        yield int(common.min()), side.side, write
