"""The command line: one module per command.

Exit status: 0 if the question was answered, whatever the answer; 1 if `decide --check` asked for a stable
dyad and it is not; 2 for input that was refused or a file that could not be read or written; 130 after
Ctrl-C; 141 if the reader of the output closed its end before the whole was written.
"""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from telespring.cli.analyse import analyse_command
from telespring.cli.common import refusals
from telespring.cli.compare import compare_command
from telespring.cli.connect import connect_command
from telespring.cli.decide import decide_command
from telespring.cli.explore import explore_command
from telespring.cli.export import export_command
from telespring.cli.help import Command, Group
from telespring.cli.identify import identify_command
from telespring.cli.merge import merge_command
from telespring.cli.predictor import predictor_command
from telespring.cli.probe import probe_command
from telespring.cli.rehearse import rehearse
from telespring.cli.replay import replay_command
from telespring.cli.reproduce import reproduce_command, study_command
from telespring.cli.simulate import simulate_command
from telespring.cli.sweep import sweep_command
from telespring.cli.terminal import close_output, output_trouble, prepare_streams
from telespring.cli.trace import trace_command

__all__ = ["app", "main"]

app = typer.Typer(
    name="telespring",
    cls=Group,
    help="Two people, two robots, one virtual spring over a network: is it stable, and by what margin?",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)
app.command("decide", cls=Command)(decide_command)
app.command("explore", cls=Command)(explore_command)
app.command("simulate", cls=Command)(simulate_command)
app.command("identify", cls=Command)(refusals()(identify_command))
app.command("rehearse", cls=Command)(refusals()(rehearse))
app.command("trace", cls=Command)(refusals()(trace_command))
app.command("compare", cls=Command)(refusals()(compare_command))
app.command("sweep", cls=Command)(refusals()(sweep_command))
app.command("analyse", cls=Command)(analyse_command)
app.command("export", cls=Command)(refusals()(export_command))
app.command("probe", cls=Command)(refusals()(probe_command))
app.command("connect", cls=Command)(refusals()(connect_command))
app.command("merge", cls=Command)(refusals()(merge_command))
app.command("replay", cls=Command)(refusals()(replay_command))
app.command("predictor", cls=Command)(predictor_command)
app.command("reproduce", cls=Command)(reproduce_command)
app.command("study", hidden=True)(study_command)


def _print_version(is_asked: bool) -> None:
    if is_asked:
        from telespring._core import __version__

        typer.echo(f"telespring {__version__}")
        raise typer.Exit


@app.callback()
def options(
    _version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit."),
    ] = False,
) -> None:
    """Decide, rehearse and analyse the haptic coupling of two robots over a network."""


def main() -> None:
    """Run the command line; the entry point of the installed program."""
    prepare_streams()
    try:
        app()
    except KeyboardInterrupt:
        sys.exit(130)
    except SystemExit as ended:
        sys.exit(close_output() or ended.code)
    except OSError as error:
        # Every file has a name, and is refused by it; what is left is the output.
        status = output_trouble(error)
        if status is None:
            raise
        sys.exit(status)
