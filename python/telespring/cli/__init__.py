"""The command line: one module per command.

Exit status: 0 if the question was answered, whatever the answer; 2 for input that was refused or a
file that could not be read or written; 130 after Ctrl-C.
"""

from __future__ import annotations

import io
import sys

import typer

from telespring.cli.analyse import analyse_command
from telespring.cli.common import refusals
from telespring.cli.decide import decide_command
from telespring.cli.identify import identify_command
from telespring.cli.rehearse import rehearse
from telespring.cli.reproduce import reproduce_command, study_command
from telespring.cli.simulate import simulate_command

__all__ = ["app", "main"]

app = typer.Typer(
    name="telespring",
    help="Two people, two robots, one virtual spring over a network: is it stable, and by what margin?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)
app.command("decide")(decide_command)
app.command("simulate")(simulate_command)
app.command("identify")(refusals()(identify_command))
app.command("rehearse")(refusals()(rehearse))
app.command("analyse")(analyse_command)
app.command("reproduce")(reproduce_command)
app.command("study", hidden=True)(study_command)


def main() -> None:
    """Run the command line; the entry point of the installed program."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # A letter that the terminal cannot write must not cost the answer.
            stream.reconfigure(errors="replace")
    try:
        app()
    except KeyboardInterrupt:
        sys.exit(130)
