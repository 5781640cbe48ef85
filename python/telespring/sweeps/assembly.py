"""The dataset of a sweep: finished rows with their labels, as netCDF or as Zarr."""

from __future__ import annotations

import secrets
import shutil
from collections.abc import Callable, Iterator
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from telespring._errors import InvalidInput
from telespring._files import replacing
from telespring._types import FloatArray
from telespring.study.conditions import condition_labels
from telespring.sweeps.measures import TIERS, Variable, point_variables, split_row, trial_variables
from telespring.sweeps.plan import SweepPlan
from telespring.sweeps.store import SCHEMA, SweepStore

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["has_sweep", "read_sweep", "require_zarr", "write_sweep"]

#: Points in a chunk of Zarr, at most, along the first dimension; about a megabyte of trials.
_CHUNK = 1000

#: Dimensions, values and attributes of a variable; the same with its name; and what yields all variables.
Values: TypeAlias = tuple[Any, FloatArray, Any]
Named: TypeAlias = tuple[str, Values]
Variables: TypeAlias = Callable[[], Iterator[Named]]


def write_sweep(store: SweepStore, plan: SweepPlan, *, as_zarr: bool) -> None:
    """Write the dataset of a finished sweep, complete or absent."""
    _write(store, plan, partial(_variables_of_rows, store, plan), as_zarr=as_zarr)


def has_sweep(store: SweepStore, plan: SweepPlan, *, as_zarr: bool) -> bool:
    """Check whether the dataset is there; it is written from the one in the other format if only that is."""
    if store.is_complete(as_zarr=as_zarr):
        return True
    if not store.is_complete(as_zarr=not as_zarr):
        return False
    dataset = read_sweep(store.dataset if as_zarr else store.zarr, as_zarr=not as_zarr)
    _write(store, plan, partial(_variables_of_dataset, dataset, plan), as_zarr=as_zarr)
    return True


def read_sweep(path: Path, *, as_zarr: bool) -> xr.Dataset:
    """Read a dataset; that of Zarr stays on the disk until its values are used."""
    import xarray as xr

    if as_zarr:
        require_zarr()
        dataset: xr.Dataset = xr.open_zarr(path, chunks=None, consolidated=False)
        return dataset
    return xr.load_dataset(path, engine="h5netcdf")


def require_zarr() -> None:
    """Refuse Zarr where its package is not installed."""
    try:
        import zarr  # noqa: F401
    except ImportError:
        raise InvalidInput(
            "zarr", "", "the package zarr is required for it", "Install it: pip install 'telespring[zarr]'."
        ) from None


def _write(store: SweepStore, plan: SweepPlan, variables: Variables, *, as_zarr: bool) -> None:
    if as_zarr:
        _write_zarr(store, plan, variables)
    else:
        _write_netcdf(store, plan, variables)


def _write_netcdf(store: SweepStore, plan: SweepPlan, variables: Variables) -> None:
    import xarray as xr

    found = dict(variables())
    dataset = xr.Dataset(found, coords=_coordinates(plan, found), attrs=_attributes(store))
    encoding: dict[str, dict[str, Any]] = {
        str(name): {"zlib": True, "complevel": 1, "shuffle": True}
        for name, variable in dataset.data_vars.items()
        if variable.size > 1000
    }
    with replacing(store.dataset) as beside:
        dataset.to_netcdf(beside, engine="h5netcdf", encoding=encoding)


def _write_zarr(store: SweepStore, plan: SweepPlan, variables: Variables) -> None:
    """Write one variable after the other, so that memory holds one beside the rows."""
    import xarray as xr

    require_zarr()
    beside = store.zarr.with_name(f".unfinished-{secrets.token_hex(8)}")
    try:
        of_points = dict(islice(variables(), len(_point_variables(plan))))
        xr.Dataset(coords=_coordinates(plan, of_points), attrs=_attributes(store)).to_zarr(
            beside, mode="w", consolidated=False
        )
        for name, (dimensions, values, attributes) in variables():
            one = xr.Dataset({name: (dimensions, values, attributes)}, attrs=_attributes(store))
            chunks = (min(_CHUNK, values.shape[0]), *values.shape[1:])
            one.to_zarr(beside, mode="a", consolidated=False, encoding={name: {"chunks": chunks}})
        if store.zarr.is_dir():
            shutil.rmtree(store.zarr)
        beside.rename(store.zarr)
    finally:
        if beside.is_dir():
            shutil.rmtree(beside)


