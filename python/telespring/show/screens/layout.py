"""Tables that fit: a table where its columns have room, the same as sentences where they have not."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

__all__ = ["Fitting", "fitting_table"]


class Fitting:
    """A title, and below it one renderable for wide terminals, another for narrow ones."""

    def __init__(self, title: RenderableType | None, wide: RenderableType, narrow: RenderableType) -> None:
        self.title = title
        self.wide = wide
        self.narrow = narrow

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        needed = Measurement.get(console, options.update(max_width=10_000), self.wide).maximum
        if self.title is not None:
            yield self.title
        yield self.wide if needed <= options.max_width else self.narrow


def fitting_table(
    title: str, headings: Sequence[str], rows: Sequence[Sequence[str | Text]], *, right: Sequence[int] = ()
) -> Fitting:
    """Lay rows out as a table, or where it does not fit as a paragraph each, with every cell by its name.

    No cell is wrapped or cut in the table. A heading may have a second line with its unit; columns in `right`
    are aligned to the right.
    """
    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0))
    for i, heading in enumerate(headings):
        table.add_column(heading, justify="right" if i in right else "left", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    lines: list[RenderableType] = []
    for row in rows:
        line = Text.assemble(row[0], ": ")
        for heading, cell in zip(headings[1:], row[1:], strict=True):
            text = cell if isinstance(cell, Text) else Text(", ".join(cell.splitlines()))
            line.append("; " if line.plain[-2:] != ": " else "")
            line.append(f"{' '.join(heading.split())} ").append_text(text)
        lines.append(line)
    return Fitting(Text(title, style="bold") if title else None, table, Group(*lines))
