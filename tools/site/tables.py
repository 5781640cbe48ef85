"""Header cells without words, which say nothing to a screen reader: they get some that are not seen."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

__all__ = ["setup"]


def _name_empty_headers(_app: Sphinx, tree: nodes.document, _page: str) -> None:
    for head in tree.findall(nodes.thead):
        for number, entry in enumerate(head.findall(nodes.entry)):
            if not entry.astext().strip():
                words = nodes.inline("", "row" if number == 0 else "remark", classes=["visually-hidden"])
                entry += nodes.paragraph("", "", words)


def setup(app: Sphinx) -> dict[str, Any]:
    """Name the empty header cells of every page."""
    app.connect("doctree-resolved", _name_empty_headers)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
