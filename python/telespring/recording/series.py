"""The signals of one site over time, and how they come onto a common grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray

__all__ = ["GAP", "SiteSeries", "on_grid"]

#: Ticks further apart than so many sample periods leave a gap; so do recorded trials.
GAP = 5.0


@dataclass(frozen=True)
class SiteSeries:
    """The ticks of one site.

    Attributes
    ----------
    side
        The robot of the study, 1 or 2.
    time
        ns of the ticks on the common time, increasing.
    signals
        By name: (tick) or (tick, axis), NaN where not known.
    """

    side: int
    time: NDArray[np.int64]
    signals: dict[str, NDArray[Any]]


def on_grid(
    time: NDArray[np.int64], values: FloatArray, grid: NDArray[np.int64], gap: float, *, is_linear: bool
) -> FloatArray:
    """Take a signal at the times of a grid (ns): between two ticks, or held since the last one.

    NaN outside the ticks, and between ticks that are more than `gap` ns apart.
    """
    if is_linear:
        # A device may report less often than the loop ticks.
        has_value = np.isfinite(values).reshape(len(values), -1).all(axis=1)
        time, values = time[has_value], values[has_value]
    if not len(time):
        return np.full((len(grid), *values.shape[1:]), np.nan)
    after = np.searchsorted(time, grid, side="right")
    before = np.clip(after - 1, 0, None)
    following = np.clip(after, None, len(time) - 1)
    span = (time[following] - time[before]).astype(np.float64)
    since = (grid - time[before]).astype(np.float64)
    shape = (-1, *(1 for _ in values.shape[1:]))
    taken = values[before].astype(np.float64)
    if is_linear:
        share = np.divide(since, span, out=np.zeros_like(since), where=span > 0.0).reshape(shape)
        taken = taken + share * (values[following] - taken)
    known = (after > 0) & (since <= gap) & ((span <= gap) | (since == 0.0))
    taken[~known] = np.nan
    return taken
