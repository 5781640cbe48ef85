"""The command `telespring identify`."""

from __future__ import annotations

import json
import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer
from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    from telespring.identification.log_reading import Log
    from telespring.identification.results import Estimate, Identification, Method

__all__ = ["identification_screen", "identify_command"]


def identify_command(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="A log in .csv, .parquet or .mat.")],
    time: Annotated[str, typer.Option("--time", help="Column of the time, s.")] = "time",
    position: Annotated[
        list[str] | None,
        typer.Option(
            "--position", help="Column of a position, m; once per axis; position_x, position_y unless given."
        ),
    ] = None,
    force: Annotated[
        list[str] | None,
        typer.Option(
            "--force",
            help="Column of a force, N; once per axis, in the same order; force_x, force_y unless given.",
        ),
    ] = None,
    axis: Annotated[
        list[str] | None,
        typer.Option("--axis", help="Name of an axis, in the same order; x, y unless given."),
    ] = None,
    time_scale: Annotated[float, typer.Option(help="Seconds per unit of the time.")] = 1.0,
    position_scale: Annotated[float, typer.Option(help="Metres per unit of the position.")] = 1.0,
    force_scale: Annotated[
        float, typer.Option(help="Newtons per unit of the force; −1 turns its sign.")
    ] = 1.0,
    force_delay: Annotated[float, typer.Option(help="By how much the force's samples are older, s.")] = 0.0,
    start: Annotated[float | None, typer.Option(help="Take samples from this time on, s.")] = None,
    end: Annotated[float | None, typer.Option(help="Take samples up to this time, s.")] = None,
    coulomb: Annotated[bool, typer.Option("--coulomb", help="Estimate Coulomb friction too.")] = False,
    offset: Annotated[bool, typer.Option("--offset", help="Estimate an offset of the force too.")] = False,
    method: Annotated[
        str, typer.Option(help="robust, ols, or paper (whose intervals mean nothing).")
    ] = "robust",
    iterations: Annotated[int, typer.Option(help="Reweightings of the paper's method.")] = 1,
    cutoff: Annotated[
        float | None, typer.Option(help="Cut-off of the filter, Hz; from the movement unless given.")
    ] = None,
    name: Annotated[str | None, typer.Option(help="The robot's name; the log's unless given.")] = None,
    out: Annotated[Path | None, typer.Option(help="Robot file to write, for decide --robot1.")] = None,
    figure: Annotated[Path | None, typer.Option(help="Figure to write, .svg, .png or .pdf.")] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units instead of the table.")
    ] = False,
) -> None:
    """Identify a robot's mass, damping and friction from a log of positions and forces."""
    from telespring.identification import identify, read_log, write_robot

    position, force = _columns(position, force)
    read = read_log(
        log,
        time=time,
        position=position,
        force=force,
        axes=axis,
        time_scale=time_scale,
        position_scale=position_scale,
        force_scale=force_scale,
        start=start,
        end=end,
    )
    found = identify(
        read.time,
        read.position,
        read.force,
        axes=read.axes,
        coulomb=coulomb,
        offset=offset,
        cutoff=cutoff,
        # Another word is refused by name.
        method=cast("Method", method),
        iterations=iterations,
        force_delay=force_delay,
    )
    if figure is not None:
        _write_figure(found, figure)
    if out is not None:
        noted = replace(found, warnings=(*read.notes, *found.warnings))
        write_robot(noted, out, name or log.stem, source=log.name)
    if as_json:
        answer = {"log": str(log), "columns": dict(read.columns)} | found.to_json()
        answer["warnings"] = [*read.notes, *found.warnings]
        escape_letters = not sys.stdout.encoding.lower().startswith("utf")
        typer.echo(json.dumps(answer, indent=1, ensure_ascii=escape_letters, allow_nan=False))
        return
    console = Console(highlight=False)
    console.print(identification_screen(found, read))
    for what, path in (("Robot", out), ("Figure", figure)):
        if path is not None:
            console.print(f"{what}: {path}", markup=False)


def _columns(position: list[str] | None, force: list[str] | None) -> tuple[list[str], list[str]]:
    """Take two axes by the usual names where none is named."""
    return position or ["position_x", "position_y"], force or ["force_x", "force_y"]


def _write_figure(found: Identification, path: Path) -> None:
    from telespring._errors import InvalidInput
    from telespring._files import replacing
    from telespring.show.figures.identification import residual_figure
    from telespring.show.figures.style import styled

    if path.suffix.lower() not in {".svg", ".png", ".pdf"}:
        raise InvalidInput(
            "figure", str(path), "the file's name must end in .svg, .png or .pdf", "Choose one of them."
        )
    with styled(), replacing(path) as beside:
        residual_figure(found).savefig(beside, dpi=200)


def identification_screen(found: Identification, log: Log) -> RenderableType:
    """Lay out what was identified for the terminal.

    Parameters
    ----------
    found
        What was identified.
    log
        The log it came from.

    Returns
    -------
    rich.console.RenderableType
        Estimates with intervals, how good the fit is, how it was made, and what to beware of.
    """
    table = Table(box=None, pad_edge=False, title_justify="left", title_style="bold", title=log.path.name)
    table.add_column("axis", no_wrap=True, min_width=4)
    for heading in ("parameter", "estimate", "95 % interval", "condition", "R²"):
        table.add_column(heading, justify="left" if heading == "parameter" else "right", no_wrap=True)
    units = {"mass": "kg", "damping": "N·s/m", "coulomb": "N", "offset": "N"}
    words = {"mass": "mass", "damping": "damping", "coulomb": "Coulomb friction", "offset": "offset"}
    for axis in found.axes:
        first = True
        for key, estimate in axis.estimates.items():
            table.add_row(
                axis.axis if first else "",
                words[key],
                *_written(estimate, units[key]),
                f"{axis.condition_number:.4g}" if first else "",
                f"{axis.r_squared:.5f}" if first else "",
            )
            first = False
    used = (
        f"{found.samples[0]} samples at {found.rate:.5g} Hz; filtered at {found.cutoff:.4g} Hz "
        f"({found.cutoff_rule}); {found.samples[1]} used."
    )
    how = {
        "robust": "Robust fit; the intervals account for correlated residuals.",
        "ols": "Least squares; the intervals account for correlated residuals.",
        "paper": (
            f"The paper's weights 1/(r² + ε), {found.iterations} reweighting"
            f"{'' if found.iterations == 1 else 's'}: these intervals mean nothing."
        ),
    }[found.method]
    state = {
        True: Text("Axes are independent, as far as this log shows.", style="green"),
        False: Text("Axes are NOT independent.", style="bold red"),
        None: Text("Whether the axes are independent cannot be told."),
    }[found.independent]
    parts: list[RenderableType] = [table, Text(used), Text(how)]
    if len(found.axes) > 1:
        parts.append(state)
    parts += [Text.assemble(("Beware: ", "bold yellow"), note) for note in (*log.notes, *found.warnings)]
    return Group(*parts)


def _written(estimate: Estimate, unit: str) -> tuple[str, str]:
    """Write a value with as many digits as its standard error leaves, at most 6 after the point."""
    error = estimate.standard_error
    digits = min(6, max(0, 1 - math.floor(math.log10(error)))) if 0.0 < error < math.inf else 6
    low, high = estimate.interval
    return f"{estimate.value:.{digits}f} {unit}", f"{low:.{digits}f} to {high:.{digits}f}"
