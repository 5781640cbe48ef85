"""The map of prediction: where each predictor stabilises the bare spring, and where it destabilises it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._errors import InvalidInput
from telespring.plot.settings import check_settings, given_or_new_axes
from telespring.show.figures.prediction import PredictionLimit, draw_prediction_limits
from telespring.show.figures.style import figure_style
from telespring.show.screens.questions import describe_robots
from telespring.theory.criteria import maximum_stiffness

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from telespring.model import Dyad

__all__ = ["prediction_map"]

#: What is drawn if nothing else is asked for.
_PREDICTORS: tuple[str | Mapping[str, Any], ...] = (
    "hold",
    "linear",
    {"kind": "kalman", "model": "constant-velocity", "process": 1.0, "position": 1e-4},
    {"kind": "kalman", "model": "constant-acceleration", "process": 100.0, "position": 1e-4},
)
_MOST = 5


def prediction_map(
    dyad: Dyad,
    predictors: Sequence[str | Mapping[str, Any]] = _PREDICTORS,
    *,
    stiffness: float = 400.0,
    delay: float = 0.35,
    points: int = 120,
    title: str | None = None,
    allow_unusual: bool = False,
    ax: Axes | None = None,
) -> Axes:
    """Draw up to which stiffness the bare spring is stable with each predictor, over the one-way delay.

    Controllers are continuous, and the delay is constant and the same each way. Left of a curve every
    stiffness is stable on every axis. A shared target has the curve of hold.

    Parameters
    ----------
    dyad
        Robots and operators.
    predictors
        Up to five predictors, as for `telespring.maximum_stiffness`; what is stable with the first is shaded.
    stiffness, delay
        Largest stiffness (N/m) and delay (s) of the map.
    points
        Delays above 0 at which each limit is computed, evenly spaced; it is computed without delay, too.
    title
        What is written above the map; by default the robots.
    allow_unusual
        Whether stiffnesses and delays that no laboratory has are meant.
    ax
        Axes to draw on.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, in N/m and ms.

    Raises
    ------
    telespring.InvalidInput
        If a value is out of its range, or unusual.

    Examples
    --------
    >>> import telespring as ts
    >>> ax = ts.plot.prediction_map(ts.hman(), ["hold", "linear"], points=12)
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['hold', 'linear', 'stable with hold']
    """
    check_settings({"stiffness": stiffness}, {"delay": delay}, allow_unusual)
    if not 1 <= len(predictors) <= _MOST:
        raise InvalidInput(
            "predictors",
            str(len(predictors)),
            f"from one to {_MOST} predictors are required",
            "Draw two maps.",
        )
    if points < 2:
        raise InvalidInput("points", str(points), "at least two delays above 0 are required", "Leave it out.")
    delays = np.linspace(0.0, delay, points + 1)  # the shade begins where there is no delay
    limits = [
        PredictionLimit(
            predictor_label(predictor),
            delays,
            np.asarray(maximum_stiffness(dyad, delays, predictor=predictor)),
        )
        for predictor in predictors
    ]
    with figure_style():
        axes = given_or_new_axes(ax, (5.0, 4.2))
        draw_prediction_limits(axes, limits, stiffness, delay)
        axes.set_title(title if title is not None else "\n".join(describe_robots(dyad)), fontsize=8.0)
    return axes


def predictor_label(predictor: str | Mapping[str, Any]) -> str:
    """Name a predictor in a legend.

    Examples
    --------
    >>> predictor_label("shared-target")
    'shared target'
    >>> predictor_label({"kind": "kalman", "model": "constant-velocity", "process": 1.0, "position": 1e-4})
    'Kalman, constant velocity (1, 0.1 mm)'
    """
    if isinstance(predictor, str):
        return predictor.replace("-", " ")
    kind, model = str(predictor.get("kind", "")), str(predictor.get("model", "constant-acceleration"))
    if kind != "kalman":
        return kind.replace("-", " ")
    label = f"Kalman, {model.replace('-', ' ')}"
    if "process" in predictor and "position" in predictor:
        label += f" ({predictor['process']:g}, {1e3 * predictor['position']:g} mm)"
    return label
