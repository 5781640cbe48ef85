"""A study at many points, on one machine or on many, and shares of any long work put together.

`docs/scale.md` describes the dataset, shares, executors, and what a million trials cost.
"""

from telespring.sweeps.merging import merge_shards
from telespring.sweeps.run import run_sweep, sweep
from telespring.sweeps.survey import survey_dyads, unsafe_quantile
from telespring.sweeps.survey_merging import merge_surveys

__all__ = [
    "merge_shards",
    "merge_surveys",
    "run_sweep",
    "survey_dyads",
    "sweep",
    "unsafe_quantile",
]
