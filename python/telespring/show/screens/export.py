"""What an export wrote, in a few lines."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.text import Text

from telespring.show.quantities import format_count

if TYPE_CHECKING:
    from telespring.exchange import BidsExport

__all__ = ["export_screen"]


def export_screen(dataset: BidsExport | None, mat_file: Path | None) -> RenderableType:
    """Say what was written where, and what is missing in it."""
    lines: list[RenderableType] = []
    if dataset is not None:
        people = " and ".join(f"sub-{label}" for label in dataset.people[:4])
        more = f" and {len(dataset.people) - 4} more" if len(dataset.people) > 4 else ""
        lines.append(
            Text(
                f"BIDS: {format_count(len(dataset.files), 'motion file')} of {people}{more}, session "
                f"{dataset.session}, in {dataset.folder}"
            )
        )
        lines += [
            Text(
                f"Robot {robot} has no file: its own site's recording is not in this one. Merge both first "
                "(telespring merge).",
                style="yellow",
            )
            for robot in dataset.missing
        ]
    if mat_file is not None:
        lines.append(Text(f"MATLAB: {mat_file}"))
    return Group(*lines)
