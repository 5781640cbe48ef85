"""The trials of an experiment with their seeds, in the order in which they are run."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

from telespring._core import Experiment, trial_seed

__all__ = ["ScheduledTrial", "schedule_trials"]


@dataclass(frozen=True)
class ScheduledTrial:
    """One trial of an experiment.

    Attributes
    ----------
    condition, trial
        Its place in the dataset, from 0.
    seed
        The seed of all its random numbers.
    order
        Its place in the order of running, from 0.
    """

    condition: int
    trial: int
    seed: int
    order: int


def schedule_trials(experiment: Experiment) -> list[ScheduledTrial]:
    """List all trials in the order of running: condition by condition, or shuffled by the seed.

    Shuffled trials are sorted by a hash of seed, condition and trial, so that the order does not depend on
    the random generator of a library.
    """
    places = [
        (condition, trial)
        for condition in range(len(experiment.conditions))
        for trial in range(experiment.trials)
    ]
    if experiment.order == "shuffled":
        places.sort(key=lambda place: _shuffling_hash(experiment.seed, *place))
    return [
        ScheduledTrial(condition, trial, trial_seed(experiment.seed, condition, trial), order)
        for order, (condition, trial) in enumerate(places)
    ]


def _shuffling_hash(seed: int, condition: int, trial: int) -> bytes:
    return hashlib.blake2b(f"order {seed} {condition} {trial}".encode(), digest_size=16).digest()
