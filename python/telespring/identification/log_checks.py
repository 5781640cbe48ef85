"""Checks of a log before it is used: refuse what cannot be right, warn about what may be wrong."""

from __future__ import annotations

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification.gaps import bridge_gaps
from telespring.identification.warning_messages import Diagnostic, diagnostic

__all__ = ["check_log"]

_LOWEST_RATE, _HIGHEST_RATE = 20.0, 100_000.0
#: Upper limits of the travel, m, and of the force, N, of a robot held by a person.
_LONGEST_TRAVEL, _LARGEST_FORCE = 10.0, 5_000.0
#: A position that does not change for this long, s, and then jumps was stuck.
_STUCK = 0.05
#: The same for a position that stays within its sensor's step or noise: for at least so long, s, and for this
#: share of the log, while the force varies by this share of its variation elsewhere.
_FROZEN, _FROZEN_SHARE, _PUSHED = 0.5, 0.05, 0.5
#: A step between two samples that is so many times the largest usual one is a jump.
_JUMP = 4.0


def check_log(time: FloatArray, position: FloatArray, force: FloatArray) -> list[Diagnostic]:
    """Check a log: times (s), and positions (m) and forces (N) of shape (axes, n).

    InvalidInput where shapes do not match, time stamps repeat, go back or are in another unit, or a sensor
    was stuck. Gaps between samples are no fault here (`gaps`).
    """
    _refuse_unequal_shapes(time, position, force)
    _refuse_wrong_time_stamps(time)
    _refuse_wrong_units(position, force)
    pieces, warnings = bridge_gaps(time, position, force)
    known = {(warning.code, warning.values.get("column")) for warning in warnings}
    for piece in pieces:
        for warning in _check_sensors(piece.time, piece.position, piece.force):
            # Of several pieces the first one tells.
            if (warning.code, warning.values.get("column")) not in known:
                known.add((warning.code, warning.values.get("column")))
                warnings.append(warning)
    return warnings


def _check_sensors(time: FloatArray, position: FloatArray, force: FloatArray) -> list[Diagnostic]:
    """Check the sensors over a piece of a log without gaps."""
    step = float(np.median(np.diff(time)))
    warnings: list[Diagnostic] = []
    for i, row in enumerate(position):
        column = f"position (column {i + 1})"
        _refuse_stuck_position(column, row, step)
        _refuse_frozen_position(column, row, force[i], step)
        warnings += _position_jumps(column, row, time)
        warnings += _held_position(column, row, step)
    for i, row in enumerate(force):
        warnings += _constant_force(f"force (column {i + 1})", row, step)
    if any(np.array_equal(position[0], row) for row in position[1:]):
        warnings.append(diagnostic("identical positions"))
    return warnings


def _refuse_unequal_shapes(time: FloatArray, position: FloatArray, force: FloatArray) -> None:
    if time.ndim != 1 or time.size < 10:
        raise InvalidInput(
            "time",
            f"an array of shape {time.shape}",
            "a one-dimensional array of at least 10 times is required, one per sample",
            "Record a longer log, or give one time in s per sample.",
        )
    for name, rows in (("position", position), ("force", force)):
        if rows.shape[-1] != time.size:
            raise InvalidInput(
                name,
                f"{rows.shape[-1]} samples",
                f"one sample per time is required, that is {time.size}",
                "Take all columns from the same log; time comes first.",
            )
    if position.shape != force.shape:
        raise InvalidInput(
            "force",
            f"{force.shape[0]} axes",
            f"as many axes as in the position are required, that is {position.shape[0]}",
            "Name one force for each position, in the same order.",
        )


def _refuse_wrong_time_stamps(time: FloatArray) -> None:
    """Refuse time stamps that do not increase, or are probably not in seconds."""
    samples = np.flatnonzero(np.isfinite(time))
    if samples.size < 2:
        raise InvalidInput(
            "time",
            "no time stamps",
            "a time in s per sample is required",
            "Name the time column, or give the sample rate with --rate.",
        )
    steps = np.diff(time[samples])
    usual = float(np.median(steps))
    wrong = np.flatnonzero(steps <= 0.0)
    if wrong.size:
        first = int(wrong[0])
        fault = "is repeated" if steps[first] == 0.0 else "goes back"
        raise InvalidInput(
            "time",
            f"{wrong.size} wrong time stamps; the first {fault} at {time[samples[first + 1]]:.9g} s, sample "
            f"{samples[first + 1] + 1}",
            "time stamps must increase",
            "Remove duplicate samples, and use one log at a time. If the stamps are rounded, give the sample "
            "rate instead (--rate).",
        )
    if not _LOWEST_RATE <= 1.0 / usual <= _HIGHEST_RATE:
        factor = "0.001" if 0.5 / _HIGHEST_RATE < 1e-3 * usual < 1.0 / _LOWEST_RATE else "1e-6"
        remedy = (
            f"If the time stamps are in {'ms' if factor == '0.001' else 'µs'}, give --time-scale {factor}."
            if usual > 1.0 / _LOWEST_RATE
            else "If the time stamps are in minutes, hours or days, give --time-scale 60, 3600 or 86400."
        )
        raise InvalidInput(
            "time",
            f"{usual:g} s from sample to sample",
            f"the rate must be {_LOWEST_RATE:g} to {_HIGHEST_RATE:g} Hz, with time stamps in seconds",
            remedy,
        )


