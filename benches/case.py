"""What all are asked: the paper's two robots under the forces of its Fig. 5."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

REFERENCE_STIFFNESS = 35.615988  # K_xy, N/m
REFERENCE_DELAY = 0.167  # Δ_xy, s
RATE = 1000.0  # Hz


@dataclass(frozen=True)
class Case:
    """One axis of two robots that push against each other with 1 N from t = 0 on."""

    m1: float
    b1: float
    m2: float
    b2: float
    k: float
    delay: float
    duration: float = 10.0

    @property
    def count(self) -> int:
        return round(self.duration * RATE) + 1

    @property
    def times(self) -> NDArray[np.float64]:
        return np.arange(self.count) / RATE

    @property
    def matrices(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """A, B and f of y' = A y(t) + B y(t - delay) + f, with y = (x1, v1, x2, v2)."""
        m1, b1, m2, b2, k = self.m1, self.b1, self.m2, self.b2, self.k
        a = np.array([[0, 1, 0, 0], [-k / m1, -b1 / m1, 0, 0], [0, 0, 0, 1], [0, 0, -k / m2, -b2 / m2]])
        b = np.zeros((4, 4))
        b[1, 2], b[3, 0] = k / m1, k / m2
        return a, b, np.array([0, 1 / m1, 0, -1 / m2])


HMAN = {"x": (0.8334, 7.7257, 0.7776, 7.4208), "y": (1.0649, 10.1168, 1.3407, 9.3496)}


def main_case(duration: float = 10.0) -> Case:
    """Axis x, 2 K_xy, 0.167 s."""
    return Case(*HMAN["x"], 2 * REFERENCE_STIFFNESS, REFERENCE_DELAY, duration)


def figure_5(duration: float = 10.0) -> list[Case]:
    """Four stiffnesses by four delays by two axes, in the order of the Rust program."""
    return [
        Case(*HMAN[axis], factor * REFERENCE_STIFFNESS, part * REFERENCE_DELAY, duration)
        for axis in "xy"
        for factor in (0.5, 1.0, 2.0, 4.0)
        for part in (0.0, 0.5, 1.0, 2.0)
    ]
