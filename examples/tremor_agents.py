"""An agent with a tremor and a target on a circle, for tremor.toml."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


class Tremor:
    """A spring to the target plus a tremor: narrow-band noise around one frequency.

    Parameters
    ----------
    seed
        Seed of this trial; every random number is drawn from it.
    stiffness
        Stiffness of the spring to the target, N/m.
    frequency
        Centre frequency of the tremor, Hz.
    amplitude
        Root mean square of the tremor on each axis, N.
    """

    def __init__(self, seed: int, stiffness: float, frequency: float, amplitude: float) -> None:
        random = np.random.default_rng(seed)
        self.stiffness = stiffness
        # Eight sines within half a hertz of it, with random phases: the amplitude of the tremor varies.
        self.rate = 2 * np.pi * (frequency + random.uniform(-0.5, 0.5, size=(8, 2)))  # rad/s
        self.phase = random.uniform(0, 2 * np.pi, size=(8, 2))  # rad
        self.each = amplitude * np.sqrt(2 / 8)  # N

    def __call__(self, time: float, position: Vector, velocity: Vector, target: Vector) -> Vector:
        """Return the force, N, at a tick of the controllers, from arguments in s, m, m/s and m."""
        del velocity  # this hand has no damping
        tremor = self.each * np.sin(self.rate * time + self.phase).sum(axis=0)
        return self.stiffness * (target - position) + tremor


def circle(times: Vector, radius: float, period: float) -> Vector:
    """Return the target's positions, m, at all ticks of a trial, s."""
    angle = 2 * np.pi * times / period
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
