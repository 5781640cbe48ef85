"""The laboratory with lumped arms a second time, in NumPy alone, all trials at once.

Per axis and side one mass with viscous damping and Coulomb friction under a force that is held for one
period of the controllers. Such a motion has a closed form: while it slides with the sign s of its velocity,
v(t) = w + (v0 - w) exp(-b t/m) with w = (u - c s)/b; it stops once at most within the period, and from rest
it either stays (|u| <= c) or leaves with the sign of u and then never stops again under the same u.

Nothing here imports telespring. Axes of every array: trial, robot, axis (x, y).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TABLE_III_MASS = np.array([[0.8334, 1.0649], [0.7776, 1.3407]])  # robot, axis
TABLE_III_DAMPING = np.array([[7.7257, 10.1168], [7.4208, 9.3496]])


def figure_eight(time: Floats, amplitude: tuple[float, float] = (0.05, 0.1), rate: float = 2.59) -> Floats:
    """Return the target of Eq. 12, (..., axis), m."""
    return np.stack([amplitude[0] * np.sin(2 * rate * time), amplitude[1] * np.sin(rate * time)], axis=-1)


@dataclass(frozen=True)
class Setup:
    """The contents of the laboratory, SI units; arrays are (robot, axis) or broadcast to it."""

    mass: Floats = field(default_factory=lambda: TABLE_III_MASS)
    damping: Floats = field(default_factory=lambda: TABLE_III_DAMPING)
    coulomb: Floats = field(default_factory=lambda: np.zeros((2, 2)))
    agent_stiffness: float = 120.0
    spots: int = 10
    spot_velocity: float = 0.3
    spot_lifetime: float = 0.2
    sample_period: float = 1e-3
    start: Floats = field(default_factory=lambda: np.zeros((2, 2)))


@dataclass(frozen=True)
class Motion:
    """What happened: time (n,), target (n, axis), position and velocity (trial, n, robot, axis)."""

    time: Floats
    target: Floats
    position: Floats
    velocity: Floats

    def tracking_error(self, discard: float) -> Floats:
        """Return the mean distance to the target from `discard` (s) on, (trial, robot), m."""
        kept = self.time >= discard - 1e-9
        apart = self.position[:, kept] - self.target[kept][:, None, :]
        return np.asarray(np.linalg.norm(apart, axis=-1).mean(axis=1))


def slide(
    force: Floats, velocity: Floats, mass: Floats, damping: Floats, coulomb: Floats, period: float
) -> tuple[Floats, Floats]:
    """Return how far each mass moves within a period, m, and its velocity at the end, m/s."""

    def free(push: Floats, v0: Floats, time: Floats) -> tuple[Floats, Floats]:
        """Move under a constant push, v' = (push - b v)/m."""
        rate = damping / mass
        x = rate * time
        # (1 - exp(-x))/x and what is left of it, by series where x is small; zero damping included
        tiny = np.abs(x) < 1e-4
        safe = np.where(tiny, 1.0, x)
        first = np.where(tiny, 1 - x / 2 + x**2 / 6 - x**3 / 24, -np.expm1(-safe) / safe)
        second = np.where(
            np.abs(x) < 1e-2,
            0.5 - x / 6 + x**2 / 24 - x**3 / 120 + x**4 / 720 - x**5 / 5040,
            (safe + np.expm1(-safe)) / safe**2,
        )
        moved = v0 * time * first + push / mass * time**2 * second
        return moved, v0 * np.exp(-x) + push / mass * time * first

    moving = velocity != 0.0
    sign = np.where(moving, np.sign(velocity), np.where(np.abs(force) > coulomb, np.sign(force), 0.0))
    push = force - coulomb * sign
    whole = np.full_like(velocity, period)
    # the time at which a sliding mass stops: exp(-b t/m) = push/(push - b v), where push is against v
    against = moving & (push * sign < 0.0)
    ratio = np.where(against, damping * velocity / np.where(against, -push, 1.0), 0.0)
    stop = np.where(
        against,
        np.where(
            ratio > 0,
            mass / np.where(damping > 0, damping, 1.0) * np.log1p(ratio),
            mass * velocity / np.where(against, -push, 1.0),
        ),
        np.inf,
    )
    stops = stop < period
    until = np.where(stops, stop, whole)
    moved, after = free(push, velocity, until)
    stuck = sign == 0.0
    moved, after = np.where(stuck, 0.0, moved), np.where(stuck | stops, 0.0, after)
    # what stops goes on the other way if the force is more than friction
    leaves = stops & (np.abs(force) > coulomb)
    again, leaving = free(force - coulomb * np.sign(force), np.zeros_like(velocity), period - until)
    return moved + np.where(leaves, again, 0.0), np.where(leaves, leaving, after)


def simulate(
    setup: Setup,
    stiffness: float | None,
    delay: float,
    duration: float,
    trials: int = 1,
    random: np.random.Generator | None = None,
) -> Motion:
    """Run trials of one condition.

    Parameters
    ----------
    setup
        The laboratory.
    stiffness
        Of the virtual spring, N/m; None is the unconnected mode.
    delay
        One way, s. The partner's position is interpolated linearly between its samples; what is older
        than the start of a trial has not arrived, and the coupling force is zero until something has.
    duration
        s.
    trials
        How many.
    random
        Where the spots' velocities come from; None for spots that do not move.
    """
    period = setup.sample_period
    ticks = round(duration / period)
    time = np.asarray(period * np.arange(ticks + 1), dtype=np.float64)
    target = figure_eight(time)
    position = np.empty((trials, ticks + 1, 2, 2))
    velocity = np.zeros((trials, ticks + 1, 2, 2))
    position[:, 0] = setup.start
    mass, damping, coulomb = (
        np.broadcast_to(each, (trials, 2, 2)) for each in (setup.mass, setup.damping, setup.coulomb)
    )
    # spot i begins at age i/N of its life, so that one is renewed every lifetime/N
    age = setup.spot_lifetime * np.arange(setup.spots) / setup.spots
    drift = np.zeros((trials, setup.spots, 2))
    if random is not None:
        drift = setup.spot_velocity * random.standard_normal(drift.shape)
    back = delay / period
    for n in range(ticks):
        p = position[:, n]
        aim = np.broadcast_to(target[n], p.shape).copy()
        if random is not None:
            aim[:, 1] += (drift * age[:, None]).mean(axis=1)
            age = age + period
            for i in np.flatnonzero(age > setup.spot_lifetime - 1e-9):
                age[i] -= setup.spot_lifetime
                drift[:, i] = setup.spot_velocity * random.standard_normal((trials, 2))
        force = setup.agent_stiffness * (aim - p)
        if stiffness is not None and n - back >= -1e-9:
            at = max(n - back, 0.0)
            low = min(int(at + 1e-9), n)
            part = max(at - low, 0.0)
            arrived = position[:, low]
            if part > 1e-9:
                arrived = (1 - part) * arrived + part * position[:, low + 1]
            force += stiffness * (arrived[:, ::-1] - p)
        moved, velocity[:, n + 1] = slide(force, velocity[:, n], mass, damping, coulomb, period)
        position[:, n + 1] = p + moved
    return Motion(time, target, position, velocity)
