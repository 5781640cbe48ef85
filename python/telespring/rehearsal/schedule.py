"""Which trials a protocol has, under which labels and seeds, and in which order they are run."""

from __future__ import annotations

import hashlib
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from telespring import _core
from telespring._types import FloatArray

if TYPE_CHECKING:
    from telespring._core import Experiment

__all__ = [
    "Trial",
    "condition_labels",
    "sample_count",
    "sample_times",
    "schedule",
    "tick_count",
    "tick_stride",
]


@dataclass(frozen=True)
class Trial:
    """One trial of a protocol.

    Attributes
    ----------
    condition, trial
        Its place in the dataset, from 0.
    seed
        From which everything random in it is drawn.
    order
        Its place in the order of running, from 0.
    """

    condition: int
    trial: int
    seed: int
    order: int


def schedule(experiment: Experiment) -> list[Trial]:
    """List all trials of a protocol in the order of running.

    Parameters
    ----------
    experiment
        The study's protocol.

    Returns
    -------
    list of Trial
        Condition after condition, or shuffled by the protocol's seed.

    Notes
    -----
    Shuffled trials are sorted by a hash of seed, condition and trial, so that the order depends on
    no generator whose stream another version of a library could change.
    """
    places = [
        (condition, trial)
        for condition in range(len(experiment.conditions))
        for trial in range(experiment.trials)
    ]
    if experiment.order == "shuffled":
        places.sort(key=lambda place: _lot(experiment.seed, *place))
    return [
        Trial(condition, trial, _core.trial_seed(experiment.seed, condition, trial), order)
        for order, (condition, trial) in enumerate(places)
    ]


def _lot(seed: int, condition: int, trial: int) -> bytes:
    return hashlib.blake2b(f"order {seed} {condition} {trial}".encode(), digest_size=16).digest()


def tick_count(experiment: Experiment) -> int:
    """Return how many periods of the controllers a trial has."""
    # 0.29 s at 1 kHz has 290, though the quotient rounds to 289.999...
    exact = experiment.duration / experiment.sample_period
    return math.floor(exact * (1.0 + 4.0 * sys.float_info.epsilon))


def tick_stride(experiment: Experiment) -> int:
    """Return every how many ticks of the controllers a row is kept."""
    return round(1.0 / (experiment.record_rate * experiment.sample_period))


def sample_count(experiment: Experiment) -> int:
    """Return how many rows are kept of a completed trial, the first at t = 0."""
    return tick_count(experiment) // tick_stride(experiment) + 1


def sample_times(experiment: Experiment) -> FloatArray:
    """Return when the rows are kept, s: at ticks of the controllers."""
    ticks = tick_stride(experiment) * np.arange(sample_count(experiment), dtype=np.float64)
    # A division by the rate gives 0.35 s at 1 kHz as it is written.
    return ticks / (1.0 / experiment.sample_period)


def condition_labels(conditions: Sequence[tuple[float | None, float]]) -> list[str]:
    """Name every condition as the paper does, by whole N/m and ms where that tells them apart.

    Parameters
    ----------
    conditions
        Stiffness, N/m (None: unconnected), and one-way delay, s.

    Returns
    -------
    list of str
        "UM" for the unconnected mode, else such as "CM-36-167". All are different: where rounding
        would make two alike, digits are added, and a condition that is really repeated is counted.

    Examples
    --------
    >>> condition_labels([(None, 0.0), (35.616, 0.0), (35.616, 0.16719)])
    ['UM', 'CM-36-0', 'CM-36-167']
    >>> condition_labels([(35.6, 0.1), (36.2, 0.1), (36.2, 0.1)])
    ['CM-35.6-100.0', 'CM-36.2-100.0', 'CM-36.2-100.0 (2)']
    """
    different = len({(k, delay if k is not None else 0.0) for k, delay in conditions})
    for digits in range(13):
        labels = [_label(k, delay, digits) for k, delay in conditions]
        if len(set(labels)) == different:
            break
    counted: dict[str, int] = {}
    found = []
    for label in labels:
        counted[label] = counted.get(label, 0) + 1
        found.append(label if counted[label] == 1 else f"{label} ({counted[label]})")
    return found


def _label(stiffness: float | None, delay: float, digits: int) -> str:
    return "UM" if stiffness is None else f"CM-{stiffness:.{digits}f}-{1e3 * delay:.{digits}f}"
