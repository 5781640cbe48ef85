"""For which dyads the paper's critical stiffness is unsafe: counted over a map, none is stored."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._core import POPULATION_BIN_RATIO, tally_population
from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.rehearsal.executors import Executor, run_tasks, tasks_in_flight
from telespring.rehearsal.shards import Shard, ShardLike, read_shard

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["survey_dyads", "unsafe_quantile"]

#: Dyads that one task counts, about: a second of one core.
_PER_TASK = 4_000_000
#: Cells at most: of each 512 counts are kept.
_MOST_CELLS = 100_000
Range = tuple[float, float]


@dataclass(frozen=True)
class _Population:
    """The keywords of the core's `tally_population`, without its part of the dyads."""

    mass: Range
    damping: Range
    mass_ratio: Range
    damping_ratio: Range
    cells: tuple[int, int]
    operator_mass: float
    operator_damping: float
    seed: int

    @classmethod
    def read(cls, **given: Any) -> _Population:
        """Read the keywords as a caller gives them; InvalidInput where one is of another kind."""
        for name in ("mass", "damping", "mass_ratio", "damping_ratio"):
            given[name] = _pair(name, given[name], float, "numbers, the smaller one first,")
        for name in ("operator_mass", "operator_damping"):
            given[name] = _number(name, given[name])
        given["cells"] = _pair("cells", given["cells"], operator.index, "whole numbers")
        given["seed"] = _whole("seed", given["seed"], 0, 2**63 - 1)
        rows, columns = given["cells"]
        if min(rows, columns) < 1 or rows * columns > _MOST_CELLS:
            raise _refused(
                "cells",
                (rows, columns),
                f"1 cell or more in each direction, and at most {_MOST_CELLS} in all, are",
            )
        return cls(**given)


def _refused(name: str, value: object, allowed: str) -> InvalidInput:
    return InvalidInput(name, str(value), f"{allowed} required", "See the documentation of survey_dyads.")


def _whole(name: str, value: Any, least: int, most: int) -> int:
    try:
        number = operator.index(value)
    except TypeError:
        number = int(value) if isinstance(value, float) and value.is_integer() else least - 1
    if not least <= number <= most:
        raise _refused(name, value, f"a whole number from {least} to {most} is")
    return number


