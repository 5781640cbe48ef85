"""The law of the guard in a trial: what both sides together may give out."""

from __future__ import annotations

import math

import numpy as np

from telespring._core import Experiment, Recording, Study
from telespring._types import FloatArray

__all__ = ["guard_spare", "law_stride"]

#: Rows of a finer recording at most, about 75 MB.
_MOST_ROWS = 300_000


def law_stride(experiment: Experiment) -> int:
    """Return every how many ticks a trial is recorded, so that the loss of the robots can be integrated.

    Each tick, unless the trial is very long: a light robot on a stiff spring swings within a few ticks,
    however few samples the protocol asks for. It divides the stride of the protocol's samples.
    """
    stride = experiment.tick_stride
    least = math.ceil(experiment.tick_count / _MOST_ROWS)
    return next((each for each in range(least, stride) if stride % each == 0), stride)


def guard_spare(recording: Recording, stiffness: float | None, experiment: Experiment, study: Study) -> float:
    """Compute what the guards could still have given out, J; below 0 their law is broken.

    NaN without a guard, as in the unconnected mode, and for a very long trial that ended early.

    The law is that of docs/guard.md, both sides together: what a side takes in the other has sent. A partner
    that lies about it adds what the intake lets through, and a force that is held longer than the account
    knows adds the overdraft. The damping is that of the robots of `study`, whatever the guards count on.
    """
    settings = study.session.guard_settings
    if settings is None or stiffness is None or len(recording.time) < 2:
        return float("nan")
    if recording.status != "completed" and recording.time[1] > 1.5 * experiment.sample_period:
        return float("nan")  # what a force gave is known at every tick only
    share, capacity, intake = settings
    damping = np.array([robot.damping for robot in study.dyad.robots])
    taken = float((damping * _squared_velocity(recording)).sum())
    lied = sum(each is not None and each.kind == "lying-peer" for each in study.adversaries)
    allowed = 2.0 * capacity + share * taken + lied * intake * float(recording.time[-1])
    return allowed + _overdraft(recording, stiffness, experiment) - _given_out(recording, experiment)


def _given_out(recording: Recording, experiment: Experiment) -> float:
    """Compute what the coupling gave out to both handles until the last row, J.

    Of a trial that ended early the last tick, in which a robot may run away, has no row.
    """
    if recording.status == "completed":
        return -recording.coupling_energy
    force = recording.coupling_force
    # a held force; behind a lag it goes from one value to the next
    held = 0.5 * (force[:-1] + force[1:]) if experiment.settings.actuator_lag > 0.0 else force[:-1]
    return float((held * np.diff(recording.position, axis=0)).sum())


def _overdraft(recording: Recording, stiffness: float, experiment: Experiment) -> float:
    """Compute how far the accounts of both sides may be overdrawn (paragraphs 4 and 5 of the proof), J."""
    settings, period = experiment.settings, experiment.sample_period
    held = period * (2.0 if settings.computing_tick else 1.0) + settings.actuator_lag
    mean_velocity = np.diff(recording.position, axis=0) / np.diff(recording.time)[:, None, None]
    fastest = [
        np.hypot(*np.moveaxis(each, -1, 0)).max(axis=0) for each in (recording.velocity, mean_velocity)
    ]
    moved = np.maximum(*fastest) * period + math.sqrt(2.0) * settings.encoder_resolution
    return float(0.5 * stiffness * (moved**2).sum() * (held / period) ** 2)


def _squared_velocity(recording: Recording) -> FloatArray:
    """Integrate the squared velocity of each robot and axis over a trial, m²/s.

    Between two rows the velocity is the quadratic function that has it at both, and moves the handle as far.
    """
    step = np.diff(recording.time)[:, None, None]
    before, after = recording.velocity[:-1], recording.velocity[1:]
    middle = 1.5 * np.diff(recording.position, axis=0) / step - 0.25 * (before + after)
    squares = (
        2.0 * (before**2 + after**2) + 8.0 * middle**2 + 2.0 * middle * (before + after) - before * after
    )
    return np.asarray((step * squares).sum(axis=0) / 15.0)
