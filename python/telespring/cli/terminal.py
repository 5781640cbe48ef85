"""The terminal: what it can write, and what happens when it cannot be written to."""

from __future__ import annotations

import codecs
import errno
import io
import os
import sys
from typing import TYPE_CHECKING, ClassVar

from rich.console import Console

from telespring.show.screens.plain_letters import for_encoding, to_ascii

if TYPE_CHECKING:
    from rich.console import RenderableType

__all__ = ["close_output", "output_trouble", "prepare_streams", "screen_console", "show"]

_OUTPUT_ERRORS = {errno.EPIPE, errno.ENOSPC, errno.EIO, errno.EFBIG, errno.EDQUOT, errno.EBADF}


def prepare_streams() -> None:
    """Let both streams write an ASCII spelling of the letters that the terminal does not have."""
    codecs.register_error("telespring", _spell)
    if type(sys.stdout) is io.TextIOWrapper:
        encoding, is_terminal = sys.stdout.encoding, sys.stdout.isatty()
        sys.stdout = _Output(sys.stdout.detach(), encoding=encoding, line_buffering=is_terminal)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="telespring")


def _spell(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeEncodeError)
    return to_ascii(error.object[error.start : error.end]), error.end


class _Output(io.TextIOWrapper):
    """The standard output, which remembers that its reader has closed it.

    What prints the help (typer, click and rich) answers a closed pipe with status 1, and does not say why.
    """

    is_closed_by_reader: ClassVar[bool] = False

    def write(self, text: str, /) -> int:
        try:
            return super().write(text)
        except BrokenPipeError:
            _Output.is_closed_by_reader = True
            raise

    def flush(self) -> None:
        try:
            super().flush()
        except BrokenPipeError:
            _Output.is_closed_by_reader = True
            raise


class _CommandConsole(Console):
    def on_broken_pipe(self) -> None:
        self.quiet = True
        _discard_output()
        raise SystemExit(141)


def screen_console(*, stderr: bool = False) -> Console:
    """Return the console of a command."""
    return _CommandConsole(highlight=False, stderr=stderr)


def show(renderable: RenderableType, console: Console | None = None) -> None:
    """Print a screen, in letters that the terminal has."""
    console = console or screen_console()
    console.print(for_encoding(renderable, console.encoding))


def close_output() -> int | None:
    """Write out what is left; return the exit status if output could not be written, else None."""
    # Not that of `sys.stdout`: click has put another one in its place.
    if _Output.is_closed_by_reader:
        _discard_output()
        return 141
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError as error:
        return output_trouble(error)
    return None


def output_trouble(error: OSError) -> int | None:
    """Return the exit status if an error without a file's name is one of the output, and tell it; else None.

    A reader that has closed its end, such as `head`, wants no more, and is no trouble.
    """
    if error.errno not in _OUTPUT_ERRORS:
        return None
    _discard_output()
    if error.errno == errno.EPIPE:
        return 141
    print(f"Refused: the output could not be written ({os.strerror(error.errno)}).", file=sys.stderr)
    print("  Check the disk, or the file that the output goes to.", file=sys.stderr)
    return 2


def _discard_output() -> None:
    # What cannot be written must not be tried again when Python ends.
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, sys.stdout.fileno())
    os.close(null)
