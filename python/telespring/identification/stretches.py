"""Stretches of logs: evenly sampled parts that are filtered separately and estimated from together.

A log without long gaps is one stretch. Several logs of one robot, the runs of one file and the parts between
long gaps are several. No filter, difference or correlation reaches from one stretch into another.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray

__all__ = ["Stretch"]


@dataclass(frozen=True)
class Stretch:
    """A part of a log at an even rate.

    Attributes
    ----------
    time
        s, shape (n,), evenly spaced.
    position, force
        m and N, shape (axes, n).
    usable
        Shape (n,): False where a sample was not measured but interpolated, over a short gap or a glitch. It
        carries the filter over, and the regression leaves out what depends on it.
    rate
        Samples per second, Hz.
    """

    time: FloatArray
    position: FloatArray
    force: FloatArray
    usable: NDArray[np.bool_]
    rate: float

    @property
    def duration(self) -> float:
        """From the first to the last sample of a stretch, s."""
        return float(self.time[-1] - self.time[0])
