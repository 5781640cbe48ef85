"""Calibration: which departure from the printed laboratory explains the published Table I."""

from telespring.paper.calibration.closed_form import ClosedForm
from telespring.paper.calibration.comparison import (
    Prediction,
    Score,
    agreeing_arrows,
    predict,
    published_arrows,
    score,
)
from telespring.paper.calibration.explain import Explanation
from telespring.paper.calibration.fit import Profile
from telespring.paper.calibration.hypotheses import COMMON, HYPOTHESES, NULL, Hypothesis, Parameter
from telespring.paper.calibration.run import Calibration, Confirmation, calibrate
from telespring.paper.calibration.setting import Setting
from telespring.paper.calibration.verdict import EVIDENCE, PREDICTION, Criteria
from telespring.paper.published import TABLE_I, PublishedRow

__all__ = [
    "COMMON",
    "EVIDENCE",
    "HYPOTHESES",
    "NULL",
    "PREDICTION",
    "TABLE_I",
    "Calibration",
    "ClosedForm",
    "Confirmation",
    "Criteria",
    "Explanation",
    "Hypothesis",
    "Parameter",
    "Prediction",
    "Profile",
    "PublishedRow",
    "Score",
    "Setting",
    "agreeing_arrows",
    "calibrate",
    "predict",
    "published_arrows",
    "score",
]
