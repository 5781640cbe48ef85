"""The paper's study as the command `telespring reproduce` made it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from typer.testing import Result

__all__ = ["PaperStudy"]


@dataclass(frozen=True)
class PaperStudy:
    """What `telespring reproduce` printed, and the folder that it wrote."""

    result: Result
    folder: Path
