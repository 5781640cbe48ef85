"""The clocks of an XDF file: what its recorder measured of each stream's clock, and both on one time base."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from telespring._types import FloatArray
from telespring.recording.common_time import MAX_DRIFT, CommonTime

__all__ = ["StreamClock", "XdfStream", "common_clock", "stream_clock"]

#: Offsets further from the median than so many median deviations are of a recorder that was held up.
_OUTLIER = 10.0


@dataclass(frozen=True, eq=False)
class StreamClock:
    """How the recorder's clock differs from a stream's.

    Attributes
    ----------
    time
        s of the stream's clock, at which the recorder compared them.
    offset
        s: what must be added to a time of the stream to have the recorder's.
    line
        Offset (s) at the first of these times, and its growth (s/s).
    scatter
        s: the largest distance of the offsets, without outliers, from that line. The file has no bound of
        their error.
    """

    time: FloatArray
    offset: FloatArray
    line: tuple[float, float]
    scatter: float

    def at(self, time: FloatArray) -> FloatArray:
        """Return the offset of the line at times of the stream, s."""
        if not self.time.size:
            return np.zeros_like(time)
        return np.asarray(self.line[0] + self.line[1] * (time - self.time[0]))


@dataclass(frozen=True)
class XdfStream:
    """What an XDF file says of one stream of a session.

    Attributes
    ----------
    name, host
        Of the stream, and of the machine that sent it.
    samples
        How many the file has.
    clock
        How the recorder's clock differs from the stream's.
    """

    name: str
    host: str
    samples: int
    clock: StreamClock


def stream_clock(times: Any, offsets: Any) -> StreamClock:
    """Fit a line to the offsets that the recorder measured; without any the clock is the recorder's."""
    time, offset = (np.asarray(each, dtype=np.float64).reshape(-1) for each in (times, offsets))
    count = min(len(time), len(offset))
    time, offset = time[:count], offset[:count]
    known = np.isfinite(time) & np.isfinite(offset)
    time, offset = time[known], offset[known]
    if not time.size:
        return StreamClock(time, offset, (0.0, 0.0), 0.0)
    order = np.argsort(time, kind="stable")
    time, offset = time[order], offset[order]
    middle = np.median(offset)
    spread = np.median(np.abs(offset - middle)) + 1e-6
    good = np.abs(offset - middle) <= _OUTLIER * spread + MAX_DRIFT * np.abs(time - np.median(time))
    since = time - time[0]
    growth = 0.0
    if good.sum() > 2 and since[good][-1] > since[good][0]:
        growth = float(np.clip(np.polyfit(since[good], offset[good], 1)[0], -MAX_DRIFT, MAX_DRIFT))
    first = float(np.median(offset[good] - growth * since[good]))
    scatter = float(np.abs(offset[good] - first - growth * since[good]).max())
    return StreamClock(time, offset, (first, growth), scatter)


def common_clock(first: StreamClock, second: StreamClock) -> CommonTime | None:
    """Return the second stream's clock less the first one's; None where one was not compared.

    The error is the sum of both scatters, and no bound.
    """
    if not (first.time.size and second.time.size):
        return None
    # At the ends of what was compared, on the second clock.
    times = np.unique(np.array([second.time[0], second.time[-1]]))
    recorder = times + second.at(times)
    # The first clock at those times of the recorder: its own line, solved for the stream's time.
    start, growth = first.line
    on_first = (recorder - start + growth * first.time[0]) / (1.0 + growth)
    difference = (times - on_first) * 1e9
    base = round(float(difference[0]))
    knots = np.rint(times * 1e9).astype(np.int64)
    drift = (
        float("nan")
        if len(times) < 2
        else float((difference[1] - difference[0]) / (1e9 * (times[1] - times[0])))
    )
    return CommonTime(
        knots=knots,
        base=base,
        offsets=difference - base,
        errors=np.full(len(times), (first.scatter + second.scatter) * 1e9),
        drift=drift,
        is_linear=True,
        disagreement=0.0,
    )
