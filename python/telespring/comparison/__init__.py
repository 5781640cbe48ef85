"""Control architectures side by side: a study rehearsed with each on each network, and the best safe choice.

`docs/compare.md` describes the dataset, the folder and the rule of the choice.
"""

from telespring.comparison.choices import (
    Alternative,
    Candidate,
    LeftOut,
    Recommendation,
    Rejection,
    Unconnected,
)
from telespring.comparison.results import Comparison
from telespring.comparison.run import compare, run_comparison

__all__ = [
    "Alternative",
    "Candidate",
    "Comparison",
    "LeftOut",
    "Recommendation",
    "Rejection",
    "Unconnected",
    "compare",
    "run_comparison",
]
