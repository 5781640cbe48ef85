"""From what a caller passes to the flat columns the core computes on, and back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from telespring._errors import InvalidInput
from telespring._types import FloatArray

Columns: TypeAlias = dict[str, FloatArray]
Number = TypeVar("Number", bound=np.generic)


def as_numbers(name: str, value: ArrayLike) -> FloatArray:
    """Return the argument as an array of doubles, or refuse it by its name."""
    try:
        given = np.asarray(value)
        if given.dtype.kind not in "biuf":
            raise TypeError
        return given.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        raise InvalidInput(
            name,
            written(value),
            "a real number or an array of real numbers is needed",
            "Convert it, for instance with numpy.asarray(..., dtype=float).",
        ) from None


def written(value: object) -> str:
    """Return the value as Python writes it, cut to a length that fits a message."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def as_number(name: str, value: ArrayLike) -> float:
    """Return the argument as one number, or refuse it by its name."""
    number = as_numbers(name, value)
    if number.size != 1:
        raise InvalidInput(
            name,
            f"an array of shape {number.shape}",
            "one number is needed here",
            "Call the function once for each element.",
        )
    return float(number.reshape(())[()])


def as_vector(name: str, value: ArrayLike) -> FloatArray:
    """Return the argument as a contiguous row of numbers; one number is a row of one."""
    numbers = as_numbers(name, value)
    if numbers.ndim > 1:
        raise InvalidInput(
            name,
            f"an array of shape {numbers.shape}",
            "one number or a one-dimensional array is needed here",
            "Flatten it with numpy.ravel.",
        )
    return np.ascontiguousarray(numbers).reshape(-1)


def over_arrays(
    compute: Callable[[Columns], NDArray[Number]], arguments: Mapping[str, ArrayLike]
) -> NDArray[Number]:
    """Broadcast the arguments, compute on flat columns, and give the result its shape back.

    The shape is () where every argument is a single number.

    Columns of length one stay that way: a map over two parameters holds two large arrays, not nine.
    """
    arrays = {name: as_numbers(name, value) for name, value in arguments.items()}
    try:
        shape = np.broadcast_shapes(*(array.shape for array in arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items() if array.ndim)
        raise InvalidInput(
            ", ".join(name for name, array in arrays.items() if array.ndim),
            shapes,
            "shapes must broadcast against each other",
            "Give them the same shape, or add axes of length one.",
        ) from None
    columns = {
        name: array.reshape(1)
        if array.size == 1
        else np.ascontiguousarray(np.broadcast_to(array, shape)).reshape(-1)
        for name, array in arrays.items()
    }
    try:
        result = compute(columns)
    except InvalidInput as refused:
        raise _placed(refused, arrays, shape) from None
    return result.reshape(shape)


def _placed(refused: InvalidInput, arrays: Mapping[str, FloatArray], shape: tuple[int, ...]) -> InvalidInput:
    """Name the element of the caller's own array that was refused."""
    array = arrays.get(refused.field)
    if array is None or array.ndim == 0 or refused._index is None:
        return refused
    across = np.unravel_index(refused._index, shape)[len(shape) - array.ndim :]
    own = (0 if length == 1 else int(i) for i, length in zip(across, array.shape, strict=True))
    return refused.at(f"{refused.field}[{', '.join(map(str, own))}]")
