"""The lowest point of a cheap function over a unit cube, on many slices of the cube at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from telespring._types import FloatArray

__all__ = ["lowest"]

Objective = Callable[[FloatArray], FloatArray]

#: A round's box is this much smaller than the one before.
_SHRINK = 0.5
#: Samples beyond a bound are moved onto it: an optimum there is found sooner.
_OVERHANG = 0.15


def lowest(
    objective: Objective,
    start: FloatArray,
    free: Sequence[int],
    *,
    first: int,
    further: int,
    rounds: int,
) -> tuple[FloatArray, FloatArray]:
    """Minimise by sampling evenly, then again and again around the best point so far.

    No derivative is needed, nothing stops at a bound or in the first valley, and the same call gives the
    same answer: the samples are Sobol's.

    Parameters
    ----------
    objective
        Takes points (slice, sample, unknown), gives (slice, sample).
    start
        One point per slice (slice, unknown); what is not free stays as it is there.
    free
        Places of the unknowns that may move.
    first, further, rounds
        Samples over the whole cube, samples of a later round, and how many of these there are.

    Returns
    -------
    tuple of ndarray
        The best points (slice, unknown) and their values (slice,).
    """
    from scipy.stats import qmc

    best = np.array(start, dtype=float)
    value = objective(best[:, None, :])[:, 0]
    if not free:
        return best, value
    chosen = list(free)
    cube = (1 + 2 * _OVERHANG) * qmc.Sobol(len(chosen), seed=0).random(max(first, further)) - _OVERHANG
    every = np.arange(len(best))
    for turn in range(rounds + 1):
        if turn == 0:
            offered = np.broadcast_to(cube[:first], (len(best), first, len(chosen)))
        else:
            width = _SHRINK**turn
            offered = best[:, None, chosen] + width * (cube[:further] - 0.5)
        points = np.repeat(best[:, None, :], offered.shape[1], axis=1)
        points[..., chosen] = np.clip(offered, 0.0, 1.0)
        values = objective(points)
        at = np.argmin(values, axis=1)
        better = values[every, at] < value
        best[better], value[better] = points[every, at][better], values[every, at][better]
    return best, value
