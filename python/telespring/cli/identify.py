"""The command `telespring identify`."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple, cast

import typer
from rich.text import Text

from telespring._errors import InvalidInput
from telespring.cli.common import LogRate, PositionScale, TimeScale, print_json
from telespring.cli.figure_file import check_figure_name, check_not_an_input, save_figure
from telespring.cli.other_files import pointing_elsewhere
from telespring.cli.terminal import show
from telespring.cli.units import FORCE, FREQUENCY, TIME, number

if TYPE_CHECKING:
    from telespring.identification.results import Method

__all__ = ["columns_of", "identify_command"]


def identify_command(
    logs: Annotated[
        list[Path],
        typer.Argument(
            metavar="LOG...",
            help="Log files of one robot: .csv (or .txt, .tsv, .dat), .parquet or .mat. Several are "
            "taken together.",
        ),
    ],
    time: Annotated[
        str, typer.Option("--time", help="Time column, s: its name, or its number from 1.")
    ] = "time",
    position: Annotated[
        list[str] | None,
        typer.Option(
            "--position",
            help="Position column, m, by name or number; repeat for each axis, or x,y or 2,3.",
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
    rate: LogRate = None,
    run: Annotated[
        str | None, typer.Option(help="Use one run of several, by number or name.", show_default=False)
    ] = None,
    run_column: Annotated[
        str | None, typer.Option(help="Column that tells the run of a sample.", show_default=False)
    ] = None,
    time_scale: TimeScale = 1.0,
    position_scale: PositionScale = 1.0,
    force_scale: Annotated[
        float,
        typer.Option(
            parser=number(FORCE),
            metavar="FORCE",
            help="One unit of the force columns, such as 1mN or 0.001 (N); -1 reverses the force.",
        ),
    ] = 1.0,
    force_delay: Annotated[
        float | None,
        typer.Option(
            parser=number(TIME),
            metavar="TIME",
            help="Lag of the force behind the position, s, if it is known; 0 if both are sampled together.",
            show_default="estimated",
        ),
    ] = None,
    start: Annotated[
        float | None,
        typer.Option(parser=number(TIME), metavar="TIME", help="Use samples from this time on, s."),
    ] = None,
    end: Annotated[
        float | None,
        typer.Option(parser=number(TIME), metavar="TIME", help="Use samples up to this time, s."),
    ] = None,
    stiffness: Annotated[
        bool | None,
        typer.Option(
            "--stiffness/--no-stiffness",
            help="A spring between robot and ground, or none.",
            show_default="estimated",
        ),
    ] = None,
    coulomb: Annotated[
        bool | None,
        typer.Option("--coulomb/--no-coulomb", help="Coulomb friction, or none.", show_default="estimated"),
    ] = None,
    offset: Annotated[
        bool | None,
        typer.Option(
            "--offset/--no-offset", help="An offset of the force, or none.", show_default="estimated"
        ),
    ] = None,
    drag: Annotated[
        bool | None,
        typer.Option(
            "--drag/--no-drag", help="A force times v|v|, or none.", show_default="if the log shows it"
        ),
    ] = None,
    stiction: Annotated[
        bool | None,
        typer.Option(
            "--stiction/--no-stiction",
            help="Larger friction near rest (Stribeck), or none.",
            show_default="if the log shows it",
        ),
    ] = None,
    radius: Annotated[
        float | None,
        typer.Option(help="For axes that turn: metres of travel per radian; gravity is then tested."),
    ] = None,
    method: Annotated[
        str, typer.Option(help="robust, ols, or paper (whose intervals are not valid).")
    ] = "robust",
    iterations: Annotated[int, typer.Option(help="Reweightings of the paper's method.")] = 1,
    cutoff: Annotated[
        float | None,
        typer.Option(
            parser=number(FREQUENCY),
            metavar="Hz",
            help="Cut-off frequency of the filter, Hz.",
            show_default="chosen from the movement",
        ),
    ] = None,
    name: Annotated[
        str | None, typer.Option(help="Name of the robot.", show_default="name of the log")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Write a robot file, for `decide --robot`.")] = None,
    figure: Annotated[
        Path | None, typer.Option(help="Write a figure of the residuals: .svg, .png or .pdf.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units instead of the table.")
    ] = False,
) -> None:
    """Identify a robot's mass, damping, friction and springs from logs of positions and forces."""
    from telespring.identification import identify_logs, read_log, write_robot
    from telespring.show.screens.identification import identification_screen

    if figure is not None:
        check_not_an_input("--figure", check_figure_name(figure), logs)
    if out is not None:
        check_not_an_input("--out", _robot_file(out), logs)
    columns = _columns_of_axes(columns_of(position), columns_of(force))
    with pointing_elsewhere("identify", logs):
        recordings = [
            read_log(
                log,
                time=time,
                position=columns.position,
                force=columns.force,
                axes=axis or columns.axes,
                time_scale=time_scale,
                position_scale=position_scale,
                force_scale=force_scale,
                rate=rate,
                run=run,
                run_column=run_column,
                start=start,
                end=end,
            )
            for log in logs
        ]
    identification = identify_logs(
        recordings,
        stiffness=stiffness,
        coulomb=coulomb,
        offset=offset,
        drag=drag,
        stiction=stiction,
        radius=radius,
        cutoff=cutoff,
        # `identify_logs` refuses an unknown method.
        method=cast("Method", method),
        iterations=iterations,
        force_delay=force_delay,
    )
    doubts = {doubt.message: doubt for recording in recordings for doubt in recording.diagnostics}
    identification = replace(identification, diagnostics=(*doubts.values(), *identification.diagnostics))
    title = ", ".join(log.name for log in logs)
    if figure is not None:
        from telespring.show.drawings.identification import draw_residuals

        save_figure(draw_residuals(identification), figure)
    if out is not None:
        write_robot(identification, out, name or logs[0].stem, source=title)
    if as_json:
        first = recordings[0]
        source = {
            "log": title if len(logs) > 1 else str(logs[0]),
            "columns": dict(first.columns),
            "time_stamps": first.time_form,
        }
        print_json(source | identification.to_json())
        return
    show(identification_screen(identification, title))
    for label, path in (("Robot file", out), ("Figure", figure)):
        if path is not None:
            show(Text(f"{label}: {path}"))


