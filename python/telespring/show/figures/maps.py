"""Maps of stability over stiffness and delay, exact and by the paper's formulas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.typing import LineStyleType
from numpy.typing import NDArray

from telespring.show.figures.style import (
    COLOURS,
    DASHES,
    FULL_WIDTH,
    figure_style,
    legend_line,
    legend_mark,
    panel_label,
)

__all__ = [
    "HORIZON",
    "STABLE",
    "MapAxis",
    "MapColumn",
    "StudyMark",
    "draw_axis_boundaries",
    "draw_condition",
    "draw_stable_region",
    "draw_study_mark",
    "draw_varying_boundary",
    "region_map",
    "stable_depth",
    "tier_map",
]

Floats = NDArray[np.float64]


STABLE = "#CFE8DF"
#: Up to this multiple of the largest delay drawn the stable intervals are needed, so that a boundary may
#: leave the map.
HORIZON = 1.25
#: Rows of a map, over the delay; between them a boundary is where it is.
_ROWS = 401
_AXIS_COLOURS = (COLOURS["blue"], COLOURS["vermilion"], COLOURS["purple"], COLOURS["sky"])


@dataclass(frozen=True)
class MapAxis:
    """The boundary of one axis: stiffness (N/m) against exact and printed maximum delay (s)."""

    name: str
    stiffness: NDArray[np.float64]
    exact: NDArray[np.float64]
    printed: NDArray[np.float64] | None


@dataclass(frozen=True)
class MapColumn:
    """One stiffness (N/m) and its stable intervals of one-way delay (s)."""

    stiffness: float
    stable: Sequence[tuple[float, float]]


@dataclass(frozen=True)
class StudyMark:
    """Where a study is on a map: its stiffness (N/m) and its shortest and longest one-way delay (s)."""

    stiffness: float
    delay: float
    longest_delay: float


def draw_study_mark(axes: Axes, mark: StudyMark, label: str = "this study") -> list[Line2D]:
    """Mark a study by a star, with a bar up to its longest delay; return the lines for the legend."""
    style: dict[str, Any] = {"color": COLOURS["black"], "zorder": 7, "clip_on": False}
    bar = []
    if mark.longest_delay > mark.delay:
        axes.plot([mark.stiffness] * 2, [1e3 * mark.delay, 1e3 * mark.longest_delay], linewidth=1.4, **style)
        # in the legend upright, as on the map
        bar.append(
            legend_mark(
                f"{label}, up to its longest delay",
                COLOURS["black"],
                "|",
                markersize=10.0,
                markeredgewidth=1.4,
            )
        )
    face: dict[str, Any] = {
        "markerfacecolor": "white",
        "markersize": 10.0,
        "markeredgewidth": 1.1,
        "linestyle": "none",
    }
    axes.plot([mark.stiffness], [1e3 * mark.delay], "*", **style, **face)
    return [Line2D([], [], color=COLOURS["black"], marker="*", label=label, **face), *bar]


def stable_depth(columns: Sequence[MapColumn], delay: Floats) -> Floats:
    """Compute how far each delay (s) of each column lies inside its stable intervals, s, (delay, column).

    The distance to the nearest end of an interval, negative outside: linear along a column, so that the
    contour at 0 passes through the ends themselves. Delay 0 is no end, and neither is one at or beyond
    `HORIZON` times the largest delay, up to where the intervals are to be given.
    """
    horizon = HORIZON * float(delay[-1])
    depth = np.empty((len(delay), len(columns)))
    for i, column in enumerate(columns):
        ends = np.array([end for interval in column.stable for end in interval])
        is_inside = np.searchsorted(ends, delay, side="right") % 2 == 1
        ends = ends[(ends > 0.0) & (ends < horizon * (1.0 - 1e-9))]
        away = np.abs(delay[:, None] - ends).min(axis=1, initial=horizon)
        depth[:, i] = np.where(is_inside, away, -away)
    return depth


def draw_stable_region(
    axes: Axes, columns: Sequence[MapColumn], longest: float
) -> tuple[Floats, Floats, Floats]:
    """Shade the stable intervals of the columns; return stiffnesses (N/m), delays (s) and `stable_depth`."""
    stiffness = np.array([column.stiffness for column in columns])
    delay = np.linspace(0.0, longest, _ROWS)
    depth = stable_depth(columns, delay)
    _shade(axes, stiffness, delay, depth)
    _outline(axes, stiffness, delay, depth, COLOURS["blue"])
    return stiffness, delay, depth


def draw_axis_boundaries(
    axes: Axes, boundaries: Sequence[tuple[str, Floats]], stiffness: Floats, delay: Floats, **shade: Any
) -> list[Line2D]:
    """Shade what is stable on every axis, and draw the boundary of each; return the lines for a legend.

    `boundaries` has a label for the boundary of each axis, and how far the points (delay, stiffness) lie
    inside its stable region, negative outside, such as `stable_depth`; the boundary is where this is 0.
    `shade` replaces the colour: what `contourf` takes.
    """
    _shade(axes, stiffness, delay, np.min([depth for _, depth in boundaries], axis=0), **shade)
    handles = []
    for (label, depth), colour in zip(boundaries, _AXIS_COLOURS, strict=False):
        _outline(axes, stiffness, delay, depth, colour)
        handles.append(legend_line(label, colour))
    axes.set(
        xlim=(0.0, stiffness[-1]),
        ylim=(0.0, 1e3 * delay[-1]),
        xlabel="Stiffness k, N/m",
        ylabel="One-way delay δ, ms",
    )
    return handles


def draw_varying_boundary(axes: Axes, depth: Floats, stiffness: Floats, delay: Floats, label: str) -> Line2D:
    """Shade what is proven while the delay varies, and draw its limit; return the line for a legend."""
    style = COLOURS["black"], DASHES[3]
    _shade(axes, stiffness, delay, depth)
    _outline(axes, stiffness, delay, depth, style[0], style[1])
    return legend_line(label, *style)


def draw_condition(
    axes: Axes, stiffness: float | None, delay: float | None, verdict: str | None
) -> list[Line2D]:
    """Mark a condition by a star and its verdict, or by a line where only one of both is known."""
    style: dict[str, Any] = {"color": COLOURS["black"], "linestyle": DASHES[0], "linewidth": 1.2}
    if stiffness is None or delay is None:
        if stiffness is not None:
            axes.axvline(stiffness, **style)
            return [legend_line("this stiffness", COLOURS["black"], DASHES[0])]
        if delay is not None:
            axes.axhline(1e3 * delay, **style)
            return [legend_line("this delay", COLOURS["black"], DASHES[0])]
        return []
    if verdict is not None:
        _write_verdict(axes, stiffness, delay, verdict)
    return draw_study_mark(axes, StudyMark(stiffness, delay, delay), "this condition")


def _write_verdict(axes: Axes, stiffness: float, delay: float, verdict: str) -> None:
    """Write the answer beside a star: towards the middle, so that it stays on the map."""
    to_left, down = stiffness > 0.6 * axes.get_xlim()[1], 1e3 * delay > 0.85 * axes.get_ylim()[1]
    axes.annotate(
        verdict.upper(),
        (stiffness, 1e3 * delay),
        xytext=(-8 if to_left else 8, -9 if down else 5),
        textcoords="offset points",
        ha="right" if to_left else "left",
        fontsize=8.0,
        fontweight="bold",
        color=COLOURS["black"],
        zorder=8,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0},
    )


def _shade(axes: Axes, stiffness: Floats, delay: Floats, depth: Floats, **style: Any) -> None:
    """Shade where the depth (delay, stiffness) is positive; from the first stiffness to none it stays."""
    style = style or {"colors": [STABLE]}
    if (depth > 0.0).any():
        axes.contourf(
            np.concatenate([[0.0], stiffness]),
            1e3 * delay,
            np.column_stack([depth[:, 0], depth]),
            levels=[0.0, np.inf],
            **style,
        )


def _outline(
    axes: Axes,
    stiffness: Floats,
    delay: Floats,
    depth: Floats,
    colour: str,
    dashes: LineStyleType = "solid",
) -> None:
    if (depth > 0.0).any() and (depth < 0.0).any():
        drawn: dict[str, Any] = {"colors": [colour], "linestyles": [dashes], "linewidths": 1.2}
        axes.contour(stiffness, 1e3 * delay, depth, levels=[0.0], **drawn)


def tier_map(
    axes_shown: Sequence[MapAxis],
    *,
    any_network: float,
    any_constant: float,
    bounded: tuple[NDArray[np.float64], NDArray[np.float64]] | None,
    conditions: Sequence[tuple[float, float]],
    extent: tuple[float, float],
    mark: StudyMark | None = None,
    stable_for: str = "all axes",
    judged: NDArray[np.float64] | None = None,
    verdict: str | None = None,
    is_sampled: bool = False,
) -> Figure:
    """Draw what each tier allows, with the exact boundary of every axis and the paper's.

    `any_network` and `any_constant` are the stiffnesses (N/m) that the two delay-free verdicts allow, and
    `bounded` is the limit of the varying-delay verdict: stiffness (N/m) and longest one-way age of a sample
    (s); None if that verdict is not available. Crosses mark the conditions of the paper's experiment.
    `extent` is the largest stiffness (N/m) and delay (s) drawn; `mark` is the study, and `verdict` the answer
    there. The region lies below `judged`, the longest stable delay (s) at each stiffness, if that is given,
    or else below the boundaries; the legend says by `stable_for` what it holds for. With `is_sampled` only
    the boundaries and the limit for any constant delay are those of continuous controllers.
    """
    widest, longest = extent
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 4.4), layout="constrained")
        axes = figure.subplots()
        stiffness = axes_shown[0].stiffness
        worst = np.min([axis.exact for axis in axes_shown], axis=0) if judged is None else judged
        axes.fill_between(stiffness, 0.0, 1e3 * np.minimum(worst, 2 * longest), color=STABLE, linewidth=0.0)
        continuous = ", continuous controllers" if is_sampled else ""
        for axis, colour in zip(axes_shown, _AXIS_COLOURS, strict=False):
            shown = np.where(np.isfinite(axis.exact), axis.exact, np.nan)
            axes.plot(axis.stiffness, 1e3 * shown, color=colour, label=f"axis {axis.name}, exact{continuous}")
            if axis.printed is not None:
                printed = np.where(np.isfinite(axis.printed), axis.printed, np.nan)
                inside = np.flatnonzero(1e3 * printed < 1e3 * longest)
                axes.plot(
                    axis.stiffness[inside][::12],
                    1e3 * printed[inside][::12],
                    linestyle="none",
                    marker="o",
                    markersize=3.6,
                    markerfacecolor="white",
                    markeredgecolor=colour,
                    label=f"axis {axis.name}, paper",
                )
        green, black = COLOURS["green"], COLOURS["black"]
        axes.axvline(any_network, color=green, linestyle=DASHES[0], label="any network: left of this")
        axes.axvline(
            any_constant,
            color=black,
            linestyle=DASHES[1],
            linewidth=1.0,
            label=f"any constant delay{continuous}: left of this",
        )
        if bounded is not None:
            axes.plot(
                bounded[0],
                1e3 * bounded[1],
                color=COLOURS["orange"],
                linestyle=DASHES[3],
                label="bounded varying delay: below this",
            )
        if conditions:
            axes.plot(
                [stiffness for stiffness, _ in conditions],
                [1e3 * delay for _, delay in conditions],
                linestyle="none",
                marker="x",
                markersize=4.5,
                color=black,
                clip_on=False,
                zorder=6,
                label="the paper's experiment",
            )
        axes.set(
            xlim=(0.0, widest),
            ylim=(0.0, 1e3 * longest),
            xlabel="Stiffness k, N/m",
            ylabel="One-way delay δ, ms",
        )
        handles, _ = axes.get_legend_handles_labels()
        if mark is not None:
            handles += draw_study_mark(axes, mark)
            if verdict is not None:
                _write_verdict(axes, mark.stiffness, mark.delay, verdict)
        handles.insert(0, Patch(color=STABLE, label=f"constant delay, stable: {stable_for}"))
        figure.legend(
            handles=handles,
            loc="outside upper center",
            ncols=3 if judged is None else 2,
            columnspacing=1.4,
        )
    return figure


def region_map(
    panels: Sequence[tuple[str, Sequence[MapColumn], NDArray[np.float64]]],
    *,
    longest: Sequence[float],
    marks: Sequence[tuple[float, float] | None],
) -> Figure:
    """Draw the stable region of single axes, and what the paper wrongly calls stable.

    A panel has a title, columns at evenly spaced stiffness, and the delay (s) up to which the paper's
    formulas call each column stable; further the largest delay drawn (s), and a stiffness and delay to mark,
    or None.
    """
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 3.3), layout="constrained")
        grid = figure.subplots(1, len(panels), squeeze=False)[0]
        for i, (axes, (title, columns, printed)) in enumerate(zip(grid, panels, strict=True)):
            stiffness, delay, depth = draw_stable_region(axes, columns, longest[i])
            claimed = np.where(np.isfinite(printed), printed, 2 * longest[i]) - delay[:, None]
            _shade(axes, stiffness, delay, np.minimum(claimed, -depth), colors=["none"], hatches=["//////"])
            edge = np.where(np.isfinite(printed), printed, np.nan)
            axes.plot(stiffness, 1e3 * edge, color=COLOURS["vermilion"], linestyle=DASHES[1])
            first = int(np.argmax(np.isfinite(printed)))
            if np.isfinite(printed).any() and first > 0:
                axes.plot(
                    [stiffness[first]] * 2,
                    [1e3 * min(printed[first], longest[i]), 1e3 * longest[i]],
                    color=COLOURS["vermilion"],
                    linestyle=DASHES[1],
                )
            mark = marks[i]
            if mark is not None:
                axes.plot([mark[0]], [1e3 * mark[1]], "x", color=COLOURS["black"], markersize=6, zorder=6)
            axes.set(
                xlim=(0.0, stiffness[-1]),
                ylim=(0.0, 1e3 * longest[i]),
                xlabel="Stiffness k, N/m",
            )
            panel_label(axes, "ab"[i], title)
        grid[0].set_ylabel("One-way delay δ, ms")
        figure.legend(
            handles=[
                Patch(facecolor=STABLE, edgecolor=COLOURS["blue"], label="stable (exact)"),
                Patch(facecolor="none", edgecolor="black", hatch="//////", label="stable only by the paper"),
                legend_line("the paper's boundary (Eqs. 5 to 9)", COLOURS["vermilion"], DASHES[1]),
            ],
            loc="outside upper center",
            ncols=3,
        )
    return figure
