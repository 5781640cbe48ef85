"""Fig. 3: the Nyquist locus over three stiffnesses and three delays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from telespring.show.figures.style import COLOURS, FULL_WIDTH, GREY, figure_style, panel_label

__all__ = ["NyquistPanel", "draw_nyquist_locus", "nyquist_figure"]

_VERDICT_COLOURS = {
    "stable": COLOURS["blue"],
    "marginal": COLOURS["orange"],
    "unstable": COLOURS["vermilion"],
}


@dataclass(frozen=True)
class NyquistPanel:
    """One locus L(jω) for ω > 0, and its encirclements of the critical point.

    Attributes
    ----------
    setting
        Stiffness and delay in words, such as "0.5K, 2Δ".
    locus
        L(jω) at rising frequencies.
    verdict
        "stable", "marginal" or "unstable".
    note
        The count in words.
    """

    setting: str
    locus: NDArray[np.complex128]
    verdict: str
    note: str


def nyquist_figure(panels: Sequence[Sequence[NyquistPanel]]) -> Figure:
    """Draw a grid of Nyquist loci, a row per stiffness and a column per delay."""
    rows, columns = len(panels), len(panels[0])
    with figure_style():
        figure = Figure(figsize=(FULL_WIDTH, FULL_WIDTH * rows / columns * 0.98), layout="constrained")
        grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        extent = 1.12 * max(1.0, max(float(np.abs(panel.locus).max()) for row in panels for panel in row))
        letters = iter("abcdefghijklmnopqrstuvwxyz")
        for row, row_panels in enumerate(panels):
            for column, panel in enumerate(row_panels):
                axes = grid[row, column]
                draw_nyquist_locus(axes, panel, extent)
                panel_label(axes, next(letters), panel.setting)
                axes.label_outer()
        figure.supxlabel("Real part of L(jω), 1", fontsize=7.5)
        figure.supylabel("Imaginary part of L(jω), 1", fontsize=7.5)
    return figure


def draw_nyquist_locus(axes: Axes, panel: NyquistPanel, extent: float) -> None:
    """Draw one locus, its mirror image at negative frequencies, the unit circle and −1, out to `extent`."""
    colour = _VERDICT_COLOURS[panel.verdict]
    around = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 181))
    axes.plot(around.real, around.imag, color=GREY, linewidth=0.6, linestyle=(0, (1.0, 1.5)))
    axes.axhline(0.0, color="#D8D8D8", linewidth=0.5, zorder=0)
    axes.axvline(0.0, color="#D8D8D8", linewidth=0.5, zorder=0)
    locus = panel.locus
    axes.plot(locus.real, -locus.imag, color=colour, linewidth=0.8, linestyle=(0, (2.5, 1.5)), alpha=0.75)
    axes.plot(locus.real, locus.imag, color=colour)
    _draw_nyquist_arrow(axes, locus, colour)
    axes.plot([-1.0], [0.0], marker="+", color=COLOURS["black"], markersize=7.0, markeredgewidth=1.2)
    axes.set_title(panel.note, loc="right", pad=3.0, fontsize=7.0, color="#303030")
    axes.set(xlim=(-extent, extent), ylim=(-extent, extent), aspect="equal")
    axes.set_xticks([-1, 0, 1])
    axes.set_yticks([-1, 0, 1])


def _draw_nyquist_arrow(axes: Axes, locus: NDArray[np.complex128], colour: str) -> None:
    """Draw an arrow towards higher frequency, a third of the way along the locus."""
    length = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(locus)))])
    at = int(np.searchsorted(length, 0.33 * length[-1]))
    before = int(np.searchsorted(length, 0.33 * length[-1] - 0.06))
    before = min(before, at - 1)
    axes.annotate(
        "",
        xy=(locus[at].real, locus[at].imag),
        xytext=(locus[before].real, locus[before].imag),
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.0, "mutation_scale": 9.0},
    )
