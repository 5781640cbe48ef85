"""Tables that fit: a table where its columns have room, the same as sentences where they have not."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

__all__ = ["Fitting", "fitting_table"]


class Fitting:
    """A title, and below it the first of some renderables that is not too wide for the terminal."""

    def __init__(self, title: RenderableType | None, *choices: RenderableType) -> None:
        self.title = title
        self.choices = choices

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        if self.title is not None:
            yield self.title
        unlimited = options.update(max_width=10_000)
        for choice in self.choices[:-1]:
            if Measurement.get(console, unlimited, choice).maximum <= options.max_width:
                yield choice
                return
        yield self.choices[-1]


def fitting_table(
    title: str,
    headings: Sequence[str],
    rows: Sequence[Sequence[str | Text]],
    *,
    right: Sequence[int] = (),
    optional: Sequence[int] = (),
) -> Fitting:
    """Lay rows out as a table, or where it does not fit as a paragraph each, with every cell by its name.

    No cell is wrapped or cut in the table. A heading may have a second line with its unit; columns in `right`
    are aligned to the right, and those in `optional` are left out where the table would not fit with them.
    """
    every = range(len(headings))
    tables = [_table(headings, rows, right, every)]
    if optional:
        tables.append(_table(headings, rows, right, [i for i in every if i not in optional]))
    lines: list[RenderableType] = []
    for row in rows:
        line = Text.assemble(row[0], ": ")
        for heading, cell in zip(headings[1:], row[1:], strict=True):
            text = cell if isinstance(cell, Text) else Text(", ".join(cell.splitlines()))
            line.append("; " if line.plain[-2:] != ": " else "")
            line.append(f"{' '.join(heading.split())} ").append_text(text)
        lines.append(line)
    return Fitting(Text(title, style="bold") if title else None, *tables, Group(*lines))


def _table(
    headings: Sequence[str],
    rows: Sequence[Sequence[str | Text]],
    right: Sequence[int],
    columns: Sequence[int],
) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0))
    for i in columns:
        table.add_column(headings[i], justify="right" if i in right else "left", no_wrap=True)
    for row in rows:
        table.add_row(*(row[i] for i in columns))
    return table
