"""Every block of every document is run, compiled or read; one that cannot be run here says so, and counts."""

from __future__ import annotations

import re
import shutil
import subprocess
import tomllib
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import telespring as ts
from document_blocks import Block, blocks_of, command_lines, documents, run_console, run_python, same_output
from made_recording import MadeSession
from made_session import write_session
from tools.site import command_reference

ROOT = Path(__file__).resolve().parent.parent
BLOCKS = {name: blocks_of(ROOT, name) for name in documents(ROOT)}

#: Languages of fences. What is none of these is not known to be right.
LANGUAGES = {"python", "console", "toml", "c", "rust", "csv", "text", "matlab", "bash", "indented"}

#: How many blocks of each document are not run. A new one is a decision, not an accident.
NOT_RUN = {
    "docs/explore.md": 1,
    "docs/scale.md": 4,
    "docs/how-to/from-matlab.md": 2,
    "docs/how-to/recordings-to-bids.md": 2,
    "docs/how-to/simulink-labview.md": 2,
    "docs/recording.md": 1,
    "docs/tutorials/couple.md": 5,
    "docs/tutorials/install.md": 3,
}


def runnable(*languages: str) -> list[Block]:
    return [
        block
        for blocks in BLOCKS.values()
        for block in blocks
        if block.language in languages and block.reason is None
    ]


def documents_with(*languages: str) -> list[str]:
    return sorted({block.document for block in runnable(*languages)})


@pytest.fixture
def workshop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return an empty folder in which the documents' commands run, with the examples in it."""
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    return tmp_path


def test_law_every_fence_says_what_it_is() -> None:
    assert {
        str(block): block.language
        for blocks in BLOCKS.values()
        for block in blocks
        if block.language not in LANGUAGES
    } == {}


def test_law_what_is_not_run_is_counted() -> None:
    marked = Counter(
        block.document for blocks in BLOCKS.values() for block in blocks if block.reason is not None
    )
    assert dict(marked) == NOT_RUN


def study_to_compare(folder: Path) -> None:
    networks = [{"name": "campus"}, {"name": "5G urban", "delay": 0.05}]
    study = ts.Study.paper().replace(
        protocol={**SHORT, "stiffness": [35.6]},
        comparison={"architectures": ["spring", "guard"], "networks": networks},
    )
    (folder / "study.toml").write_text(study.to_toml(), encoding="utf-8")


def saved_study(document: str, name: str) -> Callable[[Path], None]:
    """Return what saves the page's block of TOML as the page says."""

    def save(folder: Path) -> None:
        [study] = [block for block in BLOCKS[document] if block.language == "toml"]
        (folder / name).write_text(study.text, encoding="utf-8")

    return save


def finished_rehearsal(folder: Path) -> None:
    study = ts.Study.paper().replace(protocol={**SHORT, "stiffness": [35.6], "delay": [0.167]})
    ts.rehearse(study, folder / "out" / "rehearsal")


def robot_file(folder: Path) -> None:
    (folder / "left.toml").write_text("[robot]\nmass = 1.2\ndamping = 6.0\n")


def recordings_of_both_sites(folder: Path) -> None:
    first, second = write_session(folder / "out" / "connect")
    ts.merge_recordings(first, second, folder / "session.mcap")
    marks = [(0.2, 1, "condition soft"), (0.3, 1, "trial 1"), (0.9, 1, "trial end")]
    MadeSession(seconds=1.0, marks=marks).write(folder)


def recordings_of_two_people(folder: Path) -> None:
    marks = [(0.1, 1, "participant P01"), (0.1, 2, "participant P02"), (0.1, 1, "condition soft")]
    MadeSession(seconds=1.0, marks=[*marks, (0.3, 1, "trial 1"), (0.8, 1, "trial end")]).write(folder)


def recorded_demonstration(folder: Path) -> None:
    write_session(folder / "out" / "connect")


#: The shortest protocol that a page needs.
SHORT = {"trials": 1, "duration": 2.5, "discard": 0.5}

