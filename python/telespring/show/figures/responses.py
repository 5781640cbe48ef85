"""Fig. 5: responses of both robots to opposite steps of force, over stiffness and delay."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.typing import LineStyleType
from numpy.typing import NDArray

from telespring.show.figures.style import COLOURS, FULL_WIDTH, figure_style, legend_line, panel_label

__all__ = ["ResponsePanel", "draw_motion", "motion_legend", "response_figure"]

_AXIS_COLOURS = (COLOURS["blue"], COLOURS["vermilion"], COLOURS["green"], COLOURS["purple"])
_ROBOT_DASHES: tuple[LineStyleType, ...] = ("solid", (0.0, (3.0, 1.4)))


@dataclass(frozen=True)
class ResponsePanel:
    """One simulation.

    Attributes
    ----------
    letter
        The panel's letter in the paper's figure, or "" if the paper has no such panel.
    setting
        Stiffness and delay in words.
    time
        s; a simulation that diverged may have fewer samples than the others.
    position
        Position in m, indexed by time, robot, axis.
    verdicts
        Per axis "stable", "marginal" or "unstable".
    """

    letter: str
    setting: str
    time: NDArray[np.float64]
    position: NDArray[np.float64]
    verdicts: Sequence[str]


def draw_motion(axes: Axes, time: NDArray[np.float64], position: NDArray[np.float64]) -> None:
    """Draw positions (m, indexed by time, robot, axis) in mm: a colour per axis, robot 2 dashed."""
    for axis in range(position.shape[2]):
        for robot in range(2):
            axes.plot(
                time,
                1e3 * position[:, robot, axis],
                color=_AXIS_COLOURS[axis % len(_AXIS_COLOURS)],
                linestyle=_ROBOT_DASHES[robot],
                linewidth=0.9,
            )


def motion_legend(axis_names: Sequence[str]) -> list[Line2D]:
    """Return the lines of a legend for `draw_motion`."""
    return [
        legend_line(
            f"robot {robot + 1}, axis {name}",
            _AXIS_COLOURS[axis % len(_AXIS_COLOURS)],
            _ROBOT_DASHES[robot],
        )
        for axis, name in enumerate(axis_names)
        for robot in range(2)
    ]


def response_figure(axis_names: Sequence[str], panels: Sequence[Sequence[ResponsePanel]]) -> Figure:
    """Draw the grid of responses in time, a row per stiffness and a column per delay."""
    rows, columns = len(panels), len(panels[0])
    longest = max(float(panel.time[-1]) for row in panels for panel in row)
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 1.5 * rows + 0.5), layout="constrained")
        grid = figure.subplots(rows, columns, sharex=True, squeeze=False)
        for row, row_panels in enumerate(panels):
            for column, panel in enumerate(row_panels):
                axes = grid[row, column]
                draw_motion(axes, panel.time, panel.position)
                extent = 1.12e3 * float(np.nanmax(np.abs(panel.position)))
                # Room for the line of words under the curves.
                axes.set(xlim=(0.0, longest), ylim=(-1.45 * extent, extent))
                axes.locator_params(axis="y", nbins=5)
                panel_label(axes, panel.letter, panel.setting)
                words = ", ".join(
                    f"{name} {verdict}" for name, verdict in zip(axis_names, panel.verdicts, strict=True)
                )
                if len(set(panel.verdicts)) == 1:
                    words = panel.verdicts[0] if len(axis_names) == 1 else f"all axes {panel.verdicts[0]}"
                axes.text(
                    0.97, 0.04, words, transform=axes.transAxes, ha="right", fontsize=6.6, color="#303030"
                )
        handles = motion_legend(axis_names)
        figure.legend(handles=handles, loc="outside upper center", ncols=min(4, len(handles)))
        figure.supxlabel("Time after the step, s", fontsize=7.5)
        figure.supylabel("Position, mm", fontsize=7.5)
    return figure
