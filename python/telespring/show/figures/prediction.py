"""The map of prediction: up to which stiffness the spring is stable with each predictor, over the delay."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch
from numpy.typing import NDArray

from telespring.show.figures.maps import STABLE
from telespring.show.figures.style import COLOURS, DASHES

__all__ = ["PredictionLimit", "draw_prediction_limits"]

#: Colour, dashes and marker tell the curves apart, each alone.
_STYLES = (
    (COLOURS["black"], "solid", ""),
    (COLOURS["vermilion"], DASHES[0], "o"),
    (COLOURS["blue"], DASHES[1], "s"),
    (COLOURS["orange"], DASHES[3], "^"),
    (COLOURS["purple"], DASHES[2], "d"),
)


@dataclass(frozen=True)
class PredictionLimit:
    """A predictor and the largest stable stiffness (N/m) at each delay (s)."""

    label: str
    delay: NDArray[np.float64]
    stiffness: NDArray[np.float64]


def draw_prediction_limits(
    axes: Axes, limits: Sequence[PredictionLimit], widest: float, longest: float
) -> None:
    """Draw the limit of each predictor, and shade what is stable without one (the first limit)."""
    first = limits[0]
    shown = np.minimum(first.stiffness, 10.0 * widest)
    axes.fill_betweenx(1e3 * first.delay, 0.0, shown, color=STABLE, linewidth=0.0)
    lines = []
    for limit, (colour, dashes, marker) in zip(limits, _STYLES, strict=False):
        stiffness = np.where(np.isfinite(limit.stiffness), limit.stiffness, 1e3 * widest)
        lines += axes.plot(
            stiffness,
            1e3 * limit.delay,
            color=colour,
            linestyle=dashes,
            marker=marker or None,
            markevery=max(1, len(stiffness) // 12),
            markersize=3.6,
            linewidth=1.3,
            label=limit.label,
        )
    axes.set(
        xlim=(0.0, widest),
        ylim=(0.0, 1e3 * longest),
        xlabel="Stiffness k, N/m",
        ylabel="One-way delay δ, ms",
    )
    patch = Patch(color=STABLE, label=f"stable with {first.label}")
    axes.legend(handles=[*lines, patch], title="stable left of", loc="upper right")
