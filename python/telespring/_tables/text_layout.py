"""How a text file writes its table: separator, decimal mark, and where names and units stand."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from telespring._tables.text_lines import Line, TextLines, uncommented

__all__ = ["Heading", "TextLayout", "find_heading", "find_layout"]

#: Separator and decimal mark; where two read as many numbers, the first. A blank stands for any white space.
_LAYOUTS = [(separator, mark) for separator in "\t;|, " for mark in ".,"]
_NUMBERS = {
    mark: re.compile(rf"[+\-\u2212]?({digits})([eEdD][+-]?\d+)?")
    for mark, digits in ((".", r"\d+\.?\d*|\.\d+"), (",", r"\d+(,\d+)?|,\d+"))
}
#: Words for a number that is missing.
_MISSING = "nan,-nan,na,n/a,#n/a,null,none,inf,+inf,-inf,infinity,-infinity,--"
_MISSING_IN_C = "nan(ind),-nan(ind),nan(snan),-nan(snan)"
MISSING = frozenset(["", *_MISSING.split(","), *_MISSING_IN_C.split(",")])
#: What could separate parts of a field.
_SPLITS = re.compile(r"[\t;| ]")
#: The layout shows in so many lines.
_SAMPLED = 100
#: A field of a line of units, with brackets or without.
_UNIT = re.compile(
    r"[\[(<{]?\s*((k|m|c|d|µ|μ|u|n)?(s|sec|second|seconds|m|meter|metre|meters|metres|N|newton|newtons|Nm|V|A|g)"
    r"|rad|deg|°|Hz|-|1|%)(/s(²|\^2|2|/s)?)?\s*[\])>}]?",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class TextLayout:
    """Separator (" " for any white space), decimal mark, and whether quotation marks enclose fields."""

    separator: str
    decimal: str
    is_quoted: bool

    def split(self, text: str) -> list[str]:
        """Return the fields of a line, stripped."""
        if self.separator == " ":
            return text.split()
        if self.is_quoted and '"' in text:
            reader = csv.reader(
                io.StringIO(text, newline=""), delimiter=self.separator, skipinitialspace=True
            )
            return [field.strip() for field in next(reader)]
        return [field.strip() for field in text.split(self.separator)]

    def count(self, text: str) -> int:
        """Count the fields of a line."""
        if self.separator == " " or (self.is_quoted and '"' in text):
            return len(self.split(text))
        return text.count(self.separator) + 1

    def counts(self, texts: Sequence[str]) -> NDArray[np.int_]:
        """Count the fields of many lines."""
        if self.separator == " " or self.is_quoted:
            return np.array([self.count(text) for text in texts], dtype=int)
        # UTF-8 has no ASCII letter inside another one.
        letters = np.frombuffer("\n".join([*texts, ""]).encode(), dtype=np.uint8)
        ends = np.flatnonzero(letters == ord("\n"))
        before = np.searchsorted(np.flatnonzero(letters == ord(self.separator)), ends)
        return np.diff(before, prepend=0) + 1

    def is_number(self, field: str) -> bool:
        """Whether a field is a number, not a word for a missing one."""
        return _NUMBERS[self.decimal].fullmatch(field) is not None


@dataclass(frozen=True)
class Heading:
    """Names of the columns (None if there are none), their units, and which line of the table comes first."""

    names: list[str] | None
    units: list[str]
    first: int
    line: int | None


def find_layout(lines: TextLines) -> TextLayout:
    """Choose the separator and decimal mark by which most fields are numbers, in rows of equal length."""
    sample = lines.table[:_SAMPLED]
    named = lines.separator
    characters = set().union(*sample)
    candidates = [
        TextLayout(separator, mark, lines.is_quoted)
        for separator, mark in _LAYOUTS
        if named in (None, separator) and _may_be(separator, mark, characters, lines.is_quoted)
    ] or [TextLayout(named or ",", mark, lines.is_quoted) for mark in ".,"]
    best = max(candidates, key=lambda layout: _readable_share(sample, layout))
    if _readable_share(sample, best) > 0.0:
        return best
    # Names alone: the separator that they contain.
    return next((layout for layout in candidates if layout.count(sample[0]) > 1), candidates[0])


def _may_be(separator: str, mark: str, characters: set[str], is_quoted: bool) -> bool:
    """Whether lines of these characters may have a layout; commas are both only if fields are quoted."""
    separates = separator in characters or (separator == " " and "\t" in characters)
    return separates and (mark == "." or ("," in characters and (separator != "," or is_quoted)))


def _readable_share(sample: Sequence[str], layout: TextLayout) -> float:
    """Sum over lines the share of their fields that are numbers; lines of another length count nothing."""
    if layout.separator == " " and sum("\t" in text for text in sample) * 2 > len(sample):
        return 0.0
    shares: defaultdict[int, float] = defaultdict(float)
    for text in sample:
        row = layout.split(text)
        known = _known(row)
        # A field that could be split further counts as often as it could.
        others = sum(1 + len(_SPLITS.findall(field)) for field in known if not layout.is_number(field))
        numbers = sum(map(layout.is_number, known))
        if numbers and len(row) > 1:
            shares[len(row)] += numbers / (numbers + others)
    return max(shares.values(), default=0.0) / len(sample)


def find_heading(lines: TextLines, layout: TextLayout) -> Heading:
    """Find the line of names: the last above the first row of numbers, or in the comments above it."""
    table, numbers = lines.table, lines.numbers
    rows = [layout.split(text) for text in table[:_SAMPLED]]
    first = _first_row_of_numbers(rows, layout)
    if first is None:
        return Heading(rows[0], [], 1, int(numbers[0]))
    if _counts_from_zero(rows[first], rows[first + 1 :], layout):
        # pandas numbers the columns of an array from 0; here they are numbered from 1.
        return Heading(None, [], first + 1, int(numbers[first]))
    width = len(rows[first])
    if first == 0:
        above = [comment for comment in lines.comments if comment.number < int(numbers[0])]
        names = _fields_of_comment(above[-1], layout, width) if above else None
        return Heading(names, [], 0, above[-1].number if names else None)
    units: list[str] = []
    named = first - 1
    if named > 0 and len(rows[named - 1]) >= len(rows[named]) and _are_units(rows[named]):
        units, named = rows[named], named - 1
    names = rows[named]
    if len(names) != width:
        other = _split_otherwise(table[named], layout, width)
        names = other if other is not None else names
    return Heading(names, units, first, int(numbers[named]))


def _first_row_of_numbers(rows: Sequence[Sequence[str]], layout: TextLayout) -> int | None:
    """Return the first row with numbers in the columns that usually have them."""
    numeric = [[layout.is_number(field) for field in row] for row in rows]
    widths = Counter(len(row) for row in numeric if any(row))
    if not widths:
        return None
    usual = max(widths, key=lambda width: (widths[width], width))
    columns = [
        i
        for i in range(usual)
        if sum(row[i] for row in numeric if len(row) == usual and any(row)) * 2 > widths[usual]
    ] or [i for i in range(usual) if any(row[i] for row in numeric if len(row) == usual)]
    for place, row in enumerate(numeric):
        known = [i for i in columns if i < len(row) and rows[place][i].lower() not in MISSING]
        found = sum(row[i] for i in known)
        # "time, 1, 2, 3" are names although most of them are numbers; a time before words begins a row.
        begins_with_name = place == 0 and known[:1] == [0] and not row[0]
        begins_with_number = known[:1] == [0] and row[0]
        enough = 2 * found >= len(known) or begins_with_number if len(row) == usual else found == len(known)
        if known and enough and not begins_with_name:
            # Above it may be rows in which all numbers are missing.
            while place > 0 and _lacks_numbers(rows[place - 1], columns, usual):
                place -= 1
            return place
    return None


def _lacks_numbers(row: Sequence[str], columns: Sequence[int], width: int) -> bool:
    return len(row) == width and all(row[i].lower() in MISSING for i in columns)


def _known(fields: Sequence[str]) -> list[str]:
    return [field for field in fields if field.lower() not in MISSING]


def _counts_from_zero(row: Sequence[str], below: Sequence[Sequence[str]], layout: TextLayout) -> bool:
    counted = [str(i) for i in range(len(row))]
    from_zero = list(row) == counted or list(row) == ["", *counted[:-1]]
    decimals = [layout.decimal in field for fields in below for field in fields]
    return len(row) > 2 and from_zero and sum(decimals) * 2 > len(decimals)


def _fields_of_comment(comment: Line, layout: TextLayout, width: int) -> list[str] | None:
    """Return the names in a comment, if it has one for each column."""
    text = uncommented(comment.text)
    names = layout.split(text)
    if len(names) != width:
        names = _split_otherwise(text, layout, width) or []
    return names if names and not any(map(layout.is_number, names)) else None


def _split_otherwise(text: str, layout: TextLayout, width: int) -> list[str] | None:
    """Split a line of names at another separator than the numbers have, if this gives a name per column."""
    for separator in "\t;|, ":
        names = TextLayout(separator, layout.decimal, layout.is_quoted).split(text)
        if len(names) == width > 1:
            return names
    return None


def _are_units(fields: Sequence[str]) -> bool:
    given = [field for field in fields if field]
    return bool(given) and all(_UNIT.fullmatch(field) for field in given)
