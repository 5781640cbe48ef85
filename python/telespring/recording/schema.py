"""The layout of a message, from the protobuf schema that its file carries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from telespring._errors import InvalidInput

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["Field", "MessageLayout", "message_layout"]

#: Messages in messages that are looked into; deeper ones are left out.
_DEPTH = 3
#: The most fields that a message may declare.
_MOST_FIELDS = 1000

#: Kinds by the number of protobuf's types (descriptor.proto, FieldDescriptorProto.Type).
_KINDS = {
    1: "double",
    2: "float",
    3: "signed",
    4: "unsigned",
    5: "signed",
    6: "fixed64",
    7: "fixed32",
    8: "bool",
    9: "text",
    11: "message",
    12: "bytes",
    13: "unsigned",
    14: "signed",
    15: "sfixed32",
    16: "sfixed64",
    17: "zigzag",
    18: "zigzag",
}


@dataclass(frozen=True)
class Field:
    """A field of a message.

    Attributes
    ----------
    name
        As in the schema; after a dot that of a field of a message inside.
    kind
        How it is encoded: "double", "signed", "text" and others.
    has_presence
        Whether an absent value differs from zero.
    is_repeated
        Whether it is a list; lists are skipped.
    inner
        The layout of a message inside.
    """

    name: str
    kind: str
    has_presence: bool
    is_repeated: bool
    inner: MessageLayout | None = None


@dataclass(frozen=True)
class MessageLayout:
    """The fields of a message by their numbers."""

    fields: Mapping[int, Field]


def message_layout(schema: bytes, name: str) -> MessageLayout:
    """Return the layout of the message `name` from the bytes of a `FileDescriptorSet`.

    InvalidInput if the bytes are no such set, or the message is not in it.
    """
    from google.protobuf.descriptor_pb2 import DescriptorProto, FieldDescriptorProto, FileDescriptorSet
    from google.protobuf.message import DecodeError

    try:
        files = FileDescriptorSet.FromString(schema)
    except DecodeError:
        raise _unreadable(name) from None
    messages: dict[str, DescriptorProto] = {}

    def collect(message: DescriptorProto, scope: str) -> None:
        full = f"{scope}.{message.name}" if scope else str(message.name)
        messages[full] = message
        for nested in message.nested_type:
            collect(nested, full)

    for file in files.file:
        for message in file.message_type:
            collect(message, file.package)
    for described in messages.values():
        # protobuf gives bytes for a name that is no text
        names = (text for field in described.field for text in (field.name, field.type_name))
        if not all(isinstance(text, str) for text in (described.name, *names)):
            raise _unreadable(name)

    def resolve(written: str, scope: str) -> str | None:
        """Find a message by the name in a field: in full after a dot, otherwise from the inside out."""
        if written.startswith("."):
            return written[1:] if written[1:] in messages else None
        while True:
            full = f"{scope}.{written}" if scope else written
            if full in messages:
                return full
            if not scope:
                return None
            scope = scope.rpartition(".")[0]

    def lay_out(full: str, depth: int) -> MessageLayout:
        fields: dict[int, Field] = {}
        if len(messages[full].field) > _MOST_FIELDS:
            raise _unreadable(name)
        for field in messages[full].field:
            kind = _KINDS.get(field.type)
            if kind is None:
                continue
            inner = None
            if kind == "message":
                found = resolve(field.type_name, full)
                if found is None or depth == 0:
                    continue
                inner = lay_out(found, depth - 1)
            fields[field.number] = Field(
                name=field.name,
                kind=kind,
                has_presence=field.proto3_optional or kind == "message",
                is_repeated=field.label == FieldDescriptorProto.LABEL_REPEATED,
                inner=inner,
            )
        return MessageLayout(fields)

    if name not in messages:
        raise _unreadable(name)
    return lay_out(name, _DEPTH)


def _unreadable(name: str) -> InvalidInput:
    return InvalidInput(
        "schema",
        name[:80],
        "the file must carry the protobuf schema of its messages",
        "The file is damaged or was not written by telespring-link: copy it again.",
    )
