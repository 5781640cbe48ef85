"""One time base for two sites whose clocks differ: from what each knew of the other's clock.

Each site bounds the other's clock: it reads its own plus `offset`, with an error of at most `error` (the two
ways may differ by the whole round trip). Both bounds together, of all instants, leave an interval for the
true difference. No quartz clock drifts faster than `MAX_DRIFT`, so that a tight bound of one instant helps at
others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray

__all__ = ["MAX_DRIFT", "ClockEstimates", "CommonTime", "common_time"]

#: The largest drift of two quartz clocks, s/s, for which the live program allows, too.
MAX_DRIFT = 2e-4
#: Instants at which the bounds are taken.
_INSTANT = 1.0
_FEWEST, _MOST = 8, 20_000


@dataclass(frozen=True)
class ClockEstimates:
    """What one site knew of the other's clock.

    Attributes
    ----------
    time
        ns on its own clock, increasing.
    offset
        ns: the other's clock minus its own.
    error
        ns: the true offset differs by no more than this.
    """

    time: NDArray[np.int64]
    offset: NDArray[np.int64]
    error: NDArray[np.int64]


@dataclass(frozen=True)
class CommonTime:
    """How the second clock of a pair is converted to the first.

    Attributes
    ----------
    knots
        ns on the second clock.
    base, offsets
        ns at the knots: the second clock minus the first is their sum; in between linear, outside constant
        but for the drift.
    errors
        ns at the knots: a bound on the error of these offsets.
    drift
        s/s: by how much faster the second clock runs; NaN where the session is too short to tell.
    is_linear
        Whether one offset and one drift lie within all bounds.
    disagreement
        ns: by how much the bounds of the two sites miss each other at the worst instant; 0 where they agree.
    """

    knots: NDArray[np.int64]
    base: int
    offsets: FloatArray
    errors: FloatArray
    drift: float
    is_linear: bool
    disagreement: float

    @property
    def uncertainty(self) -> float:
        """The largest error of the common time between first and last knot, s."""
        return float(self.errors.max()) * 1e-9

    def to_first(self, time: NDArray[np.int64]) -> NDArray[np.int64]:
        """Convert times of the second clock (ns) to the first; order is kept."""
        rest = np.interp(
            (time - self.knots[0]).astype(np.float64),
            (self.knots - self.knots[0]).astype(np.float64),
            self.offsets,
        )
        if np.isfinite(self.drift):
            outside = np.clip(time, self.knots[0], self.knots[-1])
            rest += self.drift * (time - outside)
        converted: NDArray[np.int64] = time - self.base - np.rint(rest).astype(np.int64)
        return converted


def common_time(first: ClockEstimates, second: ClockEstimates) -> CommonTime | None:
    """Find the second clock minus the first over time from both sites' estimates; None without any."""
    if not first.time.size and not second.time.size:
        return None
    # Whole numbers of ns of clocks that run for months have more digits than a float.
    base = int(first.offset[0] if first.time.size else -second.offset[0])
    bounds = [
        _bounds(first.time, first.offset - base, first.error),
        # Seen from the second clock the difference has the other sign, and another time.
        _bounds(second.time + second.offset, -second.offset - base, second.error),
    ]
    bounds = [each for each in bounds if each[0].size]
    # On the first clock, where both sites know the other's clock if there is such a time.
    begin = max(int(time[0]) for time, _, _ in bounds)
    end = min(int(time[-1]) for time, _, _ in bounds)
    if end < begin:
        begin, end = (min(int(t[0]) for t, _, _ in bounds), max(int(t[-1]) for t, _, _ in bounds))
    count = int(np.clip((end - begin) * 1e-9 / _INSTANT, _FEWEST, _MOST)) + 1
    instants = begin + np.rint(np.linspace(0.0, float(end - begin), count)).astype(np.int64)
    tightened = [_at_instants(instants, *each) for each in bounds]
    lower: FloatArray = np.max([low for low, _ in tightened], axis=0)
    upper: FloatArray = np.min([high for _, high in tightened], axis=0)
    missed = np.maximum(lower - upper, 0.0)
    # Where the sites contradict each other, nothing between their bounds is excluded.
    lower, upper = np.minimum(lower, upper), np.maximum(lower, upper)
    seconds: FloatArray = np.asarray((instants - begin) * 1e-9, dtype=np.float64)
    offsets, errors, drift, is_linear = _line_or_knots(seconds, lower, upper)
    knots = instants + base + np.rint(offsets).astype(np.int64)
    distinct = np.concatenate([[True], np.diff(knots) > 0])
    return CommonTime(
        knots=knots[distinct],
        base=base,
        offsets=offsets[distinct],
        errors=errors[distinct],
        drift=drift,
        is_linear=is_linear,
        disagreement=float(missed.max()),
    )


def _bounds(
    time: NDArray[np.int64], offset: NDArray[np.int64], error: NDArray[np.int64]
) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
    order = np.argsort(time, kind="stable")
    return time[order], (offset - error)[order].astype(np.float64), (offset + error)[order].astype(np.float64)


def _at_instants(
    instants: NDArray[np.int64], time: NDArray[np.int64], lower: FloatArray, upper: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the bounds at the instants, each tightened by the bounds of all times, loosened by the drift."""
    loosening = MAX_DRIFT * (time - time[0]).astype(np.float64)
    at = MAX_DRIFT * (instants - time[0]).astype(np.float64)
    # The best bound of all earlier times, each loosened since then, and of all later ones.
    earlier = np.searchsorted(time, instants, side="right")
    later = np.searchsorted(time, instants, side="left")
    unknown = np.array([np.inf])
    low = np.maximum(
        np.concatenate([-unknown, np.maximum.accumulate(lower + loosening)])[earlier] - at,
        np.concatenate([np.maximum.accumulate((lower - loosening)[::-1])[::-1], -unknown])[later] + at,
    )
    high = np.minimum(
        np.concatenate([unknown, np.minimum.accumulate(upper - loosening)])[earlier] + at,
        np.concatenate([np.minimum.accumulate((upper + loosening)[::-1])[::-1], unknown])[later] - at,
    )
    return low, high


def _line_or_knots(
    seconds: FloatArray, lower: FloatArray, upper: FloatArray
) -> tuple[FloatArray, FloatArray, float, bool]:
    """Return offsets with their errors, the drift, and whether it is one line within all bounds."""
    middle, half = (lower + upper) / 2.0, (upper - lower) / 2.0
    weight = 1.0 / np.maximum(half, 1.0)
    most = MAX_DRIFT * 1e9
    is_long = 2.0 * float(half.max()) < most * seconds[-1]
    slope = float(np.clip(np.polyfit(seconds, middle, 1, w=weight)[0], -most, most)) if is_long else 0.0
    line = float(np.average(middle - slope * seconds, weights=weight**2)) + slope * seconds
    drift = slope * 1e-9 if is_long else float("nan")
    if np.all((line >= lower - 1.0) & (line <= upper + 1.0)):
        return line, np.maximum(upper - line, line - lower), drift, True
    return middle, half, drift, False
