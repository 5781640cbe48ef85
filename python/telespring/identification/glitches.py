"""Glitches of a sensor, found in the raw samples before any filter smears them.

A glitch is a sample or a short run at which the signal leaves its course and then comes back to it: a dropout
to zero, a spike, a value that is held. It is replaced by what the samples around it say, and marked as
unusable, so that the regression leaves out what depends on it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.identification.origin import Origin
from telespring.identification.stretches import Stretch
from telespring.identification.warning_messages import Diagnostic, diagnostic

__all__ = ["find_glitches", "without_glitches"]

#: A step of so many robust standard deviations is a jump: noise makes one in 10¹⁵ samples.
_JUMP = 8.0
#: The longest glitch, s and samples; what lasts longer is another fault (`log_checks`).
_LONGEST, _LONGEST_SAMPLES = 0.1, 100
#: Steps around each sample that tell its usual step.
_WINDOW = 9
#: After a glitch the signal is back to within this share of the jump.
_RETURN = 0.5
#: A value that so many glitches share is what the sensor says when it fails.
_FAILURE_VALUES = 3
#: A force that changes with every sample but for this share is held if so many samples are equal.
_USUAL_REPEATS, _HELD = 0.05, 4


def without_glitches(
    stretches: tuple[Stretch, ...], origin: Origin
) -> tuple[tuple[Stretch, ...], list[Diagnostic]]:
    """Replace the glitches of all stretches and mark them as unusable.

    Returns the stretches and one warning per column that has glitches.
    """
    counts: dict[str, int] = {}
    cleaned = []
    for stretch in stretches:
        usable = stretch.usable.copy()
        rows: dict[str, Any] = {}
        for kind in ("position", "force"):
            signal = getattr(stretch, kind).copy()
            for i, row in enumerate(signal):
                found = find_glitches(row, stretch.rate, is_force=kind == "force") & stretch.usable
                if found.any():
                    column = origin.column(kind, i)
                    counts[column] = counts.get(column, 0) + int(found.sum())
                    usable &= ~found
                    signal[i] = _bridge(row, found)
            rows[kind] = signal
        cleaned.append(replace(stretch, usable=usable, **rows))
    samples = sum(stretch.time.size for stretch in stretches)
    warnings = [
        diagnostic("glitches", column=column, count=count, share=count / samples)
        for column, count in counts.items()
    ]
    return tuple(cleaned), warnings


def find_glitches(values: FloatArray, rate: float, *, is_force: bool = False) -> NDArray[np.bool_]:
    """Tell which samples of a signal are glitches; the rate is in Hz.

    Examples
    --------
    >>> time = np.arange(1000) / 200.0
    >>> force = 3.0 * np.sin(2.0 * time) + np.random.default_rng(1).normal(0.0, 0.1, time.size)
    >>> force[[100, 400, 401, 700]] = 0.0
    >>> np.flatnonzero(find_glitches(force, 200.0))
    array([100, 400, 401, 700])
    """
    from scipy.ndimage import median_filter

    starts = np.concatenate([[0], np.flatnonzero(np.diff(values) != 0.0) + 1])
    lengths = np.diff(np.concatenate([starts, [values.size]]))
    usual_length = int(np.median(lengths))
    if usual_length > 1:
        # A coarse sensor, or one that is read less often than it is logged: its readings are the samples.
        return np.repeat(find_glitches(values[starts], rate / usual_length, is_force=is_force), lengths)
    steps = np.diff(values)
    moving = np.abs(steps[steps != 0.0])
    if values.size < 4 * _WINDOW or not moving.size:
        return np.zeros(values.size, dtype=bool)
    usual = median_filter(steps, _WINDOW, mode="nearest")
    excess = steps - usual
    resolution = float(moving.min()) if is_force else float(np.quantile(moving, 0.01))
    scale = max(1.4826 * float(np.median(np.abs(excess))), resolution)
    found = _excursions(values, excess, usual, _JUMP * scale, rate)
    shared, times = np.unique(values[found], return_counts=True)
    for value in np.asarray(shared, dtype=float)[np.asarray(times) >= _FAILURE_VALUES]:
        same = np.equal(values, value)
        # A coarse sensor takes the value anyway, as often as its neighbours.
        if np.count_nonzero(same) < 4 * np.count_nonzero(found & same):
            found |= same
    return found | _held(values, excess, _JUMP * scale, rate, is_force=is_force)


def _excursions(
    values: FloatArray, excess: FloatArray, usual: FloatArray, jump: float, rate: float
) -> NDArray[np.bool_]:
    """Tell which samples lie between a jump away and the jump back."""
    found = np.zeros(values.size, dtype=bool)
    longest = max(1, min(int(_LONGEST * rate), _LONGEST_SAMPLES))
    jumps: list[int] = np.flatnonzero(np.abs(excess) > jump).tolist()
    done = -1
    for number, start in enumerate(jumps):
        if start <= done:
            continue
        for end in jumps[number + 1 : number + 1 + longest]:
            if end - start > longest:
                break
            # Where the signal would have been, from the usual step before and after.
            drift = 0.5 * (usual[max(0, start - 1)] + usual[min(usual.size - 1, end + 1)]) * (end + 1 - start)
            back = values[end + 1] - values[start] - drift
            left = values[start + 1 : end + 1] - values[start] - drift * _between(end - start)
            if (
                excess[start] * excess[end] < 0.0
                and abs(back) < _RETURN * abs(excess[start])
                and (np.sign(excess[start]) * left > _RETURN * abs(excess[start])).all()
            ):
                found[start + 1 : end + 1] = True
                done = end
                break
    return found


def _between(count: int) -> FloatArray:
    """Return where `count` samples lie between the two around them, as shares of the way."""
    return np.arange(1, count + 1) / (count + 1)


def _held(
    values: FloatArray, excess: FloatArray, jump: float, rate: float, *, is_force: bool
) -> NDArray[np.bool_]:
    """Tell which samples repeat an old value: the sensor gave none."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(values) != 0.0) + 1])
    lengths = np.diff(np.concatenate([starts, [values.size]]))
    found = np.zeros(values.size, dtype=bool)
    if is_force and np.mean(lengths > 1) < _USUAL_REPEATS:
        long = np.flatnonzero(lengths >= _HELD)
    else:
        ends = starts + lengths
        inner = (lengths >= 3) & (starts > 0) & (ends < values.size)
        # A held position jumps to where the robot went meanwhile.
        catching_up = np.zeros_like(inner)
        catching_up[inner] = np.abs(excess[ends[inner] - 1]) > jump
        long = np.flatnonzero(inner & catching_up & (lengths <= _LONGEST * rate))
    for run in long:
        found[starts[run] + 1 : starts[run] + lengths[run]] = True
    return found


def _bridge(values: FloatArray, found: NDArray[np.bool_]) -> FloatArray:
    """Replace the samples that were found by a cubic through those around them."""
    bridged = values.copy()
    good = np.flatnonzero(~found)
    starts = np.flatnonzero(np.diff(np.concatenate([[False], found]).astype(int)) == 1)
    ends = np.flatnonzero(np.diff(np.concatenate([found, [False]]).astype(int)) == -1) + 1
    for start, end in zip(starts, ends, strict=True):
        reach = max(5, int(end - start))
        place = int(np.searchsorted(good, start))
        near = good[max(0, place - reach) : place + reach]
        middle = 0.5 * (start + end)
        inside = np.arange(start, end)
        order = 3 if 0 < place < good.size and near.size > 6 else 0
        fitted = np.polynomial.Polynomial.fit(near - middle, values[near], order)
        bridged[start:end] = fitted(inside - middle)
    return bridged
