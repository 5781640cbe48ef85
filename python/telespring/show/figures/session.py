"""A live session over time: handles and target, forces, ages, energy accounts, and what happened when."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.typing import LineStyleType

from telespring._types import FloatArray
from telespring.show.figures.style import (
    COLOURS,
    FULL_WIDTH,
    GREY,
    ROBOT_COLOURS,
    figure_style,
    legend_line,
    panel_label,
)

__all__ = ["SessionPanels", "session_figure"]

#: No more points are drawn of a signal: the extremes of each stretch of time.
_MOST_POINTS = 3000
#: Names of events have no room for more.
_MOST_NAMES = 12
_ROBOT_DASHES: tuple[LineStyleType, LineStyleType] = ("solid", (0.0, (5.0, 1.6)))
_TARGET: LineStyleType = (0.0, (1.2, 1.2))
_TRIAL = "#EEF3F8"


@dataclass(frozen=True, eq=False)
class SessionPanels:
    """What the figure shows; NaN is not known, and a panel of which nothing is known is left out.

    Attributes
    ----------
    time
        s, (time,).
    position
        Of both handles, m, (time, robot, axis).
    target
        m, (time, axis).
    force
        Length of the coupling force on each handle, N, (time, robot).
    age
        Of the partner's motion in use, s, (time, robot).
    account
        Energy in the account, J, (time, robot).
    events
        Time (s) and name of what happened.
    trials
        Beginning and end (s) and label of each marked trial.
    note
        What the recording does not know; "" if it knows all.
    """

    time: FloatArray
    position: FloatArray
    target: FloatArray
    force: FloatArray
    age: FloatArray
    account: FloatArray
    events: Sequence[tuple[float, str]]
    trials: Sequence[tuple[float, float, str]]
    note: str = ""


def session_figure(panels: SessionPanels) -> Figure:
    """Draw the signals of a session below each other, over one axis of time."""
    rows = [
        (
            f"{axis} of handles and target",
            f"Position {axis}, mm",
            1e3 * panels.position[..., i],
            panels.target[:, i],
        )
        for i, axis in enumerate("xy")
    ]
    quantities = [
        (title, label, values, target)
        for title, label, values, target in (
            *rows,
            ("force of the spring on each handle", "Force, N", panels.force, None),
            ("age of the partner's motion in use", "Age, ms", 1e3 * panels.age, None),
            ("energy in the account of each side", "Energy, mJ", 1e3 * panels.account, None),
        )
        if np.isfinite(values).any()
    ]
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 0.9 + 1.25 * max(1, len(quantities))), layout="constrained")
        all_axes = figure.subplots(max(1, len(quantities)), 1, sharex=True, squeeze=False)[:, 0]
        for axes, letter, (title, label, values, target) in zip(all_axes, "abcde", quantities, strict=False):
            _draw_signal(axes, panels, values, target)
            axes.set_ylabel(label)
            panel_label(axes, letter, title)
        all_axes[-1].set_xlabel("Time since the beginning of the recording, s")
        _name_events(all_axes[0], panels)
        _add_legend(figure, panels)
        if panels.note:
            figure.supxlabel(panels.note, fontsize=7.0, color="#606060")
        if panels.time.size > 1:
            all_axes[0].set_xlim(panels.time[0], panels.time[-1])
        figure.align_ylabels()
    return figure


def _draw_signal(axes: Axes, panels: SessionPanels, values: FloatArray, target: FloatArray | None) -> None:
    for begin, end, _ in panels.trials:
        axes.axvspan(begin, end, facecolor=_TRIAL, edgecolor="white", linewidth=1.5, zorder=0)
    for time, _ in panels.events:
        axes.axvline(time, color=GREY, linewidth=0.5, zorder=1)
    if target is not None:
        axes.plot(
            *_extremes(panels.time, 1e3 * target), color=COLOURS["black"], linestyle=_TARGET, linewidth=0.9
        )
    for robot in range(2):
        if np.isfinite(values[:, robot]).any():
            axes.plot(
                *_extremes(panels.time, values[:, robot]),
                color=ROBOT_COLOURS[robot],
                linestyle=_ROBOT_DASHES[robot],
                linewidth=0.9,
            )


def _add_legend(figure: Figure, panels: SessionPanels) -> None:
    lines = [
        legend_line(f"robot {robot + 1}", ROBOT_COLOURS[robot], _ROBOT_DASHES[robot])
        for robot in range(2)
        if np.isfinite(panels.position[:, robot]).any() or np.isfinite(panels.force[:, robot]).any()
    ]
    if np.isfinite(panels.target).any():
        lines.append(legend_line("target", COLOURS["black"], _TARGET))
    if panels.events:
        lines.append(legend_line("event", GREY, linewidth=0.5))
    figure.legend(handles=lines, loc="outside upper right", ncols=max(1, len(lines)))


def _name_events(axes: Axes, panels: SessionPanels) -> None:
    """Write the names of the first events into the uppermost panel, each where it happened."""
    late = panels.time[-1] - 0.12 * np.ptp(panels.time) if panels.time.size else np.inf
    for i, (time, name) in enumerate(panels.events[:_MOST_NAMES]):
        is_late = time > late
        axes.annotate(
            name,
            (time, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(-1.5 if is_late else 1.5, -7.0 - 7.5 * (i % 4)),
            textcoords="offset points",
            ha="right" if is_late else "left",
            fontsize=5.5,
            color="#404040",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.4},
            annotation_clip=True,
        )
    for begin, end, name in panels.trials:
        axes.text(
            (begin + end) / 2.0,
            0.02,
            name,
            transform=axes.get_xaxis_transform(),
            ha="center",
            va="bottom",
            fontsize=5.5,
            color="#404040",
            clip_on=True,
            parse_math=False,
        )


def _extremes(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Thin a signal out to the smallest and the largest value of each stretch; gaps stay gaps."""
    if time.size <= _MOST_POINTS:
        return time, values
    kept: list[int] = []
    for stretch in np.array_split(np.arange(time.size), _MOST_POINTS // 2):
        known = stretch[np.isfinite(values[stretch])]
        if known.size:
            kept += sorted({int(known[values[known].argmin()]), int(known[values[known].argmax()])})
        else:
            kept.append(int(stretch[0]))
    return time[kept], values[kept]
