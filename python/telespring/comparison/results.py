"""The result of a comparison: its dataset, and the choice that follows from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from telespring._html import table
from telespring.comparison.choices import Candidate, LeftOut, Recommendation
from telespring.comparison.summary import comparison_json, condition_rows

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Comparison"]


@dataclass(frozen=True, repr=False, eq=False)
class Comparison:
    """What a comparison found.

    Attributes
    ----------
    dataset
        All that was measured; `docs/compare.md` lists its variables.
    recommendation
        The best safe choice, why, whether it is better than working alone, and what became of the others.
    left_out
        Usual architectures that this study cannot have.
    folder
        Where it is stored.
    """

    dataset: xr.Dataset
    recommendation: Recommendation
    left_out: tuple[LeftOut, ...]
    folder: Path

    @property
    def recommended(self) -> Candidate | None:
        """The best safe choice; None if nothing that was compared is safe, or working alone is better."""
        return self.recommendation.recommended

    @property
    def name(self) -> str:
        """Name of the study."""
        return str(self.dataset.attrs["name"])

    def conditions(self) -> list[dict[str, Any]]:
        """List what `compare.json` has for each architecture, network, stiffness and delay."""
        return condition_rows(self.dataset)

    def to_dict(self) -> dict[str, Any]:
        """Return the content of `compare.json`."""
        return comparison_json(self.dataset, self.recommendation, self.left_out)

    def __repr__(self) -> str:
        values = ", ".join(f"{name} {value}" for name, value in self._in_short().items())
        return f"<Comparison: {values}>"

    def _repr_html_(self) -> str:
        return table(f"Comparison: {self.name}", self._in_short())

    def _in_short(self) -> Mapping[str, Any]:
        sizes = self.dataset.sizes
        best = self.recommended
        return {
            "architectures": sizes["architecture"],
            "networks": sizes["network"],
            "conditions": sizes["condition"],
            "trials": sizes["trial"],
            "recommended": "none" if best is None else f"{best.architecture} at {best.stiffness:.4g} N/m",
        }
