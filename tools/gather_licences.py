"""Print the licences of the crates that are linked into one of this workspace.

    tools/gather_licences.py CRATE TARGET

Who hands out a compiled program hands out their code, and their licences ask for their texts beside it.
A crate under a choice is taken under MIT, else under the choice with the shortest text. The text of MIT is
printed once, behind the copyright lines of all.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
_TEXT = re.compile(r"(?i)^(licen[cs]e|copying|copyright|notice|unlicense)")
_TITLE = re.compile(r"(?i)^(the )?mit license( \(mit\))?$")
_GRANT = "Permission is hereby granted"
_LIBRARY = (
    "Rust's standard library\n"
    "    Copyright (c) The Rust Project Developers; the crates in it: COPYRIGHT-library.html of Rust"
)


class Crate(NamedTuple):
    """A linked crate: name and version, its licences as SPDX says them, and its folder."""

    name: str
    licence: str
    folder: Path


def linked_crates(package: str, target: str) -> list[Crate]:
    """Return the crates of others that are linked into a package."""
    options = ["--locked", "--package", package, "--target", target, "--edges", "normal,no-proc-macro"]
    tree = subprocess.run(
        ["cargo", "tree", *options, "--prefix", "none", "--format", "{p}|{l}"],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    crates = set()
    for line in tree.splitlines():
        crate, licence = line.removesuffix(" (*)").split("|")
        name, version, *source = crate.split(" ")
        if not source:
            crates.add(Crate(f"{name} {version[1:]}", licence, sources(name, version[1:])))
        elif not source[0].startswith(f"({ROOT}"):
            raise SystemExit(f"gather_licences: {crate} is of no registry: its licence is not known.")
    return sorted(crates)


def sources(name: str, version: str) -> Path:
    """Return the folder of a crate's sources, as cargo has downloaded them."""
    home = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo"))
    for folder in sorted(home.glob(f"registry/src/*/{name}-{version}")):
        return folder
    raise SystemExit(
        f"gather_licences: no sources of {name} {version} below {home}: run 'cargo fetch --locked'."
    )


def texts(crate: Crate) -> list[str]:
    """Return the texts of a crate's licence."""
    named = sorted(path for path in crate.folder.iterdir() if _TEXT.match(path.name) and path.is_file())
    notices = [path for path in named if path.name.upper().startswith("NOTICE")]
    found = {path: path.read_text("utf-8").strip() for path in named}
    choices = re.split(r" OR |/", crate.licence)
    if "MIT" in choices:
        granted = [path for path in named if "MIT" in path.name.upper()]
        if not named:
            return [f"{authors(crate)}\n\n{mit()}"]
        named = granted + notices if granted else named
    elif len(choices) > 1 and " AND " not in crate.licence:
        named = [min(set(named) - set(notices), key=lambda path: len(found[path])), *notices]
    if not named:
        raise SystemExit(f"gather_licences: {crate.name} ({crate.licence}) has no text of its licence.")
    return [found[path] for path in named]


def authors(crate: Crate) -> str:
    """Return who made a crate that has no text of its licence, as far as it says so."""
    package = tomllib.loads((crate.folder / "Cargo.toml").read_text("utf-8"))["package"]
    made_by = ", ".join(package.get("authors", ())) or f"its authors, {package.get('repository', 'unnamed')}"
    return f"Copyright (c) {made_by}"


def mit() -> str:
    """Return the text of MIT, without who grants it: this project's own."""
    own = (ROOT / "LICENSE").read_text("utf-8")
    return own[own.index(_GRANT) :].strip()


def licences(package: str, target: str) -> str:
    """Return the licences of what is linked into a package."""
    return printed(package, linked_crates(package, target))


def printed(package: str, crates: list[Crate]) -> str:
    """Return the licences of crates that are linked into a package, as one text."""
    granted = [_LIBRARY]
    others: defaultdict[str, list[str]] = defaultdict(list)
    originals: dict[str, str] = {}
    for crate in crates:
        for text in texts(crate):
            start, found, grant = text.partition(_GRANT)
            if found and same(found + grant) == same(mit()):
                lines = (line.strip() for line in start.splitlines())
                lines = (line for line in lines if line and not _TITLE.match(line))
                granted.append("\n    ".join([crate.name, *lines]))
            else:
                originals.setdefault(same(text), text)
                others[same(text)].append(crate.name)
    parts = [f"{chr(10).join(granted)}\n\n{mit()}"]
    parts += [f"{chr(10).join(named)}\n\n{originals[text]}" for text, named in others.items()]
    title = f"{package} has code of these projects in it, under these licences."
    return f"\n\n{'=' * 72}\n\n".join([title, *parts]) + "\n"


def same(text: str) -> str:
    """Return a text as it is compared: lines may be broken elsewhere, and quotes differ."""
    return re.sub(r"\s+", " ", text.replace("“", '"').replace("”", '"').replace("''", '"')).strip()


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    # the same bytes on every system
    sys.stdout.buffer.write(licences(sys.argv[1], sys.argv[2]).encode())
