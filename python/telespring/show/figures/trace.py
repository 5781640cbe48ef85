"""A recorded trace of a network: its delays, the models that fit them, and what each play-out allows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

from telespring._types import FloatArray
from telespring.show.figures.style import COLOURS, FULL_WIDTH, GREY, figure_style, panel_label
from telespring.show.figures.thinning import extremes

__all__ = ["FittedCurve", "StiffnessCurve", "TracePanels", "trace_figure"]

#: Colour and dash of a curve by its place.
_LINES = (
    (COLOURS["vermilion"], "solid"),
    (COLOURS["blue"], (0.0, (5.0, 1.6))),
    (COLOURS["green"], (0.0, (1.2, 1.2))),
    (COLOURS["purple"], (0.0, (5.0, 1.4, 1.2, 1.4))),
)
_MARKS = "osD^"


@dataclass(frozen=True, eq=False)
class FittedCurve:
    """The share of packets that a model delays by more than each delay (s)."""

    name: str
    delay: FloatArray
    above: FloatArray


@dataclass(frozen=True, eq=False)
class StiffnessCurve:
    """The stiffness (N/m) that one tier proves over the play-out's delay (s); NaN where it does not hold."""

    name: str
    delay: FloatArray
    stiffness: FloatArray


@dataclass(frozen=True, eq=False)
class TracePanels:
    """What the figure shows: times of sending and delays (s), NaN if lost, and the curves.

    `recommended` is a play-out's delay, s, and the stiffness to use with it, N/m.
    """

    name: str
    time: FloatArray
    delay: FloatArray
    fits: Sequence[FittedCurve]
    tiers: Sequence[StiffnessCurve]
    recommended: tuple[float, float]


def trace_figure(panels: TracePanels) -> Figure:
    """Draw delays over time, their distribution with the fits, and stiffness over the play-out's delay."""
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 4.6), layout="constrained")
        grid = figure.add_gridspec(2, 2)
        _draw_delays(figure.add_subplot(grid[0, :]), panels)
        _draw_distribution(figure.add_subplot(grid[1, 0]), panels)
        _draw_stiffness(figure.add_subplot(grid[1, 1]), panels)
    return figure


def _draw_delays(axes: Axes, panels: TracePanels) -> None:
    came = np.isfinite(panels.delay)
    time, delay = extremes(panels.time[came], panels.delay[came])
    axes.plot(time, 1e3 * delay, color=COLOURS["blue"], linewidth=0.7, label="delay of a packet")
    playout = panels.recommended[0]
    axes.axhline(1e3 * playout, color=COLOURS["black"], linestyle=(0.0, (5.0, 1.6)), linewidth=0.9)
    _log_scale(axes, "y", delay)
    if not came.all():
        lost = panels.time[~came]
        low = axes.get_ylim()[0]
        axes.plot(
            lost, np.full(lost.size, low), "|", color=COLOURS["vermilion"], markersize=7.0, label="lost"
        )
    axes.plot([], [], color=COLOURS["black"], linestyle=(0.0, (5.0, 1.6)), label="recommended play-out")
    axes.margins(x=0.0)
    axes.set_xlabel("Time of sending, s")
    axes.set_ylabel("Delay, ms")
    axes.legend(loc="upper right", ncols=3, bbox_to_anchor=(1.0, 1.14), borderaxespad=0.0)
    panel_label(axes, "a", f"delay of each packet{f', {panels.name}' if panels.name else ''}")


def _draw_distribution(axes: Axes, panels: TracePanels) -> None:
    delay = np.sort(panels.delay[np.isfinite(panels.delay)])
    above = 1.0 - np.arange(1, delay.size + 1) / delay.size
    axes.step(1e3 * delay, above, where="post", color=COLOURS["black"], linewidth=1.6, label="recorded")
    for fit, (colour, dash) in zip(panels.fits, _LINES, strict=False):
        axes.plot(1e3 * fit.delay, fit.above, color=colour, linestyle=dash, label=fit.name)
    axes.set_yscale("log")
    axes.set_ylim(0.5 / delay.size, 1.2)
    _log_scale(axes, "x", delay)
    axes.set_xlabel("Delay, ms")
    axes.set_ylabel("Share of packets that take longer")
    # curves may run anywhere: the legend covers what is behind it
    axes.legend(loc="best", frameon=True, framealpha=0.9, edgecolor="none")
    panel_label(axes, "b", "distribution and fits")


def _draw_stiffness(axes: Axes, panels: TracePanels) -> None:
    for curve, (colour, dash), mark in zip(panels.tiers, _LINES, _MARKS, strict=False):
        axes.plot(
            1e3 * curve.delay,
            curve.stiffness,
            color=colour,
            linestyle=dash,
            marker=mark,
            markersize=3.5,
            label=curve.name,
        )
    playout, stiffness = panels.recommended
    axes.plot(
        1e3 * playout,
        stiffness,
        marker="*",
        markersize=9.0,
        color=COLOURS["black"],
        linestyle="none",
        label="recommended",
    )
    axes.axvline(1e3 * playout, color=GREY, linewidth=0.5)
    _log_scale(axes, "x", np.concatenate([curve.delay for curve in panels.tiers]))
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("Delay of the play-out, ms")
    axes.set_ylabel("Stiffness proven, N/m")
    axes.legend(loc="best")
    panel_label(axes, "c", "what each network model allows")


def _log_scale(axes: Axes, which: str, values: FloatArray) -> None:
    """Give an axis of delays, s, a logarithmic scale where they spread over more than a factor of 8."""
    low, high = float(values.min()), float(values.max())
    if low > 0.0 and high > 8.0 * low:
        axis = axes.xaxis if which == "x" else axes.yaxis
        axes.set(**{f"{which}scale": "log"})
        # a range of one decade needs marks within it, and all of them in whole numbers
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(ScalarFormatter())
        axis.set_minor_formatter(NullFormatter())
