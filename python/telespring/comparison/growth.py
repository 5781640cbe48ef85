"""Which trials ran away: those that ended as diverged, and those whose error had not stopped growing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.analysis.trials import Trials

__all__ = ["GROWTH", "have_run_away", "quarter_errors"]

#: An error that grows by more than this factor from the first to the last quarter of a trial runs away.
GROWTH = 2.0


def quarter_errors(trials: Trials) -> FloatArray:
    """Return how far the handles are from the target in the first and last quarter of the analysed part.

    Returns
    -------
    numpy.ndarray
        Root mean square, m, over (condition, trial, robot, 2); NaN for a trial that was not completed.
    """
    squared = ((trials.position - trials.target[..., None, :]) ** 2).sum(axis=-1)
    place = np.cumsum(trials.window, axis=-1)
    count = place[..., -1:]
    quarter = np.maximum(count // 4, 1)
    errors = []
    for part in (place <= quarter, place > count - quarter):
        window = (trials.window & part)[..., None]
        with np.errstate(invalid="ignore"):
            errors.append(np.sqrt(np.where(window, squared, 0.0).sum(axis=2) / window.sum(axis=2)))
    return np.stack(errors, axis=-1)


def have_run_away(
    status: NDArray[np.str_], quarters: FloatArray, unconnected: FloatArray
) -> NDArray[np.bool_]:
    """Return which trials ran away.

    A spring that is unstable by little grows so slowly that a trial ends before a handle is 10 m away. It
    runs away all the same: in the last quarter of the analysed part a handle is more than twice as far from
    the target as in the first, and more than twice as far as without a partner at the same time. (The second
    condition keeps a target that becomes faster from looking like an unstable spring.)

    Parameters
    ----------
    status
        (…, trial): how each trial ended.
    quarters
        The result of `quarter_errors`, (…, trial, robot, 2).
    unconnected
        The same of trials without a partner, (trial, robot, 2).

    Returns
    -------
    numpy.ndarray
        (…, trial).

    Examples
    --------
    >>> alone = np.full((1, 2, 2), 0.02)
    >>> grown, steady = [[0.04, 0.09], [0.04, 0.05]], [[0.04, 0.05], [0.04, 0.05]]
    >>> have_run_away(np.array(["completed", "completed"]), np.array([grown, steady]), alone).tolist()
    [True, False]
    """
    first, last = quarters[..., 0], quarters[..., 1]
    finished = unconnected[np.isfinite(unconnected).all(axis=(1, 2))]
    alone = finished[..., 1].max(axis=0) if len(finished) else np.zeros(2)
    # NaN, of a trial that was not completed, is not larger.
    grows = (last > GROWTH * first) & (last > GROWTH * alone)
    return np.asarray((status == "diverged") | grows.any(axis=-1))
