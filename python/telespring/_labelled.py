"""Arrays with labels, of xarray and pandas: they broadcast by the names of their dimensions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._arrays import as_numbers
from telespring._errors import InvalidInput
from telespring._types import FloatArray

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["broadcast", "is_labelled", "label", "label_map"]


def is_labelled(value: object) -> bool:
    """Whether an argument is an array of xarray, or a series of pandas."""
    return hasattr(value, "to_xarray") or (hasattr(value, "dims") and hasattr(value, "coords"))


def _as_xarray(name: str, value: Any) -> xr.DataArray:
    import xarray as xr

    array = value.to_xarray() if hasattr(value, "to_xarray") else value
    if isinstance(array, xr.DataArray):
        return array
    raise InvalidInput(
        name,
        f"a {type(value).__name__}",
        "one array is required",
        "Choose a column or a variable of it.",
    )


def broadcast(names: list[str], values: list[Any]) -> tuple[list[FloatArray], xr.DataArray]:
    """Return all arguments with the same shape, and an array with the labels of that shape."""
    import xarray as xr

    arrays = []
    for name, value in zip(names, values, strict=True):
        if is_labelled(value):
            arrays.append(_as_xarray(name, value))
            continue
        numbers = as_numbers(name, value)
        if numbers.ndim:
            raise InvalidInput(
                name,
                f"an array of shape {numbers.shape} without labels",
                "beside arrays with labels, an array needs labels, too",
                "Name its dimensions, such as xarray.DataArray(values, dims='delay').",
            )
        arrays.append(xr.DataArray(numbers))
    try:
        arrays = list(xr.broadcast(*xr.align(*arrays, join="exact")))
    except ValueError:
        labelled = [name for name, value in zip(names, values, strict=True) if is_labelled(value)]
        raise InvalidInput(
            ", ".join(labelled),
            "arrays with different labels",
            "along a dimension of the same name, labels must be equal",
            "Align them first, for instance with xarray.align(..., join='inner').",
        ) from None
    return [as_numbers(name, array.values) for name, array in zip(names, arrays, strict=True)], arrays[0]


def label(result: NDArray[Any], like: xr.DataArray, *values: Any) -> Any:
    """Return the result with the labels of an array; a series where all labelled arguments were series."""
    import xarray as xr

    array = xr.DataArray(result, coords=like.coords, dims=like.dims)
    series = [hasattr(value, "to_xarray") for value in values if is_labelled(value)]
    return array.to_series() if series and all(series) else array


def label_map(result: NDArray[np.bool_], k: Any, delay: Any) -> xr.DataArray:
    """Return a stability map with the labels of its stiffnesses and delays."""
    import xarray as xr

    axes = [
        _as_xarray(name, value) if is_labelled(value) else xr.DataArray(np.atleast_1d(value), dims=name)
        for name, value in (("k", k), ("delay", delay))
    ]
    axes = [
        axis if axis.ndim else axis.expand_dims(name) for axis, name in zip(axes, ("k", "delay"), strict=True)
    ]
    dims = [str(axis.dims[0]) for axis in axes]
    if dims[0] == dims[1]:
        raise InvalidInput(
            "k, delay",
            f"two arrays over {dims[0]!r}",
            "a map has one dimension for the stiffness and another for the delay",
            "Rename one of them.",
        )
    # a dimension without labels of its own is labelled by the values
    coords = {
        dim: axis[dim] if dim in axis.indexes else axis.values for dim, axis in zip(dims, axes, strict=True)
    }
    return xr.DataArray(result, coords=coords, dims=dims)
