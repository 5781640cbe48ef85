"""The command `telespring identify`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer
from rich.console import Console

from telespring._errors import InvalidInput
from telespring.cli.common import print_json

if TYPE_CHECKING:
    from telespring.identification.results import Identification, Method

__all__ = ["identify_command"]


def identify_command(
    log: Annotated[
        Path, typer.Argument(metavar="LOG", help="Log file: .csv (or .txt, .tsv, .dat), .parquet or .mat.")
    ],
    time: Annotated[
        str, typer.Option("--time", help="Time column, s: its name, or its number from 1.")
    ] = "time",
    position: Annotated[
        list[str] | None,
        typer.Option(
            "--position",
            help="Position column, m, by name or number; repeat for each axis, or 2,3.",
            show_default="position_x, position_y",
        ),
    ] = None,
    force: Annotated[
        list[str] | None,
        typer.Option(
            "--force",
            help="Force column, N, by name or number; repeat for each axis, in the same order.",
            show_default="force_x, force_y",
        ),
    ] = None,
    axis: Annotated[
        list[str] | None,
        typer.Option(
            "--axis", help="Name of an axis; repeat for each axis, in the same order.", show_default="x, y"
        ),
    ] = None,
    rate: Annotated[
        float | None, typer.Option(help="Samples per second, for a log without times.", show_default=False)
    ] = None,
    run: Annotated[
        str | None, typer.Option(help="Use one run of several, by number or name.", show_default=False)
    ] = None,
    run_column: Annotated[
        str | None, typer.Option(help="Column that tells the run of a sample.", show_default=False)
    ] = None,
    time_scale: Annotated[float, typer.Option(help="Seconds per unit of the time column.")] = 1.0,
    position_scale: Annotated[float, typer.Option(help="Metres per unit of the position columns.")] = 1.0,
    force_scale: Annotated[
        float, typer.Option(help="Newtons per unit of the force columns; -1 reverses the force.")
    ] = 1.0,
    force_delay: Annotated[
        float, typer.Option(help="Correct the force for this lag behind the position, s.")
    ] = 0.0,
    start: Annotated[float | None, typer.Option(help="Use samples from this time on, s.")] = None,
    end: Annotated[float | None, typer.Option(help="Use samples up to this time, s.")] = None,
    coulomb: Annotated[bool, typer.Option("--coulomb", help="Also estimate Coulomb friction.")] = False,
    offset: Annotated[bool, typer.Option("--offset", help="Also estimate an offset of the force.")] = False,
    method: Annotated[
        str, typer.Option(help="robust, ols, or paper (whose intervals are not valid).")
    ] = "robust",
    iterations: Annotated[int, typer.Option(help="Reweightings of the paper's method.")] = 1,
    cutoff: Annotated[
        float | None,
        typer.Option(help="Cut-off frequency of the filter, Hz.", show_default="chosen from the movement"),
    ] = None,
    name: Annotated[
        str | None, typer.Option(help="Name of the robot.", show_default="name of the log")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Write a robot file, for example for decide --robot1.")
    ] = None,
    figure: Annotated[
        Path | None, typer.Option(help="Write a figure of the residuals: .svg, .png or .pdf.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units instead of the table.")
    ] = False,
) -> None:
    """Identify a robot's mass, damping and friction from a log of positions and forces."""
    from telespring.identification import identify, read_log, write_robot
    from telespring.show.screens.identification import identification_screen

    columns = read_log(
        log,
        time=time,
        position=_columns(position) or ["position_x", "position_y"],
        force=_columns(force) or ["force_x", "force_y"],
        axes=axis,
        time_scale=time_scale,
        position_scale=position_scale,
        force_scale=force_scale,
        rate=rate,
        run=run,
        run_column=run_column,
        start=start,
        end=end,
    )
    if len(columns.runs) > 1:
        raise InvalidInput(
            "log",
            f"{len(columns.runs)} runs",
            "one run at a time is required",
            f"Choose one with --run: {', '.join(columns.runs[:9])}{', …' if len(columns.runs) > 9 else ''}.",
        )
    identification = identify(
        columns.time,
        columns.position,
        columns.force,
        axes=columns.axes,
        coulomb=coulomb,
        offset=offset,
        cutoff=cutoff,
        # `identify` refuses an unknown method.
        method=cast("Method", method),
        iterations=iterations,
        force_delay=force_delay,
    )
    identification = replace(identification, diagnostics=(*columns.diagnostics, *identification.diagnostics))
    if figure is not None:
        _write_residual_figure(identification, figure)
    if out is not None:
        write_robot(identification, out, name or log.stem, source=log.name)
    if as_json:
        read = {"log": str(log), "columns": dict(columns.columns), "time_stamps": columns.time_form}
        print_json(read | identification.to_json())
        return
    console = Console(highlight=False)
    console.print(identification_screen(identification, log.name))
    for label, path in (("Robot file", out), ("Figure", figure)):
        if path is not None:
            console.print(f"{label}: {path}", markup=False)


def _columns(options: list[str] | None) -> list[str]:
    """Return the columns that options name; numbers may share one option: 2,3."""
    columns: list[str] = []
    for option in options or []:
        parts = [part.strip() for part in option.split(",")]
        columns += parts if all(part.isdecimal() for part in parts) else [option]
    return columns


def _write_residual_figure(identification: Identification, path: Path) -> None:
    from telespring._files import replacing
    from telespring.show.drawings.identification import draw_residuals
    from telespring.show.figures.style import figure_style

    if path.suffix.lower() not in {".svg", ".png", ".pdf"}:
        raise InvalidInput(
            "figure",
            str(path),
            "the file's name must end in .svg, .png or .pdf",
            "Use one of these endings.",
        )
    with figure_style(), replacing(path) as temporary:
        draw_residuals(identification).savefig(temporary, dpi=200)
