"""The interactive page with the report's study inside of the report, opened when the reader asks for it."""

from __future__ import annotations

import base64
import gzip

from telespring.app.page import is_carried, page_with
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section

__all__ = ["SECTION", "find_page"]


def find_page(scene: Scene) -> Findings:
    """Pack the page with the study; nothing where the package was built without its page."""
    if not is_carried():
        return Findings()
    packed = gzip.compress(page_with(scene.study).encode(), 9, mtime=0)
    return Findings(files={"page": base64.b64encode(packed).decode("ascii")})


SECTION = Section(
    name="explore",
    anchor="explore",
    title="Other values, moved by hand",
    step="interactive page",
    find=find_page,
)
