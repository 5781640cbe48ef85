"""The help of the commands, which no terminal cuts."""

from __future__ import annotations

import inspect
import re
import shutil
from typing import Any

from typer.core import TyperCommand, TyperGroup

__all__ = ["Command", "Group"]

#: The fewest columns in which the table of options cuts no name.
_COLUMNS_OF_TABLE = 80


def _is_narrow() -> bool:
    return shutil.get_terminal_size().columns < _COLUMNS_OF_TABLE


def _paragraphs(text: str) -> str:
    """Make each paragraph one line, which the terminal breaks; Rich keeps line ends of the source."""
    return re.sub(r"(?<!\n)\n(?!\n)", " ", inspect.cleandoc(text))


class Command(TyperCommand):
    """A command whose help is plain text where its table would cut the names of options."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.help = _paragraphs(self.help or "")

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help."""
        # `TyperCommand` draws the table, its parent writes lines.
        write = super(TyperCommand, self) if _is_narrow() else super()
        write.format_help(ctx, formatter)  # type: ignore[attr-defined]


class Group(TyperGroup):
    """The commands, listed in plain text where a table would cut their names."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help."""
        write = super(TyperGroup, self) if _is_narrow() else super()
        write.format_help(ctx, formatter)  # type: ignore[attr-defined]
