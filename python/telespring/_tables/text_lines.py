"""The lines of a text file: decoded, with their numbers, without comments."""

from __future__ import annotations

import codecs
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput

__all__ = ["Line", "TextLines", "read_text", "text_lines", "uncommented"]

_COMMENT_MARKS = ("#", "%", "//")
#: The first line of a file for Excel may name the separator.
_EXCEL_SEPARATOR = re.compile(r'"?sep=(.)"?', re.IGNORECASE)
_BYTE_ORDER_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
#: An empty line, between others or at the beginning.
_EMPTY_LINE = re.compile(r"\n[^\S\n]*\n")
#: A quoted field runs over at most so many lines; beyond it the mark was no quotation mark.
_LONGEST_QUOTATION = 50


class Line(NamedTuple):
    """A line and its number in the file, from 1."""

    number: int
    text: str


class TextLines(NamedTuple):
    """Lines of a table.

    Attributes
    ----------
    table, numbers
        The lines without comments and empty ones, and the number of each in the file, from 1.
    comments
        The comments between them.
    separator
        The separator, if the file names it.
    is_quoted
        Whether quotation marks enclose fields.
    """

    table: list[str]
    numbers: NDArray[np.int_]
    comments: list[Line]
    separator: str | None
    is_quoted: bool


def text_lines(path: Path, file: str) -> TextLines:
    """Read the lines of a text file; `file` names it in a refusal.

    UTF-8, UTF-16 and the Windows code page are read. A quoted field that runs over several lines stays one.
    """
    text = read_text(path, file)
    lines = text.split("\n")
    numbers = np.arange(1, len(lines) + 1)
    named = _EXCEL_SEPARATOR.fullmatch(lines[0].strip())
    # What most files do not have is looked for in the whole text at once: a log may have a million lines.
    places = range(len(lines)) if _EMPTY_LINE.search(text) else sorted({0, len(lines) - 1})
    empty = [i for i in places if not lines[i] or lines[i].isspace() or (named and i == 0)]
    lines, numbers = _without(lines, numbers, empty)
    is_quoted = '"' in text
    if is_quoted:
        joined = _join_quotations(lines, numbers)
        if joined is None:
            is_quoted = False
        else:
            lines, numbers = joined
    found: list[int] = []
    if any(mark in text for mark in _COMMENT_MARKS):
        found = [i for i, line in enumerate(lines) if line.lstrip().startswith(_COMMENT_MARKS)]
    comments = [Line(int(numbers[i]), lines[i]) for i in found]
    table, numbers = _without(lines, numbers, found)
    return TextLines(table, numbers, comments, named[1] if named else None, is_quoted)


def read_text(path: Path, file: str) -> str:
    """Read a text file whose lines end in any way; `file` names it in a refusal.

    UTF-8 and UTF-16, with a byte order mark or without, and the Windows code page are read.
    """
    text = _decode(path.read_bytes(), file)
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


def _without(
    lines: list[str], numbers: NDArray[np.int_], places: list[int]
) -> tuple[list[str], NDArray[np.int_]]:
    """Leave out the lines at some places."""
    if not places:
        return lines, numbers
    if places == [len(lines) - 1]:
        return lines[:-1], numbers[:-1]
    left_out = set(places)
    kept = [line for i, line in enumerate(lines) if i not in left_out]
    return kept, np.delete(numbers, places)


def uncommented(text: str) -> str:
    """Return a comment without its mark."""
    return text.lstrip().lstrip("#%/ ")


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


def _join_quotations(
    lines: list[str], numbers: NDArray[np.int_]
) -> tuple[list[str], NDArray[np.int_]] | None:
    """Join the lines of a quoted field; None if quotation marks do not come in pairs."""
    joined: list[str] = []
    starts: list[int] = []
    parts: list[str] = []
    for place, line in enumerate(lines):
        if not parts:
            starts.append(place)
        parts.append(line)
        if sum(part.count('"') for part in parts) % 2 == 0:
            joined.append("\n".join(parts))
            parts = []
        elif len(parts) > _LONGEST_QUOTATION:
            return None
    return None if parts else (joined, numbers[starts])