#: What a page takes for granted: files that its reader has.
GIVEN: dict[str, Callable[[Path], None]] = {
    "docs/compare.md": study_to_compare,
    "docs/recording.md": recordings_of_both_sites,
    "docs/rehearse.md": finished_rehearsal,
    "docs/study-file.md": robot_file,
    "docs/how-to/recordings-to-bids.md": recordings_of_two_people,
    "docs/how-to/slow-robots.md": saved_study("docs/how-to/slow-robots.md", "arms.toml"),
    "docs/tutorials/couple.md": recorded_demonstration,
    "docs/tutorials/rehearse.md": saved_study("docs/tutorials/rehearse.md", "study.toml"),
}


@pytest.mark.timeout(300)
@pytest.mark.parametrize("document", documents_with("python", "console"))
def test_law_what_a_document_shows_is_what_comes_out(document: str, workshop: Path) -> None:
    if document in GIVEN:
        GIVEN[document](workshop)
    names: dict[str, Any] = {"__name__": "__main__"}
    for block in BLOCKS[document]:
        if block.reason is not None:
            continue
        if block.language == "python":
            printed = run_python(block, names)
            if block.output is not None:
                assert same_output(block.output, printed), f"{block} prints:\n{printed}"
        elif block.language == "console":
            assert run_console(block) == []


@pytest.mark.parametrize("block", runnable("toml"), ids=str)
def test_law_every_fragment_of_toml_has_keys_that_exist(block: Block) -> None:
    content = tomllib.loads(block.text)
    try:
        ts.Study.paper().replace(**content)
    except ts.InvalidInput as refusal:
        # of a site file; the program's own tests keep the list of its keys in docs/connect.md true
        listed = set(re.findall(r"`([a-z_.]+)`", (ROOT / "docs" / "connect.md").read_text(encoding="utf-8")))
        keys = {
            f"{table}.{key}" if isinstance(value, dict) else table
            for table, value in content.items()
            for key in (value if isinstance(value, dict) else [table])
        }
        unknown = {key for key in keys if not {key, f"network.{key}"} & listed}
        if unknown:
            pytest.fail(f"{block}: {unknown}; {refusal}")


@pytest.mark.parametrize("block", runnable("csv"), ids=str)
def test_law_every_table_can_be_read(block: Block, tmp_path: Path) -> None:
    (tmp_path / "trace.csv").write_text(block.text)
    assert len(ts.read_trace(tmp_path / "trace.csv").delay) > 1


@pytest.mark.skipif(
    shutil.which("cc") is None, reason="NO C COMPILER HERE: the documents' C was not compiled"
)
@pytest.mark.parametrize("block", runnable("c"), ids=str)
def test_law_every_fragment_of_c_compiles(block: Block, tmp_path: Path) -> None:
    names = "seconds, sequence, newest, told, x, y, vx, vy, enabled, homed, stopped, force[2]"
    headers = "#include <math.h>\n#include <sys/socket.h>\n"
    (tmp_path / "block.c").write_text(f"{headers}void tick(int site) {{ double {names};\n{block.text}\n}}\n")
    done = subprocess.run(
        [
            "cc",
            "-fsyntax-only",
            "-Wall",
            "-Werror",
            "-Wno-uninitialized",
            "-Wno-maybe-uninitialized",
            "block.c",
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr


def test_law_every_fragment_of_rust_is_a_test_of_the_crate() -> None:
    crate = (ROOT / "crates" / "telespring" / "src" / "lib.rs").read_text(encoding="utf-8")
    for document in documents_with("rust"):
        assert f'include_str!("../../../{document}")' in crate, f"nobody compiles the Rust of {document}"


def test_law_every_command_line_has_a_command_and_options_that_exist() -> None:
    known = {
        name: {spelling for option in each.params for spelling in (*option.opts, *option.secondary_opts)}
        | {"--help"}
        for name, each in command_reference.commands().items()
    }
    checked = 0
    for block in (
        block for blocks in BLOCKS.values() for block in blocks if block.language in ("indented", "console")
    ):
        for words in command_lines(block):
            assert words[1] in known, f"{block}: telespring {words[1]}"
            given = {word.split("=")[0].strip("[]") for word in words if re.match(r"\[?--[a-z]", word)}
            assert given <= known[words[1]], f"{block}: {given - known[words[1]]}"
            checked += 1
    assert checked > 40
