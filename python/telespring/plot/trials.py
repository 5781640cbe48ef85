"""Figures of the trials of an experiment, rehearsed or recorded."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from matplotlib import pyplot as plt

from telespring.analysis.results import compare_conditions
from telespring.analysis.sources import open_trials
from telespring.analysis.trials import Trials
from telespring.show.drawings.trials import draw_errors, draw_trajectories

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["tracking_error", "trials"]


def trials(
    source: xarray.Dataset | str | os.PathLike[str],
    *,
    discard: float | None = None,
    figure: Figure | None = None,
) -> list[Axes]:
    """Draw the trajectories of all trials, as in the paper's Fig. 7.

    Parameters
    ----------
    source
        The dataset of a rehearsal or of recorded trials, or the path of one.
    discard
        Duration to leave out at the start of every trial, s; by default what the source states.
    figure
        The figure to draw on, which is resized; by default a new one of pyplot.

    Returns
    -------
    list of matplotlib.axes.Axes
        A pair per condition, robot 1 on the left, in mm.

    Raises
    ------
    telespring.InvalidInput
        If the source has no trials, or not in the layout that `docs/recorded-trials.md` describes.

    Examples
    --------
    >>> import tempfile
    >>> import telespring as ts
    >>> study = ts.Study.paper().replace(protocol={"trials": 2, "stiffness": [71.2], "delay": [0.1]})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     axes = ts.plot.trials(ts.rehearse(study, folder))
    >>> len(axes)
    4
    """
    drawn = figure if figure is not None else plt.figure()
    return draw_trajectories(_read_trials(source, discard), drawn).axes


def tracking_error(
    source: xarray.Dataset | str | os.PathLike[str],
    *,
    discard: float | None = None,
    baseline: str | None = None,
    figure: Figure | None = None,
) -> list[Axes]:
    """Draw the tracking errors of both robots by condition, as in the paper's Fig. 8.

    Parameters
    ----------
    source
        The dataset of a rehearsal or of recorded trials, or the path of one.
    discard
        Duration to leave out at the start of every trial, s; by default what the source states.
    baseline
        The condition that the others are compared with; by default the unconnected mode.
    figure
        The figure to draw on, which is resized; by default a new one of pyplot.

    Returns
    -------
    list of matplotlib.axes.Axes
        One, in mm, or two if some errors are much larger than most: a logarithmic part on top.

    Raises
    ------
    telespring.InvalidInput
        As for `trials`.

    Examples
    --------
    >>> import tempfile
    >>> import telespring as ts
    >>> study = ts.Study.paper().replace(protocol={"trials": 4, "stiffness": [71.2], "delay": [0.1]})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [ax] = ts.plot.tracking_error(ts.rehearse(study, folder))
    >>> ax.get_ylabel()
    'Tracking error, mm'
    """
    drawn = figure if figure is not None else plt.figure()
    numbers = compare_conditions(_read_trials(source, discard), baseline)
    return draw_errors(numbers, figure=drawn).axes


def _read_trials(source: xarray.Dataset | str | os.PathLike[str], discard: float | None) -> Trials:
    dataset = open_trials(source) if isinstance(source, str | os.PathLike) else source
    return Trials.from_dataset(dataset, discard)
