"""Figures of repeated trials: trajectories (Fig. 7) and tracking errors (Fig. 8)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullLocator
from numpy.typing import NDArray

from telespring.show.figures.style import COLOURS, FULL_WIDTH, GREY, figure_style, legend_line

__all__ = ["ErrorGroup", "TrialPanel", "error_figure", "trajectory_figure"]

_ROBOTS = (COLOURS["blue"], COLOURS["vermilion"])
#: Maximum number of points per trajectory; more cannot be distinguished in such a small panel.
_POINTS = 600
#: Dots per inch of the trajectories, which are rasterised: as paths in the SVG they would take 20 MB.
_DOTS = 180
#: A panel shows at most this multiple of the target's extent; larger motions leave it.
_WIDEST = 1.6
#: Margins in inch: at the figure's edges, above each row of panels, and on either side of each pair.
_LEFT, _RIGHT, _TOP, _BOTTOM, _ABOVE, _BESIDE = 0.52, 0.05, 0.22, 0.36, 0.19, 0.16


@dataclass(frozen=True)
class TrialPanel:
    """The repeated trials of one condition.

    Attributes
    ----------
    title
        Name of the condition.
    position
        m, (trial, time, robot, axis); NaN after the end of a trial.
    target
        m, (time, axis).
    note
        A short remark, such as the number of trials that ended early; "" for none.
    """

    title: str
    position: NDArray[np.float64]
    target: NDArray[np.float64]
    note: str = ""


@dataclass(frozen=True)
class ErrorGroup:
    """The tracking errors of one condition.

    Attributes
    ----------
    label
        Tick label of the group, such as the delay.
    family
        Name under which neighbouring groups are bracketed, such as a stiffness.
    errors
        Per robot the tracking error of each trial, m; NaN if there is none.
    arrows
        Per robot "↑", "↓" or "".
    ended_early
        Number of trials without a tracking error.
    """

    label: str
    family: str
    errors: tuple[NDArray[np.float64], NDArray[np.float64]]
    arrows: tuple[str, str]
    ended_early: int = 0


def trajectory_figure(unconnected: TrialPanel | None, grid: Sequence[Sequence[TrialPanel | None]]) -> Figure:
    """Draw the paths of both robots in the plane, all trials of a condition over each other (Fig. 7).

    Every condition shows robot 1 on the left and robot 2 on the right, with the target; all panels share one
    scale, and a note marks motions that leave the panel. The unconnected mode has a column of its own; the
    grid has a row per stiffness and a column per delay, and None if there is no condition.
    """
    columns = max([len(row) for row in grid], default=0) + (unconnected is not None)
    placed: dict[tuple[int, int], TrialPanel] = {}
    if unconnected is not None:
        placed[0, 0] = unconnected
    for row, panels in enumerate(grid):
        for column, panel in enumerate(panels):
            if panel is not None:
                placed[row, column + (unconnected is not None)] = panel
    extent = _trajectory_half_extent(list(placed.values()))
    # All panels have the aspect ratio of their content, so their places are computed, in inch.
    cell = min(2.4, (FULL_WIDTH - _LEFT - _RIGHT) / max(1, columns))
    width = 0.5 * (cell - _BESIDE)
    height = min(3.0, width * extent[1] / extent[0])
    rows = max(1, len(grid))
    total = _TOP + rows * (height + _ABOVE) + _BOTTOM
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, total), dpi=_DOTS)
        for (row, column), panel in placed.items():
            bottom = _BOTTOM + (rows - 1 - row) * (height + _ABOVE)
            for robot in range(2):
                left = _LEFT + column * cell + robot * (width + 0.4 * _BESIDE)
                place = (left / FULL_WIDTH, bottom / total, width / FULL_WIDTH, height / total)
                axes = figure.add_axes(place)
                _draw_trajectories(axes, panel, robot, extent)
                axes.tick_params(
                    labelbottom=(row + 1, column) not in placed,
                    labelleft=robot == 0 and (row, column - 1) not in placed,
                )
                if robot == 0 and (row, column - 1) not in placed:
                    axes.set_ylabel("Position y, mm", fontsize=6.5, labelpad=1.5)
                if robot == 0:
                    axes.set_title(panel.title, loc="left", pad=2.5, fontsize=6.6)
                elif panel.note:
                    _annotate_trajectory_panel(axes, 0.985, panel.note, "top", "#A03000")
        handles = [
            *(
                legend_line(f"robot {robot + 1} ({side} of each pair)", _ROBOTS[robot])
                for robot, side in ((0, "left"), (1, "right"))
            ),
            legend_line("target", "black", linewidth=0.6),
        ]
        figure.legend(handles=handles, loc="upper center", ncols=3, borderaxespad=0.2)
        figure.supxlabel("Position x, mm", fontsize=7.5, y=0.05 / total, va="bottom")
    return figure


def _trajectory_half_extent(panels: Sequence[TrialPanel]) -> NDArray[np.float64]:
    """Choose half the width and height that all panels show, mm."""
    target = 1e3 * np.max([np.nanmax(np.abs(panel.target), axis=0) for panel in panels], axis=0)
    target = np.maximum(target, 0.25 * target.max())
    moved = target
    for panel in panels:
        present = np.isfinite(panel.position).all(axis=-1).any(axis=-1).any(axis=-1)
        if present.any():
            # Without the widest fifth, so that a few diverging trials do not shrink the others.
            farthest = np.nanmax(np.abs(panel.position[present]), axis=(1, 2))
            moved = np.maximum(moved, 1e3 * np.quantile(farthest, 0.8, axis=0))
    return np.asarray(1.08 * np.minimum(moved, _WIDEST * target))


def _draw_trajectories(axes: Axes, panel: TrialPanel, robot: int, extent: NDArray[np.float64]) -> None:
    stride = max(1, math.ceil(panel.position.shape[1] / _POINTS))
    shown = 1e3 * panel.position[:, ::stride, robot]
    lines = [path[np.isfinite(path).all(axis=-1)] for path in shown]
    # Anything further out is invisible, and huge coordinates break the renderer.
    lines = [np.clip(path, -4.0 * extent, 4.0 * extent) for path in lines if len(path) > 1]
    axes.add_collection(
        LineCollection(lines, colors=_ROBOTS[robot], linewidths=0.35, alpha=0.35, rasterized=True),
        autolim=False,
    )
    target = 1e3 * panel.target[:: max(1, stride // 2)]
    axes.add_collection(
        LineCollection(
            [target[np.isfinite(target).all(axis=-1)]], colors="black", linewidths=0.45, rasterized=True
        ),
        autolim=False,
    )
    axes.set(xlim=(-extent[0], extent[0]), ylim=(-extent[1], extent[1]))
    step = 10.0 ** math.floor(math.log10(extent[0]))
    edge = step * math.floor(0.85 * extent[0] / step)
    axes.set_xticks([-edge, 0.0, edge] if edge else [0.0], [f"{-edge:g}", "", f"{edge:g}"] if edge else ["0"])
    axes.locator_params(axis="y", nbins=5)
    axes.tick_params(labelsize=5.4, pad=1.5, length=1.5)
    if any(np.any(np.abs(path) > 1.1 * extent) for path in lines):
        _annotate_trajectory_panel(axes, 0.015, "leaves the panel", "bottom", "#303030")


def _annotate_trajectory_panel(axes: Axes, height: float, note: str, anchor: str, colour: str) -> None:
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6}
    axes.text(
        0.5,
        height,
        note,
        transform=axes.transAxes,
        ha="center",
        va=anchor,
        fontsize=4.8,
        color=colour,
        bbox=box,
    )


def error_figure(groups: Sequence[ErrorGroup], baseline: float | None, baseline_name: str = "UM") -> Figure:
    """Draw the tracking errors of both robots in every condition as boxes (Fig. 8).

    A box shows median and quartiles, its whiskers reach to the last value within 1.5 box heights, and every
    trial is a marker. An arrow above a box marks a significant difference from the baseline, whose median TE2
    is `baseline`, m, and None where there is no baseline.
    """
    values = [1e3 * np.concatenate(group.errors) for group in groups]
    finite = np.concatenate(values)
    finite = finite[np.isfinite(finite)]
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 3.1), layout="constrained")
        axes = figure.subplots()
        places = _error_box_places(groups)
        logarithmic = len(finite) > 0 and finite.min() > 0.0 and finite.max() > 8.0 * np.median(finite)
        if logarithmic:
            axes.set_yscale("log")
            axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axes.yaxis.set_major_formatter("{x:g}")
            axes.yaxis.set_minor_locator(NullLocator())
        for place, group in zip(places, groups, strict=True):
            for robot in range(2):
                _draw_error_box(axes, place + (robot - 0.5) * 0.44, group, robot)
            if group.ended_early:
                axes.annotate(
                    f"{group.ended_early} ended\nearly",
                    (place, 0.0),
                    (0.0, 3.0),
                    xycoords=axes.get_xaxis_transform(),
                    textcoords="offset points",
                    ha="center",
                    fontsize=5.2,
                    color="#A03000",
                )
        if baseline is not None:
            axes.axhline(1e3 * baseline, color="black", linewidth=0.7, linestyle=(0.0, (4.0, 2.0)), zorder=1)
        axes.set_xticks(places, [group.label for group in groups])
        axes.tick_params(axis="x", length=0.0)
        axes.set_xlim(places[0] - 0.7, places[-1] + 0.7)
        axes.grid(axis="y", color="#E4E4E4", linewidth=0.5)
        axes.set_axisbelow(True)
        _draw_significance_brackets(axes, places, groups)
        low, high = axes.get_ylim()
        # Room for the arrows above the highest box.
        axes.set_ylim(low, high * (high / low) ** 0.06 if logarithmic else high + 0.06 * (high - low))
        axes.set_ylabel("Tracking error, mm")
        axes.set_xlabel("One-way delay within each stiffness, ms", labelpad=16.0)
        handles: list[Patch | Line2D] = [
            Patch(facecolor=_ROBOTS[0], alpha=0.35, edgecolor=_ROBOTS[0], label="TE1, robot 1 (dots)"),
            Patch(
                facecolor=_ROBOTS[1],
                alpha=0.35,
                edgecolor=_ROBOTS[1],
                hatch="////",
                label="TE2, robot 2 (triangles)",
            ),
        ]
        if baseline is not None:
            handles += [
                legend_line(
                    f"median TE2 in {baseline_name}, {1e3 * baseline:.2f} mm",
                    "black",
                    (0.0, (4.0, 2.0)),
                    linewidth=0.7,
                ),
                Line2D([], [], linestyle="none", label=f"↑ ↓ differs from TE2 in {baseline_name}, p < 0.05"),
            ]
        figure.legend(
            handles=handles, loc="outside upper center", ncols=4, handlelength=1.8, columnspacing=1.2
        )
    return figure


def _error_box_places(groups: Sequence[ErrorGroup]) -> list[float]:
    places, place = [], 0.0
    for i, group in enumerate(groups):
        if i:
            place += 1.0 if group.family == groups[i - 1].family else 1.5
        places.append(place)
    return places


def _draw_error_box(axes: Axes, place: float, group: ErrorGroup, robot: int) -> None:
    errors = 1e3 * group.errors[robot]
    errors = errors[np.isfinite(errors)]
    if len(errors) == 0:
        return
    colour = _ROBOTS[robot]
    drawn = axes.boxplot(
        [errors],
        positions=[place],
        widths=0.36,
        patch_artist=True,
        showfliers=False,
        manage_ticks=False,
        medianprops={"color": "black", "linewidth": 0.9},
        whiskerprops={"color": colour, "linewidth": 0.7},
        capprops={"color": colour, "linewidth": 0.7},
    )
    for box in drawn["boxes"]:
        box.set(edgecolor=colour, linewidth=0.7, hatch="////" if robot else None)
        box.set_facecolor(to_rgba(colour, 0.28))
    # A fixed spread, so that the same trials give the same figure.
    spread = 0.24 * (((np.arange(len(errors)) * 0.618034) % 1.0) - 0.5)
    axes.plot(
        place + spread,
        errors,
        "^" if robot else "o",
        color=colour,
        markersize=1.5,
        markeredgewidth=0.0,
        alpha=0.8,
    )
    if group.arrows[robot]:
        axes.annotate(
            group.arrows[robot],
            (place, float(errors.max())),
            (0.0, 2.0),
            textcoords="offset points",
            ha="center",
            fontsize=8.0,
            color=colour,
            fontweight="bold",
        )


def _draw_significance_brackets(axes: Axes, places: Sequence[float], groups: Sequence[ErrorGroup]) -> None:
    for family in dict.fromkeys(group.family for group in groups if group.family):
        inside = [place for place, group in zip(places, groups, strict=True) if group.family == family]
        transform = axes.get_xaxis_transform()
        ends = [inside[0] - 0.45, inside[-1] + 0.45]
        axes.plot(ends, [-0.085] * 2, color=GREY, linewidth=0.7, transform=transform, clip_on=False)
        axes.text(
            0.5 * (inside[0] + inside[-1]),
            -0.1,
            family,
            transform=transform,
            ha="center",
            va="top",
            fontsize=7.0,
        )
