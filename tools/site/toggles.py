"""The theme's toggles in the list of pages have no words: a screen reader gets some."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

__all__ = ["named", "setup"]

_TOGGLE = '<summary><span class="toctree-toggle"'
_NAMED = '<summary aria-label="Its pages"><span class="toctree-toggle"'


def named(page: str) -> str:
    """Return a page whose toggles have a name."""
    return page.replace(_TOGGLE, _NAMED)


def _name_toggles(app: Sphinx, failed: Exception | None) -> None:
    if failed is None and app.builder.format == "html":
        for path in Path(app.outdir).rglob("*.html"):
            text = path.read_text(encoding="utf-8")
            if _TOGGLE in text:
                path.write_text(named(text), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Name the toggles of every page once the site is built."""
    app.connect("build-finished", _name_toggles)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
