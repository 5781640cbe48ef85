"""Record of one misprint and of the numbers that prove it."""

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
    """One misprint of the paper.

    Attributes
    ----------
    key
        Short name.
    where
        Equation, figure, table or section of the paper.
    printed, true
        What the paper prints, and what is correct.
    consequence
        What goes wrong for a reader who relies on the printed version.
    evidence
        The numbers that prove it.
    """

    key: str
    where: str
    printed: str
    true: str
    consequence: str
    evidence: tuple[Evidence, ...]

    def to_json(self) -> dict[str, Any]:
        """Misprint with its evidence for `study.json`."""
        return {
            "key": self.key,
            "where": self.where,
            "printed": self.printed,
            "true": self.true,
            "consequence": self.consequence,
            "evidence": [
                {"label": item.label, "value": item.value, "unit": item.unit} for item in self.evidence
            ],
        }