def _number(name: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise _refused(name, value, "a number is") from None


def _pair(name: str, value: Any, read: Callable[[Any], Any], kind: str) -> tuple[Any, Any]:
    try:
        first, second = value
        return read(first), read(second)
    except (TypeError, ValueError):
        raise _refused(name, value, f"two {kind} are") from None


def _count(population: _Population, first: int, count: int) -> tuple[Any, Any, Any, Any]:
    return tally_population(**asdict(population), first=first, count=count)


def survey_dyads(
    dyads: int,
    *,
    mass: Range = (0.5, 5.0),
    damping: Range = (1.0, 20.0),
    mass_ratio: Range = (0.05, 20.0),
    damping_ratio: Range = (0.05, 20.0),
    cells: tuple[int, int] = (40, 40),
    operator_mass: float = 0.0,
    operator_damping: float = 0.0,
    seed: int = 1,
    shard: ShardLike | None = None,
    progress: Callable[[int, int], None] | None = None,
    executor: Executor | None = None,
) -> xr.Dataset:
    r"""Count for which dyads the paper's critical stiffness (Eq. 5) is above the exact one.

    Dyads with free handles are drawn in every cell of a map over the ratios of the robots' masses and
    dampings, judged, and forgotten: a billion take minutes and no memory. The counts are whole numbers, so
    that shares add up to the same dataset, bit for bit.

    Parameters
    ----------
    dyads : int
        Number of dyads of the whole map; every cell has the same number, rounded up.
    mass, damping : pair of float
        Smallest and largest mass (kg) and damping (N·s/m) of robot 1, uniform in the logarithm.
    mass_ratio, damping_ratio : pair of float
        Robot 2's mass and damping divided by robot 1's, over the map; within a cell uniform in the logarithm.
    cells : pair of int
        Cells over the mass ratio and over the damping ratio.
    operator_mass, operator_damping : float
        Largest mass (kg) and damping (N·s/m) that a person adds to a handle; uniform from 0, each person by
        itself.
    seed : int
        From which all is drawn.
    shard : pair of int or str, optional
        Count only this share of every cell's dyads, such as ``(2, 8)``; `merge_surveys` adds them up.
    progress : callable, optional
        Called with the number of counted dyads and of all.
    executor : concurrent.futures.Executor or the like, optional
        Counts parts of the dyads instead of the threads of this process.

    Returns
    -------
    xarray.Dataset
        Over (mass_ratio, damping_ratio), at the middles of the cells: ``dyads`` and ``unsafe`` (counts) and
        ``largest``, the largest ratio of the paper's to the exact critical stiffness; ``histogram`` counts
        the unsafe dyads by that ratio, whose lower edges are ``ratio``, each 1.02 times the one before. Of a
        share, the attribute ``shard`` says which one it is.

    Raises
    ------
    InvalidInput
        If a range is empty, or a robot of it cannot be one.

    Examples
    --------
    Equal robots are safe; where one has ten times the damping of the other, many are not.

    >>> import telespring as ts
    >>> survey = ts.survey_dyads(30_000, damping_ratio=(0.9, 12.0), mass_ratio=(0.9, 1.1), cells=(1, 3))
    >>> (survey.unsafe / survey.dyads).values.round(2).tolist()
    [[0.0, 0.86, 1.0]]
    """
    population = _Population.read(
        mass=mass,
        damping=damping,
        mass_ratio=mass_ratio,
        damping_ratio=damping_ratio,
        cells=cells,
        operator_mass=operator_mass,
        operator_damping=operator_damping,
        seed=seed,
    )
    _count(population, 0, 0)  # refuses what cannot be drawn, in this process
    count = population.cells[0] * population.cells[1]
    per_cell = -(-_whole("dyads", dyads, 1, 10**18) // count)
    part = read_shard(shard)
    share = part or Shard(1, 1)
    first, last = ((index * per_cell) // share.count for index in (share.index - 1, share.index))
    step = max(1, _PER_TASK // count)
    tasks = [(population, start, min(step, last - start)) for start in range(first, last, step)]
    totals = _count(population, first, 0)
    done, total = 0, count * (last - first)
    if progress is not None:
        progress(done, total)
    with _pool(executor) as (pool, in_flight), closing(run_tasks(pool, _count, tasks, in_flight)) as parts:
        for counted in parts:
            totals = _sum(totals, counted)
            done += int(counted[0].sum())
            if progress is not None:
                progress(done, total)
    found = _dataset(population, totals).assign_attrs(dyads_per_cell=per_cell)
    return found if part is None else found.assign_attrs(shard=str(part))


@contextmanager
def _pool(executor: Executor | None) -> Iterator[tuple[Executor, int]]:
    """Return what runs tasks: one thread here, as the core counts on all cores."""
    if executor is not None:
        yield executor, tasks_in_flight(executor)
        return
    with ThreadPoolExecutor(1, thread_name_prefix="survey") as pool:
        yield pool, 2


def _sum(one: tuple[Any, ...], other: tuple[Any, ...]) -> tuple[Any, Any, Any, Any]:
    return one[0] + other[0], one[1] + other[1], np.maximum(one[2], other[2]), one[3] + other[3]


def _dataset(population: _Population, totals: tuple[Any, ...]) -> xr.Dataset:
    import xarray as xr

    rows, columns = population.cells
    bins = totals[3].shape[1]
    cell = ("mass_ratio", "damping_ratio")
    return xr.Dataset(
        {
            "dyads": (cell, totals[0].reshape(rows, columns), _about("1", "dyads that were judged")),
            "unsafe": (
                cell,
                totals[1].reshape(rows, columns),
                _about("1", "dyads for which the paper's critical stiffness is above the exact one"),
            ),
            "largest": (
                cell,
                totals[2].reshape(rows, columns),
                _about("1", "largest ratio of the paper's to the exact critical stiffness"),
            ),
            "histogram": (
                (*cell, "ratio"),
                totals[3].reshape(rows, columns, bins),
                _about("1", "unsafe dyads by that ratio"),
            ),
        },
        coords={
            "mass_ratio": (
                "mass_ratio",
                _middles(population.mass_ratio, rows),
                _about("1", "mass of robot 2 by that of robot 1, in the middle of the cell"),
            ),
            "damping_ratio": (
                "damping_ratio",
                _middles(population.damping_ratio, columns),
                _about("1", "damping of robot 2 by that of robot 1, in the middle of the cell"),
            ),
            "ratio": (
                "ratio",
                POPULATION_BIN_RATIO ** np.arange(bins),
                _about("1", "lower edge of the bin; the last has no upper one"),
            ),
        },
        attrs={
            "mass": list(population.mass),
            "damping": list(population.damping),
            "operator_mass": population.operator_mass,
            "operator_damping": population.operator_damping,
            "seed": population.seed,
            "mass_ratio_range": list(population.mass_ratio),
            "damping_ratio_range": list(population.damping_ratio),
        },
    )


def _about(units: str, long_name: str) -> dict[str, str]:
    return {"units": units, "long_name": long_name}


def _middles(ends: Range, count: int) -> FloatArray:
    edges = np.geomspace(ends[0], ends[1], count + 1)
    return np.asarray(np.sqrt(edges[:-1] * edges[1:]))


def unsafe_quantile(survey: xr.Dataset, quantile: float) -> xr.DataArray:
    """Return a quantile of the ratio of the paper's to the exact critical stiffness in each cell.

    It is exact to 1 %, half a bin of the histogram in the logarithm; a safe dyad counts as 1. NaN where a
    cell has no dyads, infinite in the last bin.

    Parameters
    ----------
    survey : xarray.Dataset
        The result of `survey_dyads` or `merge_surveys`.
    quantile : float
        From 0 to 1; 0.95 for 95 %.

    Returns
    -------
    xarray.DataArray
        The ratio (dimensionless) per cell of mass and damping ratio.

    Raises
    ------
    InvalidInput
        If `quantile` is not from 0 to 1.

    Examples
    --------
    >>> import telespring as ts
    >>> survey = ts.survey_dyads(1000, damping_ratio=(10.0, 10.0), mass_ratio=(1.0, 1.0), cells=(1, 1))
    >>> round(float(unsafe_quantile(survey, 0.5)[0, 0]), 1)  # 25.25 N/m instead of 9.461 N/m
    2.7
    """
    if not 0.0 <= quantile <= 1.0:
        raise InvalidInput("quantile", str(quantile), "a number from 0 to 1", "Give 0.95 for 95 %.")
    histogram = survey["histogram"].values
    dyads, unsafe = survey["dyads"].values, survey["unsafe"].values
    # The rank of the dyad that is looked for, from 1; those that are safe come first.
    rank = np.maximum(1, np.ceil(quantile * dyads)).astype(np.int64) - (dyads - unsafe).astype(np.int64)
    reached = np.cumsum(histogram, axis=-1).astype(np.int64) >= rank[..., None]
    place = reached.argmax(axis=-1)
    middle = survey["ratio"].values * np.sqrt(POPULATION_BIN_RATIO)
    middle[-1] = np.inf
    found = np.where(rank <= 0, 1.0, middle[place])
    found = np.where(dyads == 0, np.nan, found)
    return (
        survey["largest"]
        .copy(data=found)
        .assign_attrs(
            long_name=f"{quantile:g} quantile of the ratio of the paper's to the exact critical stiffness"
        )
    )
