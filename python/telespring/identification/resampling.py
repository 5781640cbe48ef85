"""Logs on evenly spaced times: interpolate jittering time stamps, and shift a late force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification.stretches import Stretch
from telespring.identification.warning_messages import Diagnostic, diagnostic

__all__ = ["even_stretches", "shift_force"]

#: Time stamps closer than this share of a step to even ones are taken as even.
_EVEN = 0.01


def even_stretches(
    time: FloatArray, position: FloatArray, force: FloatArray
) -> tuple[tuple[Stretch, ...], list[Diagnostic]]:
    """Turn a checked log into stretches of evenly spaced samples.

    Times are in s, shape (n,); positions (m) and forces (N) have shape (axes, n). Where time stamps jitter,
    they are interpolated by cubic splines.
    """
    # The mean, not the median: stamps may be rounded, to ms for instance.
    step = float((time[-1] - time[0]) / (time.size - 1))
    even = time[0] + step * np.arange(time.size)
    deviation = float(np.abs(time - even).max()) / step
    warnings: list[Diagnostic] = []
    if deviation > _EVEN:
        jitter = float(np.std(np.diff(time))) / step
        if jitter > 1e-3:
            from scipy.interpolate import CubicSpline

            position, force = (
                np.asarray(CubicSpline(time, rows, axis=-1)(even)) for rows in (position, force)
            )
            warnings.append(diagnostic("uneven time stamps", jitter=jitter))
    usable = np.ones(time.size, dtype=bool)
    return (Stretch(even, position, force, usable, 1.0 / step),), warnings


def shift_force(stretch: Stretch, delay: float) -> Stretch:
    """Shift the force back to the time when it acted; its samples are `delay` (s, may be negative) late."""
    from scipy.interpolate import CubicSpline

    time, step = stretch.time, 1.0 / stretch.rate
    if not abs(delay) < 0.1 * stretch.duration:
        raise InvalidInput(
            "force_delay",
            f"{delay:g} s",
            "the delay must be much shorter than the log",
            "Give it in seconds: 0.001 is one millisecond.",
        )
    lost = int(np.ceil(abs(delay) / step))
    keep = slice(0, time.size - lost) if delay > 0.0 else slice(lost, time.size)
    inner = time[keep]
    shifted = np.asarray(CubicSpline(time, stretch.force, axis=-1)(inner + delay))
    whole = np.asarray(stretch.usable, dtype=float)
    usable = np.interp(inner + delay, time, whole) * whole[keep] > 0.99
    return replace(stretch, time=inner, position=stretch.position[:, keep], force=shifted, usable=usable)
