"""The rules by which a hypothesis is supported, descriptive or excluded, fixed before any fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

__all__ = ["EVIDENCE", "PREDICTION", "Criteria", "Verdict", "aicc", "judge"]

Verdict: TypeAlias = Literal["supported", "descriptive", "excluded", "reference"]

#: A difference in AICc from which the worse model has essentially no support (Burnham and Anderson, *Model
#: Selection and Multimodel Inference*, 2nd edition, Springer 2002, section 2.6).
EVIDENCE = 10.0
#: A stiffness left out of the fit must be predicted with at most this share of the null's error: then three
#: quarters of the squared error of saying that nothing changes are gone.
PREDICTION = 0.5


@dataclass(frozen=True)
class Criteria:
    """What a verdict is made of.

    Attributes
    ----------
    stable
        The best fit is stable in every published condition. No published error is that of a dyad that runs
        away.
    better_than_null
        Its AICc is at least `EVIDENCE` below that of the null.
    predicts
        Every stiffness left out in turn is predicted, all together with a smaller error than the null's.
    predicts_well
        With at most `PREDICTION` times the null's error.
    among_the_best
        Its AICc is less than `EVIDENCE` above the smallest.
    determined
        The intervals of its own parameters end inside the searched ranges.
    """

    stable: bool
    better_than_null: bool
    predicts: bool
    predicts_well: bool
    among_the_best: bool
    determined: bool

    @property
    def verdict(self) -> Verdict:
        """Excluded without the first three; supported with all six; descriptive in between."""
        if not (self.stable and self.better_than_null and self.predicts):
            return "excluded"
        if self.predicts_well and self.among_the_best and self.determined:
            return "supported"
        return "descriptive"


def aicc(squares: float, cells: int, parameters: int) -> float:
    """Akaike's criterion for few data, of least squares; the variance counts as one more parameter.

    The cells count as independent although the two errors of a condition are not, so differences are rather
    too large.

    Parameters
    ----------
    squares
        Sum of squared residuals, mm².

    Examples
    --------
    >>> round(aicc(34.0, 34, 3), 3)  # 2·4 + 2·4·5/29
    9.379
    """
    count = parameters + 1
    return float(cells * np.log(squares / cells) + 2 * count + 2 * count * (count + 1) / (cells - count - 1))


def judge(
    *,
    aicc: float,
    null_aicc: float,
    best_aicc: float,
    left_out_error: float,
    null_left_out_error: float,
    determined: bool,
) -> Criteria:
    """Apply the rules; an infinite AICc or error is that of an unstable dyad."""
    return Criteria(
        stable=bool(np.isfinite(aicc)),
        better_than_null=aicc <= null_aicc - EVIDENCE,
        predicts=left_out_error < null_left_out_error,
        predicts_well=left_out_error <= PREDICTION * null_left_out_error,
        among_the_best=bool(np.isfinite(aicc)) and aicc < best_aicc + EVIDENCE,
        determined=determined,
    )
