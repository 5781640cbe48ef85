"""Draw the trials of an experiment and their analysis as Figs. 7 and 8."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._types import FloatArray
from telespring.analysis.trials import Trials

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_errors", "draw_trajectories"]

#: Panels per row where the conditions form no grid of stiffness and delay.
_COLUMNS = 4


def draw_trajectories(trials: Trials, figure: Figure | None = None) -> Figure:
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
        target = np.where(kept[:, None], targets[longest], np.nan)
        note = f"{early} ended early" if early else ""
        return TrialPanel(titles[i], position, target, note, trials.ended_early[i])

    titles = _condition_titles(trials)

    pairs = list(zip(trials.stiffness[connected].tolist(), trials.delay[connected].tolist(), strict=True))
    is_full_grid = len(pairs) == len(set(pairs)) == len(stiffnesses) * len(delays) and (~connected).sum() < 2
    if not is_full_grid or (len(delays) == 1 and len(stiffnesses) > 1):
        # With a row per stiffness and a column per delay most of the figure would be blank.
        panels = [panel(i) for i in range(len(trials.labels))]
        columns = math.ceil(len(panels) / math.ceil(len(panels) / _COLUMNS))
        return trajectory_figure(
            None, [panels[first : first + columns] for first in range(0, len(panels), columns)], figure
        )
    grid: list[list[TrialPanel | None]] = [[None] * len(delays) for _ in stiffnesses]
    unconnected_panel = None
    for i in range(len(trials.labels)):
        if connected[i]:
            row, column = stiffnesses.index(trials.stiffness[i]), delays.index(trials.delay[i])
            grid[row][column] = panel(i)
        else:
            unconnected_panel = panel(i)
    return trajectory_figure(unconnected_panel, grid, figure)


def _condition_titles(trials: Trials) -> list[str]:
    """Title the panels by stiffness and delay, or by the conditions' names where rounding makes two alike."""
    titles = [
        f"{k:.0f} N/m, {1e3 * delay:.0f} ms" if np.isfinite(k) else "unconnected"
        for k, delay in zip(trials.stiffness, trials.delay, strict=True)
    ]
    return titles if len(set(titles)) == len(titles) else list(trials.labels)


def draw_errors(
    numbers: Mapping[str, Any],
    published: Mapping[str, Mapping[str, float]] | None = None,
    published_baseline: float | None = None,
    figure: Figure | None = None,
) -> Figure:
    """Draw the tracking errors of all conditions, Fig. 8, from the analysis that `analyse_trials` returns.

    `published` has published values by condition, with Table I's keys (``te1_mean``, ``te1_sd``, …, mm);
    `published_baseline` is the published median of TE2 in the baseline, m.
    """
    from telespring.show.figures.tracking_errors import ErrorGroup, error_figure

    groups = []
    rows = numbers["table1"]
    stiffness_names = _distinct_numbers([row["stiffness"] for row in rows if row["stiffness"] is not None])
    for condition, row in zip(numbers["conditions"], rows, strict=True):
        measured = condition["measures"]["tracking_error"]
        errors = [_drawn_errors(measured[f"robot{robot}"]) for robot in (1, 2)]
        unconnected = row["stiffness"] is None
        same = [1e3 * other["delay"] for other in rows if other["stiffness"] == row["stiffness"]]
        printed = None if published is None else published.get(row["condition"])
        groups.append(
            ErrorGroup(
                label=row["condition"] if unconnected else _distinct_numbers(same)[1e3 * row["delay"]],
                family="" if unconnected else f"{stiffness_names[row['stiffness']]} N/m",
                errors=(errors[0], errors[1]),
                arrows=(row["te1_arrow"], row["te2_arrow"]),
                ended_early=row["ended_early"],
                published=None
                if printed is None
                else (
                    (1e-3 * printed["te1_mean"], 1e-3 * printed["te1_sd"]),
                    (1e-3 * printed["te2_mean"], 1e-3 * printed["te2_sd"]),
                ),
            )
        )
    baseline = numbers["baseline"]
    return error_figure(
        groups,
        baseline["te2_median"],
        baseline["condition"] or "",
        published_baseline,
        figure,
        unit=numbers["analysed"]["unit"],
    )


def _drawn_errors(measured: Mapping[str, Any]) -> FloatArray:
    """Return the errors of one robot in one condition, m: of dyads if they count, else of trials."""
    by_dyad = measured["dyad_means"]
    return np.array(measured["values"] if by_dyad is None else list(by_dyad.values()), dtype=float)


def _distinct_numbers(values: Sequence[float]) -> dict[float, str]:
    """Write numbers with as few decimals as tell them apart."""
    distinct = list(dict.fromkeys(values))
    names: list[str] = []
    for decimals in range(16):
        names = [f"{value:.{decimals}f}" for value in distinct]
        if len(set(names)) == len(distinct):
            break
    return dict(zip(distinct, names, strict=True))
