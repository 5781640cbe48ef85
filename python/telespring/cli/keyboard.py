"""Keys and typed lines of whoever watches a session."""

from __future__ import annotations

import os
import re
import sys
import time
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
#: What lets a force come: a person presses such a key alone, so that a pasted text consents to nothing.
_ALONE = {"consent", "resume", "clear"}
#: Begins a marker, which is typed up to Enter.
_MARK = "m"
#: Arrows and function keys: several characters, some of which are keys of their own.
_SEQUENCE = re.compile(r"\x1b(?:\[[0-9;?]*[ -/]*[@-~]|O.)")
_ESCAPE, _DELETE = "\x1b", "\x7f\b"
#: The longest typed line, and the longest marker.
_LONGEST, _LONGEST_MARK = 200, 80
#: A marker that nobody goes on typing for so long is given up, s: then keys are orders again.
_PATIENCE = 15.0


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
        self._is_escaped = False
        self._typed: str | None = None
        self._touched = 0.0

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
            return self._take_keys(piece.decode(errors="replace"))
        # the last line may end with the input
        *lines, self._waiting = (self._waiting + (piece or b"\n")).split(b"\n")
        self._waiting = self._waiting[:_LONGEST]
        texts = [line[:_LONGEST].decode("ascii", "replace").strip() for line in lines]
        return [text for text in texts if text and text.isprintable()]

    def typed(self) -> str | None:
        """Return the marker that is being typed; None if none is."""
        if self._typed is not None and time.monotonic() - self._touched > _PATIENCE:
            self._typed = None
        return self._typed

    def _take_keys(self, piece: str) -> list[str]:
        """Return the orders of keys."""
        if self._is_escaped and piece[:1] in ("[", "O"):
            piece = _ESCAPE + piece
        piece = _SEQUENCE.sub("", piece)
        self._is_escaped = piece.endswith(_ESCAPE)
        orders = []
        for key in piece:
            if self.typed() is not None:
                orders += self._type(key)
            elif key.lower() == _MARK:
                self._typed, self._touched = "", time.monotonic()
            elif key.lower() in _ORDERS:
                order = _ORDERS[key.lower()]
                if len(piece) == 1 or order not in _ALONE:
                    orders.append(order)
        return orders

    def _type(self, key: str) -> list[str]:
        """Take a key of a marker; return its order once it is whole."""
        text, self._touched = self._typed or "", time.monotonic()
        if key in "\r\n":
            self._typed = None
            return [f"mark {text.strip()}"] if text.strip() else []
        if key == _ESCAPE:
            self._typed = None
        elif key in _DELETE:
            self._typed = text[:-1]
        elif key.isascii() and key.isprintable():
            self._typed = (text + key)[:_LONGEST_MARK]
        return []


@contextmanager
def keyboard(*, wants_keys: bool) -> Iterator[Keyboard]:
    """Open the standard input; a terminal gives single keys meanwhile, and is left as it was."""
    try:
        file = sys.stdin.fileno()
        is_terminal = os.isatty(file)
    except (AttributeError, OSError, ValueError):
        yield Keyboard(None, has_keys=False)
        return
    if sys.platform == "win32" or not (is_terminal and wants_keys):
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
