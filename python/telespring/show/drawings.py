"""Figs. 7 and 8 of an experiment's trials."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring.analysis.trials import Trials

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_errors", "draw_trajectories"]

#: Conditions beside each other where they are no grid of stiffness and delay.
_COLUMNS = 4


def draw_trajectories(trials: Trials) -> Figure:
    """Draw Fig. 7 of an experiment.

    Parameters
    ----------
    trials
        The experiment; what is discarded is not drawn, and of a trial that ended early all is.

    Returns
    -------
    matplotlib.figure.Figure
        See `telespring.show.figures.trajectory_figure`.
    """
    from telespring.show.figures.trials import TrialPanel, trajectory_figure

    kept = trials.time >= trials.discard
    connected = np.isfinite(trials.stiffness)
    stiffnesses = sorted({float(k) for k in trials.stiffness[connected]})
    delays = sorted({float(d) for d in trials.delay[connected]})

    def panel(i: int) -> TrialPanel:
        position = trials.position[i].copy()
        # A trial that was completed shows its analysed part only.
        position[trials.completed[i][:, None] & ~trials.window[i]] = np.nan
        goals = trials.target[i % trials.target.shape[0]]
        goal = goals[int(np.isfinite(goals).all(axis=-1).sum(axis=-1).argmax())][kept]
        early = int(trials.ended_early[i].sum())
        unconnected = not connected[i]
        title = (
            "unconnected" if unconnected else f"{trials.stiffness[i]:.0f} N/m, {1e3 * trials.delay[i]:.0f} ms"
        )
        return TrialPanel(title, position, goal, f"{early} ended early" if early else "")

    asked = [(float(k), float(d)) for k, d in zip(trials.stiffness, trials.delay, strict=True)]
    crossed = [each for each, joined in zip(asked, connected, strict=True) if joined]
    whole = len(crossed) == len(set(crossed)) == len(stiffnesses) * len(delays)
    if not whole or (len(delays) == 1 and len(stiffnesses) > 1):
        # Most places of a row per stiffness and a column per delay would be blank paper.
        panels = [panel(i) for i in range(len(trials.labels))]
        columns = math.ceil(len(panels) / math.ceil(len(panels) / _COLUMNS))
        return trajectory_figure(
            None, [panels[first : first + columns] for first in range(0, len(panels), columns)]
        )
    grid: list[list[TrialPanel | None]] = [[None] * len(delays) for _ in stiffnesses]
    alone = None
    for i in range(len(trials.labels)):
        if connected[i]:
            row, column = stiffnesses.index(trials.stiffness[i]), delays.index(trials.delay[i])
            grid[row][column] = panel(i)
        elif alone is None:
            alone = panel(i)
    return trajectory_figure(alone, grid)


def draw_errors(numbers: Mapping[str, Any]) -> Figure:
    """Draw Fig. 8 of an experiment.

    Parameters
    ----------
    numbers
        The experiment's analysis, as `telespring.analysis.analyse_trials` gives it.

    Returns
    -------
    matplotlib.figure.Figure
        See `telespring.show.figures.error_figure`.
    """
    from telespring.show.figures.trials import ErrorGroup, error_figure

    groups = []
    for condition, row in zip(numbers["conditions"], numbers["table1"], strict=True):
        measured = condition["measures"]["tracking_error"]
        errors = [np.array(measured[f"robot{robot}"]["values"], dtype=float) for robot in (1, 2)]
        unconnected = row["stiffness"] is None
        groups.append(
            ErrorGroup(
                label=row["condition"] if unconnected else f"{1e3 * row['delay']:.0f}",
                family="" if unconnected else f"{row['stiffness']:.0f} N/m",
                errors=(errors[0], errors[1]),
                arrows=(row["te1_arrow"], row["te2_arrow"]),
                ended_early=row["ended_early"],
            )
        )
    baseline = numbers["baseline"]
    return error_figure(groups, baseline["te2_median"], baseline["condition"] or "")
