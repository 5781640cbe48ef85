"""Figures of a calibration: cells, profiles and pairs of unknowns."""

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
    "ideal": "study, nothing fitted",
    "inside": "fit, inertia inside Table III",
    "on top": "fit, inertia on top",
}


def draw_cells(calibration: Calibration) -> Figure:
    """Draw simulated and published errors, with the fitted conditions separate from those held out."""
    from telespring.show import figures

    baseline = next(row for row in calibration.published if row.stiffness is None)
    return figures.cells_figure(
        [row.label for row in calibration.published],
        figures.CellSeries(
            "published (mean, standard deviation)",
            np.array([row.mean for row in calibration.published]),
            np.array([row.standard_deviation for row in calibration.published]),
        ),
        [
            figures.CellSeries(_TITLES[name], prediction.mean, prediction.standard_deviation)
            for name, prediction in calibration.predictions.items()
        ],
        fitted=calibration.fitted,
        null=baseline.mean,
    )


def draw_profiles(calibration: Calibration) -> Figure:
    """Draw the profile likelihoods of all unknowns of the calibration for both variants."""
    from telespring.show import figures

    return figures.profiles_figure(
        [
            figures.ProfilePanel(
                _LABELS[name],
                [
                    figures.ProfileCurve(
                        _TITLES[variant],
                        fit.profiles[name].values,
                        fit.profiles[name].rise,
                        fit.threshold,
                        fit.values[name],
                    )
                    for variant, fit in calibration.fits.items()
                    if name in fit.profiles
                ],
            )
            for name in NAMES
        ],
        [_TITLES[variant] for variant in calibration.fits],
    )


def draw_pairs(calibration: Calibration) -> Figure:
    """Draw the deviance over every pair of unknowns for both variants, with their correlation."""
    from telespring.show import figures

    panels = []
    for variant in reversed(calibration.fits):
        fit = calibration.fits[variant]
        order = list(fit.values)
        for pair in fit.pairs:
            one, two = pair.names
            correlation = fit.correlation[order.index(one), order.index(two)]
            panels.append(
                figures.PairPanel(
                    f"{variant}: correlation {format_signed(correlation, 2)}",
                    (_LABELS[one], _LABELS[two]),
                    pair.first,
                    pair.second,
                    pair.rise,
                    fit.threshold,
                    (fit.values[one], fit.values[two]),
                )
            )
    return figures.pairs_figure(panels)
