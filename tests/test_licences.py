"""What is handed out has the licences of what is linked into it: `tools/gather_licences.py`."""

from __future__ import annotations

import importlib.util
import re
import subprocess
from pathlib import Path
from types import ModuleType

import pytest

MIT = "MIT License\n\nCopyright (c) 2020 {who}\n\n{grant}\n"
APACHE = "Apache License\nVersion 2.0\n\nTERMS AND CONDITIONS, which are long: " + 50 * "a word "


@pytest.fixture(scope="module")
def tool(root: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("gather_licences", root / "tools" / "gather_licences.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def grant(root: Path) -> str:
    text = (root / "LICENSE").read_text("utf-8")
    return text[text.index("Permission") :].strip()


def made_crate(tool: ModuleType, folder: Path, licence: str, **texts: str) -> object:
    folder.mkdir()
    (folder / "Cargo.toml").write_text(
        f'[package]\nname = "{folder.name}"\nauthors = ["Ada"]\n', encoding="utf-8"
    )
    for name, text in texts.items():
        (folder / name.replace("_", "-")).write_text(text, encoding="utf-8")
    return tool.Crate(f"{folder.name} 1.0.0", licence, folder)


def test_law_every_crate_of_the_wheel_has_its_licence(tool: ModuleType, root: Path) -> None:
    target = next(
        line.removeprefix("host: ")
        for line in subprocess.check_output(["rustc", "-vV"], text=True).splitlines()
        if line.startswith("host: ")
    )
    named = {crate.name for crate in tool.linked_crates("telespring-py", target)}
    # some of those that the binding calls, and what they call; what only builds or tests it is not linked
    for linked in ("numpy", "pyo3", "nalgebra", "rayon-core", "serde_core", "libm", "winnow"):
        assert any(name.startswith(f"{linked} ") for name in named), linked
    for only_builds in ("syn", "proptest", "serde_derive", "tokio", "telespring"):
        assert not any(name.startswith(f"{only_builds} ") for name in named), only_builds
    text = tool.licences("telespring-py", target)
    assert named <= set(text.splitlines())
    assert text.count(f"\n\n{grant(root)}\n\n===") == 1
    assert re.search(r"^numpy .*\n\nBSD 2-Clause License", text, re.M)
    assert re.search(r"^nalgebra .*\n(?:.+\n)*\nApache License", text, re.M)


def test_law_a_crate_is_taken_under_mit_with_its_copyright(
    tool: ModuleType, root: Path, tmp_path: Path
) -> None:
    crates = [
        # lines broken elsewhere are the same text
        made_crate(
            tool,
            tmp_path / "both",
            "MIT OR Apache-2.0",
            LICENSE_MIT=MIT.format(who="Grace", grant=" ".join(grant(root).split())),
            LICENSE_APACHE=APACHE,
            COPYING="Under either.",
        ),
        made_crate(
            tool, tmp_path / "mine", "MIT", **{"license.txt": MIT.format(who="Alan", grant=grant(root))}
        ),
        made_crate(tool, tmp_path / "silent", "MIT/Apache-2.0"),
    ]
    text = tool.printed("program", crates)
    assert text.count("Permission is hereby granted") == 1
    assert APACHE not in text
    for name, who in (("both", "2020 Grace"), ("mine", "2020 Alan"), ("silent", "Ada")):
        assert f"{name} 1.0.0\n    Copyright (c) {who}\n" in text


def test_law_other_licences_are_printed_whole_and_once(tool: ModuleType, tmp_path: Path) -> None:
    crates = [
        made_crate(tool, tmp_path / "one", "Apache-2.0", LICENSE=APACHE, NOTICE="Made by one."),
        made_crate(tool, tmp_path / "two", "Apache-2.0", LICENSE=APACHE.replace(" ", "\n")),
        made_crate(
            tool, tmp_path / "short", "Apache-2.0 OR BSL-1.0", LICENSE_APACHE=APACHE, LICENSE_BOOST="Boost"
        ),
        made_crate(
            tool,
            tmp_path / "all",
            "(Apache-2.0 OR BSL-1.0) AND BSD-3-Clause",
            LICENSE_BOOST="Boost",
            LICENSE_BSD="BSD",
        ),
    ]
    text = tool.printed("program", crates)
    assert f"\none 1.0.0\ntwo 1.0.0\n\n{APACHE.strip()}\n" in text
    assert text.count("TERMS") == 1
    assert "\none 1.0.0\n\nMade by one.\n" in text
    assert "\nshort 1.0.0\nall 1.0.0\n\nBoost\n" in text
    assert "\nall 1.0.0\n\nBSD\n" in text


def test_law_a_crate_without_the_text_of_its_licence_is_refused(tool: ModuleType, tmp_path: Path) -> None:
    crate = made_crate(tool, tmp_path / "bare", "Apache-2.0")
    with pytest.raises(SystemExit, match=r"bare 1\.0\.0 \(Apache-2\.0\) has no text of its licence"):
        tool.printed("program", [crate])
