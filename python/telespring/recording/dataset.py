"""A live session as a labelled dataset: over time, robot and axis, in the words of a rehearsal's."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.recording.series import GAP, SiteSeries, on_grid
from telespring.recording.signals import SIGNALS, TARGET, WORDS

if TYPE_CHECKING:
    import xarray as xr

    from telespring.recording.events import SessionEvent

__all__ = ["session_dataset", "session_grid"]

#: A dataset has no more samples than so many times the ticks: a session with longer gaps has a coarser grid.
_SAMPLES_PER_TICK = 8


def session_grid(sites: Sequence[SiteSeries], period: float) -> NDArray[np.int64]:
    """Return the times (ns) of a grid of this period (s) over all ticks of all sites."""
    begin = min(int(site.time[0]) for site in sites)
    end = max(int(site.time[-1]) for site in sites)
    most = _SAMPLES_PER_TICK * sum(len(site.time) for site in sites) + 1000
    step = max(round(period * 1e9), (end - begin) // most + 1)
    return np.arange(begin, end + 1, step, dtype=np.int64)


def session_dataset(
    sites: Sequence[SiteSeries],
    grid: NDArray[np.int64],
    period: float,
    events: Sequence[SessionEvent],
    attributes: dict[str, Any],
) -> xr.Dataset:
    """Put the signals of the sites (in order of their robots) on one grid; a robot without a site is NaN."""
    import xarray as xr

    gap = GAP * period * 1e9
    count = len(grid)
    variables: dict[str, Any] = {}
    for signal in SIGNALS:
        shape = (count, 2, 2) if signal.has_axes else (count, 2)
        values = np.full(shape, np.nan)
        for site in sites:
            if signal.name in site.signals:
                values[:, site.side - 1] = on_grid(
                    site.time, site.signals[signal.name], grid, gap, is_linear=signal.between == "linear"
                )
        dimensions = ("time", "robot", "axis") if signal.has_axes else ("time", "robot")
        variables[signal.name] = (dimensions, values, _attributes(signal.units, signal.long_name))
    variables[TARGET.name] = (
        ("time", "axis"),
        _target(sites, grid, gap),
        _attributes(TARGET.units, TARGET.long_name),
    )
    for name, long_name in WORDS.items():
        variables[name] = _words(sites, name, long_name, grid, gap)
    return xr.Dataset(
        variables
        | {
            "event_time": ("event", [event.time for event in events], _attributes("s", "when it happened")),
            "event_robot": (
                "event",
                np.array([event.side for event in events], dtype=np.int8),
                _attributes("1", "robot of the site at which it happened"),
            ),
            "event_name": ("event", np.array([event.event for event in events], dtype=object)),
            "event_cause": ("event", np.array([event.cause for event in events], dtype=object)),
        },
        coords={
            "time": (
                "time",
                (grid - grid[0]) * 1e-9,
                _attributes("s", "time since the beginning of the recording"),
            ),
            "robot": ("robot", np.array([1, 2]), _attributes("1", "number of the robot")),
            "axis": ("axis", np.array(["x", "y"], dtype=object), _attributes("1", "axis of motion")),
        },
        attrs=attributes,
    )


def _attributes(units: str, long_name: str, **more: Any) -> dict[str, Any]:
    return {"units": units, "long_name": long_name, **more}


def _target(sites: Sequence[SiteSeries], grid: NDArray[np.int64], gap: float) -> FloatArray:
    """Take the target from the first site that knows it: both people see the same one."""
    target = np.full((len(grid), 2), np.nan)
    for site in sites:
        if TARGET.name in site.signals:
            seen = on_grid(site.time, site.signals[TARGET.name], grid, gap, is_linear=True)
            target = np.where(np.isfinite(target), target, seen)
    return target


def _words(
    sites: Sequence[SiteSeries], name: str, long_name: str, grid: NDArray[np.int64], gap: float
) -> Any:
    """Return words over time as numbers with their meanings; -1 is not known."""
    import pandas as pd

    coded = {site.side: pd.factorize(site.signals[name]) for site in sites if name in site.signals}
    found = sorted({str(word) for _, words in coded.values() for word in words} - {""})
    values = np.full((len(grid), 2), -1, dtype=np.int8)
    for site in sites:
        if site.side not in coded:
            continue
        places, words = coded[site.side]
        codes = np.array([found.index(str(word)) if word else -1 for word in words], dtype=np.float64)
        held = on_grid(site.time, codes[places], grid, gap, is_linear=False)
        values[:, site.side - 1] = np.where(np.isfinite(held), held, -1).astype(np.int8)
    flags = [-1, *range(len(found))]
    meanings = " ".join(["unknown", *(word.replace(" ", "_") for word in found)])
    return (
        ("time", "robot"),
        values,
        _attributes("1", long_name, flag_values=np.array(flags, dtype=np.int8), flag_meanings=meanings),
    )
