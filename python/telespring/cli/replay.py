"""The command `telespring replay`: a recorded session under another strategy, stiffness or play-out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from telespring._errors import InvalidInput
from telespring._files import replacing, write_whole
from telespring.cli.common import Stiffness, Workers, print_json
from telespring.cli.figure_file import check_folder_keeps_inputs, save_figure
from telespring.cli.terminal import screen_console, show
from telespring.cli.units import TIME, number

if TYPE_CHECKING:
    from telespring.replays import Replay

__all__ = ["replay_command"]

_FIGURE, _NUMBERS = "replay.svg", "replay.json"
_SIGNALS = ("site1.nc", "site2.nc")
_REHEARSAL = "rehearsal"


def replay_command(
    session: Annotated[
        Path,
        typer.Argument(metavar="SESSION.mcap", help="The recording of one side, or of both, merged."),
    ],
    other: Annotated[
        Path | None, typer.Argument(metavar="[OTHER.mcap]", help="The recording of the other side.")
    ] = None,
    strategy: Annotated[
        str | None,
        typer.Option(help="Strategy, such as spring or guard. Default: that of the session, as all below."),
    ] = None,
    predictor: Annotated[
        str | None, typer.Option(help="Predictor: hold, linear, kalman or shared-target.")
    ] = None,
    playout: Annotated[str | None, typer.Option(help="Play-out: fixed or adaptive.")] = None,
    playout_delay: Annotated[
        float | None,
        typer.Option(
            parser=number(TIME),
            metavar="TIME",
            help="A fixed play-out with this delay, such as 80ms or 0.08 (s).",
        ),
    ] = None,
    stiffness: Stiffness = None,
    rehearse: Annotated[
        bool,
        typer.Option(
            "--rehearse",
            help="Also rehearse both settings on the session's network, with simulated people who react.",
        ),
    ] = False,
    workers: Workers = None,
    out: Annotated[
        Path, typer.Option(help="Folder for replay.json, the signals of each side (.nc) and the figure.")
    ] = Path("out/replay"),
    figure: Annotated[bool, typer.Option(help="Draw forces, ages and accounts over time.")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print replay.json instead of the table.")] = False,
) -> None:
    """Replay a recorded session: the forces that another strategy, stiffness or play-out would have given.

    Without an option the session's own settings are replayed, which must give the recorded forces, bit for
    bit. Motions and network stay as recorded: nobody reacts to the replayed force. --rehearse takes the
    network alone.

    Example: telespring replay site1.mcap site2.mcap --strategy spring
    """
    from telespring.replays import replay
    from telespring.show.screens.replay import replay_screen

    inputs = [session] if other is None else [session, other]
    written_names = [_NUMBERS, *_SIGNALS, *([_FIGURE] if figure else [])]
    check_folder_keeps_inputs("--out", out, written_names, inputs)
    found = replay(
        session,
        other,
        strategy=strategy,
        predictor=predictor,
        playout=_playout(playout, playout_delay),
        stiffness=stiffness,
    )
    numbers = found.to_dict()
    written = _write(found, numbers, out, figure=figure)
    if as_json:
        print_json(numbers)
    else:
        show(replay_screen(found, " and ".join(str(path.name) for path in inputs)))
        screen_console().print(f"Written: {', '.join(str(path) for path in written)}", markup=False)
    if rehearse:
        _rehearse(found, out / _REHEARSAL, workers, is_quiet=as_json)


def _playout(word: str | None, delay: float | None) -> Any:
    """Return the play-out as a study writes it."""
    if delay is None:
        return word
    if word not in (None, "fixed"):
        raise InvalidInput(
            "--playout-delay",
            f"{delay:g} s with --playout {word}",
            "only a fixed play-out has a delay of its own",
            "Leave out one of them.",
        )
    return {"kind": "fixed", "delay": delay}


def _write(found: Replay, numbers: dict[str, Any], folder: Path, *, figure: bool) -> list[Path]:
    """Write numbers, signals and figure, each file whole or not at all."""
    text = json.dumps(numbers, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    written = [write_whole(folder / _NUMBERS, text)]
    for side in found.sides:
        path = folder / f"site{side.side}.nc"
        with replacing(path) as beside:
            side.dataset().to_netcdf(beside, engine="h5netcdf")
        written.append(path)
    if figure:
        from telespring.show.drawings.replay import draw_replay

        save_figure(draw_replay(found), folder / _FIGURE)
        written.append(folder / _FIGURE)
    return written


def _rehearse(found: Replay, folder: Path, workers: int | None, *, is_quiet: bool) -> None:
    """Rehearse the recorded and the replayed settings on the session's network."""
    from telespring.cli.resuming import resuming
    from telespring.comparison import run_comparison
    from telespring.replays.networks import rehearsal_study, write_traces
    from telespring.show.screens.comparison import comparison_screen

    console = screen_console(stderr=is_quiet)
    study = rehearsal_study(found)
    write_traces(found, folder)
    write_whole(folder / "study.toml", study.to_toml())
    runs = folder / "comparison"
    with resuming(console, runs) as progress:
        comparison = run_comparison(study, runs, progress, workers, modules=folder, fresh=True)
    if not is_quiet:
        comparison_screen(console, comparison)
    console.print(f"Rehearsal: {folder}", markup=False)
