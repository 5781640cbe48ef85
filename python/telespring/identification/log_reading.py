"""A log for identification: the named columns of a file, scaled to SI units."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification.log_formats import read_log_columns
from telespring.identification.warning_messages import Diagnostic, diagnostic

__all__ = ["Log", "read_log"]

#: A force column whose name has one of these as a word is probably not a force.
_OTHER_QUANTITIES = {"v", "volt", "volts", "voltage", "vir", "u", "current", "amp", "amps", "mv", "ma", "pwm"}


@dataclass(frozen=True)
class Log:
    """Times, positions and forces of a file, scaled to SI units.

    Attributes
    ----------
    path
        The file.
    time
        s, shape (n,).
    position, force
        m and N, shape (n, axes).
    axes
        Names of the axes.
    columns
        The columns that were read: "time", and per axis "position x" and "force x".
    diagnostics
        Reasons to doubt the columns, with their values.
    """

    path: Path
    time: FloatArray
    position: FloatArray
    force: FloatArray
    axes: tuple[str, ...]
    columns: Mapping[str, str]
    diagnostics: tuple[Diagnostic, ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        """Messages of the diagnostics."""
        return tuple(warning.message for warning in self.diagnostics)


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
    start: float | None = None,
    end: float | None = None,
) -> Log:
    """Read the named columns of a log.

    Parameters
    ----------
    path : path-like
        A file whose name ends in .csv (first line: names), .parquet (needs pyarrow) or .mat (MATLAB, up to
        version 7.2; the columns of a matrix are named `name[0]`, `name[1]`, …, the fields of a struct
        `name.field`).
    time : str
        Name of the time column.
    position, force : sequence of str
        Names of the position and force columns, one per axis, in the same order.
    axes : sequence of str
        Names of the axes; by default "x", "y", …
    time_scale, position_scale, force_scale : float
        Factors that convert the file's numbers to s, m and N, such as 0.001 for ms or mm, or the newtons per
        volt of a motor; force_scale -1 reverses the force.
    start, end : float
        Use only samples between these times, s (after scaling).

    Returns
    -------
    Log
        The columns in SI units.

    Raises
    ------
    telespring.InvalidInput
        If the file has another format, a column is missing or contains no numbers, or a scale is 0.
    OSError
        If the file cannot be read.
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
    for option, scale in (("time", time_scale), ("position", position_scale), ("force", force_scale)):
        if not np.isfinite(scale) or scale == 0.0:
            raise InvalidInput(
                f"{option}_scale",
                f"{scale:g}",
                "a scale must be a number other than 0",
                "Omit it for 1.",
            )
    for option, limit in (("start", start), ("end", end)):
        if limit is not None and np.isnan(limit):
            raise InvalidInput(option, f"{limit:g}", "a time in s is required", "Omit it for the whole log.")
    columns = read_log_columns(log_path)
    times = time_scale * _select_log_column(log_path, columns, "time", time)
    positions, forces = (
        np.column_stack([_select_log_column(log_path, columns, option, name) for name in selected])
        for option, selected in (("position", position), ("force", force))
    )
    keep = np.ones(times.size, dtype=bool)
    # Missing times are kept here: they must be refused, not dropped.
    if start is not None:
        keep &= ~(times < start)
    if end is not None:
        keep &= ~(times > end)
    if not keep.any():
        raise InvalidInput(
            "start, end",
            f"{start} to {end} s",
            f"the log runs from {np.nanmin(times):g} to {np.nanmax(times):g} s",
            "Choose a part within it.",
        )
    return Log(
        path=log_path,
        time=times[keep],
        position=position_scale * positions[keep],
        force=force_scale * forces[keep],
        axes=names,
        columns={"time": time}
        | {f"position {axis}": name for axis, name in zip(names, position, strict=True)}
        | {f"force {axis}": name for axis, name in zip(names, force, strict=True)},
        diagnostics=tuple(_suspect_force_columns(columns, force, force_scale)),
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


def _select_log_column(path: Path, columns: Mapping[str, FloatArray], option: str, name: str) -> FloatArray:
    """Return the column that an option names, checked to have one number per sample."""
    column = columns.get(name)
    if column is None:
        available = ", ".join(other for other, values in columns.items() if values.size > 1) or "none"
        raise InvalidInput(
            f"--{option}",
            name,
            f"the columns of {path.name} are: {available}",
            f"Name the {option} column with --{option}.",
        )
    if column.size == 0:
        raise InvalidInput(
            "log",
            str(path),
            "a log with one row per sample is required, but this one contains no samples",
            "Check that the recording was saved; the file has only its first line.",
        )
    if column.size > 1 and np.isnan(column).all():
        raise InvalidInput(
            f"--{option}",
            name,
            "a column of numbers is required, but this one contains none",
            "Name another column.",
        )
    longest = max(values.size for values in columns.values())
    if column.size != longest:
        raise InvalidInput(
            f"--{option}",
            f"{name}, {column.size} values",
            f"one value per sample is required, and the log has {longest} samples",
            "Name a column that was recorded with every sample.",
        )
    return column


def _suspect_force_columns(
    columns: Mapping[str, FloatArray], force: Sequence[str], scale: float
) -> list[Diagnostic]:
    """Find a force column in other units that no scale converts, and scalars that may be the scale."""
    suspects = [name for name in force if set(name.lower().replace("[", "_").split("_")) & _OTHER_QUANTITIES]
    if scale != 1.0 or not suspects:
        return []
    scalars = ", ".join(name for name, values in columns.items() if values.size == 1)
    return [diagnostic("suspect force column", column=suspects[0], scalars=scalars or "none")]
