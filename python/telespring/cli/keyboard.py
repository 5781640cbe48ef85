"""Keys and typed lines of whoever watches a session."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

__all__ = ["Keyboard", "keyboard"]

#: What a key means to the program.
_ORDERS = {
    "p": "pause",
    " ": "pause",
    "c": "consent",
    "r": "resume",
    "w": "withdraw",
    "s": "stop",
    "x": "clear",
}
#: The longest typed line.
_LONGEST = 200


class Keyboard:
    """The standard input: single keys of a terminal, or lines of anything else.

    Attributes
    ----------
    file
        Its descriptor; None once it has ended.
    has_keys
        Whether a key is an order at once; otherwise a line is one.
    """

    def __init__(self, file: int | None, *, has_keys: bool) -> None:
        self.file = file
        self.has_keys = has_keys
        self._waiting = b""

    def orders(self) -> list[str]:
        """Read what has come, and return the orders in it."""
        assert self.file is not None
        try:
            piece = os.read(self.file, 1024)
        except OSError:
            piece = b""
        if not piece:
            self.file = None
        if self.has_keys:
            return [_ORDERS[key] for key in piece.decode(errors="replace").lower() if key in _ORDERS]
        *lines, self._waiting = (self._waiting + piece).split(b"\n")
        self._waiting = self._waiting[:_LONGEST]
        texts = [line[:_LONGEST].decode("ascii", "replace").strip() for line in lines]
        return [text for text in texts if text and text.isprintable()]


@contextmanager
def keyboard(*, wants_keys: bool) -> Iterator[Keyboard]:
    """Open the standard input; a terminal gives single keys meanwhile, and is left as it was."""
    try:
        file = sys.stdin.fileno()
        is_terminal = os.isatty(file)
    except (AttributeError, OSError, ValueError):
        yield Keyboard(None, has_keys=False)
        return
    if not (is_terminal and wants_keys):
        yield Keyboard(file, has_keys=False)
        return
    import termios
    import tty

    before = termios.tcgetattr(file)
    try:
        # Ctrl-C stays a signal
        tty.setcbreak(file)
        yield Keyboard(file, has_keys=True)
    finally:
        with suppress(termios.error):
            termios.tcsetattr(file, termios.TCSADRAIN, before)
