"""The paper's misprints, each with its numbers."""

from __future__ import annotations

from telespring.paper.misprints import misprints
from telespring.paper.scene import Found, Scene

__all__ = ["find_misprints"]


def find_misprints(_scene: Scene) -> Found:
    """Compute what is printed and what is true; the misprints are the same in every study."""
    return Found(numbers={"misprints": [each.to_json() for each in misprints()]})
