"""Figures that commands write, as SVG, PNG or PDF."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from telespring._errors import InvalidInput
from telespring._files import replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["check_figure_name", "save_figure"]


def check_figure_name(path: Path) -> Path:
    """Return the path of a figure; refuse an ending that names no format.

    Examples
    --------
    >>> check_figure_name(Path("map.SVG")).suffix
    '.SVG'
    """
    if path.suffix.lower() not in {".svg", ".png", ".pdf"}:
        raise InvalidInput(
            "--figure",
            str(path),
            "the file's name must end in .svg, .png or .pdf",
            f"Write {path.with_suffix('.png')}.",
        )
    return path


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure in the format that its file's ending names; a file there is replaced as a whole."""
    from telespring.show.figures.style import figure_style

    with figure_style(), replacing(path) as temporary:
        figure.savefig(temporary, dpi=200)
