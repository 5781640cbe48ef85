"""Long signals with fewer points: no peak is lost."""

from __future__ import annotations

import numpy as np

from telespring._types import FloatArray

__all__ = ["extremes"]

#: No more points are drawn of a signal: the extremes of each stretch of time.
_MOST_POINTS = 4000


def extremes(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Thin a signal out to the smallest and the largest value of each stretch.

    Examples
    --------
    >>> import numpy as np
    >>> time = np.arange(100_000.0)
    >>> thin, values = extremes(time, np.where(time == 777.0, 5.0, 0.0))
    >>> len(thin), values.max()
    (4000, np.float64(5.0))
    """
    if time.size <= _MOST_POINTS:
        return time, values
    kept = [
        stretch[0] + place
        for stretch in np.array_split(np.arange(time.size), _MOST_POINTS // 2)
        for place in sorted((int(values[stretch].argmin()), int(values[stretch].argmax())))
    ]
    return time[kept], values[kept]
