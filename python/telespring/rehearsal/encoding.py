"""The signals of a trial as they are stored: rounded to a resolution and compressed."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from telespring._types import FloatArray

__all__ = ["SIGNALS", "STATUSES", "TARGET", "Signal", "compress_signal", "round_signal"]


@dataclass(frozen=True)
class Signal:
    """A signal of every trial over (time, robot, axis).

    Attributes
    ----------
    name, units, long_name
        Of the variable in the dataset; the name is also that of the attribute of a `Recording`.
    bits
        Values are rounded to multiples of 2**-bits units.
    """

    name: str
    units: str
    long_name: str
    bits: int

    @property
    def resolution(self) -> float:
        """The step to which values are rounded, in the signal's units."""
        return 2.0**-self.bits


#: Full double precision would store mostly digits below the size of an atom, which do not compress. The
#: steps, about 1 nm, 8 nm/s and 1 µN, are far below the resolution of any sensor of such a robot, and halve
#: the file.
SIGNALS = (
    Signal("position", "m", "position of the handle", 30),
    Signal("velocity", "m/s", "velocity of the handle", 27),
    Signal("coupling_force", "N", "force of the virtual spring on the handle", 20),
    Signal("agent_force", "N", "force that the agent commands its arm to exert on the handle", 20),
)

#: The target of both agents, over (time, axis): the same in every trial.
TARGET = Signal("target", "m", "position of the target", 30)

#: How a trial can end; the index here is the value in the dataset.
STATUSES = ("completed", "diverged", "out of reach", "too stiff")


def compress_signal(signal: Signal, values: FloatArray, count: int) -> bytes:
    """Compress a signal of one trial to a chunk of the dataset.

    Parameters
    ----------
    signal
        The signal.
    values
        (time, robot, axis); fewer than `count` rows if the trial ended early.
    count
        Rows of a completed trial; missing rows are NaN.

    Returns
    -------
    bytes
        The output of HDF5's shuffle and deflate filters. It is made here because every thread can do it,
        while HDF5 admits one thread at a time.
    """
    padded = np.full((count, *values.shape[1:]), np.nan, dtype="<f8")
    padded[: len(values)] = round_signal(signal, values)
    return zlib.compress(padded.reshape(-1).view(np.uint8).reshape(-1, 8).T.tobytes(), 1)


def round_signal(signal: Signal, values: FloatArray) -> FloatArray:
    """Round values to the resolution of a signal."""
    scale = 2.0**signal.bits
    return np.asarray(np.rint(values * scale) / scale, dtype=np.float64)
