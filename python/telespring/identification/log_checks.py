"""Logs of positions and forces: what makes one usable, and a clear refusal where it is not."""

from __future__ import annotations

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray

__all__ = ["even_times", "shifted"]

#: A step of more than this many usual ones is a gap.
_GAP = 1.75
#: Time stamps closer than this share of a step to even ones are taken as even.
_EVEN = 0.01
_SLOWEST_RATE, _FASTEST_RATE = 20.0, 100_000.0
#: No axis of a robot that a person holds travels further, m, or is pushed harder, N.
_FARTHEST, _STRONGEST = 10.0, 5_000.0
#: A position that stands still for this long, s, and then jumps was stuck.
_STUCK = 0.05
#: The same for one that stands still within its sensor's step or noise: at least so long, s, for this share
#: of the log, while the force varies by this share of what it does elsewhere.
_RESTS, _REST_SHARE, _PUSHED = 0.5, 0.05, 0.5
#: A step between two samples that is so many times the largest usual one is a jump.
_JUMP = 4.0


def even_times(
    time: FloatArray, position: FloatArray, force: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, float, list[str]]:
    """Check a log and bring it to evenly spaced times.

    Parameters
    ----------
    time
        s, shape (n,).
    position, force
        m and N, shape (axes, n).

    Returns
    -------
    time, position, force
        At even times; interpolated by cubic splines where the stamps jitter.
    rate
        Samples per second, Hz.
    notes
        What a user should know, as sentences.

    Raises
    ------
    telespring.InvalidInput
        Where shapes do not fit, numbers are missing, time stamps repeat, go back, have gaps or are in
        another unit, or a sensor was stuck.
    """
    _refuse_shapes(time, position, force)
    _refuse_missing(time, position, force)
    step = _refuse_times(time)
    _refuse_units(position, force)
    notes: list[str] = []
    for i, row in enumerate(position):
        _refuse_stuck(f"position (column {i + 1})", row, step)
        _refuse_resting(f"position (column {i + 1})", row, force[i], step)
        notes += _jumps(f"position (column {i + 1})", row, time)
        notes += _held(f"position (column {i + 1})", row, step)
    for i, row in enumerate(force):
        notes += _stuck_force(f"force (column {i + 1})", row, step)
    for i in range(1, len(position)):
        if np.array_equal(position[0], position[i]):
            notes.append("Two axes have the same positions: is one column named twice?")
    # The mean, not the median: stamps may be rounded, to ms for instance.
    step = float((time[-1] - time[0]) / (time.size - 1))
    even = time[0] + step * np.arange(time.size)
    off = float(np.abs(time - even).max()) / step
    if off > _EVEN:
        jitter = float(np.std(np.diff(time))) / step
        if jitter > 1e-3:
            from scipy.interpolate import CubicSpline

            position, force = (
                np.asarray(CubicSpline(time, rows, axis=-1)(even)) for rows in (position, force)
            )
            notes.append(
                f"Time stamps are uneven by {100.0 * jitter:.2g} % of a step; the log was interpolated."
            )
    return even, position, force, 1.0 / step, notes


