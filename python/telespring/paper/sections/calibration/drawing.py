"""The figure of the calibration: published and computed errors of every condition."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from telespring.paper.calibration import Calibration

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_cells"]

#: At most so many supported hypotheses are drawn.
_DRAWN = 2


def draw_cells(calibration: Calibration) -> Figure:
    """Draw the published errors, the null, the printed values, and the supported hypotheses."""
    from telespring.show import figures

    table = calibration.published
    shown = [each for each in calibration.explanations if each.name == "printed values"]
    shown += calibration.supported[:_DRAWN]
    baseline = next(row for row in table if row.stiffness is None)
    return figures.cells_figure(
        [row.label for row in table],
        np.array([row.mean for row in table]),
        np.array([row.standard_deviation for row in table]),
        [figures.CellSeries(each.name, each.errors) for each in shown],
        null=baseline.mean,
    )
