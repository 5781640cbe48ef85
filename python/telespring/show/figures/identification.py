"""Figures of an identification: excitation (Fig. 9), force with the fitted plane (Fig. 10), residuals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from telespring.show.figures.style import COLOURS, FULL_WIDTH, GREY, panel_label, styled

if TYPE_CHECKING:
    from telespring.identification.excitation import Excitation
    from telespring.identification.results import AxisIdentification, Identification

__all__ = ["excitation_figure", "regression_figure", "residual_figure"]


def excitation_figure(movements: Sequence[tuple[str, Excitation]]) -> Figure:
    """Draw velocity, position and acceleration over one period (Fig. 9), a column per named movement."""
    rows = (
        ("velocity", "Velocity, m/s", COLOURS["blue"], "solid", 1.0),
        ("position", "Position, mm", COLOURS["vermilion"], (0.0, (5.0, 1.6)), 1e3),
        ("acceleration", "Acceleration, m/s²", COLOURS["green"], (0.0, (5.0, 1.4, 1.2, 1.4)), 1.0),
    )
    with styled():
        figure = Figure(figsize=(FULL_WIDTH, 3.6), layout="constrained")
        grid = figure.subplots(3, len(movements), sharex="col", sharey="row", squeeze=False)
        letters = iter("abcdefghijklmnopqrstuvwxyz")
        for i, (name, movement) in enumerate(movements):
            time = np.linspace(0.0, movement.period, 801)
            for axes, (quantity, label, colour, dash, scale) in zip(grid[:, i], rows, strict=True):
                values = scale * getattr(movement, quantity)(time)
                axes.axhline(0.0, color=GREY, linewidth=0.5)
                axes.plot(time, values, color=colour, linestyle=dash)
                axes.margins(x=0.0)
                panel_label(axes, next(letters), name if quantity == "velocity" else "")
                if i == 0:
                    axes.set_ylabel(label)
            grid[-1, i].set_xlabel("Time, s")
        figure.align_ylabels(grid[:, 0])
    return figure


def regression_figure(robots: Sequence[tuple[str, Identification]]) -> Figure:
    """Draw measured and estimated force over time, and over velocity and acceleration (Fig. 10).

    Each axis of each named robot is a row: force over time on the left, the fitted plane on the right.
    """
    rows = [(name, robot, axis) for name, robot in robots for axis in robot.axes]
    with styled():
        figure = Figure(figsize=(FULL_WIDTH, 2.05 * len(rows)), layout="constrained")
        grid = figure.add_gridspec(len(rows), 2, width_ratios=(1.0, 1.0))
        letters = iter("abcdefghijklmnopqrstuvwxyz")
        for i, (name, robot, axis) in enumerate(rows):
            time = robot.signals.time
            force = robot.signals.force[axis.signals_index]
            left = figure.add_subplot(grid[i, 0])
            left.plot(time, force, color=COLOURS["black"], linewidth=1.6, label="measured")
            left.plot(
                time,
                axis.estimated_force,
                color=COLOURS["orange"],
                linestyle=(0.0, (3.0, 2.0)),
                linewidth=1.2,
                label="estimated",
            )
            left.set_ylabel("Force, N")
            left.margins(x=0.0)
            panel_label(left, next(letters), f"{name}, axis {axis.axis}")
            if i == 0:
                left.legend(loc="upper right", ncols=2, bbox_to_anchor=(1.0, 1.16), borderaxespad=0.0)
            if i == len(rows) - 1:
                left.set_xlabel("Time, s")
            _draw_plane(figure.add_subplot(grid[i, 1], projection="3d"), robot, axis, next(letters))
    return figure


def _draw_plane(axes: Any, robot: Identification, axis: AxisIdentification, letter: str) -> None:
    """Draw the plane m a + b v, and the samples without friction and offset."""
    row = axis.signals_index
    velocity, acceleration = robot.signals.velocity[row], robot.signals.acceleration[row]
    linear = axis.mass.value * acceleration + axis.damping.value * velocity
    v, a = np.meshgrid(*(np.linspace(values.min(), values.max(), 9) for values in (velocity, acceleration)))
    axes.plot_wireframe(
        v, a, axis.mass.value * a + axis.damping.value * v, color=COLOURS["blue"], linewidth=0.4, alpha=0.7
    )
    axes.scatter(
        velocity, acceleration, linear + axis.residual, s=3.0, color=COLOURS["vermilion"], depthshade=False
    )
    axes.set_xlabel("Velocity, m/s", labelpad=-6.0)
    axes.set_ylabel("Acceleration, m/s²", labelpad=-6.0)
    axes.set_zlabel("Force, N", labelpad=-8.0)
    axes.tick_params(pad=-3.0, labelsize=6.0)
    axes.view_init(elev=18.0, azim=-60.0)
    axes.set_box_aspect((1.3, 1.3, 0.8), zoom=1.15)
    mass, damping = (_format_interval(*estimate.interval) for estimate in (axis.mass, axis.damping))
    axes.set_title(rf"$\mathbf{{({letter})}}$ m = {mass} kg, b = {damping} N·s/m", loc="center", pad=-2.0)


def _format_interval(low: float, high: float) -> str:
    """Format the midpoint of an interval ± its half-width, to two digits of the latter."""
    half = 0.5 * (high - low)
    digits = max(0, 1 - math.floor(math.log10(half))) if half > 0.0 else 4
    return f"{0.5 * (low + high):.{digits}f} ± {half:.{digits}f}"


def residual_figure(identification: Identification) -> Figure:
    """Draw the residuals of each axis over time and over velocity, and their autocorrelation.

    Crosses mark samples that the robust fit rejected.
    """
    with styled():
        figure = Figure(figsize=(FULL_WIDTH, 0.4 + 1.75 * len(identification.axes)), layout="constrained")
        grid = figure.subplots(len(identification.axes), 3, squeeze=False, width_ratios=(1.5, 1.0, 1.0))
        letters = iter("abcdefghijklmnopqrstuvwxyz")
        for i, axis in enumerate(identification.axes):
            over_time, over_velocity, correlation = grid[i]
            is_used = (
                axis.weights >= 0.5 if axis.fit.lags is not None else np.ones(axis.residual.size, dtype=bool)
            )
            velocity = identification.signals.velocity[axis.signals_index]
            for axes, abscissa in ((over_time, identification.signals.time), (over_velocity, velocity)):
                axes.axhline(0.0, color=GREY, linewidth=0.5)
                axes.plot(
                    abscissa[is_used],
                    axis.residual[is_used],
                    ".",
                    color=COLOURS["blue"],
                    markersize=2.0,
                    label="used",
                )
                if not is_used.all():
                    axes.plot(
                        abscissa[~is_used],
                        axis.residual[~is_used],
                        "x",
                        color=COLOURS["vermilion"],
                        markersize=3.0,
                        label="rejected",
                    )
            over_time.set_ylabel("Residual, N")
            if not is_used.all():
                over_time.legend(loc="upper right")
            lags = np.arange(0, min(31, axis.residual.size // 4))
            centred = axis.residual - axis.residual.mean()
            total = float((centred**2).sum()) or 1.0
            values = [float((centred[lag:] * centred[: centred.size - lag]).sum()) / total for lag in lags]
            bound = 1.96 / np.sqrt(axis.residual.size)
            spacing = float(identification.signals.time[1] - identification.signals.time[0])
            correlation.axhspan(
                -bound, bound, color=COLOURS["sky"], alpha=0.3, linewidth=0.0, label="if independent"
            )
            correlation.vlines(1e3 * spacing * lags, 0.0, values, color=COLOURS["black"], linewidth=1.0)
            correlation.axhline(0.0, color=GREY, linewidth=0.5)
            correlation.set_ylabel("Autocorrelation")
            correlation.set_ylim(-0.6, 1.05)
            panel_label(over_time, next(letters), f"axis {axis.axis}")
            panel_label(over_velocity, next(letters))
            panel_label(correlation, next(letters))
            if i == 0:
                correlation.legend(loc="upper right")
            if i == len(identification.axes) - 1:
                over_time.set_xlabel("Time, s")
                over_velocity.set_xlabel("Velocity, m/s")
                correlation.set_xlabel("Lag, ms")
    return figure