def _robot_file(path: Path) -> Path:
    """Return the path of a robot file; refuse an ending that is not TOML's."""
    if path.suffix.lower() != ".toml":
        raise InvalidInput(
            "--out",
            str(path),
            "a robot file is TOML, and its name must end in .toml",
            f"Write {path.with_suffix('.toml')}." if path.name else "Name a file.",
        )
    return path


class _Columns(NamedTuple):
    """Position and force columns, one per axis, and the names of the axes if the columns tell them."""

    position: list[str]
    force: list[str]
    axes: list[str] | None


_POSITIONS = {axis: f"position_{axis}" for axis in "xyz"}
_FORCES = {axis: f"force_{axis}" for axis in "xyz"}


def _columns_of_axes(position: list[str], force: list[str]) -> _Columns:
    """Complete the columns: whoever names only position_y means the axis y, and force_y with it.

    Examples
    --------
    >>> _columns_of_axes(["position_y"], [])
    _Columns(position=['position_y'], force=['force_y'], axes=['y'])
    """
    if position and force:
        return _Columns(position, force, None)
    if not position and not force:
        return _Columns([_POSITIONS[axis] for axis in "xy"], [_FORCES[axis] for axis in "xy"], None)
    given, names = (position, _POSITIONS) if position else (force, _FORCES)
    axes = [axis for column in given for axis, name in names.items() if column == name]
    if len(axes) == len(given):
        return _Columns([_POSITIONS[axis] for axis in axes], [_FORCES[axis] for axis in axes], axes)
    own, other, example = (
        ("--position", "--force", "force_x") if position else ("--force", "--position", "position_x")
    )
    raise InvalidInput(
        other,
        "",
        f"{own} names {', '.join(given)}, and every axis has a position and a force",
        f"Give {other} too, one column for each of these, such as {other} {example}.",
    )


def columns_of(options: list[str] | None) -> list[str]:
    """Return the columns that options name; several may share one option, 2,3 or x,y.

    A comma before a space belongs to a name, such as Fx, N.

    Examples
    --------
    >>> columns_of(["x,y"]), columns_of(["2, 3"]), columns_of(["Fx, N", "Fy, N"])
    (['x', 'y'], ['2', '3'], ['Fx, N', 'Fy, N'])
    """
    columns: list[str] = []
    for option in options or []:
        parts = [part.strip() for part in option.split(",")]
        columns += parts if all(part.isdecimal() for part in parts) else re.split(r",(?=\S)", option)
    return columns
