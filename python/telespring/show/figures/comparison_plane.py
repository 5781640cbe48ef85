"""The plane of stiffness and delay, with the measured cost of the delay without and with a guard."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from telespring.show.figures.maps import STABLE
from telespring.show.figures.style import (
    COLOURS,
    DASHES,
    FULL_WIDTH,
    figure_style,
    legend_line,
    legend_mark,
    panel_label,
    sized_figure,
)

__all__ = ["COST_CLASSES", "Boundary", "PlanePanel", "PlanePoint", "Reference", "plane_figure"]

Floats = NDArray[np.float64]

#: What errors are relative to: the bare spring without delay at the same stiffness, or no partner.
Reference: TypeAlias = Literal["undelayed", "unconnected"]

#: Errors up to this multiple of the reference, with their marks; the last one is for what is larger.
COST_CLASSES: tuple[tuple[float, str, str], ...] = (
    (1.1, COLOURS["green"], "o"),
    (1.3, COLOURS["sky"], "s"),
    (2.0, COLOURS["orange"], "^"),
    (np.inf, COLOURS["vermilion"], "D"),
)


@dataclass(frozen=True)
class PlanePoint:
    """What was measured in one condition.

    Attributes
    ----------
    stiffness, delay
        N/m and s, one way.
    ratio
        The larger of both people's tracking errors, relative to the figure's reference; NaN if no trial has
        one.
    failed, trials
        How many of the trials ran away or ended early.
    """

    stiffness: float
    delay: float
    ratio: float
    failed: int
    trials: int


@dataclass(frozen=True)
class PlanePanel:
    """One strategy: a title, and its conditions."""

    title: str
    points: Sequence[PlanePoint]


@dataclass(frozen=True)
class Boundary:
    """Where the bare spring is stable.

    Attributes
    ----------
    stiffness, delay
        Of the grid, N/m and s, ascending.
    depth
        How far each point (delay, stiffness) lies inside the stable region; negative outside.
    label
        What it holds for, in words.
    """

    stiffness: Floats
    delay: Floats
    depth: Floats
    label: str


def plane_figure(
    panels: Sequence[PlanePanel],
    boundary: Boundary | None = None,
    held: Boundary | None = None,
    figure: Figure | None = None,
    *,
    reference: Reference = "undelayed",
) -> Figure:
    """Draw what was measured over stiffness and delay, a panel per strategy.

    The first panel is that of the bare spring: `boundary` shades where it is stable. `held` is another
    boundary of it, drawn dashed, such as with the handles held. The other panels have both as lines. A mark
    shows by its shape and colour how much larger the tracking error is than that of the `reference`; the
    number beside it is the ratio, and a cross is drawn through it where trials ran away or ended early.
    """
    points = [point for panel in panels for point in panel.points]
    widest = 1.12 * max(point.stiffness for point in points)
    longest = 1.12 * max(max(point.delay for point in points), 0.05)
    with figure_style():
        # So that the numbers of neighbouring delays stay apart.
        delays = len({point.delay for point in points})
        figure = sized_figure(figure, FULL_WIDTH, min(max(3.3, 1.2 + 0.43 * delays), 7.0))
        figure.set_layout_engine("constrained")
        row = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
        for i, (axes, panel) in enumerate(zip(row, panels, strict=True)):
            if boundary is not None:
                _draw_boundary(axes, boundary, is_shaded=i == 0, dashed=False)
            if held is not None:
                _draw_boundary(axes, held, is_shaded=False, dashed=True)
            for point in panel.points:
                _draw_point(axes, point)
            axes.set(
                xlim=(0.0, widest),
                ylim=(-0.045e3 * longest, 1e3 * longest),
                xlabel="Stiffness k, N/m",
            )
            panel_label(axes, "abcdef"[i], panel.title)
        row[0].set_ylabel("One-way delay δ, ms")
        figure.legend(
            handles=_legend(points, boundary, held, reference),
            loc="outside upper center",
            ncols=3,
            columnspacing=1.4,
        )
    return figure


def cost_mark(ratio: float) -> tuple[str, str]:
    """Return colour and marker of a ratio."""
    return next((colour, marker) for limit, colour, marker in COST_CLASSES if ratio <= limit)


def _draw_boundary(axes: Axes, boundary: Boundary, *, is_shaded: bool, dashed: bool) -> None:
    stiffness, delay, depth = boundary.stiffness, 1e3 * boundary.delay, boundary.depth
    if is_shaded and (depth > 0.0).any():
        axes.contourf(
            np.concatenate([[0.0], stiffness]),
            delay,
            np.column_stack([depth[:, 0], depth]),
            levels=[0.0, np.inf],
            colors=[STABLE],
        )
    if (depth > 0.0).any() and (depth < 0.0).any():
        axes.contour(
            stiffness,
            delay,
            depth,
            levels=[0.0],
            colors=[COLOURS["purple" if dashed else "blue"]],
            linestyles=[DASHES[1] if dashed else "solid"],
            linewidths=1.1,
        )


def _draw_point(axes: Axes, point: PlanePoint) -> None:
    at = point.stiffness, 1e3 * point.delay
    is_known = bool(np.isfinite(point.ratio))
    if is_known:
        colour, marker = cost_mark(point.ratio)
        axes.plot(
            *at,
            marker,
            color=colour,
            markersize=6.0,
            markeredgecolor=COLOURS["black"],
            markeredgewidth=0.5,
            clip_on=False,
            zorder=5,
        )
    if point.failed:
        axes.plot(
            *at, "x", color=COLOURS["black"], markersize=8.0, markeredgewidth=1.4, clip_on=False, zorder=6
        )
    parts = [f"{point.ratio:.{2 if point.ratio < 1.995 else 1}f}"] if is_known else []
    if 0 < point.failed < point.trials:
        parts.append(f"{point.failed}/{point.trials}")
    axes.annotate(
        ", ".join(parts),
        at,
        xytext=(0.0, 5.0),
        textcoords="offset points",
        ha="center",
        va="bottom",
        fontsize=6.0,
        zorder=7,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.65, "pad": 0.4},
    )


def _legend(
    points: Sequence[PlanePoint], boundary: Boundary | None, held: Boundary | None, reference: Reference
) -> list[Line2D | Patch]:
    handles: list[Line2D | Patch] = []
    lower = None
    related = "the undelayed" if reference == "undelayed" else "that without a partner"
    for limit, colour, marker in COST_CLASSES:
        above = f"above {lower:.4g}" if lower is not None else ""
        words = f"up to {limit:.4g}" if np.isfinite(limit) else above
        lower = limit
        handles.append(
            legend_mark(
                f"error {words} × {related}",
                colour,
                marker,
                markersize=6.0,
                markeredgecolor=COLOURS["black"],
                markeredgewidth=0.5,
            )
        )
    if any(point.failed for point in points):
        handles.append(
            legend_mark(
                "ran away or ended early: all, or so many",
                COLOURS["black"],
                "x",
                markersize=7.0,
                markeredgewidth=1.4,
            )
        )
    if boundary is not None:
        handles.append(Patch(facecolor=STABLE, edgecolor=COLOURS["blue"], label=boundary.label))
    if held is not None:
        handles.append(legend_line(held.label, COLOURS["purple"], DASHES[1], linewidth=1.1))
    return handles
