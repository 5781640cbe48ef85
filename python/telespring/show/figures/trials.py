"""Trajectories of repeated trials in the plane (Fig. 7)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from telespring.show.figures.style import COLOURS, FULL_WIDTH, figure_style, legend_line

__all__ = ["TrialPanel", "trajectory_figure"]

_ROBOTS = (COLOURS["blue"], COLOURS["vermilion"])
#: Maximum number of points per trajectory; more cannot be distinguished in such a small panel.
_POINTS = 600
#: Dots per inch of the trajectories, which are rasterised: as paths in the SVG they would take 20 MB.
_DOTS = 180
#: Panels whose motions reach up to this multiple of the target share one scale; wider ones get a wider view.
_COMMON = 2.2
#: How many times wider a view may be; what moves still further leaves its panel.
_VIEWS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 15.0)
#: Where all trials together visit this share of the target's rectangle, they hide each other: one is shown.
_FILLED = 0.97
#: Margins in inch: at the figure's edges, above each row of panels, and on either side of each pair.
_LEFT, _RIGHT, _TOP, _BOTTOM, _ABOVE, _BESIDE = 0.52, 0.05, 0.22, 0.36, 0.19, 0.16
#: Room above a row where the row before has tick labels, inch.
_LABELLED = 0.29

_Place = tuple[int, int]


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
    ended_early
        Which trials ended early, and so may run away; None: none of them.
    """

    title: str
    position: NDArray[np.float64]
    target: NDArray[np.float64]
    note: str = ""
    ended_early: NDArray[np.bool_] | None = None


def trajectory_figure(unconnected: TrialPanel | None, grid: Sequence[Sequence[TrialPanel | None]]) -> Figure:
    """Draw the paths of both robots in the plane, all trials of a condition over each other (Fig. 7).

    Every condition shows robot 1 on the left and robot 2 on the right, with the target. Panels share one
    scale, in which all their completed trials are whole; motions that are much wider have a wider view, and a
    note says how much. Where the trials hide each other, one is shown. The unconnected mode has a column of
    its own; the grid has a row per stiffness and a column per delay, and None if there is no condition.
    """
    columns = max([len(row) for row in grid], default=0) + (unconnected is not None)
    placed: dict[_Place, TrialPanel] = {}
    if unconnected is not None:
        placed[0, 0] = unconnected
    for row, panels in enumerate(grid):
        for column, panel in enumerate(panels):
            if panel is not None:
                placed[row, column + (unconnected is not None)] = panel
    shown = {place: _shown_trials(panel) for place, panel in placed.items()}
    extent, views = _trajectory_views(placed, shown)
    labelled = {place for place in placed if _has_labels_below(place, views)}
    rows = max(1, len(grid))
    crowded = any(row < rows - 1 and (row + 1, column) in placed for row, column in labelled)
    above = _LABELLED if crowded else _ABOVE
    # All panels have the aspect ratio of their content, so their places are computed, in inch.
    cell = min(2.4, (FULL_WIDTH - _LEFT - _RIGHT) / max(1, columns))
    width = 0.5 * (cell - _BESIDE)
    height = min(3.0, width * extent[1] / extent[0])
    total = _TOP + rows * (height + above) + _BOTTOM
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, total), dpi=_DOTS)
        for (row, column), panel in placed.items():
            bottom = _BOTTOM + (rows - 1 - row) * (height + above)
            is_first = (row, column - 1) not in placed
            view = views[row, column]
            for robot in range(2):
                left = _LEFT + column * cell + robot * (width + 0.4 * _BESIDE)
                place = (left / FULL_WIDTH, bottom / total, width / FULL_WIDTH, height / total)
                axes = figure.add_axes(place)
                leaves = _draw_trajectories(axes, panel, shown[row, column], robot, view * extent)
                axes.tick_params(
                    labelbottom=(row, column) in labelled,
                    labelleft=robot == 0 and is_first and view == 1.0,
                )
                if robot == 0 and is_first:
                    axes.set_ylabel("Position y, mm", fontsize=6.5, labelpad=1.5)
                if robot == 0:
                    axes.set_title(panel.title, loc="left", pad=2.5, fontsize=6.6)
                elif panel.note:
                    _annotate_trajectory_panel(axes, 0.985, panel.note, "top", "#A03000")
                notes = [f"view {view:g}× wider"] if view > 1.0 else []
                if leaves:
                    notes.append("leaves the panel")
                if len(shown[row, column]) == 1 < len(panel.position):
                    notes.append(f"1 of {len(panel.position)} trials")
                if notes:
                    _annotate_trajectory_panel(axes, 0.015, "\n".join(notes), "bottom", "#303030")
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


