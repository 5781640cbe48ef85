"""The dataset of a sweep: finished rows with their labels, as netCDF or as Zarr."""

from __future__ import annotations

import secrets
import shutil
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

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

__all__ = ["read_sweep", "require_zarr", "write_sweep"]

#: Points in a chunk of Zarr, at most, along the first dimension; about a megabyte of trials.
_CHUNK = 1000


def write_sweep(store: SweepStore, plan: SweepPlan, *, as_zarr: bool) -> None:
    """Write the dataset of a finished sweep, complete or absent."""
    if as_zarr:
        _write_zarr(store, plan)
    else:
        _write_netcdf(store, plan)


def read_sweep(store: SweepStore, *, as_zarr: bool) -> xr.Dataset:
    """Read the dataset; that of Zarr stays on the disk until its values are used."""
    import xarray as xr

    if as_zarr:
        require_zarr()
        dataset: xr.Dataset = xr.open_zarr(store.zarr, chunks=None, consolidated=False)
        return dataset
    return xr.load_dataset(store.dataset, engine="h5netcdf")


def require_zarr() -> None:
    """Refuse Zarr where its package is not installed."""
    try:
        import zarr  # noqa: F401
    except ImportError:
        raise InvalidInput(
            "zarr", "", "the package zarr is required for it", "Install it: pip install 'telespring[zarr]'."
        ) from None


def _write_netcdf(store: SweepStore, plan: SweepPlan) -> None:
    import xarray as xr

    variables = dict(_variables(store, plan))
    dataset = xr.Dataset(variables, coords=_coordinates(plan, variables), attrs=_attributes(store))
    encoding: dict[str, dict[str, Any]] = {
        str(name): {"zlib": True, "complevel": 1, "shuffle": True}
        for name, variable in dataset.data_vars.items()
        if variable.size > 1000
    }
    with replacing(store.dataset) as beside:
        dataset.to_netcdf(beside, engine="h5netcdf", encoding=encoding)


def _write_zarr(store: SweepStore, plan: SweepPlan) -> None:
    """Write one variable after the other, so that memory holds one beside the rows."""
    import xarray as xr

    require_zarr()
    beside = store.zarr.with_name(f".unfinished-{secrets.token_hex(8)}")
    try:
        few = dict(_point_part(store, plan))
        xr.Dataset(coords=_coordinates(plan, few), attrs=_attributes(store)).to_zarr(
            beside, mode="w", consolidated=False
        )
        for name, (dimensions, values, attributes) in _variables(store, plan):
            one = xr.Dataset({name: (dimensions, values, attributes)}, attrs=_attributes(store))
            chunks = (min(_CHUNK, values.shape[0]), *values.shape[1:])
            one.to_zarr(beside, mode="a", consolidated=False, encoding={name: {"chunks": chunks}})
        if store.zarr.is_dir():
            shutil.rmtree(store.zarr)
        beside.rename(store.zarr)
    finally:
        if beside.is_dir():
            shutil.rmtree(beside)


def _variables(store: SweepStore, plan: SweepPlan) -> Iterator[tuple[str, tuple[Any, FloatArray, Any]]]:
    """Yield the variables one by one, as `xarray.Dataset` takes them."""
    yield from _point_part(store, plan)
    if plan.trials:
        _, rows = store.trials.read()
        shape = (*plan.shape, plan.conditions, plan.trials)
        yield from _laid_out(rows, trial_variables(), (*_keys(plan), "condition", "trial"), shape)


def _point_part(store: SweepStore, plan: SweepPlan) -> Iterator[tuple[str, tuple[Any, FloatArray, Any]]]:
    _, rows = store.points.read()
    axes = len(plan.study.dyad.axes)
    yield from _laid_out(rows, point_variables(plan, axes), _keys(plan), plan.shape)


def _laid_out(
    rows: FloatArray, variables: tuple[Variable, ...], dimensions: tuple[str, ...], shape: tuple[int, ...]
) -> Iterator[tuple[str, tuple[Any, FloatArray, Any]]]:
    for variable, values in split_row(rows, variables):
        attributes = {"units": variable.units, "long_name": variable.long_name}
        whole = np.ascontiguousarray(values).reshape(*shape, *variable.shape)
        yield variable.name, ((*dimensions, *variable.dimensions), whole, attributes)


def _keys(plan: SweepPlan) -> tuple[str, ...]:
    """Name the dimensions of the points."""
    keys = tuple(each.key for each in plan.over)
    return (*keys, "draw") if plan.draws else keys


def _coordinates(plan: SweepPlan, variables: dict[str, tuple[Any, FloatArray, Any]]) -> dict[str, Any]:
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


def _labels(plan: SweepPlan, variables: dict[str, tuple[Any, FloatArray, Any]]) -> list[str]:
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
