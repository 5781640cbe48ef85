"""tdcpy: spectral discretisation with Newton correction."""

from __future__ import annotations

import logging

import numpy as np
import tdcpy as peer
from case import Case
from numpy.typing import NDArray

logging.getLogger("tdcpy").setLevel(logging.ERROR)


def roots(case: Case, right_of: float) -> NDArray[np.complex128]:
    """All roots right of a line; s = 0 among them."""
    a, b, _ = case.matrices
    system = peer.RDDE(np.stack([a, b], axis=2), np.array([0.0, case.delay]))
    found, _ = peer.roots(system, r=float(right_of))
    return np.asarray(found)
