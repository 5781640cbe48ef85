"""Files that commands write: figures as SVG, PNG or PDF, and never over an input."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from telespring._errors import InvalidInput
from telespring._files import replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["check_figure_name", "check_folder_keeps_inputs", "check_not_an_input", "save_figure"]


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


def check_not_an_input(option: str, path: Path, inputs: Iterable[Path]) -> Path:
    """Return the path of a file to write; refuse one that the command reads, however it is spelt.

    Examples
    --------
    >>> check_not_an_input("--out", Path("robot.toml"), [Path("log.csv")]).name
    'robot.toml'
    """
    read = _input_at(path, inputs)
    if read is not None:
        raise InvalidInput(
            option,
            str(path),
            f"this file is an input of the command ({read}), and writing would replace it",
            "Choose another name.",
        )
    return path


def check_folder_keeps_inputs(
    option: str, folder: Path, names: Iterable[str], inputs: Sequence[Path]
) -> Path:
    """Return the folder for files with these names; refuse one where an input has one of them.

    Examples
    --------
    >>> check_folder_keeps_inputs("--out", Path("results"), ["table1.csv"], [Path("trials.csv")]).name
    'results'
    """
    for name in names:
        read = _input_at(folder / name, inputs)
        if read is not None:
            raise InvalidInput(
                option,
                str(folder),
                f"{name} would be written there, and that file is an input of the command ({read})",
                "Choose another folder.",
            )
    return folder


def _input_at(path: Path, inputs: Iterable[Path]) -> Path | None:
    for read in inputs:
        if path.resolve() == read.resolve() or (path.exists() and read.exists() and path.samefile(read)):
            return read
    return None
