"""Which trials ran away: those that ended as diverged, and those whose growth the coupling paid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.analysis.trials import Trials

__all__ = ["GROWTH", "PAID", "have_run_away", "paid_shares", "quarter_errors"]

#: An error that grows by more than this factor from the first to the last quarter of a trial runs away.
GROWTH = 2.0
#: A motion that runs away is paid by the coupling: it gives at least this share of what the robots' damping
#: takes. Under a passive strategy the people pay; the guard gives at most the share that it may spend, 0.7.
PAID = 0.85


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


def paid_shares(trials: Trials, damping: FloatArray, coulomb: FloatArray) -> FloatArray:
    """Return how much of what the robots' damping and friction took the coupling gave.

    Both in the analysed part after its first quarter: where a motion can have grown.

    Parameters
    ----------
    trials
        With velocities and coupling forces.
    damping, coulomb
        Of the robots, (robot, axis), N·s/m and N.

    Returns
    -------
    numpy.ndarray
        Over (condition, trial): 0 and less where the coupling gave nothing; about 1 where it paid for the
        motion; more where the people or their arms took energy from it, too. NaN for a trial that was not
        completed, or without motion.
    """
    assert trials.velocity is not None
    assert trials.coupling_force is not None
    place = np.cumsum(trials.window, axis=-1)
    later = trials.window & (place > np.maximum(place[..., -1:] // 4, 1))
    given = (trials.coupling_force * trials.velocity).sum(axis=(-2, -1))
    taken = (damping * trials.velocity**2 + coulomb * np.abs(trials.velocity)).sum(axis=(-2, -1))
    given, taken = (np.where(later, power, 0.0).sum(axis=-1) for power in (given, taken))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.where(taken > 0.0, given / taken, np.nan))


def have_run_away(
    status: NDArray[np.str_], quarters: FloatArray, unconnected: FloatArray, paid: FloatArray
) -> NDArray[np.bool_]:
    """Return which trials ran away.

    A spring that is unstable by little grows so slowly that a trial ends before a handle is 10 m away. It
    runs away all the same if three things hold. In the last quarter of the analysed part a handle is more
    than twice as far from the target as in the first; and more than twice as far as without a partner at the
    same time, so that a target that becomes faster does not look like an unstable spring; and the coupling
    paid for the motion, so that a network that fails late under a passive strategy does not.

    Parameters
    ----------
    status
        (…, trial): how each trial ended.
    quarters
        The result of `quarter_errors`, (…, trial, robot, 2).
    unconnected
        The same of trials without a partner, (trial, robot, 2).
    paid
        The result of `paid_shares`, (…, trial).

    Returns
    -------
    numpy.ndarray
        (…, trial).

    Examples
    --------
    >>> alone = np.full((1, 2, 2), 0.02)
    >>> grown, steady = [[0.04, 0.09], [0.04, 0.05]], [[0.04, 0.05], [0.04, 0.05]]
    >>> both = np.array(["completed", "completed"]), np.array([grown, steady]), alone
    >>> have_run_away(*both, paid=np.array([1.01, -0.2])).tolist()
    [True, False]
    >>> have_run_away(*both, paid=np.array([0.6, -0.2])).tolist()
    [False, False]
    """
    first, last = quarters[..., 0], quarters[..., 1]
    finished = unconnected[np.isfinite(unconnected).all(axis=(1, 2))]
    alone = finished[..., 1].max(axis=0) if len(finished) else np.zeros(2)
    # NaN, of a trial that was not completed, is not larger.
    grows = (last > GROWTH * first) & (last > GROWTH * alone)
    return np.asarray((status == "diverged") | (grows.any(axis=-1) & (paid >= PAID)))
