"""Decodes many protobuf messages of one schema at once: a field of all messages becomes one array.

All messages are walked in parallel, field by field, so that a step costs one operation on arrays instead of
one per message. Order and absence of fields may differ from message to message, as protobuf allows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from telespring.recording.schema import Field, MessageLayout

__all__ = ["PADDING", "Column", "MalformedMessage", "decode_messages"]

#: Bytes that the buffer must have behind the last message, so that whole numbers can be taken everywhere.
PADDING = 16
#: How often a field may stand in a message, on average over its fields, before it counts as hostile.
_REPETITIONS = 4
_SPARE_FIELDS = 64

#: Stands for the tag of a message that is read.
_NO_TAG = 2**64 - 1

_Indices = NDArray[np.int64]


class MalformedMessage(ValueError):
    """Bytes that are no message of their schema."""


@dataclass
class Column:
    """A field of all messages.

    Attributes
    ----------
    kind
        As in the schema.
    values
        A number for each message, 0 where absent; of a text or bytes its first byte in the buffer.
    lengths
        The number of bytes of a text or bytes, otherwise None.
    present
        Which messages have it. Without presence in the schema all do: absent means zero.
    """

    kind: str
    values: NDArray[Any]
    lengths: _Indices | None
    present: NDArray[np.bool_]

    def numbers(self) -> NDArray[np.float64]:
        """Return the numbers as float64, NaN where absent."""
        values = self.values.astype(np.float64)
        if not self.present.all():
            values[~self.present] = np.nan
        return values


def decode_messages(
    buffer: NDArray[np.uint8], starts: _Indices, ends: _Indices, layout: MessageLayout
) -> dict[str, Column]:
    """Decode the messages at ``buffer[start:end]``, behind which the buffer has `PADDING` more bytes.

    The last value of a field that stands twice counts, as protobuf says; lists are skipped. MalformedMessage
    where the bytes do not fit the layout.
    """
    columns: dict[str, Column] = {}
    _declare(columns, layout, "", len(starts), inside=False)
    rows = np.arange(len(starts))
    _walk(_Views(buffer), rows, starts, ends, layout, "", columns)
    return columns


class _Views:
    """The buffer, seen as numbers that begin at any byte."""

    def __init__(self, buffer: NDArray[np.uint8]) -> None:
        self.bytes = buffer

        def view(code: str) -> NDArray[Any]:
            width = int(code[2:])
            return np.ndarray((max(0, len(buffer) - width + 1),), dtype=code, buffer=buffer, strides=(1,))

        self.double, self.float = view("<f8"), view("<f4")
        self.fixed64, self.fixed32 = view("<u8"), view("<u4")
        self.sfixed64, self.sfixed32 = view("<i8"), view("<i4")


_DTYPES = {
    "double": np.float64,
    "float": np.float64,
    "signed": np.int64,
    "zigzag": np.int64,
    "sfixed64": np.int64,
    "sfixed32": np.int64,
    "unsigned": np.uint64,
    "fixed64": np.uint64,
    "fixed32": np.uint64,
    "bool": np.bool_,
    "text": np.int64,
    "bytes": np.int64,
}
#: How many bytes a value of fixed width has, by the wire type.
_WIDTHS = {1: 8, 5: 4}
_WIRE_TYPES = {"double": 1, "fixed64": 1, "sfixed64": 1, "float": 5, "fixed32": 5, "sfixed32": 5} | {
    "text": 2,
    "bytes": 2,
    "message": 2,
}


def _declare(
    columns: dict[str, Column], layout: MessageLayout, prefix: str, count: int, *, inside: bool
) -> None:
    for field in layout.fields.values():
        if field.is_repeated:
            continue
        if field.inner is not None:
            _declare(columns, field.inner, f"{prefix}{field.name}.", count, inside=True)
            continue
        is_bytes = field.kind in ("text", "bytes")
        columns[prefix + field.name] = Column(
            field.kind,
            np.zeros(count, _DTYPES[field.kind]),
            np.zeros(count, np.int64) if is_bytes else None,
            np.full(count, not (field.has_presence or inside)),
        )


def _walk(
    views: _Views,
    rows: _Indices,
    starts: _Indices,
    ends: _Indices,
    layout: MessageLayout,
    prefix: str,
    columns: dict[str, Column],
) -> None:
    """Decode messages of one layout; `rows` says to which messages of the whole they belong."""
    if prefix:
        _mark_present(columns, layout, prefix, rows)
    position, end = starts.astype(np.int64), ends.astype(np.int64)
    tag = np.zeros(rows.size, np.uint64)
    fresh: _Indices | None = None  # whose tag is not read yet; None: of all
    for _ in range(_REPETITIONS * (len(layout.fields) + _SPARE_FIELDS)):
        if fresh is None:
            unfinished = position < end
            if not unfinished.all():
                rows, position, end = rows[unfinished], position[unfinished], end[unfinished]
            if not rows.size:
                return
            tag, position = _varints(views, position, end)
        else:
            is_over = position[fresh] >= end[fresh]
            tag[fresh[is_over]] = _NO_TAG
            fresh = fresh[~is_over]
            tag[fresh], position[fresh] = _varints(views, position[fresh], end[fresh])
        # The messages with the first field go on, the others wait, so that those with the same fields stay
        # together.
        value = int(tag.min())
        if value == _NO_TAG:
            return
        chosen = np.flatnonzero(tag == value)
        if chosen.size == rows.size:
            position = _take(views, rows, position, end, value, layout, prefix, columns)
            fresh = None
        else:
            position[chosen] = _take(
                views, rows[chosen], position[chosen], end[chosen], value, layout, prefix, columns
            )
            fresh = chosen
    raise MalformedMessage


def _mark_present(columns: dict[str, Column], layout: MessageLayout, prefix: str, rows: _Indices) -> None:
    """In a message that is there, a field without presence of its own is there, too."""
    for field in layout.fields.values():
        if not field.has_presence and not field.is_repeated:
            columns[prefix + field.name].present[rows] = True


def _take(
    views: _Views,
    rows: _Indices,
    position: _Indices,
    end: _Indices,
    tag: int,
    layout: MessageLayout,
    prefix: str,
    columns: dict[str, Column],
) -> _Indices:
    """Take a field of these messages, all with the same tag; return where the next one begins."""
    number, wire = tag >> 3, tag & 7
    field = layout.fields.get(number)
    if field is None or field.is_repeated:
        return _skip(views, position, end, wire)
    if wire != _WIRE_TYPES.get(field.kind, 0):
        raise MalformedMessage
    if wire in _WIDTHS:
        following = position + _WIDTHS[wire]
        if (following > end).any():
            raise MalformedMessage
        _set(columns[prefix + field.name], rows, getattr(views, field.kind)[position])
        return following
    number_or_length, after = _varints(views, position, end)
    if wire == 0:
        _set(columns[prefix + field.name], rows, _from_varint(field, number_or_length))
        return after
    following = _behind(number_or_length, after, end)
    if field.inner is not None:
        _walk(views, rows, after, following, field.inner, f"{prefix}{field.name}.", columns)
    else:
        column = columns[prefix + field.name]
        assert column.lengths is not None
        column.lengths[rows] = following - after
        _set(column, rows, after)
    return following


def _set(column: Column, rows: _Indices, values: NDArray[Any]) -> None:
    if rows.size == column.values.size:
        column.values[:] = values
        column.present[:] = True
    else:
        column.values[rows] = values
        column.present[rows] = True


def _from_varint(field: Field, raw: NDArray[np.uint64]) -> NDArray[Any]:
    if field.kind == "bool":
        return np.asarray(raw != 0)
    if field.kind == "signed":
        return raw.view(np.int64)
    if field.kind == "zigzag":
        half = (raw >> np.uint64(1)).view(np.int64)
        return np.where(raw & np.uint64(1), ~half, half)
    return raw


def _skip(views: _Views, position: _Indices, end: _Indices, wire: int) -> _Indices:
    if wire in _WIDTHS:
        following: _Indices = position + _WIDTHS[wire]
        if (following > end).any():
            raise MalformedMessage
        return following
    if wire not in (0, 2):
        raise MalformedMessage
    length, after = _varints(views, position, end)
    return after if wire == 0 else _behind(length, after, end)


def _behind(length: NDArray[np.uint64], after: _Indices, end: _Indices) -> _Indices:
    """Return where bytes of these lengths end, all within their messages."""
    if (length > (end - after).astype(np.uint64)).any():
        raise MalformedMessage
    behind: _Indices = after + length.astype(np.int64)
    return behind


def _varints(views: _Views, position: _Indices, end: _Indices) -> tuple[NDArray[np.uint64], _Indices]:
    """Read a number of variable length in each message; return the numbers and where they end."""
    if (position >= end).any():
        raise MalformedMessage
    byte = views.bytes[position]
    value = (byte & 0x7F).astype(np.uint64)
    following = position + 1
    more = np.flatnonzero(byte >= 0x80)
    shift = 7
    while more.size:
        if shift > 63:
            raise MalformedMessage
        place = following[more]
        if (place >= end[more]).any():
            raise MalformedMessage
        byte = views.bytes[place]
        value[more] |= (byte & 0x7F).astype(np.uint64) << np.uint64(shift)
        following[more] = place + 1
        more = more[byte >= 0x80]
        shift += 7
    return value, following
