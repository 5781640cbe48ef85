"""What `telespring analyse` does with the recording of a live session."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.text import Text

from telespring._errors import InvalidInput
from telespring._files import replacing, write_whole
from telespring.cli.common import print_json
from telespring.cli.figure_file import check_folder_keeps_inputs, save_figure
from telespring.cli.terminal import show

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["analyse_session_file"]

_WRITTEN = ("analysis.json", "session.nc", "session.svg", "session.png", "table1.csv")


def analyse_session_file(
    path: Path,
    out: Path,
    *,
    discard: float | None,
    baseline: str | None,
    figures: bool,
    as_json: bool,
    refused: dict[str, Any],
) -> None:
    """Measure a recorded session, and write its dataset, its analysis and its figure to a folder.

    `refused` has the options that need trials as CSV: what was given of them is refused.
    """
    for option, value in refused.items():
        if value is not None:
            raise InvalidInput(
                option,
                str(value),
                "this option is for recorded trials, and a session has its own target and layout",
                "Leave it out.",
            )
    from telespring.analysis.sessions import analyse_session
    from telespring.recording import read_recording
    from telespring.show.screens.session import session_screen

    check_folder_keeps_inputs("--out", out, _WRITTEN, [path])
    recording = read_recording(path)
    session = recording.dataset()
    found = analyse_session(recording, session, discard, baseline)
    written = [
        write_whole(
            out / "analysis.json", json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
        ),
        _write_dataset(out / "session.nc", recording.trials()),
    ]
    if found["experiment"] is not None:
        from telespring.analysis.table import table_1_csv

        written.append(write_whole(out / "table1.csv", table_1_csv(found["experiment"]["table1"])))
    if figures:
        from telespring.show.drawings.session import draw_session

        figure = draw_session(session, recording.marked_trials(session))
        for ending in ("svg", "png"):
            save_figure(figure, out / f"session.{ending}")
            written.append(out / f"session.{ending}")
    if as_json:
        print_json(found)
        return
    show(session_screen(found, str(path)))
    show(Text(f"Written: {', '.join(str(file) for file in written)}"))


def _write_dataset(path: Path, dataset: xr.Dataset) -> Path:
    """Write a dataset as compressed netCDF, complete or absent."""
    numbers = {
        name: {"zlib": True, "complevel": 1, "shuffle": True}
        for name, variable in dataset.data_vars.items()
        if variable.ndim > 1 and variable.dtype.kind == "f"
    }
    with replacing(path) as beside:
        dataset.to_netcdf(beside, engine="h5netcdf", encoding=numbers)
    return path
