"""Draw the trials of an experiment and their analysis as Figs. 7 and 8."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring.analysis.trials import Trials

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_errors", "draw_trajectories"]

#: Panels per row where the conditions form no grid of stiffness and delay.
_COLUMNS = 4


def draw_trajectories(trials: Trials) -> Figure:
    """Draw the trajectories of all trials, Fig. 7, from the trials themselves.

    The discarded part of a completed trial is not drawn; a trial that ended early is drawn whole.
    """
    from telespring.show.figures.trials import TrialPanel, trajectory_figure

    kept = trials.time >= trials.discard
    connected = np.isfinite(trials.stiffness)
    stiffnesses = sorted({float(k) for k in trials.stiffness[connected]})
    delays = sorted({float(d) for d in trials.delay[connected]})

    def panel(i: int) -> TrialPanel:
        position = trials.position[i].copy()
        position[trials.completed[i][:, None] & ~trials.window[i]] = np.nan
        targets = trials.target[i % trials.target.shape[0]]
        longest = int(np.isfinite(targets).all(axis=-1).sum(axis=-1).argmax())
        early = int(trials.ended_early[i].sum())
        unconnected = not connected[i]
        title = (
            "unconnected" if unconnected else f"{trials.stiffness[i]:.0f} N/m, {1e3 * trials.delay[i]:.0f} ms"
        )
        return TrialPanel(title, position, targets[longest][kept], f"{early} ended early" if early else "")

    pairs = list(zip(trials.stiffness[connected].tolist(), trials.delay[connected].tolist(), strict=True))
    is_full_grid = len(pairs) == len(set(pairs)) == len(stiffnesses) * len(delays)
    if not is_full_grid or (len(delays) == 1 and len(stiffnesses) > 1):
        # With a row per stiffness and a column per delay most of the figure would be blank.
        panels = [panel(i) for i in range(len(trials.labels))]
        columns = math.ceil(len(panels) / math.ceil(len(panels) / _COLUMNS))
        return trajectory_figure(
            None, [panels[first : first + columns] for first in range(0, len(panels), columns)]
        )
    grid: list[list[TrialPanel | None]] = [[None] * len(delays) for _ in stiffnesses]
    unconnected_panel = None
    for i in range(len(trials.labels)):
        if connected[i]:
            row, column = stiffnesses.index(trials.stiffness[i]), delays.index(trials.delay[i])
            grid[row][column] = panel(i)
        elif unconnected_panel is None:
            unconnected_panel = panel(i)
    return trajectory_figure(unconnected_panel, grid)


def draw_errors(numbers: Mapping[str, Any]) -> Figure:
    """Draw the tracking errors of all conditions, Fig. 8, from the analysis that `analyse_trials` returns."""
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
