"""The command `telespring merge`: both sites of a live session on one time base."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from telespring.cli.common import print_json
from telespring.cli.figure_file import check_not_an_input
from telespring.cli.terminal import show

__all__ = ["merge_command"]


def merge_command(
    first: Annotated[Path, typer.Argument(metavar="A.mcap", help="The recording of one site.")],
    second: Annotated[Path, typer.Argument(metavar="B.mcap", help="The recording of the other site.")],
    out: Annotated[
        Path, typer.Option("--out", metavar="SESSION.mcap", help="Where to write the merged recording.")
    ],
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units instead of the sentences.")
    ] = False,
) -> None:
    """Put the recordings of both sites of a live session on one time base.

    The clocks are compared by what each site knew of the other's; the rest is stated as the uncertainty of
    the common time.

    Example: telespring merge site1.mcap site2.mcap --out session.mcap
    """
    from telespring.analysis.sessions import recording_facts
    from telespring.recording import merge_recordings
    from telespring.show.screens.session import merge_screen

    check_not_an_input("--out", out, [first, second])
    found = recording_facts(merge_recordings(first, second, out))
    if as_json:
        print_json(found | {"out": str(out)})
    else:
        show(merge_screen(found, str(out)))
