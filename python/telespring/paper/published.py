"""Values that Du et al. (2025) print: Tables I to III and the conditions of their experiment, in SI units."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from telespring.analysis import condition_label
from telespring.references import read_reference

__all__ = [
    "AGENT_STIFFNESS",
    "BASELINE_MEDIAN",
    "EXPERIMENT_DELAYS",
    "EXPERIMENT_DELAY_FACTORS",
    "EXPERIMENT_STIFFNESSES",
    "EXPERIMENT_STIFFNESS_FACTORS",
    "TABLE_I",
    "TABLE_II",
    "TABLE_III",
    "TRIALS",
    "PublishedRow",
    "PublishedTableIII",
]

_DU2025 = read_reference("du2025")
_MILLI = 1e-3


@dataclass(frozen=True)
class PublishedRow:
    """One condition of Table I; pairs are robot 1 and 2.

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


@dataclass(frozen=True)
class PublishedTableIII:
    """Table III's base robot and reference values, kg, N·s/m, N/m and s."""

    base_mass: float
    base_damping: float
    base_stiffness: float
    base_delay: float
    reference_stiffness: float
    reference_delay: float


def _read_table_1() -> tuple[PublishedRow, ...]:
    arrows = {"less": "↓", "greater": "↑", "": ""}

    def pair(row: dict[str, Any], key: str) -> tuple[float, float]:
        return _MILLI * row["TE1"][key], _MILLI * row["TE2"][key]

    return tuple(
        PublishedRow(
            row.get("stiffness"),
            _MILLI * row.get("delay", 0.0),
            pair(row, "mean"),
            pair(row, "standard_deviation"),
            (arrows[row["TE1"]["against_baseline"]], arrows[row["TE2"]["against_baseline"]]),
        )
        for row in _DU2025["table1"]["row"]
    )


def _read_table_3() -> PublishedTableIII:
    base, reference = _DU2025["table3"]["base"], _DU2025["table3"]["reference"]
    return PublishedTableIII(
        base_mass=base["M"]["value"],
        base_damping=base["B"]["value"],
        base_stiffness=base["K"]["value"],
        base_delay=_MILLI * base["Delta"]["value"],
        reference_stiffness=reference["K_xy"]["value"],
        reference_delay=_MILLI * reference["Delta_xy"]["value"],
    )


#: All 17 conditions of Table I.
TABLE_I: Sequence[PublishedRow] = _read_table_1()
#: Table II, a row per range of stiffness from small to large: sets of η₁, η₂, ξ₁, ξ₂ and ξ₃.
TABLE_II: tuple[tuple[str, ...], ...] = tuple(tuple(row["sets"]) for row in _DU2025["table2"]["row"])
TABLE_III = _read_table_3()
#: Stiffness k_c of an agent's arm, N/m (Table III).
AGENT_STIFFNESS: float = _DU2025["table3"]["reference"]["k_c"]["value"]
#: Median of TE2 in the unconnected mode, m (Fig. 8, caption).
BASELINE_MEDIAN: float = _MILLI * _DU2025["table1"]["baseline_median_TE2"]
#: Section IV-D: stiffness (N/m) and one-way delay (s) of the experiment.
EXPERIMENT_STIFFNESSES: tuple[float, ...] = tuple(_DU2025["conditions"]["stiffness"]["values"])
EXPERIMENT_DELAYS: tuple[float, ...] = tuple(
    _MILLI * delay for delay in _DU2025["conditions"]["delay"]["values"]
)
#: The same conditions in multiples of K_xy and Δ_xy.
EXPERIMENT_STIFFNESS_FACTORS: tuple[float, ...] = tuple(
    _DU2025["conditions"]["stiffness"]["as_multiples_of_K_xy"]
)
EXPERIMENT_DELAY_FACTORS: tuple[float, ...] = tuple(
    _DU2025["conditions"]["delay"]["as_multiples_of_Delta_xy"]
)
#: Trials of each condition.
TRIALS: int = _DU2025["conditions"]["trials"]