def _has_labels_below(place: _Place, views: Mapping[_Place, float]) -> bool:
    """Whether a panel has the tick labels of its column: the lowest one with the common scale."""
    row, column = place
    same = [r for (r, c), view in views.items() if c == column and view == 1.0]
    return views[place] == 1.0 and row == max(same)


def _ended_early(panel: TrialPanel) -> NDArray[np.bool_]:
    return np.zeros(len(panel.position), dtype=bool) if panel.ended_early is None else panel.ended_early


def _shown_trials(panel: TrialPanel) -> list[int]:
    """Choose the trials to draw: all, or the median completed one where they hide each other."""
    everything = list(range(len(panel.position)))
    completed = np.flatnonzero(~_ended_early(panel))
    half = np.nanmax(np.abs(panel.target), axis=0)
    if len(completed) < 2 or half.min() <= 0.0:
        return everything
    edges = [np.linspace(-size, size, 31) for size in half]
    filled = False
    for robot in (0, 1):
        path = panel.position[:, :, robot].reshape(-1, 2)
        path = path[np.isfinite(path).all(axis=-1)]
        visited, *_ = np.histogram2d(path[:, 0], path[:, 1], bins=edges)
        filled |= bool(np.mean(visited > 0) >= _FILLED)
    if not filled:
        return everything
    with np.errstate(invalid="ignore"):
        distance = np.hypot(*np.moveaxis(panel.position[completed] - panel.target[:, None], -1, 0))
    typical = np.nanmean(distance, axis=(1, 2))
    return [int(completed[np.argsort(typical)[len(typical) // 2]])]


def _trajectory_views(
    placed: Mapping[_Place, TrialPanel], shown: Mapping[_Place, list[int]]
) -> tuple[NDArray[np.float64], dict[_Place, float]]:
    """Choose half the width and height of the common view, mm, and how many times wider each panel's is."""
    target = 1e3 * np.max([np.nanmax(np.abs(panel.target), axis=0) for panel in placed.values()], axis=0)
    target = np.maximum(target, max(0.25 * target.max(), 1e-3))
    reached = {place: _reach(panel, shown[place]) for place, panel in placed.items()}
    common = target
    for reach in reached.values():
        if np.all(reach <= _COMMON * target):
            common = np.maximum(common, reach)
    if all(np.any(reach > _COMMON * target) for reach in reached.values()):
        # Nothing is near the target: the narrowest motion sets the scale.
        narrowest = min(reached.values(), key=lambda reach: float(np.max(reach / target)))
        common = np.maximum(target, np.minimum(narrowest, _VIEWS[-1] * target))
    views = {}
    for place, reach in reached.items():
        needed = float(np.max(reach / common))
        views[place] = next((view for view in _VIEWS if view >= needed * (1.0 - 1e-9)), _VIEWS[-1])
    return np.asarray(1.08 * common), views


def _reach(panel: TrialPanel, shown: Sequence[int]) -> NDArray[np.float64]:
    """Compute how far the trials that are shown move, mm per axis: the completed ones, if there are any."""
    early = _ended_early(panel)
    completed = [trial for trial in shown if not early[trial]]
    size = np.abs(panel.position[completed or list(shown)]).reshape(-1, 2)
    size = size[np.isfinite(size).all(axis=-1)]
    if not len(size):
        return np.zeros(2)
    return np.asarray(1e3 * (size.max(axis=0) if completed else np.quantile(size, 0.8, axis=0)))


def _draw_trajectories(
    axes: Axes, panel: TrialPanel, trials: Sequence[int], robot: int, extent: NDArray[np.float64]
) -> bool:
    """Draw one robot's trials and the target; return whether any of them leaves the panel."""
    stride = max(1, math.ceil(panel.position.shape[1] / _POINTS)) if len(trials) > 1 else 1
    shown = 1e3 * panel.position[list(trials), ::stride, robot]
    lines = [path[np.isfinite(path).all(axis=-1)] for path in shown]
    # Anything further out is invisible, and huge coordinates break the renderer.
    lines = [np.clip(path, -4.0 * extent, 4.0 * extent) for path in lines if len(path) > 1]
    alone = len(trials) == 1
    axes.add_collection(
        LineCollection(
            lines,
            colors=_ROBOTS[robot],
            linewidths=0.5 if alone else 0.35,
            alpha=0.8 if alone else 0.35,
            rasterized=True,
        ),
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
    step = 10.0 ** math.floor(math.log10(0.85 * extent[0]))
    edge = step * math.floor(0.85 * extent[0] / step)
    axes.set_xticks([-edge, 0.0, edge], [f"{-edge:g}", "", f"{edge:g}"])
    axes.locator_params(axis="y", nbins=5)
    axes.tick_params(labelsize=5.4, pad=1.5, length=1.5)
    return any(np.any(np.abs(path) > extent) for path in lines)


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
