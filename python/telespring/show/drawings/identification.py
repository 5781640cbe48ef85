"""The figures of an identification, from its results."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from telespring.identification.covariance import NORMAL_HALF_WIDTH
from telespring.show.figures.identification import (
    ExcitationPanel,
    RegressionPanel,
    ResidualPanel,
    excitation_figure,
    regression_figure,
    residual_figure,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from telespring.identification import Excitation, Identification

__all__ = ["draw_excitation", "draw_regression", "draw_residuals"]

#: Lags of the autocorrelation that are drawn, 0 included.
_LAGS = 31


def draw_excitation(movements: Sequence[tuple[str, Excitation]]) -> Figure:
    """Draw one period of each movement, with its name above it (Fig. 9)."""
    panels = []
    for name, movement in movements:
        time = np.linspace(0.0, movement.period, 801)
        position, velocity, acceleration = (
            np.asarray(quantity(time), dtype=float)
            for quantity in (movement.position, movement.velocity, movement.acceleration)
        )
        panels.append(ExcitationPanel(name, time, position, velocity, acceleration))
    return excitation_figure(panels)


def draw_regression(robots: Sequence[tuple[str, Identification]]) -> Figure:
    """Draw the fit of each named robot, axis by axis (Fig. 10)."""
    return regression_figure(
        [
            RegressionPanel(
                label=f"{name}, axis {axis.axis}",
                time=robot.signals.time,
                measured=axis.measured_force,
                estimated=axis.estimated_force,
                residual=axis.residual,
                velocity=robot.signals.velocity[axis.signals_index],
                acceleration=robot.signals.acceleration[axis.signals_index],
                mass=(axis.mass.value, *axis.mass.interval),
                damping=(axis.damping.value, *axis.damping.interval),
            )
            for name, robot in robots
            for axis in robot.axes
        ]
    )


def draw_residuals(identification: Identification) -> Figure:
    """Draw the residuals of an identification, axis by axis."""
    time = identification.signals.time
    panels = []
    for axis in identification.axes:
        lags = np.arange(min(_LAGS, axis.residual.size // 4))
        centred = axis.residual - axis.residual.mean()
        total = float((centred**2).sum()) or 1.0
        robust = axis.fit.lags is not None
        panels.append(
            ResidualPanel(
                axis=axis.axis,
                time=time,
                velocity=identification.signals.velocity[axis.signals_index],
                residual=axis.residual,
                used=axis.weights >= 0.5 if robust else np.ones(axis.residual.size, dtype=bool),
                lags=np.asarray(lags * (time[1] - time[0]), dtype=float),
                autocorrelation=np.array(
                    [float((centred[lag:] * centred[: centred.size - lag]).sum()) / total for lag in lags]
                ),
                bound=NORMAL_HALF_WIDTH / axis.residual.size**0.5,
            )
        )
    return residual_figure(panels)
