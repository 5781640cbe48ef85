"""Writes the messages of several recordings, unchanged, into one MCAP file with times of its own."""

from __future__ import annotations

import zlib
from collections import Counter
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from mcap.records import Channel, Schema

__all__ = ["MergedFile"]

_MAGIC = b"\x89MCAP0\r\n"
#: Of a message's record: where its channel and its times are, and its data begin.
_CHANNEL, _LOG_TIME, _DATA = 9, 15, 31


class MergedFile:
    """An MCAP file that takes whole chunks.

    The writer of the `mcap` package takes messages one by one: a minute for a session of ten minutes.
    """

    def __init__(self, stream: IO[bytes], library: str) -> None:
        from mcap.records import Header

        self._stream = stream
        self._stream.write(_MAGIC)
        self._schemas: dict[tuple[str, bytes], Schema] = {}
        self._channels: list[Channel] = []
        self._indices: dict[str, list[Any]] = {"chunk": [], "attachment": [], "metadata": []}
        self._counts: Counter[int] = Counter()
        self._span = (2**64 - 1, 0)
        self._write(Header("telespring", library))

    def _write(self, *records: Any) -> tuple[int, int]:
        """Write records; return where they begin, and their length."""
        from mcap.data_stream import RecordBuilder

        builder = RecordBuilder()
        for record in records:
            record.write(builder)
        begin, content = self._stream.tell(), builder.end()
        self._stream.write(content)
        return begin, len(content)

    def add_metadata(self, name: str, content: dict[str, str]) -> None:
        """Write metadata."""
        from mcap.records import Metadata, MetadataIndex

        begin, length = self._write(Metadata(name=name, metadata=content))
        self._indices["metadata"].append(MetadataIndex(offset=begin, length=length, name=name))

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Write an attachment."""
        from mcap.records import Attachment, AttachmentIndex

        stamps = {"create_time": 0, "log_time": 0}
        begin, length = self._write(Attachment(name=name, media_type=media_type, data=data, **stamps))
        self._indices["attachment"].append(
            AttachmentIndex(
                offset=begin, length=length, name=name, media_type=media_type, data_size=len(data), **stamps
            )
        )

    def add_channel(self, channel: Channel, schema: Schema | None) -> int:
        """Write a channel and, if it is new, its schema; return the number of the channel here."""
        from mcap.records import Channel, Schema

        schema_id = 0
        if schema is not None:
            key = schema.name, schema.data
            if key not in self._schemas:
                self._schemas[key] = Schema(
                    id=len(self._schemas) + 1, name=schema.name, encoding=schema.encoding, data=schema.data
                )
                self._write(self._schemas[key])
            schema_id = self._schemas[key].id
        added = Channel(
            id=len(self._channels) + 1,
            topic=channel.topic,
            message_encoding=channel.message_encoding,
            metadata=channel.metadata,
            schema_id=schema_id,
        )
        self._channels.append(added)
        self._write(added)
        return int(added.id)

    def add_messages(
        self,
        data: bytes,
        starts: NDArray[np.int64],
        ends: NDArray[np.int64],
        channels: NDArray[np.int64],
        log_times: NDArray[np.int64],
    ) -> None:
        """Write messages as one chunk: their records in `data`, in order, with these channels and times (ns).

        `starts` and `ends` are those of what the messages contain, as in `telespring.recording.mcap_file`.
        """
        import zstandard
        from mcap.records import Chunk, ChunkIndex, MessageIndex

        if not len(starts):
            return
        raw = np.frombuffer(data, dtype=np.uint8).copy()
        begins = starts - _DATA
        for width, offset, values in (("<u2", _CHANNEL, channels), ("<u8", _LOG_TIME, log_times)):
            view: NDArray[Any] = np.ndarray(
                (len(raw) - int(width[2:]) + 1,), dtype=width, buffer=raw, strides=(1,)
            )
            view[begins + offset] = values
        # Between the messages stand the channels and schemas of the old file.
        marks = np.zeros(len(raw) + 1, dtype=np.int8)
        marks[begins] += 1
        marks[ends] -= 1
        content = raw[np.cumsum(marks[:-1]) > 0].tobytes()
        places = np.concatenate([[0], np.cumsum(ends - begins)[:-1]])
        first, last = int(log_times.min()), int(log_times.max())
        packed = zstandard.compress(content)
        begin, length = self._write(
            Chunk(
                compression="zstd",
                data=packed,
                message_start_time=first,
                message_end_time=last,
                uncompressed_crc=zlib.crc32(content),
                uncompressed_size=len(content),
            )
        )
        offsets = {}
        for channel in np.unique(channels).tolist():
            own = channels == channel
            records = list(zip(log_times[own].tolist(), places[own].tolist(), strict=True))
            offsets[channel], _ = self._write(MessageIndex(channel_id=channel, records=records))
            self._counts[channel] += len(records)
        self._indices["chunk"].append(
            ChunkIndex(
                message_start_time=first,
                message_end_time=last,
                chunk_start_offset=begin,
                chunk_length=length,
                message_index_offsets=offsets,
                message_index_length=self._stream.tell() - begin - length,
                compression="zstd",
                compressed_size=len(packed),
                uncompressed_size=len(content),
            )
        )
        self._span = min(self._span[0], first), max(self._span[1], last)

    def finish(self) -> None:
        """Write what readers look for at the end: channels, counts and indices."""
        from mcap.opcode import Opcode
        from mcap.records import DataEnd, Footer, Statistics, SummaryOffset

        self._write(DataEnd(0))
        begin = self._stream.tell()
        statistics = Statistics(
            attachment_count=len(self._indices["attachment"]),
            channel_count=len(self._channels),
            channel_message_counts=dict(self._counts),
            chunk_count=len(self._indices["chunk"]),
            message_count=self._counts.total(),
            message_start_time=self._span[0] if self._counts else 0,
            message_end_time=self._span[1],
            metadata_count=len(self._indices["metadata"]),
            schema_count=len(self._schemas),
        )
        groups = (
            (Opcode.SCHEMA, list(self._schemas.values())),
            (Opcode.CHANNEL, self._channels),
            (Opcode.STATISTICS, [statistics]),
            (Opcode.CHUNK_INDEX, self._indices["chunk"]),
            (Opcode.ATTACHMENT_INDEX, self._indices["attachment"]),
            (Opcode.METADATA_INDEX, self._indices["metadata"]),
        )
        written = [(opcode, *self._write(*records)) for opcode, records in groups if records]
        offsets, _ = self._write(
            *(
                SummaryOffset(group_opcode=code, group_start=start, group_length=size)
                for code, start, size in written
            )
        )
        # 0: no checksum of the summary
        self._write(Footer(summary_start=begin, summary_offset_start=offsets, summary_crc=0))
        self._stream.write(_MAGIC)
