"""The live program while it runs: lines from it, orders to it, and its end."""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from telespring.connection.session import Line

__all__ = ["RunningProgram"]

#: Bytes that are read at once.
_PIECE = 65_536
#: The longest line that is read; a summary has up to some thousand events.
_LONGEST = 16 * 2**20
#: Orders that wait for a program which does not listen, bytes; more are dropped.
_UNHEARD = 2**20
#: The most lines of complaints that are kept.
_COMPLAINTS = 50
#: How long a session that was asked to leave may take, s: its force ramps out, and its recording is closed.
_LEAVING = 15.0


class RunningProgram:
    """The program as a child process with a console.

    It has a session of its own: Ctrl-C in the terminal reaches the parent only, which asks it to leave. If
    the parent dies, the program finds its input closed, and leaves as after Ctrl-C.
    """

    def __init__(self, program: Path, arguments: Sequence[str]) -> None:
        self._process = subprocess.Popen(
            [program, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            bufsize=0,
            start_new_session=True,
        )
        stdout, stderr = self._process.stdout, self._process.stderr
        assert stdout is not None
        assert stderr is not None
        self._open = {stdout.fileno(): bytearray(), stderr.fileno(): bytearray()}
        self._stdout = stdout.fileno()
        assert self._process.stdin is not None
        if sys.platform != "win32":  # where no live program runs
            os.set_blocking(self._process.stdin.fileno(), False)
        self._unheard = bytearray()
        self._complaints: deque[str] = deque(maxlen=_COMPLAINTS)
        self._asked: float | None = None

    def __enter__(self) -> Self:
        """Return the program itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """See that no process is left: ask it to leave, and end it if it does not."""
        self.close()

    @property
    def is_over(self) -> bool:
        """Whether the program has ended and all that it wrote was read."""
        return not self._open

    @property
    def complaints(self) -> list[str]:
        """The latest lines that the program wrote as errors."""
        return list(self._complaints)

    def read(self, timeout: float, keyboard: int | None = None) -> tuple[list[Line], bool]:
        """Wait for lines, at most `timeout` s; also tell whether the file `keyboard` can be read."""
        self._say()
        watched = [*self._open, *([] if keyboard is None else [keyboard])]
        ready, _, _ = select.select(watched, [], [], timeout)
        lines: list[Line] = []
        for file in ready:
            if file == keyboard:
                continue
            lines += self._take(file)
        return lines, keyboard in ready

    def _take(self, file: int) -> list[Line]:
        piece = os.read(file, _PIECE)
        waiting = self._open[file]
        waiting += piece
        if not piece:
            del self._open[file]
            waiting += b"\n"
        if len(waiting) > _LONGEST:
            waiting.clear()
        *whole, rest = waiting.split(b"\n")
        waiting[:] = rest
        if file != self._stdout:
            self._complaints += [text for line in whole if (text := line.decode(errors="replace").strip())]
            return []
        return [line for text in whole if (line := _object(bytes(text))) is not None]

    def order(self, text: str) -> None:
        """Tell the program an order, once it listens, after those before; one that has ended hears none."""
        if len(self._unheard) < _UNHEARD:
            self._unheard += text.encode() + b"\n"
        self._say()

    def _say(self) -> None:
        """Write what the program has not heard yet, as far as there is room."""
        stdin = self._process.stdin
        if self._unheard and stdin is not None:
            with suppress(OSError):
                del self._unheard[: stdin.write(self._unheard) or 0]

    def leave(self) -> None:
        """Ask the session to ramp out and say goodbye; asked again a second or more later, end the program.

        Then the device ends its force by its own deadline, and the partner's falls for silence.
        """
        now = time.monotonic()
        if self._asked is None:
            self._asked = now
            self._process.send_signal(signal.SIGINT)
        elif now - self._asked > 1.0:
            self._process.kill()

    def wait(self) -> int:
        """Wait for the end, and return the exit status: 1 if a signal ended the program."""
        status = self._process.wait()
        return status if status >= 0 else 1

    def close(self) -> None:
        """Leave no process behind: leave a session that still runs in order, or end it if that takes long."""
        if self._process.poll() is None:
            if self._asked is None:
                self._asked = time.monotonic()
                self._process.send_signal(signal.SIGINT)
            end = time.monotonic() + _LEAVING
            # what it still writes is read, so that it does not wait for a reader
            while not self.is_over and time.monotonic() < end:
                self.read(0.1)
            try:
                self._process.wait(max(0.1, end - time.monotonic()))
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        for file in (self._process.stdin, self._process.stdout, self._process.stderr):
            if file is not None:
                with suppress(OSError):
                    file.close()
        self._open.clear()


def _object(text: bytes) -> Line | None:
    try:
        line = json.loads(text)
    except ValueError:
        return None
    return line if isinstance(line, dict) else None
