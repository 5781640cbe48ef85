"""Whether a handle's coordinates are those of the target: unit, order and sign of the axes, origin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray

__all__ = ["CENTIMETRES", "DOUBTS", "MILLIMETRES", "CoordinateFault", "Doubt", "find_coordinate_fault"]

#: A handle that travels so many times as far as the target, or its inverse, is in another unit; from these
#: factors on probably in cm, and in mm.
_SCALE, CENTIMETRES, MILLIMETRES = 8.0, 30.0, 300.0
#: A centre of the path so far from the target's, in extents of the target, is another origin.
_OFFSET = 0.25
#: Other axes explain the path if they correlate with the target at least so well, and so much better than the
#: recorded ones. (A periodic target resembles itself mirrored and shifted.)
_RIGHT, _BETTER = 0.7, 0.35
#: A person follows within so many seconds.
_LAG = 0.6
#: Swaps and mirrors of the axes, in the words of the warning.
_TRANSFORMS = {
    "the x axis is mirrored": ((0, -1.0), (1, 1.0)),
    "the y axis is mirrored": ((0, 1.0), (1, -1.0)),
    "both axes are mirrored": ((0, -1.0), (1, -1.0)),
    "x and y are swapped": ((1, 1.0), (0, 1.0)),
    "x and y are swapped and then x is mirrored": ((1, -1.0), (0, 1.0)),
    "x and y are swapped and then y is mirrored": ((1, 1.0), (0, -1.0)),
    "x and y are swapped and then both are mirrored": ((1, -1.0), (0, -1.0)),
}


Doubt: TypeAlias = Literal["scale", "axes", "offset"]
DOUBTS: tuple[Doubt, ...] = get_args(Doubt)


@dataclass(frozen=True)
class CoordinateFault:
    """A doubt about coordinates: travel per target's travel, the axes in words, or the offset in m."""

    kind: Doubt
    value: float | str


def find_coordinate_fault(path: FloatArray, target: FloatArray, step: float) -> CoordinateFault | None:
    """Compare a path with its target, both (sample, axis) in m at samples `step` (s) apart."""
    extent = float(np.ptp(target, axis=0).max())
    centred, goal = path - path.mean(axis=0), target - target.mean(axis=0)
    travel, wanted = (float(np.sqrt((values**2).mean())) for values in (centred, goal))
    if extent == 0.0 or travel == 0.0:
        return None
    ratio = travel / wanted
    if not 1.0 / _SCALE < ratio < _SCALE:
        return CoordinateFault("scale", ratio)
    as_recorded = _correlation(centred, goal, ((0, 1.0), (1, 1.0)), step)
    if as_recorded < 1.0 - _BETTER:
        others = {words: _correlation(centred, goal, axes, step) for words, axes in _TRANSFORMS.items()}
        words, best = max(others.items(), key=lambda item: item[1])
        if best > max(_RIGHT, as_recorded + _BETTER):
            return CoordinateFault("axes", words)
    offset = float(np.hypot(*(path - target).mean(axis=0)))
    return CoordinateFault("offset", offset) if offset > _OFFSET * extent else None


def _correlation(
    path: FloatArray, target: FloatArray, axes: tuple[tuple[int, float], tuple[int, float]], step: float
) -> float:
    """Correlate a path, its axes taken in another order and sign, with the target at the best lag.

    The axes count alike, however far the target moves along them; one along which it stays does not count.
    """
    longest = min(round(_LAG / step), len(path) // 2)
    lags = np.arange(0, longest + 1, max(1, longest // 30))
    total, count = np.zeros(len(lags)), 0
    for (axis, sign), goal in zip(axes, target.T, strict=True):
        if np.ptp(goal) > 1e-9 * float(np.ptp(target)):
            total += sign * _correlations_at(np.ascontiguousarray(path[:, axis]), goal.copy(), lags)
            count += 1
    return max(-1.0, float(total.max()) / count)


def _correlations_at(path: FloatArray, target: FloatArray, lags: NDArray[np.intp]) -> FloatArray:
    """Correlate a path with a target that is so many samples earlier; 0 where one of both rests at 0."""
    size = len(path)
    products = np.array([np.dot(path[lag:], target[: size - lag]) for lag in lags.tolist()])
    # what is left of both sums of squares where their ends do not overlap
    late, early = (path**2)[::-1].cumsum()[::-1][lags], (target**2).cumsum()[size - 1 - lags]
    sizes = np.sqrt(late * early)
    return np.asarray(products / np.where(sizes > 0.0, sizes, np.inf))
