"""Fit what the ideal laboratory does not know of the real one to a part of Table I, predict the rest."""

from telespring.calibration.calibration import Calibration, calibrate
from telespring.calibration.comparison import Prediction, Score, null_prediction, predict, score
from telespring.calibration.drawing import draw_cells, draw_pairs, draw_profiles
from telespring.calibration.fit import Fit, PairMap, Profile
from telespring.calibration.least_squares import LeastSquares
from telespring.calibration.published import TABLE_I, PublishedRow
from telespring.calibration.unknowns import UNKNOWNS, VARIANTS, Unknown

__all__ = [
    "TABLE_I",
    "UNKNOWNS",
    "VARIANTS",
    "Calibration",
    "Fit",
    "LeastSquares",
    "PairMap",
    "Prediction",
    "Profile",
    "PublishedRow",
    "Score",
    "Unknown",
    "calibrate",
    "draw_cells",
    "draw_pairs",
    "draw_profiles",
    "null_prediction",
    "predict",
    "score",
]
