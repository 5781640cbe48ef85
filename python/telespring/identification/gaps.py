"""Lost samples of a log: short gaps are bridged and marked, long ones cut the log into pieces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._quantities import format_count, format_time
from telespring._types import FloatArray
from telespring.identification.origin import Origin
from telespring.identification.warning_messages import Diagnostic, diagnostic

__all__ = ["LONGEST_BRIDGE", "Piece", "bridge_gaps"]

#: A step longer than so many usual ones is a gap.
_GAP = 1.75
#: The longest step that is bridged, in usual steps and rounded; the same as in recorded trials.
LONGEST_BRIDGE = 5.0
#: A piece between two long gaps with fewer samples is left out.
_FEWEST_SAMPLES = 10


@dataclass(frozen=True, eq=False)
class Piece:
    """A part of a log without gaps.

    Attributes
    ----------
    time
        s, shape (n,).
    position, force
        m and N, shape (axes, n).
    usable
        Shape (n,): False where a sample was lost, and was interpolated.
    sample
        Number of each sample in the log, from 0; of a lost one that of the sample before.
    """

    time: FloatArray
    position: FloatArray
    force: FloatArray
    usable: NDArray[np.bool_]
    sample: NDArray[np.int_]


def bridge_gaps(
    time: FloatArray, position: FloatArray, force: FloatArray, origin: Origin | None = None
) -> tuple[tuple[Piece, ...], list[Diagnostic]]:
    """Cut a log at its long gaps, and bridge the short ones by linear interpolation.

    Times (s) have shape (n,), positions (m) and forces (N) have shape (axes, n). A sample is lost if its time
    stamp or one of its numbers is missing or infinite, or if there is no row for it. `origin` names samples
    in warnings. InvalidInput if no piece has enough samples.
    """
    origin = origin or Origin([str(i + 1) for i in range(len(position))], time=time)
    whole = np.isfinite(time) & np.isfinite(position).all(axis=0) & np.isfinite(force).all(axis=0)
    measured = np.flatnonzero(whole)
    if measured.size < _FEWEST_SAMPLES:
        complete = format_count(measured.size, "sample that has", "samples that have")
        raise InvalidInput(
            "time, position, force",
            f"{complete} all numbers, of {time.size}",
            f"at least {_FEWEST_SAMPLES} are required",
            "If position and force were logged at different times, interpolate them to common times.",
        )
    steps = np.diff(time[measured])
    # Where one signal is logged less often than the other, its own samples are the log's.
    usual = float(np.median(steps))
    cuts = np.flatnonzero(np.rint(steps / usual) > LONGEST_BRIDGE) + 1
    pieces: list[Piece] = []
    bridged, gaps, longest, left_out = 0, 0, 0.0, 0
    for part in np.split(measured, cuts):
        if part.size < _FEWEST_SAMPLES:
            left_out += part.size
            continue
        even, before, usable = _with_lost_times(time[part], usual)
        positions, forces = (
            np.stack([np.interp(even, time[part], row[part]) for row in rows]) for rows in (position, force)
        )
        pieces.append(Piece(even, positions, forces, usable, part[before]))
        short = np.diff(time[part])[np.diff(time[part]) > _GAP * usual]
        bridged += int((~usable).sum())
        gaps += short.size
        longest = max(longest, float(short.max(initial=0.0)))
    if not pieces:
        raise InvalidInput(
            "time",
            f"{format_count(cuts.size, 'gap')}, and no {_FEWEST_SAMPLES} samples between two of them",
            f"gaps of up to {LONGEST_BRIDGE:g} samples ({format_time(LONGEST_BRIDGE * usual)}) are bridged",
            "Record the log again without losing samples.",
        )
    found = []
    if bridged:
        found.append(diagnostic("bridged gaps", count=bridged, gaps=gaps, longest=longest))
    if cuts.size:
        largest = int(cuts[np.argmax(steps[cuts - 1])])
        found.append(
            diagnostic(
                "long gaps",
                count=cuts.size,
                longest=float(steps[largest - 1]),
                place=origin.place(int(measured[largest - 1])),
                pieces=len(pieces),
            )
        )
    if left_out:
        found.append(diagnostic("samples between gaps", count=left_out))
    return tuple(pieces), found


def _with_lost_times(
    time: FloatArray, usual: float
) -> tuple[FloatArray, NDArray[np.int_], NDArray[np.bool_]]:
    """Insert evenly spaced times into the gaps.

    Returns also the last measured sample before each, and which ones were measured.
    """
    steps = np.diff(time)
    lost = np.where(steps > _GAP * usual, np.rint(steps / usual).astype(int) - 1, 0)
    # Each measured time, followed by those that were lost after it.
    repeats = np.append(lost + 1, 1)
    first = np.repeat(np.arange(time.size), repeats)
    inside = np.arange(first.size) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    step = np.append(steps / (lost + 1), 0.0)
    return time[first] + inside * step[first], first, inside == 0
