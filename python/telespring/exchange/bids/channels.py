"""The channels of a motion file: which signals of a robot it has, and what each is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from telespring.exchange.bids.runs import mean_period
from telespring.exchange.material import code_words, robot_signals, signal_values

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["KINDS", "Channel", "channels"]

Kind = Literal["POS", "VEL", "MISC", "LATENCY"]
#: In this order they stand in a file.
KINDS: tuple[Kind, ...] = ("POS", "VEL", "MISC", "LATENCY")
#: Samples that stray from an even clock by more than this share of a period have their times beside them.
_UNEVEN = 0.01
#: Signals that are motion, and of what; all others are of no kind that BIDS knows.
_MOTION: dict[str, tuple[Kind, str]] = {
    "position": ("POS", "handle"),
    "velocity": ("VEL", "handle"),
    "target": ("POS", "target"),
    "own_target": ("POS", "target"),
    "played_position": ("POS", "partner"),
    "predicted_position": ("POS", "partner"),
}


@dataclass(frozen=True, eq=False)
class Channel:
    """A column of a motion file, and its line in the channels file."""

    name: str
    component: str
    kind: Kind
    tracked_point: str
    units: str
    description: str
    values: NDArray[np.float64]


def channels(data: xr.Dataset, robot: int) -> list[Channel]:
    """Return the channels of one robot (0 or 1) in a run: motion first, in the order of the dataset."""
    found = [channel for name in robot_signals(data) for channel in _of_signal(data, name, robot)]
    if not any(channel.name.startswith("own_target") for channel in found):
        found += _split("target", np.asarray(data["target"], dtype=np.float64), data["target"])
    known = [channel for channel in found if np.isfinite(channel.values).any()]
    known = sorted(known, key=lambda channel: KINDS.index(channel.kind))
    return known + _latency(np.asarray(data["time"], dtype=np.float64))


def _latency(time: NDArray[np.float64]) -> list[Channel]:
    """Return the channel that says when each sample was taken, where their number alone does not."""
    period = mean_period(time)
    strays = np.abs(time - time[0] - period * np.arange(len(time)))
    if len(time) < 2 or strays.max() <= _UNEVEN * period:
        return []
    description = "time of the sample since the first one; they are not evenly spaced"
    return [Channel("latency", "n/a", "LATENCY", "n/a", "s", description, time - time[0])]


def _of_signal(data: xr.Dataset, name: str, robot: int) -> Iterator[Channel]:
    yield from _split(name, signal_values(data, name, robot), data[name])


def _split(name: str, values: NDArray[np.float64], variable: xr.DataArray) -> Iterator[Channel]:
    kind, point = _MOTION.get(name, ("MISC", "handle" if values.ndim == 2 else "n/a"))
    units = str(variable.attrs.get("units", "n/a")).strip()
    description = str(variable.attrs.get("long_name", name.replace("_", " ")))
    if "flag_meanings" in variable.attrs:
        description = f"{description}: {code_words(variable)}"
    for i, axis in enumerate(("x", "y") if values.ndim == 2 else ("n/a",)):
        yield Channel(
            name if axis == "n/a" else f"{name}_{axis}",
            axis,
            kind,
            point,
            "n/a" if units in ("", "1") else units,
            description,
            values[:, i] if values.ndim == 2 else values,
        )
