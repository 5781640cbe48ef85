"""Recordings of a robot: times, positions and forces, from arrays or from the runs of a log."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from telespring._arrays import as_numbers
from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification.copies import find_copies
from telespring.identification.origin import Origin
from telespring.identification.warning_messages import Diagnostic, diagnostic

if TYPE_CHECKING:
    from telespring.identification.log_reading import Log

__all__ = ["Recording", "recording_of_arrays", "recordings_of_logs", "without_copies"]


@dataclass(frozen=True, eq=False)
class Recording:
    """One run of one robot.

    Attributes
    ----------
    name
        How messages name it among others.
    time
        s, shape (n,).
    position, force
        m and N, shape (axes, n).
    origin
        Names of its columns and samples.
    warnings
        What was found so far.
    """

    name: str
    time: FloatArray
    position: FloatArray
    force: FloatArray
    origin: Origin
    warnings: tuple[Diagnostic, ...] = ()


def recording_of_arrays(
    time: ArrayLike, position: ArrayLike, force: ArrayLike, axes: Sequence[str] | None, number: int = 1
) -> Recording:
    """Check arrays over (time,) or (time, axis), and name their axes."""
    times = as_numbers("time", time)
    positions, forces = _rows("position", position), _rows("force", force)
    names = _axis_names(axes, len(positions))
    return Recording(f"log {number}", times, positions, forces, Origin(names, time=times))


def recordings_of_logs(
    logs: Sequence[Log | tuple[ArrayLike, ArrayLike, ArrayLike]], axes: Sequence[str] | None
) -> list[Recording]:
    """Return every run of every log; the names of the axes are by default those of the first log."""
    if not logs:
        raise InvalidInput("logs", "none", "at least one log is required", "Name a log.")
    recordings: list[Recording] = []
    for number, log in enumerate(logs, start=1):
        if isinstance(log, tuple):
            recordings.append(recording_of_arrays(*log, axes, number))
            continue
        for run, part in zip(log.runs, log.split(), strict=True):
            position, force = _rows("position", part.position), _rows("force", part.force)
            known = _axis_names(axes if axes is not None else part.axes, len(position))
            name = log.path.name if len(log.runs) == 1 else f"{log.path.name}, run {run}"
            # The columns have the names of the log's own axes.
            columns = {kind: name for kind, name in part.columns.items() if kind == "time"} | {
                f"{kind} {axis}": part.columns[f"{kind} {own}"]
                for kind in ("position", "force")
                for axis, own in zip(known, part.axes, strict=True)
                if f"{kind} {own}" in part.columns
            }
            origin = part.origin or Origin(known, time=part.time)
            origin = replace(origin, axes=known, file=name, columns=columns)
            recordings.append(Recording(name, part.time, position, force, origin))
    counts = [len(recording.position) for recording in recordings]
    if len(set(counts)) > 1:
        raise InvalidInput(
            "logs",
            " and ".join(map(str, counts)) + " axes",
            "logs of one robot have the same axes",
            "Identify each robot by itself.",
        )
    return recordings


def without_copies(recordings: Sequence[Recording]) -> tuple[list[Recording], list[Diagnostic]]:
    """Let samples that repeat others count once: a copied log is dropped, a repeated part is lost.

    Returns the recordings, of which one with a repeated part has a warning, and a warning per dropped one.
    """
    found = find_copies(
        [
            np.vstack([recording.position, recording.force]).T
            if recording.position.shape == recording.force.shape
            else np.zeros((0, 1))
            for recording in recordings
        ]
    )
    kept: list[Recording] = []
    dropped: list[Diagnostic] = []
    for recording, copies in zip(recordings, found, strict=True):
        if not copies.repeated.any():
            kept.append(recording)
            continue
        source = recordings[copies.log]
        if copies.repeated.all():
            code = "same log" if recording.name == source.name else "copied log"
            dropped.append(diagnostic(code, log=recording.name, other=source.name))
            continue
        place = source.origin.place(copies.sample)
        told = diagnostic(
            "repeated part",
            count=int(copies.repeated.sum()),
            place=recording.origin.place(copies.first),
            source=place if source is recording else f"{place} in {source.name}",
        )
        kept.append(
            replace(
                recording,
                position=_lost(recording.position, copies.repeated),
                warnings=(*recording.warnings, told),
            )
        )
    return kept, dropped


def _lost(rows: FloatArray, samples: NDArray[np.bool_]) -> FloatArray:
    """Return the rows with some samples missing."""
    lost = rows.copy()
    lost[:, samples] = np.nan
    return lost


def _rows(name: str, values: ArrayLike) -> FloatArray:
    """Transpose an array over (time,) or (time, axis) to one row per axis."""
    array = as_numbers(name, values)
    if array.ndim not in (1, 2) or array.size == 0:
        raise InvalidInput(
            name,
            f"an array of shape {array.shape}",
            "one value per sample, or one row per sample with one value per axis, is required",
            "Put time first: one row per sample.",
        )
    return np.ascontiguousarray(array.reshape(array.shape[0], -1).T)


def _axis_names(axes: Sequence[str] | None, count: int) -> list[str]:
    """Return the given axis names, checked, or x, y, z."""
    if axes is None:
        return ["x", "y", "z"][:count] if count <= 3 else [f"axis {i + 1}" for i in range(count)]
    names = [str(name) for name in axes]
    if len(names) != count or len(set(names)) != count:
        raise InvalidInput(
            "axes",
            repr(names),
            f"{count} different names are required, one per axis",
            "Omit them for x, y.",
        )
    return names
