"""Results as JSON: only what `json.dumps(..., allow_nan=False)` takes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

__all__ = ["finite_or_none", "json_ready"]


def finite_or_none(value: float) -> float | None:
    """Return the number, or None if it is infinite or not a number: JSON has neither."""
    return float(value) if math.isfinite(value) else None


def json_ready(value: Any) -> Any:
    """Convert records, tuples and arrays to dicts and lists, and numbers that JSON lacks to None.

    A complex number becomes the pair of its real and imaginary part.
    """
    if isinstance(value, float):
        return finite_or_none(value)
    if isinstance(value, complex):
        return [finite_or_none(value.real), finite_or_none(value.imag)]
    if isinstance(value, np.ndarray | np.generic):
        return json_ready(value.tolist())
    if isinstance(value, list | tuple):
        return [json_ready(item) for item in value]
    if isinstance(value, dict):
        return {name: json_ready(item) for name, item in value.items()}
    return value.to_dict() if hasattr(value, "to_dict") else value
