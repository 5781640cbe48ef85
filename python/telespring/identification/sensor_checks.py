"""Checks of the sensors over a piece of a log: stuck positions, jumps, held and constant values."""

from __future__ import annotations

import numpy as np

from telespring._errors import InvalidInput
from telespring._quantities import format_number, format_time
from telespring._types import FloatArray
from telespring.identification.gaps import Piece
from telespring.identification.origin import Origin
from telespring.identification.warning_messages import Diagnostic, diagnostic

__all__ = ["check_sensors"]

#: A position that does not change for this long, s, and then jumps was stuck.
_STUCK = 0.05
#: The same for a position that stays within its sensor's step or noise: for at least so long, s, and for this
#: share of the log, while the force varies by this share of its variation elsewhere.
_FROZEN, _FROZEN_SHARE, _PUSHED = 0.5, 0.05, 0.5
#: A step between two samples that is so many times the largest usual one is a jump.
_JUMP = 4.0


def check_sensors(piece: Piece, origin: Origin) -> list[Diagnostic]:
    """Check the sensors over a piece of a log without gaps."""
    step = float(np.median(np.diff(piece.time)))
    warnings: list[Diagnostic] = []
    for i, row in enumerate(piece.position):
        column = origin.column("position", i)
        _refuse_stuck_position(column, row, piece, origin)
        _refuse_frozen_position(column, row, piece.force[i], piece, origin)
        warnings += _position_jumps(column, row, piece, origin)
        warnings += _held_position(column, row, step)
    for i, row in enumerate(piece.force):
        warnings += _constant_force(origin.column("force", i), row, piece.position[i], step, piece, origin)
    if any(np.array_equal(piece.position[0], row) for row in piece.position[1:]):
        warnings.append(diagnostic("identical positions"))
    return warnings


def _place(piece: Piece, origin: Origin, sample: int) -> str:
    """Name a sample of a piece as the log does."""
    return origin.place(int(piece.sample[sample]))


def _remedy(piece: Piece, start: int, end: int) -> str:
    """Say how to leave out the samples from one to before another, where a sensor was stuck."""
    parts = [f"--end {piece.time[start]:.9g}"] if start else []
    if end < piece.time.size:
        parts.append(f"--start {piece.time[end]:.9g}")
    return f"The sensor was stuck. Leave this part out with {' or '.join(parts)}."


