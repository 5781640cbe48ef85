"""A log for identification: the named columns of a file, scaled to SI units."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._quantities import format_number
from telespring._types import FloatArray
from telespring.identification.log_columns import (
    check_column_lengths,
    check_column_numbers,
    find_column,
    refuse_column_without_numbers,
    suspect_force_columns,
    words_among_numbers,
)
from telespring.identification.log_formats import read_log_columns
from telespring.identification.origin import Origin, refusals_in
from telespring.identification.runs import find_runs, select_run
from telespring.identification.time_stamps import TimeStamps, read_time_stamps
from telespring.identification.warning_messages import Diagnostic, diagnostic

__all__ = ["Log", "read_log"]


@dataclass(frozen=True)
class Log:
    """Times, positions and forces of a file, scaled to SI units.

    Attributes
    ----------
    path
        The file.
    time
        s, shape (n,). Dates, times of the day and counts since 1970 are counted from the first sample.
    position, force
        m and N, shape (n, axes); NaN where the file has no number.
    axes
        Names of the axes.
    columns
        The columns that were read: "time", and per axis "position x" and "force x".
    run
        Run of each sample, from 0, shape (n,).
    runs
        Names of the runs.
    time_form
        How the file writes the time: "s", "epoch in ms" (or s, µs, ns), "date", "time of the day", or "sample
        rate" if it was given instead.
    first_time
        The first time stamp as an ISO date, if the stamps tell the date.
    diagnostics
        Reasons to doubt the columns, with their values.
    origin
        Where each sample is in the file, for messages.
    """

    path: Path
    time: FloatArray
    position: FloatArray
    force: FloatArray
    axes: tuple[str, ...]
    columns: Mapping[str, str]
    run: NDArray[np.int_]
    runs: tuple[str, ...] = ("1",)
    time_form: str = "s"
    first_time: str | None = None
    diagnostics: tuple[Diagnostic, ...] = ()
    origin: Origin | None = field(default=None, repr=False, compare=False)

    @property
    def notes(self) -> tuple[str, ...]:
        """Messages of the diagnostics."""
        return tuple(warning.message for warning in self.diagnostics)

    def split(self) -> tuple[Log, ...]:
        """Return one log per run, in the order of the file."""
        return tuple(
            replace(
                self,
                time=self.time[self.run == i],
                position=self.position[self.run == i],
                force=self.force[self.run == i],
                run=np.zeros(int((self.run == i).sum()), dtype=int),
                runs=(name,),
                origin=None if self.origin is None else self.origin.select(self.run == i),
            )
            for i, name in enumerate(self.runs)
        )


def read_log(
    path: str | os.PathLike[str],
    *,
    time: str = "time",
    position: Sequence[str] = ("position_x", "position_y"),
    force: Sequence[str] = ("force_x", "force_y"),
    axes: Sequence[str] | None = None,
    time_scale: float = 1.0,
    position_scale: float = 1.0,
    force_scale: float = 1.0,
    rate: float | None = None,
    run: str | int | None = None,
    run_column: str | None = None,
    start: float | None = None,
    end: float | None = None,
) -> Log:
    r"""Read the columns of a log.

    Parameters
    ----------
    path : path-like
        A table in a text file (.csv, .txt, .tsv, .dat), .parquet (needs pyarrow) or .mat (all versions). In a
        text file the separator, the decimal mark, comments and the line of names are found by themselves. The
        columns of a MATLAB matrix are named `name[0]`, `name[1]`, …, the fields of a struct `name.field`.
    time : str
        Time column: its name, or its number from 1. Seconds, or with `time_scale` another unit; dates (ISO
        8601), times of the day, and counts since 1970 in s, ms, µs or ns are known by themselves.
    position, force : sequence of str
        Position and force columns by name or number, one per axis, in the same order.
    axes : sequence of str
        Names of the axes; by default "x", "y", …
    time_scale, position_scale, force_scale : float
        Factors that convert the file's numbers to s, m and N, such as 0.001 for ms or mm, or the newtons per
        volt of a motor; force_scale -1 reverses the force.
    rate : float
        Samples per second, for a log without time stamps. No time column is read then, and lost samples
        cannot be noticed.
    run : str or int
        Read only this run of several: the value in the run column or, where the time starts again, its number
        from 1. By default all runs are read; `Log.split` separates them.
    run_column : str
        Column that tells the run of each sample.
    start, end : float
        Use only samples between these times, s (after scaling; from the first sample if stamps are dates).

    Returns
    -------
    Log
        The columns in SI units.

    Raises
    ------
    telespring.InvalidInput
        If the file has another format, a line of another length, a column that is missing or contains no
        numbers, or a scale is 0.
    OSError
        If the file cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> path = Path(tempfile.mkdtemp()) / "log.csv"
    >>> _ = path.write_text("0,00;0,01;1,5\n0,01;0,02;1,6\n")
    >>> read_log(path, time="1", position=["2"], force=["3"]).position.ravel().tolist()
    [0.01, 0.02]
    """
    log_path = Path(path)
    if len(position) != len(force) or not position:
        raise InvalidInput(
            "position, force",
            f"{len(position)} and {len(force)} columns",
            "as many forces as positions, one per axis, are required",
            "Name both once per axis, in the same order.",
        )
    names = _log_axis_names(axes, position)
    _check_scales({"time": time_scale, "position": position_scale, "force": force_scale}, rate)
    for option, limit in (("start", start), ("end", end)):
        if limit is not None and np.isnan(limit):
            raise InvalidInput(option, f"{limit:g}", "a time in s is required", "Omit it for the whole log.")
    with refusals_in(Origin(names, log_path.name)):
        log = read_log_columns(log_path)
        position_names = [find_column(log, "position", name, position_scale) for name in position]
        force_names = [find_column(log, "force", name, force_scale) for name in force]
        time_name = None if rate is not None else find_column(log, "time", time, time_scale)
        check_column_lengths(log, [*([time_name] if time_name else []), *position_names, *force_names])
        positions, forces = (
            np.column_stack([log.numbers(name) for name in selected])
            for selected in (position_names, force_names)
        )
        check_column_numbers(position_names, positions, "position")
        check_column_numbers(force_names, forces, "force")
        if time_name is not None:
            with refusals_in(Origin((), log_path.name, {"time": time_name})):
                stamps = read_time_stamps(log.columns[time_name], time_scale, log.decimal)
            if np.isnan(stamps.seconds).all():
                raise refuse_column_without_numbers("time", time)
        else:
            assert rate is not None  # otherwise there is a time column
            stamps = TimeStamps(np.arange(len(positions)) / rate, "sample rate")
        run_name = None if run_column is None else find_column(log, "run-column", run_column, 1.0)
        belongs, runs = find_runs(stamps.seconds, None if run_name is None else log.columns[run_name])
        repeated = _repeated_samples(stamps.seconds, positions, forces)
        keep = ~repeated
        if run is not None:
            chosen = select_run(str(run), runs)
            keep &= belongs == chosen
            belongs, runs = np.zeros_like(belongs), (runs[chosen],)
        keep &= _samples_between(stamps.seconds, keep, start, end)
        columns = ({} if time_name is None else {"time": time_name}) | {
            f"{kind} {axis}": name
            for kind, chosen in (("position", position_names), ("force", force_names))
            for axis, name in zip(names, chosen, strict=True)
        }
        # Stamps that are not the seconds of `Log.time` are shown as they are written.
        is_plain = stamps.form in ("s", "sample rate") and time_scale == 1.0
        origin = Origin(
            names,
            log_path.name,
            columns,
            stamps.seconds,
            None if is_plain or time_name is None else log.columns[time_name],
            lines=log.lines,
        )
        return Log(
            path=log_path,
            time=stamps.seconds[keep],
            position=position_scale * positions[keep],
            force=force_scale * forces[keep],
            axes=names,
            columns=columns,
            run=belongs[keep],
            runs=runs,
            time_form=stamps.form,
            first_time=stamps.first,
            diagnostics=(
                *suspect_force_columns(log, force_names, force_scale),
                *words_among_numbers(log, [*position_names, *force_names]),
                *([diagnostic("repeated samples", count=int(repeated.sum()))] if repeated.any() else []),
            ),
            origin=origin.select(keep),
        )


def _log_axis_names(axes: Sequence[str] | None, position: Sequence[str]) -> tuple[str, ...]:
    """Name the axis of each position column."""
    if axes:
        if len(axes) != len(position):
            raise InvalidInput(
                "axis",
                ", ".join(axes),
                f"one name per position is required, here {len(position)}",
                "Name each axis once, in the order of the positions.",
            )
        return tuple(axes)
    return ("x", "y", "z")[: len(position)] if len(position) <= 3 else tuple(map(str, range(len(position))))


def _check_scales(scales: Mapping[str, float], rate: float | None) -> None:
    for option, scale in scales.items():
        if not np.isfinite(scale) or scale == 0.0:
            raise InvalidInput(
                f"{option}_scale",
                f"{scale:g}",
                "a scale must be a number other than 0",
                "Omit it for 1.",
            )
    if rate is not None and not (np.isfinite(rate) and rate > 0.0):
        raise InvalidInput(
            "rate", f"{rate:g}", "samples per second are required", "Omit it if the log has times."
        )


def _repeated_samples(time: FloatArray, *values: FloatArray) -> NDArray[np.bool_]:
    """Find rows that repeat the row before, as some buses deliver a message twice."""
    again = np.flatnonzero(time[1:] == time[:-1]) + 1
    repeated = np.zeros(time.size, dtype=bool)
    rows = np.column_stack(values)
    now, before = rows[again], rows[again - 1]
    repeated[again] = ((now == before) | (np.isnan(now) & np.isnan(before))).all(axis=1)
    return repeated


def _samples_between(
    time: FloatArray, chosen: NDArray[np.bool_], start: float | None, end: float | None
) -> NDArray[np.bool_]:
    """Select the samples between two times, s; a sample without a time stamp stays, and is a lost one."""
    keep = np.ones(time.size, dtype=bool)
    if start is not None:
        keep &= ~(time < start)
    if end is not None:
        keep &= ~(time > end)
    if not (keep & chosen).any():
        limits = [
            f"from {format_number(start, 6)} s" if start is not None else "",
            f"to {format_number(end, 6)} s" if end is not None else "",
        ]
        raise InvalidInput(
            "start, end",
            " ".join(filter(None, limits)),
            f"the log runs from {format_number(np.nanmin(time[chosen]), 6)} to "
            f"{format_number(np.nanmax(time[chosen]), 6)} s",
            "Choose a part within it.",
        )
    return keep
