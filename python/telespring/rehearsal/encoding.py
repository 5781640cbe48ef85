"""The signals of a trial as they are stored: rounded to a resolution and compressed."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from telespring._core import Architecture
from telespring._types import FloatArray

__all__ = [
    "ACCOUNT",
    "AGE",
    "REPORTS",
    "SIDE_REPORTS",
    "SIGNALS",
    "STATUSES",
    "TARGET",
    "Report",
    "Signal",
    "compress_signal",
    "round_signal",
    "stored_signals",
]


@dataclass(frozen=True)
class Signal:
    """A signal of every trial over (time, robot, axis) or (time, robot).

    Attributes
    ----------
    name, units, long_name
        Of the variable in the dataset; the name is also that of the attribute of a `Recording`.
    bits
        Values are rounded to multiples of 2**-bits units.
    has_axes
        Whether there is a value for each axis.
    """

    name: str
    units: str
    long_name: str
    bits: int
    has_axes: bool = True

    @property
    def resolution(self) -> float:
        """The step to which a stored signal is rounded, in its units."""
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

#: Kept only where the strategy has an account; the step is about 1 nJ.
ACCOUNT = Signal("account", "J", "energy in the account of the side's strategy", 30, has_axes=False)

#: Of what was played, before any prediction; NaN while there is nothing. The step is about 1 ns.
AGE = Signal("age", "s", "age of the partner's motion that a robot uses, as played", 30, has_axes=False)

#: The target of both agents, over (time, axis): the same in every trial.
TARGET = Signal("target", "m", "position of the target", 30)


@dataclass(frozen=True)
class Report:
    """A number that a trial's coupling reports at its end.

    The name is that of the variable in the dataset and of the attribute of a `Recording`.
    """

    name: str
    units: str
    long_name: str


#: Of each robot's side; NaN in the unconnected mode, but for what the hand got.
SIDE_REPORTS = (
    Report("limited_share", "1", "share of the ticks at which the strategy changed the force of the spring"),
    Report("withheld_share", "1", "mean share of the spring's force that was withheld at those ticks"),
    Report("given_out", "J", "energy that the coupling gave out to the handle, as the side measured it"),
    Report("energy_sent", "J", "energy that the side's strategy sent to its partner"),
    Report("hand_energy", "J", "energy that the hand got; negative if it gave more than it got"),
    Report("age_mean", "s", "mean age of the partner's motion in use"),
    Report("age_low", "s", "smallest age of a partner's sample in use"),
    Report("age_high", "s", "largest age of a partner's sample in use"),
    Report("held_share", "1", "share of the ticks at which an old motion was held"),
    Report("lost", "1", "packets that had not come although later ones had"),
)

#: Of the whole coupling.
REPORTS = (
    Report(
        "coupling_energy", "J", "energy that the coupling took at both handles, less what it gave out there"
    ),
    Report("coupling_energy_minimum", "J", "smallest value of this energy during the trial"),
)

#: How a trial can end; the index here is the value in the dataset.
STATUSES = ("completed", "diverged", "out of reach", "too stiff")


def stored_signals(session: Architecture) -> tuple[Signal, ...]:
    """Return the signals that a rehearsal with this session keeps of every trial."""
    return (*SIGNALS, AGE, ACCOUNT) if session.has_account else (*SIGNALS, AGE)


def compress_signal(signal: Signal, values: FloatArray, count: int) -> bytes:
    """Compress a signal (time, robot) or (time, robot, axis) of one trial to a chunk of the dataset.

    It may have fewer rows than `count`, those of a completed trial; missing rows are NaN. The bytes are those
    of HDF5's shuffle and deflate filters. They are made here because every thread can do it, while HDF5
    admits one thread at a time.
    """
    padded = np.full((count, *values.shape[1:]), np.nan, dtype="<f8")
    padded[: len(values)] = round_signal(signal, values)
    return zlib.compress(padded.reshape(-1).view(np.uint8).reshape(-1, 8).T.tobytes(), 1)


def round_signal(signal: Signal, values: FloatArray) -> FloatArray:
    """Round a signal to the resolution in which it is stored."""
    scale = 2.0**signal.bits
    return np.asarray(np.rint(values * scale) / scale, dtype=np.float64)
