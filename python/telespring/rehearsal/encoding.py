"""What is kept of a trial, to which resolution, and as which bytes."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from telespring._types import FloatArray

__all__ = ["SIGNALS", "STATUSES", "TARGET", "Signal", "pack", "rounded"]


@dataclass(frozen=True)
class Signal:
    """A signal over (time, robot, axis) that every trial has.

    Attributes
    ----------
    name, units, long_name
        Of the variable in the dataset; the name is also that of the array which the laboratory gives.
    bits
        Values are rounded to whole multiples of 2**-bits units.
    """

    name: str
    units: str
    long_name: str
    bits: int

    @property
    def resolution(self) -> float:
        """The step to which values are rounded, in the signal's units."""
        return 2.0**-self.bits


#: Full double precision would store mostly digits below the size of an atom, and no compression helps
#: against them. The steps, about 1 nm, 8 nm/s and 1 µN, are far below what any sensor of such a robot
#: resolves, and halve the file.
SIGNALS = (
    Signal("position", "m", "position of the handle", 30),
    Signal("velocity", "m/s", "velocity of the handle", 27),
    Signal("coupling_force", "N", "force of the virtual spring on the handle", 20),
    Signal("agent_force", "N", "force that the agent commands its arm to exert on the handle", 20),
)

#: What both agents follow, over (time, axis): the same in every trial.
TARGET = Signal("target", "m", "position of the target", 30)

#: How a trial can end; its place here is its value in the dataset.
STATUSES = ("completed", "diverged", "out of reach", "too stiff")


def pack(signal: Signal, values: FloatArray, count: int) -> bytes:
    """Make one trial's chunk of the dataset: rounded, filled up with NaN, shuffled, deflated.

    Parameters
    ----------
    signal
        Which signal it is.
    values
        (time, robot, axis); fewer than `count` rows where the trial ended early.
    count
        Rows of a whole trial.

    Returns
    -------
    bytes
        What HDF5's shuffle and deflate filters would make of it. Made here, and not by HDF5, because
        here every thread can do it; HDF5 lets one in at a time.
    """
    whole = np.full((count, *values.shape[1:]), np.nan, dtype="<f8")
    whole[: len(values)] = rounded(signal, values)
    return zlib.compress(whole.reshape(-1).view(np.uint8).reshape(-1, 8).T.tobytes(), 1)


def rounded(signal: Signal, values: FloatArray) -> FloatArray:
    """Round values to the signal's resolution."""
    scale = 2.0**signal.bits
    return np.asarray(np.rint(values * scale) / scale, dtype=np.float64)
