"""Reads a recorded trace of a network from a file."""

from __future__ import annotations

from pathlib import Path

from telespring._arrays import quoted_value
from telespring._core import Trace
from telespring._errors import InvalidInput

__all__ = ["is_irtt", "read_trace"]


def read_trace(path: str | Path, *, round_trip: bool = False, backward: bool = False) -> Trace:
    r"""Read a recorded trace of a network from a file.

    A table has a header with the columns `time` (of sending), `delay` and, if lost packets have rows, `lost`.
    The unit is part of the name: `time_s`, `delay(ms)`. Commas, semicolons, tabs or blanks separate the
    columns; others are ignored. Or the file is the JSON that `irtt client -o` writes. docs/networks.md has
    the details.

    Parameters
    ----------
    path : str or Path
        The file.
    round_trip : bool
        Whether the delays are round trips: the trace has half of each, which is right only if both ways take
        equally long. Of IRTT's delays it takes the round trips.
    backward : bool
        Whether to take the way from the server to the client of IRTT's delays, not that from the client to
        the server. Without meaning for a table.

    Returns
    -------
    Trace
        The delay of each packet one way, s.

    Raises
    ------
    InvalidInput
        If the file is no such table or JSON; the refusal names the line.
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
    content = path.read_bytes()
    for encoding in ("utf-8", "utf-16") if content[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8",):
        try:
            text = content.decode(encoding)
            break
        except UnicodeDecodeError:
            continue
    else:
        raise InvalidInput(
            "trace",
            path.name,
            "a recorded trace is text in UTF-8: a table, or the JSON of IRTT",
            "Save it in that encoding.",
        )
    return Trace._read(text, path.name, round_trip, not backward)


def is_irtt(path: Path) -> bool:
    """Return whether a file is JSON, as IRTT writes it, rather than a table."""
    with path.open("rb") as file:
        return file.read(64).lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{")
