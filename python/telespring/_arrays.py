"""Numbers and arrays as callers pass them: checked, or refused by their name."""

from __future__ import annotations

import operator
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from telespring._errors import InvalidInput
from telespring._types import FloatArray


def unmasked(value: Any) -> Any:
    """Return an array with NaN for masked values, also one of a list of masked arrays; all else as it is.

    `numpy.asarray` drops the mask, and then what was masked for being wrong counts as right.

    Examples
    --------
    >>> unmasked(np.ma.array([1, 999], mask=[False, True])).tolist()
    [1.0, nan]
    """
    if isinstance(value, list | tuple) and any(isinstance(part, np.ma.MaskedArray) for part in value):
        value = np.ma.array(value)
    if not isinstance(value, np.ma.MaskedArray):
        return value
    if value.dtype.kind not in "biufc" or not np.ma.is_masked(value):
        return value.data
    return np.ma.filled(value.astype(np.complex128 if value.dtype.kind == "c" else np.float64), np.nan)


def as_numbers(name: str, value: ArrayLike) -> FloatArray:
    """Return the argument as an array of doubles, NaN where it is masked, or refuse it by its name.

    Truth values are refused: Python counts them as 1 and 0, but who passes one has mixed up two arguments.
    """
    try:
        given = np.asarray(unmasked(value))
        if given.dtype.kind not in "iuf" or _holds_truth_value(value):
            raise TypeError
        return given.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        raise InvalidInput(
            name,
            quoted_value(value),
            "a real number or an array of real numbers is required",
            "Convert it, for instance with numpy.asarray(..., dtype=float).",
        ) from None


def _holds_truth_value(value: object) -> bool:
    if isinstance(value, list | tuple):
        return any(map(_holds_truth_value, value))
    return isinstance(value, bool | np.bool_) or (isinstance(value, np.ndarray) and value.dtype.kind == "b")


def quoted_value(value: object) -> str:
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
            "one number is required here",
            "Call the function once for each element.",
        )
    return float(number.reshape(())[()])


def as_whole_number(name: str, value: SupportsIndex) -> int:
    """Return the argument as a whole number of 1 or more, or refuse it by its name."""
    try:
        number = 0 if isinstance(value, bool) else operator.index(value)
    except TypeError:
        number = 0
    if number < 1 or number >= 2**63:
        raise InvalidInput(
            name, quoted_value(value), "a whole number of 1 or more is required", "Give an int."
        )
    return number


def as_vector(name: str, value: ArrayLike) -> FloatArray:
    """Return the argument as a contiguous row of numbers; one number is a row of one."""
    numbers = as_numbers(name, value)
    if numbers.ndim > 1:
        raise InvalidInput(
            name,
            f"an array of shape {numbers.shape}",
            "one number or a one-dimensional array is required here",
            "Flatten it with numpy.ravel.",
        )
    return np.ascontiguousarray(numbers).reshape(-1)
