"""Global minimisation of a cheap function over a unit cube, on many slices of the cube at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from telespring._types import FloatArray

__all__ = ["minimise"]

Objective = Callable[[FloatArray], FloatArray]

#: Width of a round's box, relative to the one before.
_SHRINK = 0.5
#: Samples beyond a bound are moved onto it, so that an optimum there is found sooner.
_OVERHANG = 0.15


def minimise(
    objective: Objective,
    start: FloatArray,
    free: Sequence[int],
    *,
    first: int,
    further: int,
    rounds: int,
) -> tuple[FloatArray, FloatArray]:
    """Minimise by sampling the cube evenly, then repeatedly in smaller boxes around the best point so far.

    It needs no derivative and does not stop at a bound or in the first valley. The samples are Sobol's, so
    the same call returns the same result. The objective maps points (slice, sample, unknown) to values
    (slice, sample); `start` has one point per slice, whose unknowns that are not in `free` keep these values.
    `first` samples are over the whole cube, `further` ones in each of the later `rounds`.
    """
    from scipy.stats import qmc

    best = np.array(start, dtype=float)
    value = objective(best[:, None, :])[:, 0]
    if not free:
        return best, value
    chosen = list(free)
    cube = (1 + 2 * _OVERHANG) * qmc.Sobol(len(chosen), seed=0).random(max(first, further)) - _OVERHANG
    slices = np.arange(len(best))
    for step in range(rounds + 1):
        if step == 0:
            samples = np.broadcast_to(cube[:first], (len(best), first, len(chosen)))
        else:
            width = _SHRINK**step
            samples = best[:, None, chosen] + width * (cube[:further] - 0.5)
        points = np.repeat(best[:, None, :], samples.shape[1], axis=1)
        points[..., chosen] = np.clip(samples, 0.0, 1.0)
        values = objective(points)
        at = np.argmin(values, axis=1)
        better = values[slices, at] < value
        best[better], value[better] = points[slices, at][better], values[slices, at][better]
    return best, value
