"""The page that needs no server, embedded in the site where it was made."""

from __future__ import annotations

from pathlib import Path

__all__ = ["files", "write"]

_FRAME = """# Try it

Drag the star in the map, or scroll down in the frame to the sliders: the verdict, its margins and the
motion of the robots follow. Nothing leaves this page.
<a href="../{name}">Open it on its own</a> for more room, to save it or to send it to a colleague.

<iframe class="try-it" src="../{name}" title="telespring: try a dyad" loading="lazy"
allow="clipboard-write"></iframe>
"""

_ABSENT = """# Try it

This copy of the site was built without the interactive page. `make page` makes it, in
`out/page/telespring.html`; the next `make docs` shows it here. Meanwhile the
[first tutorial](../tutorials/decide.md) asks the same question on the command line.
"""


def files(made: Path) -> list[str]:
    """Return what the site carries as it is: the page, if it was made."""
    return [str(made)] if made.exists() else []


def write(target: Path, made: Path) -> None:
    """Write the page of the site that shows the interactive one, or says how to make it."""
    target.parent.mkdir(parents=True, exist_ok=True)
    text = _FRAME.format(name=made.name) if made.exists() else _ABSENT
    if not target.exists() or target.read_text(encoding="utf-8") != text:
        target.write_text(text, encoding="utf-8")
