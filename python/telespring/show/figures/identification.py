"""Figs. 9 and 10: the excitation, the fitted forces, and what the fit leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from telespring._types import FloatArray
from telespring.show.figures.style import COLOURS, FULL_WIDTH, GREY, figure_style, panel_label
from telespring.show.quantities import format_interval

__all__ = [
    "ExcitationPanel",
    "RegressionPanel",
    "ResidualPanel",
    "excitation_figure",
    "regression_figure",
    "residual_figure",
]


@dataclass(frozen=True, eq=False)
class ExcitationPanel:
    """One movement over one period: time (s), position (m), velocity (m/s), acceleration (m/s²)."""

    name: str
    time: FloatArray
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray


@dataclass(frozen=True, eq=False)
class RegressionPanel:
    """Forces of one robot on one axis: measured, estimated, and what remains, N.

    `mass` and `damping` are estimates with both ends of their intervals, kg and N·s/m.
    """

    label: str
    time: FloatArray
    measured: FloatArray
    estimated: FloatArray
    residual: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    mass: tuple[float, float, float]
    damping: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class ResidualPanel:
    """Residuals of one axis, N, their autocorrelation at lags in s, and which samples the fit used.

    The autocorrelation of independent residuals lies within `bound` of 0 at 95 % of the lags.
    """

    axis: str
    time: FloatArray
    velocity: FloatArray
    residual: FloatArray
    used: np.ndarray[Any, np.dtype[np.bool_]]
    lags: FloatArray
    autocorrelation: FloatArray
    bound: float


def excitation_figure(movements: Sequence[ExcitationPanel]) -> Figure:
    """Draw velocity, position and acceleration over one period, one column per movement (Fig. 9)."""
    rows = (
        ("velocity", "Velocity, m/s", COLOURS["blue"], "solid", 1.0),
        ("position", "Position, mm", COLOURS["vermilion"], (0.0, (5.0, 1.6)), 1e3),
        ("acceleration", "Acceleration, m/s²", COLOURS["green"], (0.0, (5.0, 1.4, 1.2, 1.4)), 1.0),
    )
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 3.6), layout="constrained")
        grid = figure.subplots(3, len(movements), sharex="col", sharey="row", squeeze=False)
        letters = iter("abcdefghijklmnopqrstuvwxyz")
        for i, movement in enumerate(movements):
            for axes, (quantity, label, colour, dash, scale) in zip(grid[:, i], rows, strict=True):
                axes.axhline(0.0, color=GREY, linewidth=0.5)
                axes.plot(movement.time, scale * getattr(movement, quantity), color=colour, linestyle=dash)
                axes.margins(x=0.0)
                panel_label(axes, next(letters), movement.name if quantity == "velocity" else "")
                if i == 0:
                    axes.set_ylabel(label)
            grid[-1, i].set_xlabel("Time, s")
        figure.align_ylabels(grid[:, 0])
    return figure


def regression_figure(panels: Sequence[RegressionPanel]) -> Figure:
    """Draw forces in time, and as a plane over velocity and acceleration, row by row (Fig. 10)."""
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 2.35 * len(panels)), layout="constrained")
        grid = figure.add_gridspec(len(panels), 2, width_ratios=(1.0, 1.0))
        letters = iter("abcdefghijklmnopqrstuvwxyz")
        for i, panel in enumerate(panels):
            left = figure.add_subplot(grid[i, 0])
            left.plot(panel.time, panel.measured, color=COLOURS["black"], linewidth=1.6, label="measured")
            left.plot(
                panel.time,
                panel.estimated,
                color=COLOURS["orange"],
                linestyle=(0.0, (3.0, 2.0)),
                linewidth=1.2,
                label="estimated",
            )
            left.set_ylabel("Force, N")
            left.margins(x=0.0)
            panel_label(left, next(letters), panel.label)
            if i == 0:
                left.legend(loc="upper right", ncols=2, bbox_to_anchor=(1.0, 1.16), borderaxespad=0.0)
            if i == len(panels) - 1:
                left.set_xlabel("Time, s")
            _draw_regression_plane(figure.add_subplot(grid[i, 1], projection="3d"), panel, next(letters))
    return figure


def _draw_regression_plane(axes: Any, panel: RegressionPanel, letter: str) -> None:
    """Draw the plane m a + b v, and the samples without friction and offset."""
    velocity, acceleration = panel.velocity, panel.acceleration
    (m, *mass), (b, *damping) = panel.mass, panel.damping
    linear = m * acceleration + b * velocity
    v, a = np.meshgrid(*(np.linspace(values.min(), values.max(), 9) for values in (velocity, acceleration)))
    axes.plot_wireframe(v, a, m * a + b * v, color=COLOURS["blue"], linewidth=0.4, alpha=0.7)
    axes.scatter(
        velocity, acceleration, linear + panel.residual, s=3.0, color=COLOURS["vermilion"], depthshade=False
    )
    axes.set_xlabel("Velocity, m/s", labelpad=-6.0)
    axes.set_ylabel("Acceleration, m/s²", labelpad=-6.0)
    axes.set_zlabel("Force, N", labelpad=-8.0)
    axes.tick_params(pad=-3.0, labelsize=6.0)
    # From where the plane is neither seen on its edge nor face-on.
    axes.view_init(elev=26.0, azim=-128.0)
    axes.set_box_aspect((1.5, 1.2, 0.8), zoom=1.12)
    estimates = f"m = {format_interval(*mass)} kg, b = {format_interval(*damping)} N·s/m"
    axes.set_title(rf"$\mathbf{{({letter})}}$ {estimates}", loc="center", pad=-2.0)


def residual_figure(panels: Sequence[ResidualPanel]) -> Figure:
    """Draw residuals over time and velocity, and their autocorrelation, one row per axis.

    Samples that the robust fit left out are crossed.
    """
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 0.4 + 1.75 * len(panels)), layout="constrained")
        grid = figure.subplots(len(panels), 3, squeeze=False, width_ratios=(1.5, 1.0, 1.0))
        letters = iter("abcdefghijklmnopqrstuvwxyz")
        for i, panel in enumerate(panels):
            over_time, over_velocity, correlation = grid[i]
            used = panel.used
            for axes, abscissa in ((over_time, panel.time), (over_velocity, panel.velocity)):
                axes.axhline(0.0, color=GREY, linewidth=0.5)
                axes.plot(
                    abscissa[used],
                    panel.residual[used],
                    ".",
                    color=COLOURS["blue"],
                    markersize=2.0,
                    label="used",
                )
                if not used.all():
                    axes.plot(
                        abscissa[~used],
                        panel.residual[~used],
                        "x",
                        color=COLOURS["vermilion"],
                        markersize=3.0,
                        label="rejected",
                    )
            over_time.set_ylabel("Residual, N")
            if not used.all():
                over_time.legend(loc="upper right")
            bound = panel.bound
            correlation.axhspan(
                -bound, bound, color=COLOURS["sky"], alpha=0.3, linewidth=0.0, label="if independent"
            )
            correlation.vlines(
                1e3 * panel.lags, 0.0, panel.autocorrelation, color=COLOURS["black"], linewidth=1.0
            )
            correlation.axhline(0.0, color=GREY, linewidth=0.5)
            correlation.set_ylabel("Autocorrelation")
            correlation.set_ylim(-0.6, 1.05)
            panel_label(over_time, next(letters), f"axis {panel.axis}")
            panel_label(over_velocity, next(letters))
            panel_label(correlation, next(letters))
            if i == 0:
                correlation.legend(loc="upper right")
            if i == len(panels) - 1:
                over_time.set_xlabel("Time, s")
                over_velocity.set_xlabel("Velocity, m/s")
                correlation.set_xlabel("Lag, ms")
    return figure
