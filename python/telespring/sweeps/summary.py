"""A sweep in a few numbers: for each value of each key, how the points and trials came out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._json import json_ready
from telespring._types import FloatArray
from telespring.rehearsal.encoding import STATUSES

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["SweepRow", "SweepSummary", "summarise_sweep"]

#: J; the integral of what the damping took is not more exact.
_SPARE_ERROR = 1e-3


@dataclass(frozen=True)
class SweepRow:
    """All points of a sweep, or those with one value of one key.

    Attributes
    ----------
    value
        The value, a number or a word; None for all points.
    stable_share
        Share of the connected conditions at which the bare spring is stable; None without any.
    trials
        Number of trials.
    early_ends
        How many of them ended early, by status.
    tracking_error
        Mean of both robots over completed trials, m; None without any.
    limited_share
        Mean share of the ticks at which the strategy changed the spring's force; None without any.
    guard_broken
        Trials in which the guards gave out more than their law allows, though both robots have the damping
        that they count on; None without a guard.
    guard_overtaxed
        The same with a drawn robot that has less damping than they count on.
    """

    value: float | str | None
    stable_share: float | None
    trials: int
    early_ends: Mapping[str, int]
    tracking_error: float | None
    limited_share: float | None
    guard_broken: int | None
    guard_overtaxed: int | None


@dataclass(frozen=True)
class SweepSummary:
    """A sweep in a few numbers.

    Attributes
    ----------
    name
        Of the study.
    points
        Number of points.
    whole
        Over all points.
    keys
        For each key a row per value.
    without_effect
        Keys with several values that all have the same results.
    """

    name: str
    points: int
    whole: SweepRow
    keys: Mapping[str, tuple[SweepRow, ...]]
    without_effect: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return it as `json.dumps` takes it."""
        rows = {key: [vars(row) for row in rows] for key, rows in self.keys.items()}
        found = {"name": self.name, "points": self.points, "all": vars(self.whole), "keys": rows}
        found["without_effect"] = list(self.without_effect)
        return dict(json_ready(found))


def summarise_sweep(dataset: xr.Dataset, trials: int) -> SweepSummary:
    """Summarise the dataset of a sweep, with so many trials of each condition."""
    shape = dict(dataset["robot_mass"].sizes)
    keys = [str(name) for name in dataset["robot_mass"].dims if name not in ("robot", "axis", "draw")]
    return SweepSummary(
        name=str(dataset.attrs["name"]),
        points=int(np.prod([length for name, length in shape.items() if name not in ("robot", "axis")])),
        whole=_row(None, dataset, trials),
        keys={
            key: tuple(
                _row(_plain(value), dataset.isel({key: place}), trials)
                for place, value in enumerate(dataset[key].values)
            )
            for key in keys
        },
        without_effect=tuple(key for key in keys if dataset.sizes[key] > 1 and _is_alike(dataset, key)),
    )


def _is_alike(dataset: xr.Dataset, key: str) -> bool:
    """Check whether all values of a key have the same results."""
    for variable in dataset.data_vars.values():
        if key in variable.dims:
            values = np.moveaxis(variable.values, variable.dims.index(key), 0)
            if not np.array_equal(values, np.broadcast_to(values[0], values.shape), equal_nan=True):
                return False
    return True


def _plain(value: Any) -> float | str:
    return float(value) if isinstance(value, np.number) else str(value)


def _row(value: float | str | None, part: xr.Dataset, trials: int) -> SweepRow:
    if not trials:
        return SweepRow(value, _mean(part["stable"].values), 0, {}, None, None, None, None)
    status = part["status"].values
    broken = part["guard_spare"] < -_SPARE_ERROR
    has_less = (part["robot_damping"] < part["counted_damping"]).any(("robot", "axis"))
    has_guard = bool(np.isfinite(part["guard_spare"].values).any())
    return SweepRow(
        value=value,
        stable_share=_mean(part["stable"].values),
        trials=int(status.size),
        early_ends={
            word: count
            for number, word in enumerate(STATUSES)
            if number and (count := int(np.count_nonzero(status == number)))
        },
        tracking_error=_mean(part["tracking_error"].values),
        limited_share=_mean(part["limited_share"].values),
        guard_broken=int((broken & ~has_less).sum()) if has_guard else None,
        guard_overtaxed=int((broken & has_less).sum()) if has_guard else None,
    )


def _mean(values: FloatArray) -> float | None:
    """Average what is finite; None where nothing is."""
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else None
