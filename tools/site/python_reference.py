"""The list of public names for the reference of Python: each has a page of its own, made of its docstring."""

from __future__ import annotations

import tomllib
from importlib import import_module
from inspect import getdoc, isclass
from pathlib import Path
from typing import Any

__all__ = ["ELSEWHERE", "names", "own_names", "rooms", "text", "write"]

ROOT = Path(__file__).resolve().parent.parent.parent

#: Rooms whose names have no page here, and what stands for them.
ELSEWHERE = {
    "cli": "the page of the commands",
    "paper": "the command `reproduce`",
    "connection": "the command `connect`",
}

_INTRODUCTION = """Python
======

Most scripts need ``telespring`` only. The other modules hold the single steps behind it and what they return.
All numbers are in SI units: m, s, N, kg, N/m, N·s/m, rad/s.
"""


def rooms() -> list[str]:
    """Return the rooms that the layers of pyproject.toml list, without private ones."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    [layers] = [each for each in settings["tool"]["importlinter"]["contracts"] if each["id"] == "layers"]
    found = (room.strip(" ()") for floor in layers["layers"] for room in floor.split("|"))
    return sorted(room for room in found if not room.startswith("_"))


def names(module: str) -> tuple[list[str], list[str]]:
    """Return the public classes and functions of a module, each sorted."""
    found = import_module(module)
    listed = sorted(getattr(found, "__all__", ()), key=str.lower)
    public = [name for name in listed if not name.startswith("_") and callable(getattr(found, name))]
    classes = [name for name in public if isclass(getattr(found, name))]
    return classes, [name for name in public if name not in classes]


def own_names(room: str) -> tuple[list[str], list[str]]:
    """Return the classes and functions of a room that are not those of `telespring` itself."""
    package, module = import_module("telespring"), import_module(f"telespring.{room}")

    def is_own(name: str) -> bool:
        return name not in package.__all__ or getattr(package, name) is not getattr(module, name)

    classes, functions = ([name for name in kind if is_own(name)] for kind in names(module.__name__))
    return classes, functions


def _purpose(module: Any) -> str:
    return (getdoc(module) or "").partition("\n")[0]


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


def _section(module: str, classes: list[str], functions: list[str]) -> str:
    heading = f"\n{module}\n{'-' * len(module)}\n\n{_purpose(import_module(module))}\n"
    return heading + _table("Functions", module, functions) + _table("Classes", module, classes)


def text() -> str:
    """Return the page in reStructuredText."""
    page = _INTRODUCTION + _section("telespring", *names("telespring"))
    for room in rooms():
        classes, functions = own_names(room)
        if room not in ELSEWHERE and (classes or functions):
            page += _section(f"telespring.{room}", classes, functions)
    return page


def write(target: Path) -> None:
    """Write the page, if it would change."""
    target.parent.mkdir(parents=True, exist_ok=True)
    if not target.exists() or target.read_text(encoding="utf-8") != text():
        target.write_text(text(), encoding="utf-8")
