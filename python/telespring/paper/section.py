"""A section of the report: its numbers, its place on the page, and the figures and tables it reproduces."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Any

from telespring.paper.scene import Scene

__all__ = ["Findings", "Place", "Section"]


@dataclass(frozen=True)
class Findings:
    """Results of one section.

    Attributes
    ----------
    numbers
        Keys of `study.json` with their values, in SI units; no two sections share a key.
    drawings
        Name to the text of one `<svg>` element.
    files
        Name to a file that the section carries, compressed (gzip) and written in base64; empty if it is left
        out because the page would grow too large.
    """

    numbers: Mapping[str, Any] = field(default_factory=dict)
    drawings: Mapping[str, str] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Place:
    """A figure or table of the paper, such as "Fig. 3", and the anchor on the page where it is reproduced."""

    name: str
    anchor: str


@dataclass(frozen=True)
class Section:
    """One section of the report: the folder `sections/<name>`, declared in its `section.py`.

    Its template `page.html.jinja` sees the section's own numbers and drawings, `numbers.study`, and the
    numbers of the sections in `mentions`, nothing else; so a report may consist of any sections.

    Attributes
    ----------
    name
        Of the folder.
    anchor
        Identifier of its heading on the page.
    title
        In the table of contents; empty for a section above it.
    step
        Name of its computation, as a progress bar shows it.
    find
        Computes its numbers and drawings. The section is shown where there are any, and always if it
        computes nothing.
    start
        Begins its computation beside that of the other sections: a context that gives what `find` returns,
        and that ends the computation when it is left.
    holds
        The paper's figures and tables that it reproduces.
    mentions
        Sections whose numbers its template quotes where they are part of the report.
    computed_after
        The section after which it is computed, where that is not the one before it on the page. Keys of
        `study.json` are in the order of computation.
    is_long
        Whether a quick reproduction leaves it out.
    """

    name: str
    anchor: str
    title: str = ""
    step: str = ""
    find: Callable[[Scene], Findings] | None = None
    start: Callable[[Scene], AbstractContextManager[Callable[[], Findings]]] | None = None
    holds: tuple[Place, ...] = ()
    mentions: tuple[str, ...] = ()
    computed_after: str = ""
    is_long: bool = False

    @property
    def template(self) -> str:
        """Path of the section's template below the folder of this package."""
        return f"sections/{self.name}/page.html.jinja"

    @property
    def of_paper(self) -> str:
        """The paper's figures and tables that the section holds, as in "Figs. 7 and 8, Table I"."""
        figures = [place.name.removeprefix("Fig. ") for place in self.holds if place.name.startswith("Fig. ")]
        tables = [place.name for place in self.holds if place.name.startswith("Table ")]
        if figures:
            tables.insert(0, f"Fig{'s' if len(figures) > 1 else ''}. {' and '.join(figures)}")
        return ", ".join(tables)
