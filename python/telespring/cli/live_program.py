"""What the commands that start the live program share: an orderly end, and its complaints."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from telespring.connection import RunningProgram

__all__ = ["complain", "leaving"]


@contextmanager
def leaving(running: RunningProgram) -> Iterator[None]:
    """Let Ctrl-C, and the end of the terminal, end the program in order; Ctrl-C again ends it at once."""

    def leave(*_: object) -> None:
        running.leave()

    signals = [signal.SIGINT, signal.SIGTERM]
    if sys.platform != "win32":  # which has no such end of a terminal
        signals.append(signal.SIGHUP)
    before: list[tuple[signal.Signals, Any]] = []
    try:
        before.extend((each, signal.signal(each, leave)) for each in signals)
        yield
    finally:
        for each, handler in before:
            signal.signal(each, handler)


def complain(lines: Sequence[str], status: int) -> None:
    """Pass on what the program wrote as errors."""
    say: Callable[[str], str] = (lambda line: f"Refused: {line}") if status == 2 else str
    for index, line in enumerate(lines):
        print(say(line) if index == 0 else line, file=sys.stderr)
