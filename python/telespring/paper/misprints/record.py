"""What one misprint is made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

__all__ = ["Evidence", "Misprint"]


@dataclass(frozen=True)
class Evidence:
    """One computed number; `unit` is SI, "1" for a pure number."""

    label: str
    value: float | None
    unit: str


@dataclass(frozen=True)
class Misprint:
    """One place in the paper.

    Attributes
    ----------
    key
        A word to find it by.
    where
        Equation, figure, table or section of the paper.
    printed, true
        What stands there, and what is right.
    consequence
        What a reader who trusts the print would do wrongly.
    evidence
        The numbers that show it.
    """

    key: str
    where: str
    printed: str
    true: str
    consequence: str
    evidence: tuple[Evidence, ...]

    def to_json(self) -> dict[str, Any]:
        """Plain data for `study.json`."""
        return {
            "key": self.key,
            "where": self.where,
            "printed": self.printed,
            "true": self.true,
            "consequence": self.consequence,
            "evidence": [
                {"label": each.label, "value": each.value, "unit": each.unit} for each in self.evidence
            ],
        }
