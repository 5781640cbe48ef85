"""Links of the documents to files outside docs/: to their page on the site, or to a copy of the file."""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

__all__ = ["PAGES", "setup", "site_link"]

#: A file of the repository, and the page of the site that shows it.
PAGES = {
    "README.md": "index.md",
    "ARCHITECTURE.md": "project/architecture.md",
    "CHANGELOG.md": "project/changelog.md",
    "CONTRIBUTING.md": "project/contributing.md",
    "ROADMAP.md": "project/roadmap.md",
    "SECURITY.md": "project/security.md",
    "SUPPORT.md": "project/support.md",
    "NOTATION.md": "reference/notation.md",
    "examples/README.md": "reference/examples.md",
    "drivers/hebi/README.md": "how-to/driver-hebi.md",
    "drivers/lsl/README.md": "how-to/driver-lsl.md",
    "drivers/ros2/README.md": "how-to/driver-ros2.md",
}

_LINK = re.compile(r"\]\((?!https?:|#|mailto:)([^)#\s]+)(#[^)\s]*)?\)")


def site_link(target: str, document: str, page: str) -> str:
    """Return where a link leads on the site.

    Parameters
    ----------
    target : str
        The link, relative to its document.
    document : str
        The document's path in the repository, such as docs/guard.md.
    page : str
        The path of the page that shows it, from docs/.
    """
    path = posixpath.normpath(posixpath.join(posixpath.dirname(document), target))
    place = PAGES.get(path, path.removeprefix("docs/") if path.startswith("docs/") else f"../{path}")
    return posixpath.relpath(place, posixpath.dirname(page) or ".")


def _document_of(page: str) -> str:
    shown = {shown: document for document, shown in PAGES.items() if shown != "index.md"}
    return shown.get(page, f"docs/{page}")


def setup(app: Sphinx) -> dict[str, Any]:
    """Let the links of every page lead somewhere on the site."""

    def rewrite(app: Sphinx, name: str, source: list[str]) -> None:
        page = f"{name}.md"
        path = Path(app.srcdir) / page
        if not path.exists() or name.startswith("_generated"):
            return
        document = _document_of(page)
        if document != f"docs/{page}":  # the page is its document and nothing else
            source[0] = (Path(app.srcdir).parent / document).read_text(encoding="utf-8")

        def replaced(link: re.Match[str]) -> str:
            return f"]({site_link(link[1], document, page)}{link[2] or ''})"

        source[0] = _LINK.sub(replaced, source[0])

    app.connect("source-read", rewrite)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