def _point_variables(plan: SweepPlan) -> tuple[Variable, ...]:
    return point_variables(plan, len(plan.study.dyad.axes))


def _variables_of_rows(store: SweepStore, plan: SweepPlan) -> Iterator[Named]:
    """Yield the variables of finished rows one by one: those of the points first."""
    _, rows = store.points.read()
    yield from _laid_out(rows, _point_variables(plan), _keys(plan), plan.shape)
    if plan.trials:
        _, rows = store.trials.read()
        shape = (*plan.shape, plan.conditions, plan.trials)
        yield from _laid_out(rows, trial_variables(), (*_keys(plan), "condition", "trial"), shape)


def _variables_of_dataset(dataset: xr.Dataset, plan: SweepPlan) -> Iterator[Named]:
    """Yield the variables of a dataset in the same order."""
    for each in (*_point_variables(plan), *(trial_variables() if plan.trials else ())):
        variable = dataset[each.name]
        yield each.name, (variable.dims, variable.values, variable.attrs)


def _laid_out(
    rows: FloatArray, variables: tuple[Variable, ...], dimensions: tuple[str, ...], shape: tuple[int, ...]
) -> Iterator[Named]:
    for variable, values in split_row(rows, variables):
        attributes = {"units": variable.units, "long_name": variable.long_name}
        whole = np.ascontiguousarray(values).reshape(*shape, *variable.shape)
        yield variable.name, ((*dimensions, *variable.dimensions), whole, attributes)


def _keys(plan: SweepPlan) -> tuple[str, ...]:
    """Name the dimensions of the points."""
    keys = tuple(each.key for each in plan.over)
    return (*keys, "draw") if plan.draws else keys


def _coordinates(plan: SweepPlan, variables: dict[str, Values]) -> dict[str, Any]:
    coordinates: dict[str, Any] = {
        name: (name, each.coordinate(), {"long_name": f"{each.key} of the study"})
        for name, each in zip(_keys(plan), plan.over, strict=False)
    }
    if plan.draws:
        about = {"long_name": "number of the draw of both robots"}
        coordinates["draw"] = ("draw", np.arange(1, plan.draws + 1), about)
    if plan.trials:
        coordinates["trial"] = ("trial", np.arange(1, plan.trials + 1), {"long_name": "number of the trial"})
    return coordinates | {
        "condition": (
            "condition",
            np.array(_labels(plan, variables), dtype=object),
            {"long_name": "UM: unconnected; CM: connected, with stiffness and delay if they never change"},
        ),
        "robot": ("robot", np.array([1, 2]), {"long_name": "number of the robot"}),
        "axis": ("axis", np.array(plan.study.dyad.axes, dtype=object), {"long_name": "axis of motion"}),
        "tier": ("tier", np.array(TIERS, dtype=object), {"long_name": "what the network may do"}),
    }


def _labels(plan: SweepPlan, variables: dict[str, Values]) -> list[str]:
    """Name the conditions by stiffness and delay, or by number where they differ from point to point."""
    stiffness, delay = (
        variables[f"condition_{name}"][1].reshape(-1, plan.conditions) for name in ("stiffness", "delay")
    )
    connected = np.isfinite(stiffness[0])
    # delays without a spring mean nothing
    if np.array_equal(stiffness, np.broadcast_to(stiffness[0], stiffness.shape), equal_nan=True) and (
        np.array_equal(delay[:, connected], np.broadcast_to(delay[0, connected], delay[:, connected].shape))
    ):
        pairs = zip(stiffness[0].tolist(), delay[0].tolist(), strict=True)
        return condition_labels((None if np.isnan(k) else k, each) for k, each in pairs)
    return [f"CM {number}" if there else "UM" for number, there in enumerate(connected.tolist(), start=1)]


def _attributes(store: SweepStore) -> dict[str, Any]:
    """List what the dataset depends on; no time stamps: equal sweeps give equal datasets."""
    identity = store.identity
    return {
        "schema": SCHEMA,
        "telespring_version": identity.version,
        "name": identity.name,
        "study": identity.study,
        "draws": identity.draws,
        "draw_seed": identity.seed,
        "identity": identity.to_json(),
    }
