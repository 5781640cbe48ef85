"""Stability and coupling of the axes in the poses along the target's path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

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

__all__ = ["PoseRange", "poses_figure"]

#: Width of a mark for each percent of cross-axis inertia, points.
_WIDTH = 0.25


@dataclass(frozen=True)
class PoseRange:
    """One condition over all poses.

    Attributes
    ----------
    label
        Its stiffness and delay, for a reader.
    least, worst
        Spectral abscissa in the best and in the worst pose, 1/s.
    independent
        The worst with all that couples the axes left out, 1/s.
    worst_position
        Of both handles in the worst pose, m.
    """

    label: str
    least: float
    worst: float
    independent: float
    worst_position: tuple[float, float]


def poses_figure(
    conditions: Sequence[PoseRange], places: NDArray[np.float64], cross_inertia: NDArray[np.float64]
) -> Figure:
    """Draw the coupling of the axes along the path, and the abscissa of each condition over the poses.

    `places` (m) and `cross_inertia` (of robot 1 and 2, arm included, over the diagonal) have shape (pose, 2).
    """
    blue, vermilion, black = COLOURS["blue"], COLOURS["vermilion"], COLOURS["black"]
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 2.3 + 0.16 * max(len(conditions), 4)), layout="constrained")
        path, ranges = figure.subplots(1, 2, width_ratios=(1.0, 1.7))
        x, y = 1e3 * places.T
        for robot, (marker, colour) in enumerate((("o", blue), ("s", vermilion))):
            share = 100.0 * cross_inertia[:, robot]
            path.scatter(
                x, y, s=(_WIDTH * share) ** 2 + 1.0, marker=marker, facecolors="none", edgecolors=colour
            )
        worst = sorted({condition.worst_position for condition in conditions})
        path.plot([1e3 * at[0] for at in worst], [1e3 * at[1] for at in worst], "*", color=black, ms=7.0)
        path.set(xlabel="x, mm", ylabel="y, mm")
        path.set_aspect("equal", adjustable="box")
        path.margins(0.12)
        panel_label(path, "a", "cross-axis inertia (width)")

        ranges.axvline(0.0, color=GREY, linestyle=DASHES[1], linewidth=0.8)
        for row, condition in enumerate(conditions):
            unstable = condition.worst >= 0.0
            ranges.plot([condition.least, condition.worst], [row, row], color=blue, linewidth=2.0)
            ranges.plot(
                condition.independent, row, "D", color=vermilion, markerfacecolor="white", ms=4.5, zorder=4
            )
            ranges.plot(
                condition.worst,
                row,
                "X" if unstable else "o",
                color=black,
                markerfacecolor=black if unstable else "white",
                ms=6.0 if unstable else 4.0,
                zorder=5,
            )
        ranges.set_yticks(range(len(conditions)), [condition.label for condition in conditions])
        ranges.set_ylim(max(len(conditions), 1) - 0.4, -0.6)
        ranges.set_xlabel("Spectral abscissa, 1/s")
        ranges.margins(x=0.08)
        panel_label(ranges, "b", "over the poses; unstable above 0")
        if not conditions:
            ranges.clear()
            ranges.set_axis_off()

        one, two = 100.0 * cross_inertia.max(axis=0)
        hollow: Any = {"markerfacecolor": "white", "markersize": 4.5}
        figure.legend(
            handles=[
                legend_mark(f"robot 1 (largest {one:.2g} %)", blue, "o", **hollow),
                legend_mark(f"robot 2 (largest {two:.2g} %)", vermilion, "s", **hollow),
                legend_mark("worst pose of a condition", black, "*"),
                legend_line("from best to worst pose", blue, linewidth=2.0),
                legend_mark("worst pose, stable", black, "o", **hollow),
                legend_mark("worst pose, unstable", black, "X"),
                legend_mark("worst if uncoupled", vermilion, "D", **hollow),
            ],
            loc="outside upper center",
            ncols=4,
        )
    return figure
