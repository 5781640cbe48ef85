"""The command `telespring export`: results and recordings in the formats of the field."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from telespring._errors import InvalidInput
from telespring.cli.common import print_json
from telespring.cli.figure_file import check_not_an_input
from telespring.cli.terminal import show
from telespring.cli.units import FREQUENCY, number

__all__ = ["export_command"]


def export_command(
    path: Annotated[
        Path,
        typer.Argument(
            metavar="PATH",
            help="A rehearsal (.nc or its folder), recorded trials (CSV) or a live session (.mcap, .xdf).",
        ),
    ],
    bids: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Write a motion-BIDS dataset, or add a session to the one there."),
    ] = None,
    mat: Annotated[
        Path | None, typer.Option(metavar="FILE.mat", help="Write a MATLAB file, which Octave reads, too.")
    ] = None,
    participants: Annotated[
        str | None,
        typer.Option(
            metavar="CODE,CODE",
            help="Who held robots 1 and 2, for BIDS. Default: the session's markers, else dyad and robot.",
        ),
    ] = None,
    session: Annotated[str, typer.Option(metavar="LABEL", help="Label of the session, for BIDS.")] = "01",
    task: Annotated[str, typer.Option(metavar="LABEL", help="Label of the task, for BIDS.")] = "coupled",
    rate: Annotated[
        float | None,
        typer.Option(
            parser=number(FREQUENCY),
            metavar="Hz",
            help="Samples per second of a live session. Default: all.",
            show_default=False,
        ),
    ] = None,
    hide_date: Annotated[
        bool, typer.Option("--hide-date", help="Write 1900-01-01 for a live session's date, in BIDS.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of the sentences.")] = False,
) -> None:
    """Write trials or a live session in the formats of the field.

    Example: telespring export session.mcap --bids dataset --participants P01,P02
    """
    if bids is None and mat is None:
        raise InvalidInput(
            "--bids, --mat",
            "missing",
            "one of them is required",
            "Write --bids DIR for a BIDS dataset, --mat FILE.mat for MATLAB.",
        )
    from telespring.cli.other_files import pointing_elsewhere
    from telespring.exchange import export_bids, export_mat
    from telespring.show.screens.export import export_screen

    if mat is not None:
        check_not_an_input("--mat", mat, [path])
    with pointing_elsewhere("analyse", [path]):
        file = None if mat is None else export_mat(path, mat, rate=rate)
        dataset = (
            None
            if bids is None
            else export_bids(
                path,
                bids,
                participants=None if participants is None else participants.split(","),
                session=session,
                task=task,
                rate=rate,
                hide_date=hide_date,
            )
        )
    if as_json:
        print_json(
            {
                "mat": None if file is None else str(file),
                "bids": None
                if dataset is None
                else {
                    "folder": str(dataset.folder),
                    "session": dataset.session,
                    "people": list(dataset.people),
                    "files": [str(each) for each in dataset.files],
                    "missing": list(dataset.missing),
                },
            }
        )
        return
    show(export_screen(dataset, file))
