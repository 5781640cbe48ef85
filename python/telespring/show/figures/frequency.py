"""Fig. 4: magnitude and phase of the loop's transfer function, one parameter varied at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from telespring.show.figures.style import DASHES, FULL_WIDTH, GREY, SERIES, figure_style, panel_label

__all__ = ["FrequencyCurve", "FrequencyFamily", "frequency_figure"]


@dataclass(frozen=True)
class FrequencyCurve:
    """One curve: label of its factor, magnitude (1) and unwrapped phase (degree) over frequency."""

    label: str
    magnitude: NDArray[np.float64]
    phase: NDArray[np.float64]
    #: Frequency (rad/s) and phase (degree) where the magnitude falls through 1, where it does.
    gain_crossing: tuple[float, float] | None


@dataclass(frozen=True)
class FrequencyFamily:
    """One column of the figure: the parameter varied, and its curves."""

    parameter: str
    curves: Sequence[FrequencyCurve]


def frequency_figure(frequency: NDArray[np.float64], families: Sequence[FrequencyFamily]) -> Figure:
    """Draw magnitude above phase over frequency (rad/s), a column per varied parameter of up to 4 curves."""
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, 3.9), layout="constrained")
        grid = figure.subplots(2, len(families), sharex=True, sharey="row", squeeze=False)
        for column, family in enumerate(families):
            top, bottom = grid[0, column], grid[1, column]
            for curve, colour, dashes in zip(family.curves, SERIES, DASHES, strict=False):
                top.plot(frequency, curve.magnitude, color=colour, linestyle=dashes, label=curve.label)
                bottom.plot(frequency, curve.phase, color=colour, linestyle=dashes)
                if curve.gain_crossing is not None:
                    crossing, phase = curve.gain_crossing
                    for axes, height in ((top, 1.0), (bottom, phase)):
                        axes.plot([crossing], [height], "o", color=colour, markersize=3.4, zorder=5)
            first = family.curves[0].magnitude
            if all(np.allclose(curve.magnitude, first, rtol=1e-6) for curve in family.curves):
                top.text(
                    0.97,
                    0.95,
                    "all curves coincide",
                    transform=top.transAxes,
                    ha="right",
                    va="top",
                    fontsize=6.6,
                )
            top.axhline(1.0, color=GREY, linewidth=0.6, zorder=0)
            bottom.axhline(-180.0, color=GREY, linewidth=0.6, zorder=0)
            top.set(xscale="log", yscale="log", ylim=(3e-3, 5.0), xlim=(frequency[0], frequency[-1]))
            bottom.set(ylim=(-460.0, 20.0))
            bottom.set_yticks([0, -90, -180, -270, -360, -450])
            panel_label(top, "abcdefgh"[column], family.parameter)
            top.legend(loc="lower left", borderaxespad=0.3, labelspacing=0.25)
        grid[0, 0].set_ylabel("Magnitude |H|, m/m")
        grid[1, 0].set_ylabel("Phase of H, degree")
        figure.supxlabel("Frequency ω, rad/s", fontsize=7.5)
    return figure
