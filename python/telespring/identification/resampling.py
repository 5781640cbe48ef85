"""Logs on evenly spaced times: interpolate jittering time stamps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from telespring._types import FloatArray
from telespring.identification.gaps import Piece
from telespring.identification.stretches import Stretch
from telespring.identification.warning_messages import Diagnostic, diagnostic

__all__ = ["even_stretches"]

#: Time stamps closer than this share of a step to even ones are taken as even.
_EVEN = 0.01
#: A smaller deviation of the steps, in steps, is rounding.
_LEAST_JITTER = 1e-3


def even_stretches(pieces: Sequence[Piece]) -> tuple[tuple[Stretch, ...], list[Diagnostic]]:
    """Turn the pieces of a log into stretches of evenly spaced samples, all of one rate.

    Where time stamps jitter, they are interpolated by cubic splines.
    """
    # The mean, not the median: stamps may be rounded, to ms for instance.
    duration = sum(float(piece.time[-1] - piece.time[0]) for piece in pieces)
    step = duration / sum(piece.time.size - 1 for piece in pieces)
    jitters = [_jitter(piece.time) for piece in pieces]
    stretches = tuple(
        _even_stretch(piece, step, is_jittering=jitter > 0.0)
        for piece, jitter in zip(pieces, jitters, strict=True)
    )
    jitter = max(jitters)
    return stretches, [diagnostic("uneven time stamps", jitter=jitter)] if jitter > 0.0 else []


def _jitter(time: FloatArray) -> float:
    """Return the jitter of time stamps in steps; 0 if they are as good as even."""
    step = float((time[-1] - time[0]) / (time.size - 1))
    deviation = float(np.abs(time - time[0] - step * np.arange(time.size)).max()) / step
    jitter = float(np.std(np.diff(time))) / step
    return jitter if deviation > _EVEN and jitter > _LEAST_JITTER else 0.0


def _even_stretch(piece: Piece, step: float, *, is_jittering: bool) -> Stretch:
    """Give a piece of a log evenly spaced times, `step` (s) apart."""
    time = piece.time
    drift = abs(float(time[-1] - time[0]) - step * (time.size - 1)) / step
    if not is_jittering and drift <= _EVEN:
        even = time[0] + step * np.arange(time.size)
        return Stretch(even, piece.position, piece.force, piece.usable, 1.0 / step)
    from scipy.interpolate import CubicSpline

    even = time[0] + step * np.arange(int((time[-1] - time[0]) / step + _EVEN) + 1)
    position, force = (
        np.asarray(CubicSpline(time, rows, axis=-1)(even)) for rows in (piece.position, piece.force)
    )
    usable = np.interp(even, time, piece.usable.astype(float)) > 1.0 - _EVEN
    return Stretch(even, position, force, usable, 1.0 / step)
