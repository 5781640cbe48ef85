"""The lines of a text file: decoded, with their numbers, without comments."""

from __future__ import annotations

import codecs
import re
from pathlib import Path
from typing import NamedTuple

from telespring._errors import InvalidInput

__all__ = ["Line", "TextLines", "text_lines", "uncommented"]

_COMMENT = re.compile(r"\s*(#|%|//)")
#: The first line of a file for Excel may name the separator.
_EXCEL_SEPARATOR = re.compile(r'"?sep=(.)"?', re.IGNORECASE)
_BYTE_ORDER_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
#: A quoted field runs over at most so many lines; beyond it the mark was no quotation mark.
_LONGEST_QUOTATION = 50


class Line(NamedTuple):
    """A line and its number in the file, from 1."""

    number: int
    text: str


class TextLines(NamedTuple):
    """Lines of a table, and the comments between them; the separator, if the file names it."""

    table: list[Line]
    comments: list[Line]
    separator: str | None
    is_quoted: bool


def text_lines(path: Path, file: str) -> TextLines:
    """Read the lines of a text file; `file` names it in a refusal.

    UTF-8, UTF-16 and the Windows code page are read. A quoted field that runs over several lines stays one.
    """
    lines = _decode(path.read_bytes(), file).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    named = _EXCEL_SEPARATOR.fullmatch(lines[0].strip())
    numbered = [
        Line(number, text) for number, text in enumerate(lines, start=1) if text and not text.isspace()
    ]
    if named:
        numbered = [line for line in numbered if line.number > 1]
    is_quoted = any('"' in line.text for line in numbered)
    if is_quoted:
        joined = _join_quotations(numbered)
        numbered, is_quoted = (numbered, False) if joined is None else (joined, True)
    table: list[Line] = []
    comments: list[Line] = []
    for line in numbered:
        (comments if _COMMENT.match(line.text) else table).append(line)
    return TextLines(table, comments, named[1] if named else None, is_quoted)


def uncommented(text: str) -> str:
    """Return a comment without its mark."""
    return _COMMENT.sub("", text, count=1).lstrip("#%/ ")


def _decode(content: bytes, file: str) -> str:
    refusal = InvalidInput(
        file, "not text", "a text file is required", "Export the table as CSV, with the encoding UTF-8."
    )
    for mark, encoding in _BYTE_ORDER_MARKS.items():
        if content.startswith(mark):
            try:
                return content.decode(encoding)
            except UnicodeDecodeError:
                raise refusal from None
    beginning = content[:2000]
    if b"\0" in beginning:
        # Without a mark, every second byte of Latin text tells UTF-16.
        for offset, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
            if beginning[offset::2].count(0) > 0.4 * len(beginning) and not beginning[1 - offset :: 2].count(
                0
            ):
                return content.decode(encoding, errors="replace")
        raise refusal
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        text = content.decode("cp1252", errors="replace")
    # Only names and units are other than ASCII in a table of numbers.
    if sum(character < " " and character not in "\t\r\n\f" for character in text[:2000]):
        raise refusal
    return text


def _join_quotations(lines: list[Line]) -> list[Line] | None:
    """Join the lines of a quoted field; None if quotation marks do not come in pairs."""
    joined: list[Line] = []
    number, parts = 0, list[str]()
    for line in lines:
        if not parts:
            number = line.number
        parts.append(line.text)
        if sum(part.count('"') for part in parts) % 2 == 0:
            joined.append(Line(number, "\n".join(parts)))
            parts = []
        elif len(parts) > _LONGEST_QUOTATION:
            return None
    return None if parts else joined
