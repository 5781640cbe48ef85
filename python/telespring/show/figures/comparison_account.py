"""One trial under an energy account: what the account held, what the force was, where the handles were."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from telespring.show.figures.style import (
    COLOURS,
    FULL_WIDTH,
    GREY,
    ROBOT_COLOURS,
    figure_style,
    legend_line,
    sized_figure,
)

__all__ = ["AccountTrial", "account_figure"]

Floats = NDArray[np.float64]
Intervals = Sequence[tuple[float, float]]

_DASHED = (0.0, (3.5, 1.5))
_DOTTED = (0.0, (1.0, 1.2))
_LIMITED = "#E8D9A8"


@dataclass(frozen=True)
class AccountTrial:
    """One trial; a quantity that was not kept is None, and its panel is left out.

    Attributes
    ----------
    time
        s.
    balance
        What the account of each side held, J, (time, robot).
    spring_energy
        Energy of a spring that pulls with the force that acted, |F|²/2k, J, (time, robot).
    limited
        From when to when the account limited the force of each robot, s.
    intended, delivered
        Length of the force of a spring without delay, and of the one that acted, N, (time, robot).
    position, target
        Of both handles, m, (time, robot), and of the target, m, (time,), along `axis`.
    without_guard
        Position of the handles in the same trial under the bare spring, m, (time, robot).
    axis
        Name of the axis of the positions.
    """

    time: Floats
    balance: Floats
    spring_energy: Floats | None = None
    limited: tuple[Intervals, Intervals] | None = None
    intended: Floats | None = None
    delivered: Floats | None = None
    position: Floats | None = None
    target: Floats | None = None
    without_guard: Floats | None = None
    axis: str = "y"


def account_figure(trial: AccountTrial, title: str = "", figure: Figure | None = None) -> Figure:
    """Draw one trial over time: energy, a panel per robot; its force; and the positions of both handles.

    Shaded is the time in which the account limited the force. Energy and force of robot 2 have their own
    panels, so that nothing hides anything.
    """
    has_force = trial.delivered is not None
    has_position = trial.position is not None
    rows = 2 + 2 * has_force + has_position
    with figure_style():
        figure = sized_figure(figure, FULL_WIDTH, 0.75 + 0.95 * rows + 0.35 * has_position)
        figure.set_layout_engine("constrained")
        heights = [1.0] * (2 + 2 * has_force) + [1.5] * has_position
        column = figure.subplots(rows, 1, squeeze=False, sharex=True, height_ratios=heights)[:, 0]
        for robot in (0, 1):
            axes = column[robot * (1 + has_force)]
            _shade_limited(axes, trial, robot)
            _draw_energy(axes, trial, robot)
            if has_force:
                axes = column[robot * 2 + 1]
                _shade_limited(axes, trial, robot)
                _draw_force(axes, trial, robot)
        if has_position:
            _draw_positions(column[-1], trial)
        column[0].set_xlim(float(trial.time[0]), float(trial.time[-1]))
        column[-1].set_xlabel("Time, s")
        figure.align_ylabels(list(column))
        if title:
            column[0].set_title(title, loc="left", pad=3.0)
        figure.legend(handles=_legend(trial), loc="outside upper center", ncols=3, columnspacing=2.0)
    return figure


def _shade_limited(axes: Axes, trial: AccountTrial, robot: int) -> None:
    """Shade the times at which the account limited the force."""
    for start, end in () if trial.limited is None else trial.limited[robot]:
        axes.axvspan(start, end, color=_LIMITED, linewidth=0.0, zorder=0)


def _draw_energy(axes: Axes, trial: AccountTrial, robot: int) -> None:
    axes.plot(trial.time, 1e3 * trial.balance[:, robot], color=ROBOT_COLOURS[robot], linewidth=1.0)
    if trial.spring_energy is not None:
        axes.plot(
            trial.time,
            1e3 * trial.spring_energy[:, robot],
            color=COLOURS["black"],
            linestyle=_DASHED,
            linewidth=0.8,
        )
    axes.axhline(0.0, color=GREY, linewidth=0.4, zorder=1)
    axes.set_ylabel(f"Robot {robot + 1}:\nenergy, mJ")
    axes.set_ylim(bottom=min(0.0, 1.05e3 * float(np.nanmin(trial.balance[:, robot]))))


def _draw_force(axes: Axes, trial: AccountTrial, robot: int) -> None:
    assert trial.delivered is not None
    if trial.intended is not None:
        axes.plot(trial.time, trial.intended[:, robot], color=GREY, linestyle="solid", linewidth=0.9)
    axes.plot(trial.time, trial.delivered[:, robot], color=COLOURS["black"], linestyle=_DASHED, linewidth=0.8)
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel(f"Robot {robot + 1}:\nforce, N")


def _draw_positions(axes: Axes, trial: AccountTrial) -> None:
    assert trial.position is not None
    if trial.target is not None:
        axes.plot(trial.time, 1e3 * trial.target, color=COLOURS["black"], linewidth=0.6)
    if trial.without_guard is not None:
        bare = 1e3 * trial.without_guard[:, 0]
        axes.plot(trial.time, bare, color=GREY, linestyle=_DOTTED, linewidth=0.9)
    for robot in (0, 1):
        axes.plot(trial.time, 1e3 * trial.position[:, robot], color=ROBOT_COLOURS[robot], linewidth=0.9)
    axes.set_ylabel(f"Position {trial.axis}, mm")


def _legend(trial: AccountTrial) -> list[Line2D | Patch]:
    also = "" if trial.position is None else ", position"
    handles: list[Line2D | Patch] = [
        legend_line(f"robot {robot + 1}: account{also}", ROBOT_COLOURS[robot]) for robot in (0, 1)
    ]
    if trial.delivered is not None or trial.spring_energy is not None:
        words = ["force that acted"] * (trial.delivered is not None)
        words += ["its energy"] * (trial.spring_energy is not None)
        handles.append(legend_line(", ".join(words), COLOURS["black"], _DASHED, linewidth=0.8))
    if trial.intended is not None:
        handles.append(legend_line("force of a spring without delay", GREY, linewidth=0.9))
    if trial.limited is not None:
        handles.append(Patch(color=_LIMITED, label="limited by the account"))
    if trial.target is not None:
        handles.append(legend_line("target", COLOURS["black"], linewidth=0.6))
    if trial.without_guard is not None:
        handles.append(legend_line("robot 1 under the bare spring", GREY, _DOTTED, linewidth=0.9))
    return handles
