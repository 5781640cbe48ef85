"""The list of public names for the reference of Python: each has a page of its own, made of its docstring."""

from __future__ import annotations

from importlib import import_module
from inspect import isclass
from pathlib import Path

__all__ = ["ROOMS", "names", "text", "write"]

#: Public modules, and what they are for.
ROOMS = {
    "telespring": "The public names. All numbers are in SI units: m, s, N, kg, N/m, N·s/m, rad/s.",
    "telespring.plot": "Figures for scripts and notebooks: results in, matplotlib axes out.",
    "telespring.identification": "A robot's parameters from a log; movements that excite it.",
    "telespring.analysis": "What trials show, rehearsed or recorded, and the statistics that compare them.",
}


def names(module: str) -> tuple[list[str], list[str]]:
    """Return the public classes and functions of a module, each sorted."""
    found = import_module(module)
    public = [name for name in sorted(found.__all__, key=str.lower) if not name.startswith("_")]
    classes = [name for name in public if isclass(getattr(found, name))]
    return classes, [name for name in public if name not in classes]


def _table(title: str, module: str, listed: list[str]) -> str:
    if not listed:
        return ""
    rows = "\n".join(f"   {name}" for name in listed)
    return f"""
.. rubric:: {title}

.. currentmodule:: {module}

.. autosummary::
   :toctree: python
   :nosignatures:

{rows}
"""


def text() -> str:
    """Return the page in reStructuredText."""
    page = ["Python\n======\n"]
    for module, purpose in ROOMS.items():
        classes, functions = names(module)
        page.append(f"\n{module}\n{'-' * len(module)}\n\n{purpose}\n")
        page.append(_table("Functions", module, functions))
        page.append(_table("Classes", module, classes))
    return "".join(page)


def write(target: Path) -> None:
    """Write the page, if it would change."""
    target.parent.mkdir(parents=True, exist_ok=True)
    if not target.exists() or target.read_text(encoding="utf-8") != text():
        target.write_text(text(), encoding="utf-8")
