"""Small experiments of known trials in the layout of a rehearsal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

FREQUENCY = 2.59  # rad/s, Eq. 12
RATE = 100.0  # Hz
PER_SAMPLE = ("condition", "trial", "time", "robot", "axis")


def figure_eight(time: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.stack([0.05 * np.sin(2.0 * FREQUENCY * time), 0.1 * np.sin(FREQUENCY * time)], axis=-1)


def experiment(
    position: NDArray[np.float64],
    conditions: Sequence[tuple[float, float]],
    discard: float = 0.0,
    **variables: Any,
) -> xr.Dataset:
    """Lay positions (condition, trial, time, robot, axis) out as a rehearsal does."""
    time = np.arange(position.shape[2]) / RATE
    labels = ["UM" if np.isnan(k) else f"CM-{k:.0f}-{1e3 * d:.0f}" for k, d in conditions]
    return xr.Dataset(
        {
            "position": (PER_SAMPLE, position, {"units": "m"}),
            "target": (("time", "axis"), figure_eight(time), {"units": "m"}),
            **variables,
        },
        coords={
            "condition": ("condition", labels),
            "stiffness": ("condition", [k for k, _ in conditions], {"units": "N/m"}),
            "delay": ("condition", [d for _, d in conditions], {"units": "s"}),
            "trial": ("trial", np.arange(1, position.shape[1] + 1)),
            "time": ("time", time, {"units": "s"}),
            "robot": ("robot", [1, 2]),
            "axis": ("axis", ["x", "y"]),
        },
        attrs={"discard": discard},
    )


def offsets(
    errors: NDArray[np.float64], conditions: Sequence[tuple[float, float]], duration: float = 2.0
) -> xr.Dataset:
    """Make trials whose tracking errors are exactly `errors` (condition, trial, robot), m."""
    time = np.arange(round(duration * RATE) + 1) / RATE
    turning = np.stack([np.cos(7.0 * time), np.sin(7.0 * time)], axis=-1)
    away = errors[:, :, None, :, None] * turning[:, None, :]
    return experiment(figure_eight(time)[:, None, :] + away, conditions)


def small(trials: int = 3, seed: int = 5) -> xr.Dataset:
    """Make a whole small rehearsal: every variable, one trial that diverged, one that is absent."""
    rng = np.random.default_rng(seed)
    conditions = [(np.nan, 0.0), (35.61599, 0.0), (35.61599, 0.16718632)]
    shape = (3, trials, 201, 2, 2)
    series = {name: rng.normal(0.0, 0.02, shape) for name in ("position", "velocity")}
    series |= {name: rng.normal(0.0, 2.0, shape) for name in ("coupling_force", "agent_force")}
    status = np.full(shape[:2], "completed")
    ended = np.full(shape[:2], np.nan)
    status[2, 1], ended[2, 1] = "diverged", 1.2345
    status[1, 2] = "absent"
    for values in series.values():
        values[2, 1, 124:] = np.nan
        values[1, 2] = np.nan
    seeds = rng.integers(0, 2**64, shape[:2], dtype=np.uint64)
    seeds[1, 2] = 0
    position = series.pop("position")
    units = {"velocity": "m/s", "coupling_force": "N", "agent_force": "N"}
    return experiment(
        position,
        conditions,
        discard=0.5,
        **{name: (PER_SAMPLE, values, {"units": units[name]}) for name, values in series.items()},
        status=(("condition", "trial"), status),
        ended_at=(("condition", "trial"), ended, {"units": "s"}),
        seed=(("condition", "trial"), seeds),
    )
