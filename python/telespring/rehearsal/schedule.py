"""Which trials a protocol has, under which labels and seeds, and in which order they are run."""

from __future__ import annotations

import hashlib
import math
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from telespring import _core
from telespring._types import FloatArray

if TYPE_CHECKING:
    from telespring._core import Experiment

__all__ = [
    "Trial",
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
