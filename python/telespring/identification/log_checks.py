"""Checks of a log before it is used: refuse what cannot be right, warn about what may be wrong."""

from __future__ import annotations

import numpy as np

from telespring._errors import InvalidInput
from telespring._quantities import format_count, format_number, format_time
from telespring._types import FloatArray
from telespring.identification.gaps import Piece, bridge_gaps
from telespring.identification.origin import Origin
from telespring.identification.sensor_checks import check_sensors
from telespring.identification.warning_messages import Diagnostic

__all__ = ["check_log"]

_LOWEST_RATE, _HIGHEST_RATE = 20.0, 100_000.0
#: Upper limits of the travel, m, and of the force, N, of a robot held by a person.
_LONGEST_TRAVEL, _LARGEST_FORCE = 10.0, 5_000.0


def check_log(
    time: FloatArray, position: FloatArray, force: FloatArray, origin: Origin
) -> tuple[tuple[Piece, ...], list[Diagnostic]]:
    """Check a log, and cut it at its gaps: times (s), and positions (m) and forces (N) of shape (axes, n).

    `origin` names columns and samples. InvalidInput where shapes do not match, time stamps repeat, go back or
    are in another unit, or a sensor was stuck. Gaps between samples are no fault here (`gaps`).
    """
    _refuse_unequal_shapes(time, position, force)
    _refuse_wrong_time_stamps(time, origin)
    _refuse_wrong_units(position, force, origin)
    pieces, warnings = bridge_gaps(time, position, force, origin)
    known = {(warning.code, warning.values.get("column")) for warning in warnings}
    for piece in pieces:
        for warning in check_sensors(piece, origin):
            # Of several pieces the first one tells.
            if (warning.code, warning.values.get("column")) not in known:
                known.add((warning.code, warning.values.get("column")))
                warnings.append(warning)
    return pieces, warnings


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
                format_count(rows.shape[-1], "sample"),
                f"one sample per time is required, that is {time.size}",
                "Take all columns from the same log; time comes first.",
            )
    if position.shape != force.shape:
        raise InvalidInput(
            "force",
            format_count(force.shape[0], "axis", "axes"),
            f"as many axes as in the position are required, that is {position.shape[0]}",
            "Name one force for each position, in the same order.",
        )


def _refuse_wrong_time_stamps(time: FloatArray, origin: Origin) -> None:
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
        stamps = format_count(wrong.size, "wrong time stamp")
        fault = "is repeated" if steps[first] == 0.0 else "goes back"
        raise InvalidInput(
            "time",
            f"{stamps}; the first {fault} at {origin.place(int(samples[first + 1]))}",
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
            f"{format_time(usual, 3)} from sample to sample",
            f"the rate must be {_LOWEST_RATE:g} to {_HIGHEST_RATE:g} Hz, with time stamps in seconds",
            remedy,
        )


def _refuse_wrong_units(position: FloatArray, force: FloatArray, origin: Origin) -> None:
    travels = np.nanmax(position, axis=-1) - np.nanmin(position, axis=-1)
    travel = float(travels.max())
    if travel > _LONGEST_TRAVEL:
        raise InvalidInput(
            origin.column("position", int(travels.argmax())),
            f"a travel of {format_number(travel, 3)} m",
            f"a robot held by a person travels less than {_LONGEST_TRAVEL:g} m",
            "If the positions are in mm, give --position-scale 0.001; in cm, 0.01. If they are angles in "
            "degrees or rad, give the metres of travel per degree or rad.",
        )
    peaks = np.nanmax(np.abs(force), axis=-1)
    largest = float(peaks.max())
    if largest > _LARGEST_FORCE:
        raise InvalidInput(
            origin.column("force", int(peaks.argmax())),
            f"up to {format_number(largest, 3)} N",
            f"the force on a robot held by a person is less than {_LARGEST_FORCE:g} N",
            "If the forces are in mN or in counts, give --force-scale with the newtons per unit.",
        )
