"""Reads the records of an MCAP file, whole or cut off anywhere, and believes no length that it states."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._quantities import format_count

if TYPE_CHECKING:
    from mcap.records import Channel, Schema

__all__ = ["Chunk", "McapFile", "Messages", "refuse_file"]

_MAGIC = b"\x89MCAP0\r\n"
_HEADER, _FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK = 0x01, 0x02, 0x03, 0x04, 0x05, 0x06
_ATTACHMENT, _METADATA = 0x09, 0x0C

#: A chunk of half a second has 0.5 MB; what is much larger was not written by the live program.
_LARGEST_CHUNK = 64 * 2**20
#: A record outside the chunks: the study and the site file are a few kilobytes.
_LARGEST_RECORD = 4 * 2**20
_MOST_CHANNELS = 1000
#: Records in a chunk that are no messages: a channel and a schema each.
_MOST_OTHERS = 2 * _MOST_CHANNELS
#: Five and a half hours at 1 kHz with ticks and arrivals.
_MOST_MESSAGES = 40_000_000

_RECORD = struct.Struct("<BQ")
_MESSAGE_START = struct.Struct("<BQH")
#: From the beginning of a message's record to its fields: opcode, length, channel, sequence, two times.
_SEQUENCE, _LOG_TIME, _PUBLISH_TIME, _DATA = 11, 15, 23, 31


def refuse_file(name: str, value: str, allowed: str, remedy: str = "") -> InvalidInput:
    """Return the refusal of a file that is no recording of a live session."""
    return InvalidInput(
        name,
        value,
        allowed,
        remedy or "Name a file that `telespring-link` recorded, or that `telespring merge` wrote.",
    )


@dataclass(frozen=True)
class Messages:
    """Messages of one channel in a chunk.

    Attributes
    ----------
    starts, ends
        Where their bytes are in the chunk.
    log_time, publish_time
        ns, as the file has them.
    """

    starts: NDArray[np.int64]
    ends: NDArray[np.int64]
    log_time: NDArray[np.uint64]
    publish_time: NDArray[np.uint64]
    sequence: NDArray[np.uint32]


@dataclass(frozen=True)
class Chunk:
    """The bytes of a whole chunk, and its messages by channel."""

    data: bytes
    messages: dict[int, Messages]


@dataclass
class McapFile:
    """An MCAP file, read from its beginning; what the attributes say is known once `chunks` is exhausted.

    Attributes
    ----------
    path
        The file.
    profile, library
        What its header says.
    channels, schemas
        By their numbers.
    metadata
        By name; of two with one name the later counts. A long session may repeat one.
    attachments
        By name, as far as they are small.
    is_complete
        Whether the file has its end.
    lost_bytes
        Bytes behind the last whole record.
    damaged_chunks
        Chunks that are there, but whose bytes are not those that were written.
    """

    path: Path
    profile: str = ""
    library: str = ""
    channels: dict[int, Channel] = field(default_factory=dict)
    schemas: dict[int, Schema] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    is_complete: bool = False
    lost_bytes: int = 0
    damaged_chunks: int = 0
    _count: int = 0

    @property
    def name(self) -> str:
        """The name of the file without its folder."""
        return self.path.name

    def chunks(self) -> Iterator[Chunk]:
        """Yield the whole chunks in the order of the file.

        InvalidInput if it is no MCAP file, or states sizes that no session has; OSError if it cannot be read.
        """
        with self.path.open("rb") as file:
            size = self.path.stat().st_size
            if size == 0:
                raise refuse_file(self.name, "empty", "a recording of a live session is required")
            start = file.read(len(_MAGIC))
            if start != _MAGIC[: len(start)]:
                raise refuse_file(self.name, "another format", "an MCAP file is required")
            place = len(_MAGIC)
            while True:
                head = file.read(_RECORD.size)
                if len(head) < _RECORD.size:
                    break
                opcode, length = _RECORD.unpack(head)
                if length > size - place - _RECORD.size:
                    break
                if opcode == _CHUNK:
                    chunk = self._chunk(file, length)
                    if chunk is not None:
                        yield chunk
                elif length > _LARGEST_RECORD:
                    file.seek(length, 1)
                else:
                    self._record(opcode, file.read(length))
                place += _RECORD.size + length
                if opcode == _FOOTER:
                    self.is_complete = file.read(len(_MAGIC)) == _MAGIC
                    break
            if not self.is_complete:
                self.lost_bytes = max(0, size - place)

    def _record(self, opcode: int, content: bytes) -> None:
        """Take a record outside the chunks, or a schema or channel inside; a damaged one counts as absent."""
        from mcap import records
        from mcap.data_stream import ReadDataStream
        from mcap.exceptions import EndOfFile

        stream = ReadDataStream(BytesIO(content))
        try:
            if opcode == _HEADER:
                header = records.Header.read(stream)
                self.profile, self.library = header.profile, header.library
            elif opcode == _SCHEMA:
                schema = records.Schema.read(stream)
                self.schemas[schema.id] = schema
            elif opcode == _CHANNEL:
                channel = records.Channel.read(stream)
                self.channels[channel.id] = channel
            elif opcode == _METADATA:
                metadata = records.Metadata.read(stream)
                self.metadata[metadata.name] = metadata.metadata
            elif opcode == _ATTACHMENT:
                attachment = records.Attachment.read(stream)
                self.attachments[attachment.name] = attachment.data
        except (EndOfFile, struct.error, UnicodeDecodeError):
            return
        if (
            max(len(self.channels), len(self.schemas), len(self.metadata), len(self.attachments))
            > _MOST_CHANNELS
        ):
            raise refuse_file(
                self.name,
                f"more than {_MOST_CHANNELS} channels",
                "a recording of a live session has fewer than 100",
            )

    def _chunk(self, file: Any, length: int) -> Chunk | None:
        """Read a chunk whose bytes are all there; None if they are not those that were written."""
        if length > _LARGEST_CHUNK:
            raise self._too_large(length)
        try:
            data = self._decompress(file.read(length))
        except InvalidInput:  # is a ValueError, too
            raise
        except (ValueError, RuntimeError, EOFError, struct.error):
            data = None
        if data is None:
            self.damaged_chunks += 1
            return None
        return Chunk(data, self._messages(data))

    def _decompress(self, content: bytes) -> bytes | None:
        _, _, size, checksum, name_length = struct.unpack_from("<QQQII", content)
        at = 32 + name_length
        compression = content[32:at]
        (stored,) = struct.unpack_from("<Q", content, at)
        packed = content[at + 8 :]
        if stored != len(packed):
            return None
        if size > _LARGEST_CHUNK:
            raise self._too_large(size)
        if compression == b"lz4":
            from lz4.frame import LZ4FrameDecompressor

            # One byte more than stated, so that more than that is noticed.
            data = bytes(LZ4FrameDecompressor().decompress(packed, max_length=size + 1))
        elif compression == b"zstd":
            from zstandard import ZstdDecompressor, ZstdError

            try:
                data = ZstdDecompressor().stream_reader(packed).read(size + 1)
            except ZstdError as error:
                raise ValueError from error
        elif compression == b"":
            data = packed
        else:
            raise refuse_file(
                self.name,
                f"compressed by {compression[:40]!r}",
                "chunks compressed by lz4 or zstd, or not at all, are required",
            )
        if len(data) != size or checksum not in (0, zlib.crc32(data)):
            return None
        return data

    def _too_large(self, size: int) -> InvalidInput:
        return refuse_file(
            self.name,
            f"a chunk of {size / 2**20:.0f} MB",
            f"chunks of at most {_LARGEST_CHUNK // 2**20} MB, of half a second each, are required",
        )

    def _messages(self, data: bytes) -> dict[int, Messages]:
        """Find the messages in the bytes of a chunk."""
        places: dict[int, list[int]] = {}
        place, end = 0, len(data)
        unpack = _MESSAGE_START.unpack_from
        last = end - _DATA
        others = 0
        while place <= last:
            opcode, length, channel = unpack(data, place)
            following = place + 9 + length
            if following > end:
                break
            if opcode == _MESSAGE:
                if length < _DATA - 9:
                    break
                try:
                    places[channel].append(place)
                except KeyError:
                    places[channel] = [place]
            else:
                others += 1
                if others > _MOST_OTHERS:
                    break
                self._record(opcode, data[place + 9 : following])
            place = following
        while place + 9 <= end and others <= _MOST_OTHERS:  # a short record at the end
            opcode, length = _RECORD.unpack_from(data, place)
            if length > end - place - 9:
                break
            others += 1
            self._record(opcode, data[place + 9 : place + 9 + length])
            place += 9 + length
        self._count += sum(len(found) for found in places.values())
        if self._count > _MOST_MESSAGES:
            raise refuse_file(
                self.name,
                f"more than {format_count(_MOST_MESSAGES, 'message')}",
                "a session of at most 5 h is required",
            )
        return {channel: _messages_at(data, found) for channel, found in places.items()}


def _messages_at(data: bytes, places: list[int]) -> Messages:
    at = np.array(places, dtype=np.int64)

    def take(code: str, offset: int) -> NDArray[Any]:
        view: NDArray[Any] = np.ndarray(
            (len(data) - int(code[2:]) + 1,), dtype=code, buffer=data, strides=(1,)
        )
        return view[at + offset]

    return Messages(
        starts=at + _DATA,
        ends=at + 9 + take("<u8", 1).astype(np.int64),
        log_time=take("<u8", _LOG_TIME),
        publish_time=take("<u8", _PUBLISH_TIME),
        sequence=take("<u4", _SEQUENCE),
    )
