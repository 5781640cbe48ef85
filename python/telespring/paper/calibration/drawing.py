"""The figures of a calibration."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from telespring.paper.calibration.run import Calibration
from telespring.paper.calibration.unknowns import NAMES
from telespring.show.quantities import format_signed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_cells", "draw_pairs", "draw_profiles"]

_LABELS = {
    "arm_mass": "Arm mass, kg",
    "arm_damping": "Arm damping, N·s/m",
    "coulomb": "Coulomb friction, N",
    "spot_velocity": "Spot velocity, m/s",
}
_TITLES = {
    "ideal": "the study as it is",
    "inside": "fit, inertia inside Table III",
    "on top": "fit, inertia on top",
}


def draw_cells(found: Calibration) -> Figure:
    """Draw simulated beside published errors, held-out conditions apart from fitted ones."""
    from telespring.show import figures

    baseline = next(row for row in found.published if row.stiffness is None)
    return figures.cells_figure(
        [row.label for row in found.published],
        figures.CellSeries(
            "published (mean, standard deviation)",
            np.array([row.mean for row in found.published]),
            np.array([row.standard_deviation for row in found.published]),
        ),
        [
            figures.CellSeries(_TITLES[name], each.mean, each.standard_deviation)
            for name, each in found.predictions.items()
        ],
        fitted=found.fitted,
        null=baseline.mean,
    )


def draw_profiles(found: Calibration) -> Figure:
    """Draw the profile likelihoods of all unknowns, both variants."""
    from telespring.show import figures

    return figures.profiles_figure(
        [
            figures.ProfilePanel(
                _LABELS[name],
                [
                    figures.ProfileCurve(
                        _TITLES[variant],
                        each.profiles[name].values,
                        each.profiles[name].rise,
                        each.threshold,
                        each.values[name],
                    )
                    for variant, each in found.fits.items()
                    if name in each.profiles
                ],
            )
            for name in NAMES
        ],
        [_TITLES[variant] for variant in found.fits],
    )


def draw_pairs(found: Calibration) -> Figure:
    """Draw the deviance over every pair of unknowns, both variants, with their correlation."""
    from telespring.show import figures

    panels = []
    for variant in reversed(found.fits):
        each = found.fits[variant]
        order = list(each.values)
        for pair in each.pairs:
            one, two = pair.names
            correlation = each.correlation[order.index(one), order.index(two)]
            panels.append(
                figures.PairPanel(
                    f"{variant}: correlation {format_signed(correlation, 2)}",
                    (_LABELS[one], _LABELS[two]),
                    pair.first,
                    pair.second,
                    pair.rise,
                    each.threshold,
                    (each.values[one], each.values[two]),
                )
            )
    return figures.pairs_figure(panels)
