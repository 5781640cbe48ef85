"""Stability over stiffness and delay, with free handles and with arms at the handles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from telespring.show.figures.maps import (
    STABLE,
    MapColumn,
    StudyMark,
    draw_stable_region,
    draw_study_mark,
)
from telespring.show.figures.style import (
    COLOURS,
    DASHES,
    FULL_WIDTH,
    figure_style,
    legend_line,
    legend_mark,
    panel_label,
)

__all__ = ["ArmsPanel", "arms_figure"]


@dataclass(frozen=True)
class ArmsPanel:
    """One axis of the dyad.

    Attributes
    ----------
    name
        The axis.
    held
        Stable delays in arms, at evenly spaced stiffnesses.
    free
        Smallest delay (s) at which stability is lost with free handles, at the same stiffnesses;
        infinite if none is.
    conditions
        Stiffness (N/m), delay (s), and whether this axis is stable there in arms.
    """

    name: str
    held: Sequence[MapColumn]
    free: NDArray[np.float64]
    conditions: Sequence[tuple[float, float, bool]]


def arms_figure(panels: Sequence[ArmsPanel], *, longest: float, mark: StudyMark | None = None) -> Figure:
    """Draw the stable region with arms, and the boundary with free handles, axis by axis to `longest` s.

    `mark` is the study itself.
    """
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 3.6), layout="constrained")
        row = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
        for i, (axes, panel) in enumerate(zip(row, panels, strict=True)):
            stiffness, _, _ = draw_stable_region(axes, panel.held, longest)
            edge = np.where(np.isfinite(panel.free), panel.free, np.nan)
            axes.plot(stiffness, 1e3 * edge, color=COLOURS["vermilion"], linestyle=DASHES[1])
            for k, at, is_stable in panel.conditions:
                axes.plot(
                    [k],
                    [1e3 * at],
                    "o" if is_stable else "X",
                    color=COLOURS["black"],
                    markerfacecolor="white" if is_stable else COLOURS["black"],
                    markersize=4.5 if is_stable else 6.0,
                    clip_on=False,
                    zorder=6,
                )
            axes.set(
                xlim=(0.0, stiffness[-1]),
                ylim=(0.0, 1e3 * longest),
                xlabel="Stiffness of the virtual spring k, N/m",
            )
            panel_label(axes, "abcdef"[i], f"axis {panel.name}")
            marked = [] if mark is None else draw_study_mark(axes, mark)
        row[0].set_ylabel("One-way delay δ, ms")
        black = COLOURS["black"]
        figure.legend(
            handles=[
                Patch(facecolor=STABLE, edgecolor=COLOURS["blue"], label="stable with arms"),
                legend_line("free handles: stable below", COLOURS["vermilion"], DASHES[1]),
                legend_mark(
                    "condition, stable with arms", black, "o", markerfacecolor="white", markersize=4.5
                ),
                legend_mark("condition, unstable with arms", black, "X"),
                *marked,
            ],
            loc="outside upper center",
            ncols=3,
        )
    return figure
