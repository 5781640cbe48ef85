"""A log on evenly spaced times: interpolate jittering time stamps, and shift a late force."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification.warning_messages import Diagnostic, diagnostic

__all__ = ["UniformLog", "resample_uniformly", "shift_force"]

#: Time stamps closer than this share of a step to even ones are taken as even.
_EVEN = 0.01


@dataclass(frozen=True)
class UniformLog:
    """Times (s), and positions (m) and forces (N) of shape (axes, n), sampled at an even rate (Hz)."""

    time: FloatArray
    position: FloatArray
    force: FloatArray
    rate: float


def resample_uniformly(
    time: FloatArray, position: FloatArray, force: FloatArray
) -> tuple[UniformLog, list[Diagnostic]]:
    """Interpolate a checked log to evenly spaced times, by cubic splines where its time stamps jitter."""
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
    return UniformLog(even, position, force, 1.0 / step), warnings


def shift_force(log: UniformLog, delay: float) -> UniformLog:
    """Shift the force back to the time when it acted; its samples are `delay` (s, may be negative) late."""
    from scipy.interpolate import CubicSpline

    time, position, force = log.time, log.position, log.force
    step = float(time[1] - time[0])
    if not abs(delay) < 0.1 * float(time[-1] - time[0]):
        raise InvalidInput(
            "force_delay",
            f"{delay:g} s",
            "the delay must be much shorter than the log",
            "Give it in seconds: 0.001 is one millisecond.",
        )
    lost = int(np.ceil(abs(delay) / step))
    keep = slice(0, time.size - lost) if delay > 0.0 else slice(lost, time.size)
    inner = time[keep]
    shifted = np.asarray(CubicSpline(time, force, axis=-1)(inner + delay))
    return UniformLog(inner, position[:, keep], shifted, log.rate)
