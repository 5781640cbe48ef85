"""What happened in a live session, and the trials that its markers name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["MarkedTrial", "SessionEvent", "marked_trials"]

#: Texts of a trial's marker that end it instead of beginning one.
_ENDS = {"end", "stop", "over"}


@dataclass(frozen=True)
class SessionEvent:
    """Something that happened at one site.

    Attributes
    ----------
    time
        s since the beginning of the recording, on the common time.
    side
        The robot of the study, 1 or 2.
    event
        What happened, in a word, as in the summary of the live program.
    cause
        Why, or with which value; "" if there is nothing to say.
    """

    time: float
    side: int
    event: str
    cause: str = ""


@dataclass(frozen=True)
class MarkedTrial:
    """A trial between two markers, or the whole session where there is none.

    Attributes
    ----------
    label
        The text of its marker, "1" without.
    condition
        The latest condition marked before; "" without.
    participants
        The codes of who held robots 1 and 2; "" where none was marked.
    begin, end
        s since the beginning of the recording.
    is_marked
        Whether a marker began it.
    """

    label: str
    condition: str
    participants: tuple[str, str]
    begin: float
    end: float
    is_marked: bool


def marked_trials(
    marks: Sequence[tuple[float, int, str, str]], begin: float, end: float
) -> list[MarkedTrial]:
    """Split a session that was coupled from `begin` to `end` by its markers: time, side, kind, text.

    A trial lasts from its marker to the next one of a trial, to its end's, or to the end of the coupling.
    Both sites may mark the same: what one repeats within a second of the other counts once. A condition and a
    participant hold for the trials that begin at their time or later. Without any trial marked, the session
    is one trial.

    Examples
    --------
    >>> marks = [(1.0, 1, "condition", "soft"), (2.0, 1, "trial", "1"), (9.0, 1, "trial", "end")]
    >>> [(trial.label, trial.condition, trial.begin, trial.end) for trial in marked_trials(marks, 0.5, 20.0)]
    [('1', 'soft', 2.0, 9.0)]
    """
    condition = ""
    trials: list[MarkedTrial] = []
    opened: tuple[str, str, tuple[str, str], float] | None = None
    latest = (-2.0, 0, "")

    def close(time: float) -> None:
        if opened is not None and time > opened[3]:
            trials.append(MarkedTrial(*opened, time, is_marked=True))

    # Of markers at the same time those of conditions and participants come first: they hold for that trial.
    for time, side, kind, text in sorted(marks, key=lambda mark: (mark[0], mark[2] == "trial")):
        if kind == "condition":
            condition = text
        elif kind == "trial":
            if text == latest[2] and side != latest[1] and time - latest[0] < 1.0:
                continue
            latest = time, side, text
            close(min(time, end))
            is_end = text.strip().casefold() in _ENDS
            opened = None if is_end else (text, condition, _participants(marks, time, side), max(time, begin))
    close(end)
    if not trials and end > begin:
        trials = [MarkedTrial("1", condition, _participants(marks, end, 0), begin, end, is_marked=False)]
    return trials


def _participants(marks: Sequence[tuple[float, int, str, str]], time: float, side: int) -> tuple[str, str]:
    """Return the codes that hold for a trial marked at this time and site.

    The other site may have been told of the same trial, and first of its participant, up to a second later.
    """
    codes = ["", ""]
    for when, each, kind, text in sorted(marks):
        if kind == "participant" and when <= time + (1.0 if each != side else 0.0):
            codes[each - 1] = text
    return codes[0], codes[1]