def _refuse_wrong_units(position: FloatArray, force: FloatArray) -> None:
    travel = float((np.nanmax(position, axis=-1) - np.nanmin(position, axis=-1)).max())
    if travel > _LONGEST_TRAVEL:
        raise InvalidInput(
            "position",
            f"a travel of {travel:.4g} m",
            f"a robot held by a person travels less than {_LONGEST_TRAVEL:g} m",
            "If the positions are in mm, give --position-scale 0.001; in cm, 0.01. If they are angles in "
            "degrees or rad, give the metres of travel per degree or rad.",
        )
    largest = float(np.nanmax(np.abs(force)))
    if largest > _LARGEST_FORCE:
        raise InvalidInput(
            "force",
            f"up to {largest:.4g} N",
            f"the force on a robot held by a person is less than {_LARGEST_FORCE:g} N",
            "If the forces are in mN or in counts, give --force-scale with the newtons per unit.",
        )


def _runs_of_equal_samples(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return start and length of every run of equal samples."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(values) != 0.0) + 1])
    return starts, np.diff(np.concatenate([starts, [values.size]]))


def _refuse_stuck_position(column: str, position: FloatArray, step: float) -> None:
    """Refuse a position that stopped while the robot moved on: it jumps later, or never moves again."""
    if float(np.ptp(position)) == 0.0:
        raise InvalidInput(
            column,
            f"{position[0]:g} m throughout",
            "a position that changes is required",
            "Check that this is the right column and that the sensor is connected.",
        )
    starts, lengths = _runs_of_equal_samples(position)
    moves = np.abs(np.diff(position))
    # The robot moves at most this far between two samples; beyond it, it moved while the sensor was stuck.
    usual = float(np.quantile(moves[moves > 0.0], 0.99))
    shortest = max(3, int(_STUCK / step))
    for run in np.flatnonzero((lengths >= shortest) & (starts > 0)):
        start, length = int(starts[run]), int(lengths[run])
        end = start + length
        speed_before = abs(float(position[start] - position[max(0, start - shortest)])) / shortest
        jumps = end < position.size and moves[end - 1] > max(5.0 * usual, 0.2 * length * speed_before)
        lasts = end == position.size and speed_before > 0.2 * usual
        if jumps or lasts:
            raise InvalidInput(
                column,
                f"constant for {1e3 * length * step:.4g} ms from sample {start + 1}"
                + (", then a jump" if jumps else " to the end, although the robot was moving"),
                "a position that follows the robot all the time is required",
                "The sensor was stuck. Choose a part of the log without this (--start, --end).",
            )


def _refuse_frozen_position(column: str, position: FloatArray, force: FloatArray, step: float) -> None:
    """Refuse a position that stays within its noise while a varying force pushes the robot."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

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
            f"constant within {1e3 * still:.2g} mm for {duration:.3g} s from sample {first + 1}, although "
            "the force continues as before",
            "a position that follows the robot all the time is required",
            "The sensor was stuck. Choose a part of the log without this (--start, --end).",
        )


def _held_position(column: str, position: FloatArray, step: float) -> list[Diagnostic]:
    """Detect a position that was updated less often than it was logged, so that each value repeats."""
    _, lengths = _runs_of_equal_samples(position)
    usual = int(np.median(lengths))
    if usual < 2 or np.mean(lengths == usual) < 0.8:
        return []
    period, age = usual * step, 0.5 * (usual - 1) * step
    return [diagnostic("held position", column=column, repeats=usual, period=period, age=age)]


def _position_jumps(column: str, position: FloatArray, time: FloatArray) -> list[Diagnostic]:
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
            time=float(time[largest]),
            count=jumps.size,
        )
    ]


def _constant_force(column: str, force: FloatArray, step: float) -> list[Diagnostic]:
    if float(np.ptp(force)) == 0.0:
        raise InvalidInput(
            column,
            f"{force[0]:g} N throughout",
            "a force that varies is required",
            "Check that this is the right column and that the sensor is connected.",
        )
    starts, lengths = _runs_of_equal_samples(force)
    longest = int(np.argmax(lengths))
    duration = float(lengths[longest]) * step
    if duration < max(4.0 * _STUCK, 10.0 * step):
        return []
    value = float(force[int(starts[longest])])
    is_extreme = value in (float(force.max()), float(force.min()))
    code = "saturated force" if is_extreme else "constant force"
    return [diagnostic(code, column=column, force=value, duration=duration)]
