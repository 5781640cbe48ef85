"""The documents agree with the code."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

from document_blocks import documents
from made_session import write_session

#: What the build of the site writes, besides one page per example of the gallery.
SITE_PAGES = ("commands", "python", "gallery/index", "try-it", "examples.zip")

DOCUMENTS = documents(Path(__file__).resolve().parent.parent)


def test_ref_the_readme_example_runs_and_says_what_the_paper_has(root: Path) -> None:
    examples = re.findall(r"```python\n(.*?)```", (root / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    printed = []
    for example in examples:
        assert len(example.splitlines()) <= 14
        done = subprocess.run(
            [sys.executable, "-W", "error", "-c", example],
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )
        assert done.returncode == 0, done.stderr
        printed.append(done.stdout.splitlines())
    [answer, lines] = printed
    assert answer[0] == "stable"
    assert 190.4 <= float(answer[1]) < 190.5  # what the command shows above
    # 2 K_x and its maximum delay, 167.186 ms, from the paper's Table III by its own equations
    assert lines[0] == "stiffness 71.2 N/m is stable below 167.1 ms one way"
    assert "at 0.16 s: -" in lines[2]
    assert "at 0.18 s: +" in lines[3]


def test_law_versions_are_said_once_and_alike(root: Path) -> None:
    cargo = tomllib.loads((root / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    readme = (root / "README.md").read_text(encoding="utf-8")
    assert f"Rust ≥ {cargo['rust-version']}" in readme
    assert f"Python {project['requires-python'].replace('>=', '≥ ')}" in readme
    assert f"version: {cargo['version']}\n" in (root / "CITATION.cff").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", DOCUMENTS)
def test_law_links_lead_somewhere(root: Path, name: str) -> None:
    for target in re.findall(r"\]\((?!https?:)([^)#]+)", (root / name).read_text(encoding="utf-8")):
        if "_generated/" in target:  # by the build of the site, from these
            made = target.rpartition("_generated/")[2]
            source = root / "docs" / f"{made}.py"
            assert made in SITE_PAGES or source.exists(), f"{name} links to {target}"
        else:
            assert ((root / name).parent / target).exists(), f"{name} links to {target}"


@pytest.mark.parametrize("name", DOCUMENTS)
def test_law_every_make_target_named_exists(root: Path, name: str) -> None:
    makefile = (root / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(
        r"(?:^    |`)make ([a-z0-9-]+)", (root / name).read_text(encoding="utf-8"), re.MULTILINE
    ):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), f"{name} names make {target}"


def test_law_every_test_that_a_page_names_exists(root: Path) -> None:
    files = [
        *(root / "crates").rglob("*.rs"),
        *(root / "drivers").rglob("*.rs"),
        *(root / "tests").glob("*.py"),
    ]
    written = {name for file in files for name in re.findall(r"(?:fn|def) (\w+)\(", file.read_text("utf-8"))}
    # a page may name a whole file or folder
    written |= {part for file in files for part in file.with_suffix("").parts}
    named = {
        (page.name, name)
        for page in (root / "docs").glob("*.md")
        for name in re.findall(r"`((?:test_)?(?:law|ref|cross|pin)_\w+)`", page.read_text("utf-8"))
    }
    assert {page for page, _ in named} >= {"faults.md", "hazards.md", "threat-model.md"}
    assert [each for each in sorted(named) if each[1] not in written] == []


def test_law_requirements_are_pinned_exactly(root: Path) -> None:
    seen: dict[str, str] = {}
    for path in sorted((root / "requirements").glob("*.txt")):
        for line in path.read_text(encoding="utf-8").splitlines():
            if not line or line.startswith("#"):
                continue
            pin = re.fullmatch(r"([a-z0-9-]+)==([0-9][0-9a-z.]*)", line)
            assert pin, f"{path.name}: {line}"
            assert pin[1] not in seen, f"{pin[1]} stands in {seen.get(pin[1])} and {path.name}"
            seen[pin[1]] = path.name


def test_ref_the_paper_is_transcribed_whole(du2025: dict[str, Any]) -> None:
    conditions = du2025["conditions"]
    tasks = ["UM"] + [
        f"CM-{k:.0f}-{delay:.0f}"
        for k in conditions["stiffness"]["values"]
        for delay in conditions["delay"]["values"]
    ]
    assert [row["task"] for row in du2025["table1"]["row"]] == tasks
    misprints = du2025["misprint"]
    assert len({misprint["id"] for misprint in misprints}) == len(misprints)
    for misprint in misprints:
        assert {"id", "where", "printed", "correct", "kind"} <= set(misprint)


def readme_commands(root: Path) -> list[str]:
    text = (root / "README.md").read_text(encoding="utf-8")
    return re.findall(r"^    (telespring .*)$", text, re.MULTILINE)


@pytest.mark.timeout(600)
def test_law_every_command_of_the_readme_runs_as_pasted(root: Path, tmp_path: Path) -> None:
    commands = readme_commands(root)
    assert len(commands) > 8
    (tmp_path / "examples").symlink_to(root / "examples")
    # what the demonstration, a program that is built apart, would have recorded
    write_session(tmp_path / "out" / "connect")
    for command in commands:
        if command.startswith(("telespring reproduce", "telespring connect", "telespring explore")):
            continue  # minutes, the demonstration, or the page, which is built apart; other tests run them
        words = []
        for word in shlex.split(command):
            found = sorted(tmp_path.glob(word)) if "*" in word else []
            words += [str(path.relative_to(tmp_path)) for path in found] or [word]
        done = subprocess.run(
            [sys.executable, "-m", *words],
            capture_output=True,
            text=True,
            check=False,
            cwd=tmp_path,
            timeout=300,
        )
        assert done.returncode == 0, f"{command}: {done.stderr}"
        assert done.stderr == "", command


def test_law_the_readme_shows_what_the_command_prints(root: Path) -> None:
    text = (root / "README.md").read_text(encoding="utf-8")
    [command, shown] = re.findall(r"^    \$ (.*)\n((?:    .*\n)+)", text, re.MULTILINE)[0]
    done = subprocess.run(
        [sys.executable, "-m", *shlex.split(command)], capture_output=True, text=True, check=True, timeout=60
    )
    printed = " ".join(done.stdout.split())
    for line in shown.splitlines():
        assert line.strip() in printed


@pytest.mark.parametrize("name", ["docs/tutorials/couple.md", "docs/console.md"])
def test_law_keys_of_a_live_session_that_a_page_names_exist(root: Path, name: str) -> None:
    from telespring.show.screens.live import KEYS

    text = (root / name).read_text(encoding="utf-8")
    named = set(re.findall(r"`([a-z])`", text))
    assert named
    assert named <= set(re.findall(r"\b([a-z]) \w", KEYS)), name
