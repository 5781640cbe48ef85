"""Logs for identification made from closed forms, with the faults that real ones have."""

from __future__ import annotations

import numpy as np

from telespring._types import FloatArray
from telespring.identification import Excitation, paper_excitation

#: Mass, kg, and damping, N·s/m, of the axes x and y.
TRUTH = ((0.8334, 7.7257), (1.0649, 10.1168))


def made_log(
    random: np.random.Generator,
    *,
    rate: float = 1000.0,
    seconds: float = 20.0,
    movement: Excitation | None = None,
    spring: float = 0.0,
    lag: float = 0.0,
    zeros: float = 0.0,
    coulomb: float = 0.0,
    stiction: float = 0.0,
    drag: float = 0.0,
    uneven_damping: float = 0.0,
    gravity: float = 0.0,
    radius: float = 1.0,
    noise: float = 0.1,
    scale: float = 1.0,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return time (s), position (m) and force (N) of two axes, y a quarter of a period after x.

    The encoder has steps of 20 µm and a backlash of 5 µm. `zeros` is the share of the samples of the force on
    x that read 0, `lag` (s) the delay of the force, `stiction` (N) decays within 0.02 m/s, and
    `uneven_damping` is in N·s/m². `scale` is the gain of the force sensor.
    """
    command = movement or paper_excitation()
    time = np.arange(round(seconds * rate)) / rate
    positions, forces = [], []
    for i, (mass, damping) in enumerate(TRUTH):
        shift = 0.25 * i * command.period
        acted = time - lag - shift
        p, v = command.position(acted), command.velocity(acted)
        force = (
            mass * command.acceleration(acted)
            + (damping + uneven_damping * p) * v
            + spring * (p - 0.01)
            + drag * v * np.abs(v)
            + np.sign(v) * (coulomb + stiction * np.exp(-((v / 0.02) ** 2)))
            + gravity * np.sin(p / radius)
        )
        forces.append(scale * force + random.normal(0.0, noise, time.size))
        played = command.position(time - shift) + random.normal(0.0, 5e-6, time.size)
        positions.append(np.round((played + random.uniform(0.0, 2e-5)) / 2e-5) * 2e-5)
    position, force = np.column_stack(positions), np.column_stack(forces)
    force[random.random(time.size) < zeros, 0] = 0.0
    return time, position, force
