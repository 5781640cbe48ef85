"""Published and computed tracking errors of the paper's conditions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
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

__all__ = ["CellSeries", "cells_figure"]

Floats = NDArray[np.float64]

#: Computed series: colour, marker, and horizontal offset from the condition. Each robot has a panel of its
#: own, so no colour stands for a robot.
_LOOKS = ((COLOURS["orange"], "x", -0.24), (COLOURS["purple"], "s", 0.16), (COLOURS["sky"], "^", 0.32))


@dataclass(frozen=True)
class CellSeries:
    """Computed errors of all conditions (condition, robot), m; infinite where the dyad is unstable."""

    name: str
    mean: Floats


def cells_figure(
    labels: Sequence[str],
    mean: Floats,
    standard_deviation: Floats,
    computed: Sequence[CellSeries],
    *,
    null: tuple[float, float],
    highest: float = 0.062,
) -> Figure:
    """Draw the published errors (condition, robot), m, of every condition, and up to three computed series.

    `null` is the error of both robots, m, that is predicted where nothing changes from the unconnected
    mode. What lies above `highest`, m, is marked at the edge with its value.
    """
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 4.8), layout="constrained")
        rows = figure.subplots(2, 1, sharex=True)
        at = np.arange(len(labels), dtype=float)
        lowest = 1e3 * min(
            float(np.min(mean - standard_deviation)), *(float(np.min(series.mean)) for series in computed)
        )
        for robot, axes in enumerate(rows):
            axes.axhline(1e3 * null[robot], color=GREY, linestyle=DASHES[0], linewidth=1.0)
            axes.errorbar(
                at,
                1e3 * mean[:, robot],
                yerr=1e3 * standard_deviation[:, robot],
                color=COLOURS["black"],
                marker="o",
                markersize=3.5,
                linestyle="none",
                elinewidth=0.8,
                capsize=1.5,
            )
            for (colour, marker, beside), series in zip(_LOOKS, computed, strict=False):
                values = 1e3 * series.mean[:, robot]
                inside = values <= 1e3 * highest
                axes.plot(
                    at[inside] + beside,
                    values[inside],
                    color=colour,
                    marker=marker,
                    markersize=4.0,
                    linestyle="none",
                )
                for outside in np.flatnonzero(~inside):
                    text = f"{values[outside]:.0f} ↑" if np.isfinite(values[outside]) else "unstable ↑"
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
                legend_mark("published (mean, standard deviation)", COLOURS["black"], "o", markersize=3.5),
                legend_line("as unconnected", GREY, DASHES[0]),
                *(
                    legend_mark(series.name, colour, marker, markersize=4.0)
                    for (colour, marker, _), series in zip(_LOOKS, computed, strict=False)
                ),
            ],
            loc="outside upper center",
            ncols=3,
        )
    return figure
