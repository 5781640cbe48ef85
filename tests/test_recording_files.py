"""MCAP files as they are found after a crash: what is whole is read, and no length in them is believed."""

from __future__ import annotations

import io
import struct
from typing import TYPE_CHECKING

import pytest
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk, Header
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

import telespring as ts

# The reader of the format has no public name; recordings are read through it.
from telespring.recording.mcap_file import McapFile

if TYPE_CHECKING:
    from pathlib import Path

MESSAGES, EVERY = 400, 20


def written(compression: CompressionType, *, finish: bool = True) -> bytes:
    """Return a file with a chunk of every 20 messages."""
    stream = io.BytesIO()
    writer = Writer(stream, compression=compression)
    writer.start("telespring", "test")
    schema = writer.register_schema("a.B", "protobuf", b"")
    channel = writer.register_channel("/a", "protobuf", schema)
    for i in range(MESSAGES):
        writer.add_message(channel, log_time=1000 + i, data=struct.pack("<Q", i), publish_time=i, sequence=i)
        if i % EVERY == EVERY - 1:
            writer.flush()
    writer.add_metadata("note", {"key": "value"})
    if finish:
        writer.finish()
    return stream.getvalue()


def read(path: Path) -> tuple[McapFile, list[int]]:
    file = McapFile(path)
    values: list[int] = []
    for chunk in file.chunks():
        for messages in chunk.messages.values():
            assert messages.log_time.tolist() == [1000 + number for number in messages.sequence.tolist()]
            for start, end in zip(messages.starts, messages.ends, strict=True):
                values += struct.unpack("<Q", chunk.data[start:end])
    return file, values


@pytest.mark.parametrize("compression", CompressionType)
def test_law_a_whole_file_is_read_whole(compression: CompressionType, tmp_path: Path) -> None:
    path = tmp_path / "whole.mcap"
    path.write_bytes(written(compression))
    file, values = read(path)
    assert values == list(range(MESSAGES))
    assert (file.is_complete, file.lost_bytes, file.damaged_chunks) == (True, 0, 0)
    assert (file.profile, file.metadata) == ("telespring", {"note": {"key": "value"}})


@pytest.mark.parametrize("compression", CompressionType)
def test_law_a_file_cut_anywhere_gives_its_whole_chunks(compression: CompressionType, tmp_path: Path) -> None:
    whole = written(compression)
    path = tmp_path / "cut.mcap"
    counts = []
    for length in range(1, len(whole), 37):
        path.write_bytes(whole[:length])
        file, values = read(path)
        assert values == list(range(len(values)))
        assert len(values) % EVERY == 0
        assert not file.is_complete
        assert file.damaged_chunks == 0
        assert file.lost_bytes < 4096
        counts.append(len(values))
    assert counts == sorted(counts)
    assert counts[-1] == MESSAGES


@pytest.mark.parametrize("compression", [CompressionType.LZ4, CompressionType.ZSTD])
def test_law_a_damaged_chunk_is_left_out_and_counted(compression: CompressionType, tmp_path: Path) -> None:
    whole = bytearray(written(compression))
    middle = bytes(whole).index(compression.name.lower().encode(), len(whole) // 3) + 40
    whole[middle] ^= 0xFF
    path = tmp_path / "damaged.mcap"
    path.write_bytes(whole)
    file, values = read(path)
    assert file.damaged_chunks == 1
    assert len(values) == MESSAGES - EVERY
    assert file.is_complete


def test_law_a_chunk_begun_by_a_killed_writer_is_the_end(tmp_path: Path) -> None:
    # A writer that seeks back writes the greatest length first.
    path = tmp_path / "killed.mcap"
    begun = struct.pack("<BQ", 0x06, 2**64 - 1) + bytes(500)
    path.write_bytes(written(CompressionType.LZ4, finish=False) + begun)
    file, values = read(path)
    assert values == list(range(MESSAGES))
    assert (file.is_complete, file.lost_bytes) == (False, len(begun))


def hostile(uncompressed_size: int, data: bytes, compression: str) -> bytes:
    builder = RecordBuilder()
    Header("telespring", "hostile").write(builder)
    Chunk(
        compression=compression,
        data=data,
        message_start_time=0,
        message_end_time=0,
        uncompressed_crc=0,
        uncompressed_size=uncompressed_size,
    ).write(builder)
    return bytes(MCAP0_MAGIC + builder.end())


def test_law_a_chunk_that_would_fill_the_memory_is_refused_or_left_out(tmp_path: Path) -> None:
    import lz4.frame
    import zstandard

    zeros = bytes(200 * 2**20)
    path = tmp_path / "bomb.mcap"
    for name, packed in (("lz4", lz4.frame.compress(zeros)), ("zstd", zstandard.compress(zeros))):
        path.write_bytes(hostile(len(zeros), packed, name))
        with pytest.raises(ts.InvalidInput, match="MB"):
            read(path)
        # It says to be small, and is not.
        path.write_bytes(hostile(1000, packed, name))
        file, values = read(path)
        assert (file.damaged_chunks, values) == (1, [])
    # Millions of empty records in a chunk of an allowed size end soon: the suite has a limit of time.
    for _ in range(3):
        path.write_bytes(hostile(60 * 2**20, lz4.frame.compress(bytes(60 * 2**20)), "lz4"))
        assert read(path)[1] == []
    path.write_bytes(hostile(10, bytes(10), "rot13"))
    with pytest.raises(ts.InvalidInput, match="lz4"):
        read(path)


@pytest.mark.parametrize(
    ("content", "value"),
    [(b"", "empty"), (b"time_s,delay_s\n0,1\n", "another format"), (b"\x89HDF\r\n\x1a\n", "another format")],
)
def test_law_what_is_no_recording_is_refused(content: bytes, value: str, tmp_path: Path) -> None:
    path = tmp_path / "foreign.mcap"
    path.write_bytes(content)
    with pytest.raises(ts.InvalidInput, match=value):
        read(path)
