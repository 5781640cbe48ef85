"""Reads a recorded trace of a network from a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from telespring._arrays import quoted_value
from telespring._core import Trace
from telespring._errors import InvalidInput
from telespring._tables import read_text

if TYPE_CHECKING:
    from telespring._types import TraceFormat

__all__ = ["TraceRecording", "read_recording", "read_trace"]


@dataclass(frozen=True)
class TraceRecording:
    """A file with a recorded trace of a network.

    Attributes
    ----------
    traces
        One way, which counts for both, or the ways forward and backward.
    format
        What the file is: "table", "irtt" or "ping".
    is_halved
        Whether its delays are round trips, of which a way has half.
    """

    traces: Trace | tuple[Trace, Trace]
    format: TraceFormat
    is_halved: bool


def read_recording(path: Path, *, round_trip: bool = False) -> TraceRecording:
    """Read what a file has recorded: both ways where it has them, and is not to be taken as round trips."""
    text = read_text(path, path.name)
    form = Trace._format(text)
    forward = Trace._read(text, path.name, round_trip, True)
    if form == "irtt" and not round_trip:
        return TraceRecording((forward, Trace._read(text, path.name, round_trip, False)), form, False)
    return TraceRecording(forward, form, round_trip or form == "ping")


def read_trace(path: str | Path, *, round_trip: bool = False, backward: bool = False) -> Trace:
    r"""Read a recorded trace of a network from a file.

    A table has a header with the columns `time` (of sending), `delay` and, if lost packets have rows, `lost`.
    The unit is part of the name: `time_s`, `delay(ms)`. Commas, semicolons, tabs or blanks separate the
    columns; others are ignored. Or the file is the JSON that `irtt client -o` writes, or the log of
    `ping -D`. docs/networks.md has the details.

    Parameters
    ----------
    path : str or Path
        The file.
    round_trip : bool
        Whether the delays are round trips: the trace has half of each, which is right only if both ways take
        equally long. Of IRTT's delays it takes the round trips. The delays of a ping always are round trips.
    backward : bool
        Whether to take the way from the server to the client of IRTT's delays, not that from the client to
        the server. Without meaning for a table and a ping.

    Returns
    -------
    Trace
        The delay of each packet one way, s.

    Raises
    ------
    InvalidInput
        If the file is no such table, JSON or log; the refusal names the line.
    OSError
        If the file cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import telespring as ts
    >>> path = Path(tempfile.mkdtemp()) / "ping.csv"
    >>> _ = path.write_text("time_s,delay_ms,lost\n0.00,48,0\n0.02,,1\n0.04,52,0\n")
    >>> trace = ts.read_trace(path, round_trip=True)
    >>> trace.delay, trace.statistics().loss
    (array([0.024,   nan, 0.026]), 0.333...)
    """
    try:
        path = Path(path)
    except TypeError:
        raise InvalidInput(
            "path", quoted_value(path), "the name of a file is required", "Give it as text or as a Path."
        ) from None
    return Trace._read(read_text(path, path.name), path.name, round_trip, not backward)
