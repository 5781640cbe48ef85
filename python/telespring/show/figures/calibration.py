"""Calibration against published errors: per cell, per unknown and per pair of unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.typing import LineStyleType
from numpy.typing import NDArray

from telespring.show.figures.style import (
    COLOURS,
    DASHES,
    FULL_WIDTH,
    GREY,
    figure_style,
    legend_line,
    legend_mark,
    panel_label,
)

__all__ = [
    "CellSeries",
    "PairPanel",
    "ProfileCurve",
    "ProfilePanel",
    "cells_figure",
    "pairs_figure",
    "profiles_figure",
]

Floats = NDArray[np.float64]

_FITTED = "#EFEFEF"
#: Simulated series: colour, marker, and horizontal offset from the condition.
_LOOKS = ((GREY, "x", -0.24), (COLOURS["blue"], "s", 0.16), (COLOURS["vermilion"], "^", 0.32))
_VARIANTS: tuple[tuple[str, LineStyleType], ...] = (
    (COLOURS["blue"], "solid"),
    (COLOURS["vermilion"], DASHES[1]),
)
#: Pairs are shaded up to this many times the rise that ends an interval.
_RISES = 2.0


@dataclass(frozen=True)
class CellSeries:
    """Simulated errors of all conditions: mean and standard deviation (condition, robot), m."""

    name: str
    mean: Floats
    standard_deviation: Floats


@dataclass(frozen=True)
class ProfileCurve:
    """Rise of the deviance along an unknown, and the threshold of its interval."""

    name: str
    values: Floats
    rise: Floats
    limit: float
    best: float


@dataclass(frozen=True)
class ProfilePanel:
    """The curves of one unknown; `label` is its axis with the unit."""

    label: str
    curves: Sequence[ProfileCurve]


@dataclass(frozen=True)
class PairPanel:
    """Rise of the deviance over two unknowns, (second, first); `labels` are the axes with their units."""

    title: str
    labels: tuple[str, str]
    first: Floats
    second: Floats
    rise: Floats
    limit: float
    best: tuple[float, float]


def cells_figure(
    labels: Sequence[str],
    published: CellSeries,
    simulated: Sequence[CellSeries],
    *,
    fitted: Sequence[int],
    null: tuple[float, float],
    highest: float = 0.062,
) -> Figure:
    """Draw simulated and published errors of every condition, for up to three laboratories.

    Conditions that the fit has seen (`fitted`, their places) have a shaded background. `null` is the error of
    both robots, m, that is predicted where nothing changes from the unconnected mode. What lies above
    `highest`, m, is marked at the edge with its value.
    """
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 4.8), layout="constrained")
        rows = figure.subplots(2, 1, sharex=True)
        at = np.arange(len(labels), dtype=float)
        lowest = 1e3 * float(
            min(np.nanmin(series.mean - series.standard_deviation) for series in (published, *simulated))
        )
        for robot, axes in enumerate(rows):
            for i in fitted:
                axes.axvspan(i - 0.5, i + 0.5, color=_FITTED, linewidth=0, zorder=0)
            axes.axhline(1e3 * null[robot], color=COLOURS["green"], linestyle=DASHES[0], linewidth=1.0)
            axes.errorbar(
                at,
                1e3 * published.mean[:, robot],
                yerr=1e3 * published.standard_deviation[:, robot],
                color=COLOURS["black"],
                marker="o",
                markersize=3.5,
                linestyle="none",
                elinewidth=0.8,
                capsize=1.5,
            )
            for (colour, marker, beside), series in zip(_LOOKS, simulated, strict=False):
                values = 1e3 * series.mean[:, robot]
                inside = values <= 1e3 * highest
                axes.errorbar(
                    at[inside] + beside,
                    values[inside],
                    yerr=1e3 * series.standard_deviation[inside, robot],
                    color=colour,
                    marker=marker,
                    markersize=3.5,
                    linestyle="none",
                    elinewidth=0.8,
                )
                for outside in np.flatnonzero(~inside):
                    text = f"{values[outside]:.0f} ↑" if np.isfinite(values[outside]) else "diverged ↑"
                    axes.annotate(
                        text,
                        (at[outside] + beside, 1e3 * highest),
                        xytext=(0, -2),
                        textcoords="offset points",
                        ha="center",
                        va="top",
                        color="#606060",
                        fontsize=6.0,
                    )
            axes.set(
                ylim=(lowest - 1.5, 1e3 * highest),
                xlim=(-0.6, len(labels) - 0.4),
                ylabel=f"TE{robot + 1}, mm",
            )
            panel_label(axes, "ab"[robot], f"robot {robot + 1}, {('skilled', 'less skilled')[robot]} agent")
        rows[1].set_xticks(at, list(labels), rotation=45, ha="right", rotation_mode="anchor")
        figure.legend(
            handles=[
                legend_mark(published.name, COLOURS["black"], "o", markersize=3.5),
                *(
                    legend_mark(series.name, colour, marker, markersize=3.5)
                    for (colour, marker, _), series in zip(_LOOKS, simulated, strict=False)
                ),
                legend_line("as unconnected", COLOURS["green"], DASHES[0]),
                Patch(facecolor=_FITTED, edgecolor="#B0B0B0", label="fitted; the rest is held out"),
            ],
            loc="outside upper center",
            ncols=3,
        )
    return figure


def profiles_figure(panels: Sequence[ProfilePanel], names: Sequence[str]) -> Figure:
    """Draw the profile of the deviance along each unknown of the calibration, the others refitted.

    The same of up to two names looks the same in every panel.
    """
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 2.5), layout="constrained")
        row = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
        looks = dict(zip(names, _VARIANTS, strict=False))
        highest = 1.5 * max(curve.limit for panel in panels for curve in panel.curves)
        for i, (axes, panel) in enumerate(zip(row, panels, strict=True)):
            for curve in panel.curves:
                colour, dashes = looks[curve.name]
                axes.plot(curve.values, curve.rise, color=colour, linestyle=dashes)
                axes.axhline(curve.limit, color=colour, linestyle=DASHES[0], linewidth=0.8)
                axes.plot(
                    [curve.best], [0.0], marker="o", color=colour, markersize=4, clip_on=False, zorder=5
                )
            axes.set(
                xlabel=panel.label,
                ylim=(0.0, highest),
                xlim=(0.0, max(curve.values[-1] for curve in panel.curves)),
            )
            panel_label(axes, "abcdef"[i])
        row[0].set_ylabel("Rise of the deviance")
        figure.legend(
            handles=[
                *(legend_line(name, colour, dashes) for name, (colour, dashes) in looks.items()),
                legend_line("limit, 95 %", GREY, DASHES[0], linewidth=0.8),
                legend_mark("optimum", GREY, "o", markersize=4),
            ],
            loc="outside upper center",
            ncols=4,
        )
    return figure


def pairs_figure(panels: Sequence[PairPanel], *, columns: int = 3) -> Figure:
    """Draw the deviance over pairs of unknowns: ridges show which ones trade off."""
    count = -(-len(panels) // columns)
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 2.05 * count + 0.4), layout="constrained")
        grid = figure.subplots(count, columns, squeeze=False)
        shading = None
        for axes, panel in zip(grid.ravel(), panels, strict=False):
            shading = axes.contourf(
                panel.first,
                panel.second,
                np.minimum(panel.rise / panel.limit, _RISES),
                levels=np.linspace(0.0, _RISES, 9),
                cmap="Blues_r",
            )
            axes.contour(
                panel.first,
                panel.second,
                panel.rise / panel.limit,
                levels=[1.0],
                colors=[COLOURS["vermilion"]],
                linewidths=1.2,
            )
            axes.plot(
                [panel.best[0]],
                [panel.best[1]],
                "X",
                color=COLOURS["black"],
                markeredgecolor="white",
                markersize=6,
                clip_on=False,
                zorder=5,
            )
            axes.set(xlabel=panel.labels[0], ylabel=panel.labels[1])
            panel_label(axes, "", panel.title)
        for axes in grid.ravel()[len(panels) :]:
            axes.set_visible(False)
        if shading is not None:
            bar = figure.colorbar(shading, ax=grid, shrink=0.6, aspect=30)
            bar.set_label("Rise of the deviance over the 95 % limit")
        figure.legend(
            handles=[
                legend_line("95 % limit", COLOURS["vermilion"], linewidth=1.2),
                legend_mark("optimum", COLOURS["black"], "X"),
            ],
            loc="outside upper center",
            ncols=2,
        )
    return figure
