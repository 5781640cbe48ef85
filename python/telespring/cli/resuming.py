"""Long work that keeps finished trials: its bar, and what is said when it cannot go on."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import typer
from rich.console import Console

from telespring._errors import InvalidInput
from telespring.cli.terminal import screen_console
from telespring.show.screens.refusal import refusal_screen
from telespring.show.screens.rehearsal import rehearsal_progress_bar, rehearsal_resume_sentence

__all__ = ["resuming"]


@contextmanager
def resuming(console: Console, folder: Path, things: str = "trials") -> Iterator[Callable[[int, int], None]]:
    """Show a bar; the block calls what it receives with the number of finished trials and of all trials.

    `things` is what is counted.

    Ctrl-C ends the command with status 130, a disk that cannot be written with 2; both say what is kept.
    """
    finished, trials = 0, 0
    try:
        with rehearsal_progress_bar(console, things) as show_progress:

            def progress(done: int, total: int) -> None:
                nonlocal finished, trials
                finished, trials = done, total
                show_progress(done, total)

            yield progress
    except KeyboardInterrupt:
        console.print(f"Stopped. {rehearsal_resume_sentence(finished, trials, things)}", markup=False)
        raise typer.Exit(130) from None
    except OSError as error:
        if not trials:  # before the first trial: a file to read, or the folder itself
            raise
        refused = InvalidInput(
            "out",
            str(error.filename or folder),
            f"a writable folder with enough space is required ({error.strerror or error})",
            f"Provide one. {rehearsal_resume_sentence(finished, trials, things)}",
        )
        refusal_screen(screen_console(stderr=True), refused)
        raise typer.Exit(2) from None
