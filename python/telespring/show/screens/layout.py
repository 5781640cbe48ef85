"""Tables that fit: a table where its columns have room, the same as lines of text where they have not."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.measure import Measurement
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

__all__ = ["Fitting", "fitting_table"]


class Fitting:
    """One renderable for wide terminals, another for narrow ones."""

    def __init__(self, wide: RenderableType, narrow: RenderableType) -> None:
        self.wide = wide
        self.narrow = narrow

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        needed = Measurement.get(console, options.update(max_width=10_000), self.wide).minimum
        yield self.wide if needed <= options.max_width else self.narrow


def fitting_table(
    title: str, headings: Sequence[str], rows: Sequence[Sequence[str | Text]], *, right: Sequence[int] = ()
) -> Fitting:
    """Lay rows out as a table, or where it does not fit as the first cell and the others, named, below it.

    No cell is wrapped or cut in the table. A heading may have a second line with its unit; columns in `right`
    are aligned to the right.
    """
    table = Table(
        title=title or None,
        title_justify="left",
        title_style="bold",
        box=None,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    for i, heading in enumerate(headings):
        table.add_column(heading, justify="right" if i in right else "left", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    lines: list[RenderableType] = [Text(title, style="bold")] if title else []
    for row in rows:
        lines.append(Text.assemble(row[0]) if isinstance(row[0], str) else row[0])
        for heading, cell in zip(headings[1:], row[1:], strict=True):
            name = " ".join(heading.split())
            cell_text = cell if isinstance(cell, Text) else Text(" ".join(cell.split("\n")))
            if cell_text.plain:
                lines.append(Padding(Text.assemble(f"{name}: ", cell_text), (0, 0, 0, 2)))
    return Fitting(table, Group(*lines))
