"""The messages of a recording as tables: one for each topic, with a column for each field."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from telespring.recording.columns import PADDING, Column, MalformedMessage, decode_messages
from telespring.recording.mcap_file import Chunk, McapFile, Messages, refuse_file
from telespring.recording.schema import MessageLayout, message_layout

__all__ = ["TopicTable", "read_topics"]

#: So many messages are decoded at once: their columns stay in the processor's cache.
_BLOCK = 8192
#: Bytes of chunks that wait to be decoded.
_BATCH_BYTES = 16 * 2**20
#: The longest text; more is cut off.
_LONGEST_TEXT = 4096


@dataclass(frozen=True)
class TopicTable:
    """All messages of a topic, in the order of the file.

    Attributes
    ----------
    columns
        By field, "a.b" for a field of a message inside: an array of numbers, of texts (str), or of bytes: (n,
        length) where all are as long, otherwise of objects.
    present
        Which messages have the field; absent numbers are NaN where they are of floating point, else 0.
    log_time, publish_time
        ns, as in the file.
    sequence
        The number of the message, as its writer counted.
    """

    columns: dict[str, NDArray[Any]]
    present: dict[str, NDArray[np.bool_]]
    log_time: NDArray[np.uint64]
    publish_time: NDArray[np.uint64]
    sequence: NDArray[np.uint32]

    def __len__(self) -> int:
        return len(self.log_time)


def read_topics(path: Path, is_wanted: Any) -> tuple[McapFile, dict[str, TopicTable]]:
    """Read the topics for which `is_wanted` returns True; the file says how whole it is.

    InvalidInput if it is no MCAP file, or its messages do not fit their schemas; OSError if it cannot be
    read.
    """
    file = McapFile(path)
    reader = _TopicReader(file, is_wanted)
    for chunk in file.chunks():
        reader.add(chunk)
    reader.decode()
    return file, reader.tables()


class _TopicReader:
    """Collects the chunks, and decodes them some at a time."""

    def __init__(self, file: McapFile, is_wanted: Any) -> None:
        self._file, self._is_wanted = file, is_wanted
        self._chunks: list[Chunk] = []
        self._bytes = 0
        self._layouts: dict[str, tuple[int, bytes, MessageLayout]] = {}
        self._parts: dict[str, list[TopicTable]] = {}

    def add(self, chunk: Chunk) -> None:
        self._chunks.append(chunk)
        self._bytes += len(chunk.data)
        if self._bytes > _BATCH_BYTES:
            self.decode()

    def decode(self) -> None:
        waiting: dict[str, list[tuple[int, Messages]]] = {}
        offset = 0
        for chunk in self._chunks:
            for number, messages in chunk.messages.items():
                channel = self._file.channels.get(number)
                if channel is not None and self._is_wanted(channel.topic):
                    self._lay_out(channel)
                    waiting.setdefault(channel.topic, []).append((offset, messages))
            offset += len(chunk.data)
        buffer = np.frombuffer(
            b"".join([*(chunk.data for chunk in self._chunks), bytes(PADDING)]), dtype=np.uint8
        )
        self._chunks, self._bytes = [], 0
        for topic, found in waiting.items():
            starts = np.concatenate([messages.starts + begin for begin, messages in found])
            ends = np.concatenate([messages.ends + begin for begin, messages in found])
            stamps = [
                np.concatenate([getattr(messages, name) for _, messages in found])
                for name in ("log_time", "publish_time", "sequence")
            ]
            for at in range(0, len(starts), _BLOCK):
                block = slice(at, at + _BLOCK)
                table = self._table(topic, buffer, starts[block], ends[block], [s[block] for s in stamps])
                self._parts.setdefault(topic, []).append(table)

    def _lay_out(self, channel: Any) -> None:
        """Take the schema of a channel; the schema of a topic stays the same throughout a file."""
        schema = self._file.schemas.get(channel.schema_id)
        if channel.message_encoding != "protobuf" or schema is None or schema.encoding != "protobuf":
            raise refuse_file(
                self._file.name,
                f"{channel.topic[:80]} encoded as {channel.message_encoding[:40] or 'nothing'}",
                "messages in protobuf, with their schema, are required",
            )
        known = self._layouts.get(channel.topic)
        if known is None:
            layout = message_layout(schema.data, schema.name)
            self._layouts[channel.topic] = schema.id, schema.data, layout
        elif known[1] != schema.data:
            raise refuse_file(
                self._file.name, f"{channel.topic[:80]} with two schemas", "one schema per topic is required"
            )

    def _table(
        self,
        topic: str,
        buffer: NDArray[np.uint8],
        starts: NDArray[np.int64],
        ends: NDArray[np.int64],
        stamps: list[NDArray[Any]],
    ) -> TopicTable:
        try:
            decoded = decode_messages(buffer, starts, ends, self._layouts[topic][2])
        except MalformedMessage:
            raise refuse_file(
                self._file.name,
                f"a message of {topic[:80]} that is not what its schema says",
                "messages as their schema has them are required",
                "The file was written by another program, or changed: record again.",
            ) from None
        return TopicTable(
            {name: _array(buffer, column) for name, column in decoded.items()},
            {name: column.present for name, column in decoded.items()},
            *stamps,
        )

    def tables(self) -> dict[str, TopicTable]:
        return {topic: _joined(parts) for topic, parts in self._parts.items()}


def _array(buffer: NDArray[np.uint8], column: Column) -> NDArray[Any]:
    """Return the values of a column; texts and bytes are copied from the buffer."""
    if column.lengths is None:
        return column.numbers() if column.values.dtype == np.float64 else column.values
    starts, lengths = column.values, column.lengths
    if column.kind == "bytes":
        length = int(lengths.max(initial=0))
        if (lengths == length).all():
            rows: NDArray[np.uint8] = buffer[starts[:, None] + np.arange(length)]
            return rows
        pieces = np.empty(len(starts), dtype=object)
        pieces[:] = [
            buffer[start : start + size].tobytes() for start, size in zip(starts, lengths, strict=True)
        ]
        return pieces
    # Most texts are words that repeat: each is decoded once.
    words: dict[bytes, str] = {}
    texts = np.empty(len(starts), dtype=object)
    for i, (start, size) in enumerate(zip(starts.tolist(), lengths.tolist(), strict=True)):
        raw = buffer[start : start + min(size, _LONGEST_TEXT)].tobytes()
        if raw not in words:
            words[raw] = raw.decode("utf-8", "replace")
        texts[i] = words[raw]
    return texts


def _joined(parts: Collection[TopicTable]) -> TopicTable:
    if len(parts) == 1:
        return next(iter(parts))
    first = next(iter(parts))
    columns: dict[str, NDArray[Any]] = {}
    for name in first.columns:
        pieces = [part.columns[name] for part in parts]
        if len({(piece.dtype, piece.shape[1:]) for piece in pieces}) > 1:
            pieces = [_as_objects(piece) for piece in pieces]
        columns[name] = np.concatenate(pieces)
    return TopicTable(
        columns,
        {name: np.concatenate([part.present[name] for part in parts]) for name in first.present},
        *(
            np.concatenate([getattr(part, name) for part in parts])
            for name in ("log_time", "publish_time", "sequence")
        ),
    )


def _as_objects(piece: NDArray[Any]) -> NDArray[Any]:
    objects = np.empty(len(piece), dtype=object)
    objects[:] = [row.tobytes() if isinstance(row, np.ndarray) else row for row in piece]
    return objects