def _runs_of_equal_samples(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return start and length of every run of equal samples."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(values) != 0.0) + 1])
    return starts, np.diff(np.concatenate([starts, [values.size]]))


def _refuse_stuck_position(column: str, position: FloatArray, piece: Piece, origin: Origin) -> None:
    """Refuse a position that stopped while the robot moved on: it jumps later, or never moves again."""
    if float(np.ptp(position)) == 0.0:
        raise InvalidInput(
            column,
            f"{format_number(position[0], 6)} m throughout",
            "a position that changes is required",
            "Check that this is the right column and that the sensor is connected.",
        )
    step = float(np.median(np.diff(piece.time)))
    starts, lengths = _runs_of_equal_samples(position)
    moves = np.abs(np.diff(position))
    # The robot moves at most this far between two samples; beyond it, it moved while the sensor was stuck.
    usual = float(np.quantile(moves[moves > 0.0], 0.99))
    shortest = max(3, int(_STUCK / step))
    for run in np.flatnonzero((lengths >= shortest) & (starts > 0)):
        start, length = int(starts[run]), int(lengths[run])
        end = start + length
        speed_before = abs(float(position[start] - position[max(0, start - shortest)])) / shortest
        jumps = end < position.size and moves[end - 1] > 5.0 * usual
        lasts = end == position.size and speed_before > 0.2 * usual
        if jumps or lasts:
            raise InvalidInput(
                column,
                f"constant for {format_time(length * step, 3)} from {_place(piece, origin, start)} on"
                + (", then a jump" if jumps else ", to the end, although the robot was moving"),
                "a position that follows the robot all the time is required",
                _remedy(piece, start, end),
            )


def _refuse_frozen_position(
    column: str, position: FloatArray, force: FloatArray, piece: Piece, origin: Origin
) -> None:
    """Refuse a position that stays within its noise while a varying force pushes the robot."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    step = float(np.median(np.diff(piece.time)))
    window = max(3, round(_FROZEN / step))
    if 4 * window > position.size:
        return
    # The smallest moves show the noise from sample to sample; and an encoder may flicker by a step.
    moves = np.abs(np.diff(position))
    moving = moves[moves > 0.0]
    reach = maximum_filter1d(position, window) - minimum_filter1d(position, window)
    still = max(float(np.quantile(moving, 0.01)) * 2.0, 1e-3 * float(np.quantile(reach, 0.9)))
    resting = np.flatnonzero(reach[window // 2 : -(window // 2)] <= still) + window // 2
    if not resting.size:
        return
    runs = np.split(resting, np.flatnonzero(np.diff(resting) > 1) + 1)
    longest = max(runs, key=len)
    first, last = int(longest[0]) - window // 2, int(longest[-1]) + window // 2
    duration = (last - first) * step
    # Without a force, rest is rest; friction holds a robot only against a small force.
    inside = np.zeros(position.size, dtype=bool)
    inside[first : last + 1] = True
    is_pushed = (
        float(np.std(force[inside])) > _PUSHED * float(np.std(force[~inside])) if (~inside).any() else True
    )
    if duration >= _FROZEN_SHARE * position.size * step and is_pushed:
        raise InvalidInput(
            column,
            f"constant within {format_number(still, 2, shift=3)} mm for {format_time(duration, 3)} from "
            f"{_place(piece, origin, first)} on, although the force continues as before",
            "a position that follows the robot all the time is required",
            _remedy(piece, first, last + 1),
        )


def _held_position(column: str, position: FloatArray, step: float) -> list[Diagnostic]:
    """Detect a position that was updated less often than it was logged, so that each value repeats."""
    _, lengths = _runs_of_equal_samples(position)
    usual = int(np.median(lengths))
    if usual < 2 or np.mean(lengths == usual) < 0.8:
        return []
    period, age = usual * step, 0.5 * (usual - 1) * step
    return [diagnostic("held position", column=column, repeats=usual, period=period, age=age)]


def _position_jumps(column: str, position: FloatArray, piece: Piece, origin: Origin) -> list[Diagnostic]:
    moves = np.abs(np.diff(position))
    usual = float(np.quantile(moves, 0.99))
    jumps = np.flatnonzero(moves > _JUMP * usual)
    if usual == 0.0 or not jumps.size:
        return []
    largest = int(jumps[np.argmax(moves[jumps])])
    return [
        diagnostic(
            "position jumps",
            column=column,
            size=float(moves[largest]),
            place=_place(piece, origin, largest),
            count=jumps.size,
        )
    ]


def _constant_force(
    column: str, force: FloatArray, position: FloatArray, step: float, piece: Piece, origin: Origin
) -> list[Diagnostic]:
    if float(np.ptp(force)) == 0.0:
        raise InvalidInput(
            column,
            f"{format_number(force[0], 6)} N throughout",
            "a force that varies is required",
            "Check that this is the right column and that the sensor is connected.",
        )
    starts, lengths = _runs_of_equal_samples(force)
    longest = int(np.argmax(lengths))
    duration = float(lengths[longest]) * step
    if duration < max(4.0 * _STUCK, 10.0 * step):
        return []
    start = int(starts[longest])
    value = float(force[start])
    _refuse_dead_force(column, value, position, piece, origin, start, start + int(lengths[longest]))
    is_extreme = value in (float(force.max()), float(force.min()))
    code = "saturated force" if is_extreme else "constant force"
    place = _place(piece, origin, start)
    return [diagnostic(code, column=column, force=value, duration=duration, place=place)]


def _refuse_dead_force(
    column: str, force: float, position: FloatArray, piece: Piece, origin: Origin, start: int, end: int
) -> None:
    """Refuse a force that is constant from one sample to before another while the robot moves as before."""
    duration = (end - start) * float(np.median(np.diff(piece.time)))
    if duration < _FROZEN or end - start < _FROZEN_SHARE * position.size:
        return
    moves = np.diff(position)
    inside = np.zeros(moves.size, dtype=bool)
    inside[start : end - 1] = True
    # A robot that is let go comes to rest; one that moves on is pushed.
    if not (~inside).any() or float(np.std(moves[inside])) > _PUSHED * float(np.std(moves[~inside])):
        raise InvalidInput(
            column,
            f"{format_number(force, 6)} N for {format_time(duration, 3)} from "
            f"{_place(piece, origin, start)} on, although the robot moves as before",
            "a force that varies with the movement is required",
            _remedy(piece, start, end),
        )