def shifted(
    time: FloatArray, position: FloatArray, force: FloatArray, delay: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Put the force back to when it acted, where its samples are late by `delay` (s, may be negative)."""
    from scipy.interpolate import CubicSpline

    step = float(time[1] - time[0])
    if not abs(delay) < 0.1 * float(time[-1] - time[0]):
        raise InvalidInput(
            "force_delay",
            f"{delay:g} s",
            "a delay much shorter than the log is needed",
            "It is in seconds: 0.001 is one millisecond.",
        )
    lost = int(np.ceil(abs(delay) / step))
    keep = slice(0, time.size - lost) if delay > 0.0 else slice(lost, time.size)
    inner = time[keep]
    return inner, position[:, keep], np.asarray(CubicSpline(time, force, axis=-1)(inner + delay))


def _refuse_shapes(time: FloatArray, position: FloatArray, force: FloatArray) -> None:
    if time.ndim != 1 or time.size < 10:
        raise InvalidInput(
            "time",
            f"an array of shape {time.shape}",
            "one time per sample, 10 at least, is needed",
            "In seconds.",
        )
    for name, rows in (("position", position), ("force", force)):
        if rows.shape[-1] != time.size:
            raise InvalidInput(
                name,
                f"{rows.shape[-1]} samples",
                f"as many samples as times, {time.size}, are needed",
                "Take all columns from the same log; time comes first.",
            )
    if position.shape != force.shape:
        raise InvalidInput(
            "force",
            f"{force.shape[0]} axes",
            f"as many axes as the position has, {position.shape[0]}, are needed",
            "Name one force for each position, in the same order.",
        )


def _refuse_missing(time: FloatArray, position: FloatArray, force: FloatArray) -> None:
    for name, rows in (("time", time[None]), ("position", position), ("force", force)):
        missing = ~np.isfinite(rows)
        if missing.any():
            row, sample = (int(i) for i in np.argwhere(missing)[0])
            where = name if name == "time" else f"{name} (column {row + 1})"
            raise InvalidInput(
                where,
                f"{int(missing.sum())} values missing or infinite, the first in sample {sample + 1}",
                "every sample needs a finite number",
                "Choose a piece of the log without them (--start, --end); they cannot be filtered over.",
            )


def _refuse_times(time: FloatArray) -> float:
    """Return the usual step, s, of stamps that increase without gaps."""
    steps = np.diff(time)
    usual = float(np.median(steps))
    wrong = np.flatnonzero(steps <= 0.0)
    if wrong.size:
        at = int(wrong[0])
        kind = "is repeated" if steps[at] == 0.0 else "goes back"
        raise InvalidInput(
            "time",
            f"{wrong.size} wrong stamps; the first {kind} at {time[at + 1]:g} s, sample {at + 2}",
            "time stamps must increase",
            "Remove doubled samples, and give one log at a time.",
        )
    if not _SLOWEST_RATE <= 1.0 / usual <= _FASTEST_RATE:
        factor = "0.001" if 0.5 / _FASTEST_RATE < 1e-3 * usual < 1.0 / _SLOWEST_RATE else "1e-6"
        guess = (
            f"If the stamps are in {'ms' if factor == '0.001' else 'µs'}, give --time-scale {factor}."
            if usual > 1.0 / _SLOWEST_RATE
            else "If the stamps are in minutes or hours, give --time-scale 60 or 3600."
        )
        raise InvalidInput(
            "time",
            f"{usual:g} s from sample to sample",
            f"{_SLOWEST_RATE:g} to {_FASTEST_RATE:g} samples per second, stamped in seconds, are needed",
            guess,
        )
    gaps = np.flatnonzero(steps > _GAP * usual)
    if gaps.size:
        longest = int(gaps[np.argmax(steps[gaps])])
        pieces = np.concatenate([[0], gaps + 1, [time.size]])
        piece = int(np.argmax(np.diff(pieces)))
        start, end = float(time[pieces[piece]]), float(time[pieces[piece + 1] - 1])
        raise InvalidInput(
            "time",
            f"{gaps.size} gaps, the longest {1e3 * steps[longest]:.4g} ms after {time[longest]:.6g} s",
            f"a log without gaps is needed; its samples are {1e3 * usual:.4g} ms apart",
            f"Its longest piece without a gap is --start {start:.6g} --end {end:.6g}.",
        )
    return usual


def _refuse_units(position: FloatArray, force: FloatArray) -> None:
    travelled = float(np.ptp(position, axis=-1).max())
    if travelled > _FARTHEST:
        raise InvalidInput(
            "position",
            f"moves through {travelled:.4g} m",
            f"a robot that a person holds moves through less than {_FARTHEST:g} m",
            "If the positions are in mm, give --position-scale 0.001; in cm, 0.01; if they are angles, in "
            "degrees or rad, give the metres of travel per degree or rad.",
        )
    strongest = float(np.abs(force).max())
    if strongest > _STRONGEST:
        raise InvalidInput(
            "force",
            f"up to {strongest:.4g} N",
            f"a robot that a person holds is pushed with less than {_STRONGEST:g} N",
            "If the forces are in mN or in counts, give --force-scale with the newtons per unit.",
        )


def _still(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give start and length of every run of equal samples."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(values) != 0.0) + 1])
    return starts, np.diff(np.concatenate([starts, [values.size]]))


def _refuse_stuck(name: str, position: FloatArray, step: float) -> None:
    """Refuse a position that stood still while the robot went on: it then jumps, or never moves again."""
    if float(np.ptp(position)) == 0.0:
        raise InvalidInput(
            name,
            f"{position[0]:g} m throughout",
            "a position that moves is needed",
            "Look whether this is the right column and the sensor is connected.",
        )
    starts, lengths = _still(position)
    moves = np.abs(np.diff(position))
    # Between two samples the robot moves no further than this; a jump beyond it was made unseen.
    usual = float(np.quantile(moves[moves > 0.0], 0.99))
    least = max(3, int(_STUCK / step))
    for run in np.flatnonzero((lengths >= least) & (starts > 0)):
        start, length = int(starts[run]), int(lengths[run])
        end = start + length
        before = abs(float(position[start] - position[max(0, start - least)])) / least
        jumps = end < position.size and moves[end - 1] > max(5.0 * usual, 0.2 * length * before)
        ends = end == position.size and before > 0.2 * usual
        if jumps or ends:
            raise InvalidInput(
                name,
                f"stands still for {1e3 * length * step:.4g} ms from sample {start + 1}"
                + (" and then jumps" if jumps else " in the midst of a movement, to the end"),
                "a position that follows the robot all the time is needed",
                "The sensor was stuck. Choose a piece of the log without this (--start, --end).",
            )


def _refuse_resting(name: str, position: FloatArray, force: FloatArray, step: float) -> None:
    """Refuse a position that stands still, but for its noise, while a force pushes the robot about."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    window = max(3, round(_RESTS / step))
    if 4 * window > position.size:
        return
    # What the noise does between samples is seen where nothing moves; and an encoder may flicker by a step.
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
    # Without a force, rest is rest; friction holds a robot only against a force that is small.
    inside = np.zeros(position.size, dtype=bool)
    inside[first : last + 1] = True
    pushed = (
        float(np.std(force[inside])) > _PUSHED * float(np.std(force[~inside])) if (~inside).any() else True
    )
    if duration >= _REST_SHARE * position.size * step and pushed:
        raise InvalidInput(
            name,
            f"stands still within {1e3 * still:.2g} mm for {duration:.3g} s from sample {first + 1}, while "
            "the force goes on as before",
            "a position that follows the robot all the time is needed",
            "The sensor was stuck. Choose a piece of the log without this (--start, --end).",
        )


def _held(name: str, position: FloatArray, step: float) -> list[str]:
    """Tell of positions that were read less often than they were logged: each stands there several times."""
    _, lengths = _still(position)
    usual = int(np.median(lengths))
    if usual < 2 or np.mean(lengths == usual) < 0.8:
        return []
    period, age = 1e3 * usual * step, 500.0 * (usual - 1) * step
    text = (
        f"The {name} has every value {usual} times: it was read every {period:.3g} ms and is {age:.2g} ms "
        f"old on average, which shifts the mass. Keep the first of each {usual} samples only."
    )
    return [text]


def _jumps(name: str, position: FloatArray, time: FloatArray) -> list[str]:
    moves = np.abs(np.diff(position))
    usual = float(np.quantile(moves, 0.99))
    wild = np.flatnonzero(moves > _JUMP * usual)
    if usual == 0.0 or not wild.size:
        return []
    largest = int(wild[np.argmax(moves[wild])])
    more = f" and {wild.size - 1} more times" if wild.size > 1 else ""
    size, when = 1e3 * moves[largest], time[largest]
    return [
        f"The {name} jumps by {size:.3g} mm between two samples, at {when:.4g} s{more}: did the sensor slip?"
    ]


def _stuck_force(name: str, force: FloatArray, step: float) -> list[str]:
    if float(np.ptp(force)) == 0.0:
        raise InvalidInput(
            name,
            f"{force[0]:g} N throughout",
            "a force that varies is needed",
            "Look whether this is the right column and the sensor is connected.",
        )
    starts, lengths = _still(force)
    longest = int(np.argmax(lengths))
    duration = float(lengths[longest]) * step
    if duration < max(4.0 * _STUCK, 10.0 * step):
        return []
    value = float(force[int(starts[longest])])
    if value in (float(force.max()), float(force.min())):
        return [
            f"The {name} stays at its limit of {value:.4g} N for {1e3 * duration:.4g} ms: was it saturated?"
        ]
    return [f"The {name} stays at {value:.4g} N for {1e3 * duration:.4g} ms: was the sensor stuck?"]
