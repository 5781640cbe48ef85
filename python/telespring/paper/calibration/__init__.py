"""Calibration: fit unknowns of the real arms and robots to a part of Table I, and predict the rest."""

from telespring.paper.calibration.comparison import Prediction, Score, null_prediction, predict, score
from telespring.paper.calibration.drawing import draw_cells, draw_pairs, draw_profiles
from telespring.paper.calibration.fit import Fit, PairMap, Profile
from telespring.paper.calibration.least_squares import LeastSquares
from telespring.paper.calibration.run import Calibration, calibrate
from telespring.paper.calibration.unknowns import UNKNOWNS, VARIANTS, Unknown
from telespring.paper.published import TABLE_I, PublishedRow

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
