"""Messages of a recording: decoded as protobuf itself does, whatever fields they have, and never believed."""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from hypothesis import given
from hypothesis import strategies as st

# The decoder has no public name: recordings are read through it, and it must agree with protobuf message by
# message.
from telespring.recording.columns import PADDING, MalformedMessage, decode_messages
from telespring.recording.schema import message_layout

F = descriptor_pb2.FieldDescriptorProto
KINDS = {
    "double": F.TYPE_DOUBLE,
    "float": F.TYPE_FLOAT,
    "int64": F.TYPE_INT64,
    "uint64": F.TYPE_UINT64,
    "int32": F.TYPE_INT32,
    "uint32": F.TYPE_UINT32,
    "sint64": F.TYPE_SINT64,
    "fixed64": F.TYPE_FIXED64,
    "sfixed64": F.TYPE_SFIXED64,
    "fixed32": F.TYPE_FIXED32,
    "sfixed32": F.TYPE_SFIXED32,
    "bool": F.TYPE_BOOL,
    "string": F.TYPE_STRING,
    "bytes": F.TYPE_BYTES,
}


def schema() -> descriptor_pb2.FileDescriptorProto:
    """Return a schema with every kind of field, each with and without presence, and a message inside."""
    file = descriptor_pb2.FileDescriptorProto(name="every.proto", package="every", syntax="proto3")
    message = file.message_type.add(name="Every")
    for number, (name, kind) in enumerate(KINDS.items(), 1):
        message.field.add(name=name, number=number, type=kind, label=F.LABEL_OPTIONAL)
        optional = message.field.add(
            name=f"maybe_{name}", number=100 + number, type=kind, label=F.LABEL_OPTIONAL, proto3_optional=True
        )
        optional.oneof_index = len(message.oneof_decl)
        message.oneof_decl.add(name=f"_maybe_{name}")
    pair = message.nested_type.add(name="Pair")
    for number, name in ((1, "x"), (2, "y")):
        pair.field.add(name=name, number=number, type=F.TYPE_DOUBLE, label=F.LABEL_OPTIONAL)
    message.field.add(
        name="pair", number=50, type=F.TYPE_MESSAGE, type_name=".every.Every.Pair", label=F.LABEL_OPTIONAL
    )
    message.field.add(name="list", number=51, type=F.TYPE_DOUBLE, label=F.LABEL_REPEATED)
    return file


FILE = schema()
SET = descriptor_pb2.FileDescriptorSet(file=[FILE]).SerializeToString()
LAYOUT = message_layout(SET, "every.Every")
POOL = descriptor_pool.DescriptorPool()
POOL.Add(FILE)
EVERY: Any = message_factory.GetMessageClass(POOL.FindMessageTypeByName("every.Every"))


def integers(low: int, high: int) -> st.SearchStrategy[int]:
    return st.one_of(st.integers(low, high), st.sampled_from([low, high]))


VALUES: dict[str, st.SearchStrategy[Any]] = {
    "double": st.floats(allow_nan=False),
    "float": st.floats(width=32, allow_nan=False),
    "int64": integers(-(2**63), 2**63 - 1),
    "uint64": integers(0, 2**64 - 1),
    "int32": integers(-(2**31), 2**31 - 1),
    "uint32": integers(0, 2**32 - 1),
    "sint64": integers(-(2**63), 2**63 - 1),
    "fixed64": integers(0, 2**64 - 1),
    "sfixed64": integers(-(2**63), 2**63 - 1),
    "fixed32": integers(0, 2**32 - 1),
    "sfixed32": integers(-(2**31), 2**31 - 1),
    "bool": st.booleans(),
    "string": st.text(max_size=12),
    "bytes": st.binary(max_size=200),
}


@st.composite
def messages(draw: st.DrawFn) -> Any:
    message = EVERY()
    for name, values in VALUES.items():
        for field in (name, f"maybe_{name}"):
            if draw(st.booleans()):
                setattr(message, field, draw(values))
    if draw(st.booleans()):
        message.pair.x = draw(st.floats(allow_nan=False))
    message.list.extend(draw(st.lists(st.floats(allow_nan=False), max_size=3)))
    return message


def laid_out(encoded: list[bytes]) -> tuple[Any, Any, Any]:
    ends = np.cumsum([len(each) for each in encoded], dtype=np.int64)
    starts = np.concatenate([[0], ends[:-1]]).astype(np.int64)
    return np.frombuffer(b"".join(encoded) + bytes(PADDING), dtype=np.uint8), starts, ends


@given(st.lists(messages(), min_size=1, max_size=5))
def test_cross_messages_are_decoded_as_protobuf_decodes_them(sent: list[Any]) -> None:
    buffer, starts, ends = laid_out([message.SerializeToString() for message in sent])
    columns = decode_messages(buffer, starts, ends, LAYOUT)
    assert "list" not in columns
    for i, message in enumerate(sent):
        for name in (*KINDS, *(f"maybe_{each}" for each in KINDS)):
            column, value = columns[name], getattr(message, name)
            assert column.present[i] == (not name.startswith("maybe_") or message.HasField(name))
            if isinstance(value, (str, bytes)):
                assert column.lengths is not None
                begin = int(column.values[i])
                found = buffer[begin : begin + int(column.lengths[i])].tobytes()
                assert found == (value.encode() if isinstance(value, str) else value) or not column.present[i]
            else:
                assert column.values[i] == value
        assert columns["pair.x"].present[i] == message.HasField("pair")
        assert columns["pair.x"].values[i] == message.pair.x


@given(st.lists(st.binary(max_size=60), min_size=1, max_size=4))
def test_law_any_bytes_are_decoded_or_refused(garbage: list[bytes]) -> None:
    with contextlib.suppress(MalformedMessage):
        columns = decode_messages(*laid_out(garbage), LAYOUT)
        assert all(len(column.values) == len(garbage) for column in columns.values())


def test_law_messages_cut_short_are_refused() -> None:
    message = EVERY(double=1.5, uint64=2**40, string="word", maybe_fixed64=7)
    message.pair.y = 2.0
    whole = message.SerializeToString()
    refused = 0
    for length in range(len(whole)):
        try:
            decode_messages(*laid_out([whole[:length], whole]), LAYOUT)
        except MalformedMessage:
            refused += 1
    assert refused > len(whole) // 2  # a cut between two fields leaves a shorter message


def test_law_a_message_of_a_million_fields_ends_soon() -> None:
    with pytest.raises(MalformedMessage):
        decode_messages(*laid_out([b"\xf8\x3f\x00" * 400_000]), LAYOUT)
