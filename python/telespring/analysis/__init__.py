"""Measure and compare the trials of an experiment, rehearsed or recorded, as section V of the paper does."""

from typing import TYPE_CHECKING

from telespring._deprecated import old_names
from telespring.analysis.effect_sizes import superiority_interval
from telespring.analysis.group_tests import GroupTest, kruskal_wallis
from telespring.analysis.measures import measure, measure_trials
from telespring.analysis.prediction import (
    HandMotion,
    PredictorComparison,
    PredictorErrors,
    compare_predictors,
    motions_of_trials,
)
from telespring.analysis.recordings.reading import read_recorded
from telespring.analysis.recordings.writing import write_recorded, write_template
from telespring.analysis.results import analyse_trials, compare_conditions
from telespring.analysis.statistics import (
    Comparison,
    compare,
    compare_pairs,
    holm,
)
from telespring.analysis.trials import Trials
from telespring.study.conditions import condition_label

__all__ = [
    "Comparison",
    "GroupTest",
    "HandMotion",
    "PredictorComparison",
    "PredictorErrors",
    "Trials",
    "analyse_trials",
    "compare",
    "compare_conditions",
    "compare_pairs",
    "compare_predictors",
    "condition_label",
    "holm",
    "kruskal_wallis",
    "measure",
    "measure_trials",
    "motions_of_trials",
    "read_recorded",
    "superiority_interval",
    "write_recorded",
    "write_template",
]

if not TYPE_CHECKING:
    __getattr__ = old_names(__name__)
