"""qpmr: zero-level curves of the quasi-polynomial on a grid, then Newton."""

from __future__ import annotations

import logging
from typing import Any

import numpy as np
import qpmr as peer
from case import Case
from numpy.typing import NDArray

logging.getLogger("qpmr").setLevel(logging.ERROR)


def roots(
    case: Case, region: tuple[float, float, float, float] | None = None, **options: Any
) -> NDArray[Any]:
    """Roots in a rectangle (re, re, im, im), or in the one that it proposes itself."""
    square = np.polynomial.polynomial.polymul([case.k, case.b1, case.m1], [case.k, case.b2, case.m2])
    coefficients = np.zeros((2, 5))
    coefficients[0] = square
    coefficients[1, 0] = -(case.k**2)
    if region is not None:
        options["region"] = region
    found, _ = peer.qpmr(coefficients, np.array([0.0, 2 * case.delay]), **options)
    return np.asarray(found)
