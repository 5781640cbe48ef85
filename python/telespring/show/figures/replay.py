"""A replayed session: forces as recorded and as replayed, ages, and the energy in the accounts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from telespring._types import FloatArray
from telespring.show.figures.style import (
    COLOURS,
    FULL_WIDTH,
    ROBOT_COLOURS,
    figure_style,
    legend_line,
    panel_label,
)
from telespring.show.figures.thinning import extremes

__all__ = ["ReplayPanels", "ReplayedCurves", "replay_figure"]

_DASHED = (0.0, (5.0, 1.6))


@dataclass(frozen=True, eq=False)
class ReplayedCurves:
    """One side: time (s), forces (N, per axis), ages (s) and accounts (J), as recorded and as replayed.

    NaN where there is none.
    """

    side: int
    time: FloatArray
    recorded_force: FloatArray
    force: FloatArray
    recorded_age: FloatArray
    age: FloatArray
    recorded_account: FloatArray
    account: FloatArray


@dataclass(frozen=True, eq=False)
class ReplayPanels:
    """What the figure shows: both settings in words, and each side."""

    recorded: str
    replayed: str
    sides: Sequence[ReplayedCurves]


def replay_figure(panels: ReplayPanels) -> Figure:
    """Draw the forces of each side along both axes, the ages, and the accounts if there are any."""
    has_account = any(
        np.isfinite(values).any() for side in panels.sides for values in (side.recorded_account, side.account)
    )
    rows = 2 * len(panels.sides) + 1 + int(has_account)
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 0.6 + 1.25 * rows), layout="constrained")
        axes = figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]
        labels = iter("abcdef")
        places = iter(axes)
        for side in panels.sides:
            for axis, name in enumerate("xy"):
                _draw_force(
                    next(places), side, axis, next(labels), f"force on handle {side.side} along {name}"
                )
        ages = [(side.side, side.time, 1e3 * side.recorded_age, 1e3 * side.age) for side in panels.sides]
        _draw_sides(next(places), ages, "Age, ms", next(labels), "age of the partner's motion in use")
        if has_account:
            accounts = [(side.side, side.time, side.recorded_account, side.account) for side in panels.sides]
            _draw_sides(next(places), accounts, "Account, J", next(labels), "energy in the account")
        axes[-1].set_xlabel("Time since the first tick of the side, s")
        lines = [
            legend_line(f"recorded: {panels.recorded}", COLOURS["black"], _DASHED),
            legend_line(f"replayed: {panels.replayed}", COLOURS["black"]),
        ]
        figure.legend(handles=lines, loc="outside upper right", ncols=2, borderaxespad=0.0)
    return figure


def _draw_force(axes: Axes, side: ReplayedCurves, axis: int, label: str, text: str) -> None:
    colour = ROBOT_COLOURS[(side.side - 1) % 2]
    axes.plot(*extremes(side.time, side.force[:, axis]), color=colour, linewidth=1.0)
    recorded = extremes(side.time, side.recorded_force[:, axis])
    axes.plot(*recorded, color=COLOURS["black"], linestyle=_DASHED, linewidth=0.8)
    axes.set_ylabel("Force, N")
    axes.margins(x=0.0)
    panel_label(axes, label, text)


def _draw_sides(
    axes: Axes,
    sides: Sequence[tuple[int, FloatArray, FloatArray, FloatArray]],
    unit: str,
    label: str,
    text: str,
) -> None:
    for side, time, recorded, replayed in sides:
        colour = ROBOT_COLOURS[(side - 1) % 2]
        for values, dash, width in ((replayed, "solid", 1.0), (recorded, _DASHED, 0.8)):
            is_known = np.isfinite(values)
            if is_known.any():
                axes.plot(
                    *extremes(time[is_known], values[is_known]), color=colour, linestyle=dash, linewidth=width
                )
        axes.plot([], [], color=colour, label=f"site {side}")
    axes.set_ylabel(unit)
    axes.margins(x=0.0)
    if len(sides) > 1:
        axes.legend(loc="best", ncols=2, frameon=True, framealpha=0.9, edgecolor="none")
    panel_label(axes, label, text)
