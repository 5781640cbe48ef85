"""What does not fit into a scale, written above it: each note over its place, none over another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Note", "PlacedNote", "place_notes"]

#: Width of a letter of a note, and distance between two notes, in multiples of its font size.
_LETTER, _APART = 0.68, 0.9


@dataclass(frozen=True)
class Note:
    """A short text over a place of the axis, a share of its length; `label` says whose it is."""

    place: float
    text: str
    label: str


@dataclass(frozen=True)
class PlacedNote:
    """A note with the middle of its text (a share of the axis) and its row, from 0 upwards."""

    note: Note
    middle: float
    row: int


def place_notes(notes: Sequence[Note], width: float, font_size: float) -> list[PlacedNote]:
    """Place notes over an axis of some width, pt, in as few rows as keep them apart.

    A note stays within the axis where it is short enough.

    Examples
    --------
    >>> notes = [Note(0.0, "212", "a"), Note(0.1, "999", "a"), Note(0.9, "174", "a")]
    >>> [(round(each.middle, 2), each.row) for each in place_notes(notes, 100.0, 6.0)]
    [(0.06, 0), (0.1, 1), (0.9, 0)]
    """
    placed: list[PlacedNote] = []
    ends: list[float] = []
    for note in sorted(notes, key=lambda note: note.place):
        half = 0.5 * _LETTER * font_size * len(note.text) / width
        middle = min(max(note.place, half), max(1.0 - half, half))
        start, end = middle - half, middle + half + _APART * font_size / width
        row = next((row for row, taken in enumerate(ends) if taken <= start), len(ends))
        if row == len(ends):
            ends.append(end)
        ends[row] = end
        placed.append(PlacedNote(note, middle, row))
    return placed
