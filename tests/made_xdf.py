"""XDF files, written chunk by chunk as the specification of the format has them, without its library."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

HEADER, STREAM, SAMPLES, CLOCK, FOOTER = 1, 2, 3, 4, 6


@dataclass
class MadeStream:
    """A stream: its samples (rows) or texts, and the offsets that a recorder measured (time, offset)."""

    name: str
    stamps: NDArray[np.float64]
    samples: NDArray[np.float64] | Sequence[str]
    labels: Sequence[str] = ()
    offsets: Sequence[tuple[float, float]] = ()
    host: str = "one"
    rate: float = 0.0
    parts: int = field(default=2)

    @property
    def is_text(self) -> bool:
        return not isinstance(self.samples, np.ndarray)


def chunk(tag: int, content: bytes) -> bytes:
    body = struct.pack("<H", tag) + content
    return b"\x04" + struct.pack("<I", len(body)) + body


def count(number: int) -> bytes:
    return b"\x04" + struct.pack("<I", number)


def header(stream: MadeStream) -> bytes:
    channels = "".join(f"<channel><label>{escape(label)}</label></channel>" for label in stream.labels)
    text = (
        f"<?xml version='1.0'?><info><name>{escape(stream.name)}</name><type>Haptics</type>"
        f"<channel_count>{1 if stream.is_text else len(stream.labels)}</channel_count>"
        f"<nominal_srate>{stream.rate:g}</nominal_srate>"
        f"<channel_format>{'string' if stream.is_text else 'double64'}</channel_format>"
        f"<hostname>{stream.host}</hostname><desc><channels>{channels}</channels></desc></info>"
    )
    return text.encode()


def row(stream: MadeStream, place: int) -> bytes:
    stamp = b"\x08" + struct.pack("<d", stream.stamps[place])
    if isinstance(stream.samples, np.ndarray):
        return stamp + bytes(stream.samples[place].astype("<f8").tobytes())
    text = stream.samples[place].encode()
    return stamp + count(len(text)) + text


def write_xdf(path: Path, streams: Sequence[MadeStream]) -> Path:
    """Write a file as LabRecorder does."""
    parts = [b"XDF:", chunk(HEADER, b"<?xml version='1.0'?><info><version>1.0</version></info>")]
    for number, stream in enumerate(streams, 1):
        own = struct.pack("<I", number)
        parts.append(chunk(STREAM, own + header(stream)))
        for places in np.array_split(np.arange(len(stream.stamps)), stream.parts):
            rows = b"".join(row(stream, int(place)) for place in places)
            parts.append(chunk(SAMPLES, own + count(len(places)) + rows))
        parts += [chunk(CLOCK, own + struct.pack("<dd", *pair)) for pair in stream.offsets]
        parts.append(chunk(FOOTER, own + b"<?xml version='1.0'?><info></info>"))
    path.write_bytes(b"".join(parts))
    return path
