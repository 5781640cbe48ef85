"""Table I of the paper: the tracking errors that its experiment measured."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from telespring.analysis import condition_label

__all__ = ["TABLE_I", "TRIALS", "PublishedRow"]

#: Repetitions of each condition (Section IV-D).
TRIALS = 20


@dataclass(frozen=True)
class PublishedRow:
    """One condition; pairs are robot 1 and 2.

    Attributes
    ----------
    stiffness
        Of the virtual spring, N/m; None in the unconnected mode.
    delay
        One way, s.
    mean, standard_deviation
        Of the tracking error over the trials, m.
    arrow
        "↑" or "↓" where the error is greater or less than TE2 in the unconnected mode at p < 0.05, else "".
    """

    stiffness: float | None
    delay: float
    mean: tuple[float, float]
    standard_deviation: tuple[float, float]
    arrow: tuple[str, str]

    @property
    def label(self) -> str:
        """The paper's name of the condition, as CM-142-84."""
        return condition_label(math.nan if self.stiffness is None else self.stiffness, self.delay)


def _row(
    stiffness: float | None, delay: float, te1: tuple[float, float, str], te2: tuple[float, float, str]
) -> PublishedRow:
    """Turn what is printed, N/m, ms and mm, into SI units."""
    return PublishedRow(
        stiffness,
        1e-3 * delay,
        (1e-3 * te1[0], 1e-3 * te2[0]),
        (1e-3 * te1[1], 1e-3 * te2[1]),
        (te1[2], te2[2]),
    )


#: All 17 conditions as printed.
TABLE_I: Sequence[PublishedRow] = (
    _row(None, 0.0, (34.83, 2.72, "↓"), (38.75, 1.69, "")),
    _row(18.0, 0.0, (33.24, 0.69, "↓"), (38.45, 1.36, "")),
    _row(18.0, 84.0, (32.63, 0.56, "↓"), (39.36, 1.8, "")),
    _row(18.0, 167.0, (32.72, 0.37, "↓"), (39.3, 2.33, "")),
    _row(18.0, 334.0, (32.11, 0.71, "↓"), (37.9, 2.12, "")),
    _row(36.0, 0.0, (33.01, 0.38, "↓"), (38.25, 1.67, "")),
    _row(36.0, 84.0, (32.99, 0.59, "↓"), (38.23, 1.62, "")),
    _row(36.0, 167.0, (33.19, 0.61, "↓"), (39.03, 2.11, "")),
    _row(36.0, 334.0, (32.69, 0.62, "↓"), (39.1, 2.83, "")),
    _row(71.0, 0.0, (33.06, 0.33, "↓"), (38.17, 1.72, "")),
    _row(71.0, 84.0, (34.45, 1.16, "↓"), (38.93, 2.12, "")),
    _row(71.0, 167.0, (36.53, 0.69, "↓"), (40.04, 2.08, "↑")),
    _row(71.0, 334.0, (36.84, 1.1, "↓"), (40.27, 2.19, "↑")),
    _row(142.0, 0.0, (33.88, 0.73, "↓"), (37.75, 2.15, "↓")),
    _row(142.0, 84.0, (39.19, 0.66, "↑"), (40.11, 0.96, "↑")),
    _row(142.0, 167.0, (43.28, 0.8, "↑"), (43.65, 1.36, "↑")),
    _row(142.0, 334.0, (43.84, 0.98, "↑"), (45.45, 1.11, "↑")),
)
