"""Measure and compare the trials of an experiment, rehearsed or recorded, as the paper's section V does."""

from telespring.analysis.measures import measure, measure_trials
from telespring.analysis.recordings.reading import read_recorded, target_of
from telespring.analysis.recordings.writing import write_recorded, write_template
from telespring.analysis.results import analyse_taken, analyse_trials
from telespring.analysis.statistics import (
    Comparison,
    GroupTest,
    compare,
    compare_pairs,
    holm,
    kruskal_wallis,
    superiority_interval,
)
from telespring.analysis.trials import Trials, take_trials
from telespring.study.conditions import condition_label

__all__ = [
    "Comparison",
    "GroupTest",
    "Trials",
    "analyse_taken",
    "analyse_trials",
    "compare",
    "compare_pairs",
    "condition_label",
    "holm",
    "kruskal_wallis",
    "measure",
    "measure_trials",
    "read_recorded",
    "superiority_interval",
    "take_trials",
    "target_of",
    "write_recorded",
    "write_template",
]
