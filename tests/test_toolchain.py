"""What a person reads whose machine lacks something: one sentence that says what to install."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from browser import find_chromium

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.skipif(os.name != "posix", reason="the set-up is a POSIX shell script")

# what the script itself calls
UTILITIES = ("sh", "sed", "head", "dirname", "mktemp", "rm", "cat")


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    """A folder of programs that is all there is on the PATH, each good enough to pass."""
    folder = tmp_path / "bin"
    folder.mkdir()
    for name in UTILITIES:
        found = shutil.which(name)
        assert found
        (folder / name).symlink_to(found)
    program(folder, "cargo", "echo cargo 1.89.0")
    program(folder, "rustc", "echo 'rustc 1.89.0 (29483883e 2025-08-04)'")
    program(folder, "python3", f'exec "{sys.executable}" "$@"')
    program(folder, "cc", "exit 0")
    program(folder, "make", "exit 0")
    return folder


def program(folder: Path, name: str, body: str) -> None:
    path = folder / name
    path.write_text(f"#!/bin/sh\n{body}\n")
    path.chmod(0o755)


def check(root: Path, machine: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [machine / "sh", root / "tools" / "check-toolchain.sh", *arguments],
        env={"PATH": str(machine)},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


def test_ref_a_complete_machine_passes_without_a_word(root: Path, machine: Path) -> None:
    done = check(root, machine)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert check(root, machine, "--python").stdout == "python3\n"


@pytest.mark.parametrize(
    ("name", "body", "said"),
    [
        ("cargo", None, "install Rust from https://rustup.rs"),
        ("rustc", None, "install Rust from https://rustup.rs"),
        (
            "rustc",
            "echo 'rustc 1.88.0'",
            "found 1.88: update it with 'rustup update stable'",
        ),
        ("rustc", "echo no default toolchain >&2; exit 1", "rustup default stable"),
        ("python3", None, "Python 3.11 or newer and found none"),
        ("python3", "echo 3.9", "Python 3.11 or newer and found 3.9"),
        ("python3", 'case "$2" in *version*) echo 3.12;; *) exit 1;; esac', "apt install python3-venv"),
        ("cc", None, "found no 'cc': install one"),
        ("cc", "exit 1", "'cc' cannot build a program"),
        ("make", None, "telespring needs make and found none"),
    ],
)
def test_ref_what_is_missing_or_too_old_is_told_in_one_sentence(
    root: Path, machine: Path, name: str, body: str | None, said: str
) -> None:
    (machine / name).unlink()
    if body is not None:
        program(machine, name, body)
    done = check(root, machine)
    assert done.returncode == 1
    assert done.stdout == ""
    [sentence] = done.stderr.splitlines()
    assert said in sentence
    assert sentence.startswith("telespring needs ")
    assert sentence.endswith(".")


def test_ref_everything_missing_is_told_at_once(root: Path, machine: Path) -> None:
    for name in ("cargo", "python3", "cc", "make"):
        (machine / name).unlink()
    assert len(check(root, machine).stderr.splitlines()) == 4


def test_ref_only_the_documentation_site_needs_node(root: Path, machine: Path) -> None:
    done = check(root, machine, "--docs")
    assert done.returncode == 1
    [sentence] = done.stderr.splitlines()
    assert sentence.startswith("the documentation site needs Node.js with npm and found none")
    program(machine, "node", "exit 0")
    program(machine, "npm", "exit 0")
    assert check(root, machine, "--docs").returncode == 0


def test_law_newer_versions_pass(root: Path, machine: Path) -> None:
    program(machine, "rustc", "echo 'rustc 2.1.0 (0000000 2030-01-01)'")
    assert check(root, machine).returncode == 0


def test_law_a_newer_python_beside_an_old_one_is_found(root: Path, machine: Path) -> None:
    program(machine, "python3.12", f'exec "{sys.executable}" "$@"')
    program(machine, "python3", "echo 3.9")
    assert check(root, machine, "--python").stdout == "python3.12\n"


def test_law_the_live_program_alone_needs_a_newer_rust(root: Path, machine: Path) -> None:
    done = check(root, machine, "--link")
    assert done.returncode == 1
    [sentence] = done.stderr.splitlines()
    assert sentence.startswith("the live program needs Rust 1.91 or newer and found 1.89")
    program(machine, "rustc", "echo 'rustc 1.91.0'")
    assert check(root, machine, "--link").returncode == 0


@pytest.mark.skipif(
    shutil.which("node") is None, reason="NO NODE.JS HERE: its search for Chromium is untested"
)
@pytest.mark.parametrize("named", [None, "", "/opt/chrome"])
@pytest.mark.parametrize("installed", [(), ("google-chrome", "chromium-browser"), ("google-chrome",)])
def test_law_all_tests_look_for_the_same_browser(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: str | None, installed: tuple[str, ...]
) -> None:
    node = shutil.which("node") or "node"
    folders = [tmp_path / "first", tmp_path / "second"]
    for folder in folders:
        folder.mkdir()
    for folder, name in zip(
        folders, installed, strict=False
    ):  # the order of the names counts, not that of the folders
        program(folder, name, "exit 0")
    (folders[0] / "chromium").mkdir()  # a folder is no program
    monkeypatch.setenv("PATH", os.pathsep.join(map(str, folders)))
    monkeypatch.delenv("CHROMIUM", raising=False)
    if named is not None:
        monkeypatch.setenv("CHROMIUM", named)
    script = "console.log((await import(process.argv[1])).chromium_file)"
    asked = [node, "--input-type=module", "-e", script, str(root / "tools" / "chromium.mjs")]
    answer = subprocess.run(asked, capture_output=True, text=True, check=True, timeout=60).stdout.strip()
    found = find_chromium()
    assert answer == ("undefined" if found is None else found)
    assert found == named if named else found is None or found.endswith(installed[-1])
