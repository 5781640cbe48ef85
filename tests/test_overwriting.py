"""No command replaces a file that it reads, however its name is spelt."""

from __future__ import annotations

from pathlib import Path

import pytest

import telespring as ts
from made_trials import small
from questions import flat, run
from telespring.analysis import write_recorded, write_template

STUDY = """
[robot1]
mass = 1.2
damping = 6.0
[robot2]
mass = 2.0
damping = 9.0
[coupling]
stiffness = 100.0
[network]
delay = 0.04
"""
ROBOT = "[robot]\nmass = [1.2]\ndamping = [6.0]\n"


def refused(*arguments: str) -> str:
    found = run(*arguments)
    assert found.exit_code == 2, found.output
    return flat(found.stderr)


def spellings(path: Path) -> list[Path]:
    """The file itself, a way around, and a second name of it."""
    (path.parent / "folder").mkdir(exist_ok=True)
    link = path.with_name(f"link{path.suffix}")
    link.hardlink_to(path)
    return [path, path.parent / "folder" / ".." / path.name, link]


@pytest.mark.parametrize("suffix", [".png", ".svg", ".PDF"])
def test_law_the_map_replaces_no_study(tmp_path: Path, suffix: str) -> None:
    study = tmp_path / f"study{suffix}"
    study.write_text(STUDY)
    for spelt in spellings(study):
        message = refused("decide", str(study), "--figure", str(spelt))
        assert "is an input of the command" in message
        assert "Choose another name." in message
    assert study.read_text() == STUDY


def test_law_the_map_replaces_no_robot(tmp_path: Path) -> None:
    robot = tmp_path / "robot.png"
    robot.write_text(ROBOT)
    asked = ("--robot", str(robot), "--robot", str(robot), "--ping", "80ms")
    assert "is an input of the command" in refused("decide", *asked, "--figure", str(robot))
    assert robot.read_text() == ROBOT


@pytest.mark.parametrize("suffix", [".nc", ".csv"])
def test_law_a_simulation_replaces_neither_study_nor_robot(tmp_path: Path, suffix: str) -> None:
    study, robot = tmp_path / f"study{suffix}", tmp_path / f"robot{suffix}"
    study.write_text(STUDY)
    robot.write_text(ROBOT)
    for spelt in (study, robot):
        message = refused(
            "simulate", str(study), "--robot1", str(robot), "--robot2", "2,9", "--out", str(spelt)
        )
        assert spelt.name in message.replace(" ", "")
        assert "is an input of the command" in message
    assert (study.read_text(), robot.read_text()) == (STUDY, ROBOT)


@pytest.mark.parametrize(
    ("command", "name"),
    [
        ("rehearse", "rehearsal.json"),
        ("rehearse", "rehearsal.nc"),
        ("reproduce", "report.html"),
        ("reproduce", "study.json"),
        ("study", "study.json"),
    ],
)
def test_law_a_folder_of_results_keeps_the_study(tmp_path: Path, command: str, name: str) -> None:
    study = tmp_path / name
    study.write_text(STUDY)
    fresh = ["--fresh"] if command == "rehearse" else []
    message = refused(command, str(study), "--out", str(tmp_path / "."), *fresh)
    assert f"{name} would be written there" in message
    assert "Choose another folder." in message
    assert study.read_text() == STUDY


def test_law_an_analysis_keeps_the_trials_that_it_reads(tmp_path: Path) -> None:
    index = write_template(tmp_path / "lab")
    # A lab may call its list, or a trial's file, what the analysis calls its table.
    first = sorted(path for path in index.parent.iterdir() if path.name not in {index.name, "study.toml"})[0]
    text = index.read_text().replace(first.name, "table1.csv")
    first.rename(index.with_name("table1.csv"))
    index.write_text(text)
    before = {path.name: path.read_bytes() for path in index.parent.iterdir()}
    message = refused("analyse", str(index.parent), "--out", str(index.parent))
    assert "table1.csv would be written there" in message
    assert {path.name: path.read_bytes() for path in index.parent.iterdir()} == before
    # The table beside trials of other names is written again and again.
    other = write_template(tmp_path / "other").parent
    for _ in range(2):
        assert run("analyse", str(other), "--out", str(other), "--no-figures").exit_code == 0


def test_law_an_export_keeps_the_trials_and_the_study(tmp_path: Path) -> None:
    index = write_template(tmp_path / "lab")
    renamed = index.rename(index.with_name("mine.csv"))
    before = {path.name: path.read_bytes() for path in index.parent.iterdir()}
    message = refused(
        "analyse", str(renamed), "--export", str(index.parent), "--out", str(tmp_path), "--no-figures"
    )
    assert "mine.csv in it is an input" in message
    assert {path.name: path.read_bytes() for path in index.parent.iterdir()} == before


def test_law_trials_with_a_study_do_not_replace_another(tmp_path: Path) -> None:
    trials = small().assign_attrs(study=ts.Study.paper().to_toml())
    (tmp_path / "study.toml").write_text(STUDY)
    with pytest.raises(ts.InvalidInput, match=r"without another study\.toml"):
        write_recorded(trials, tmp_path)
    assert (tmp_path / "study.toml").read_text() == STUDY
    assert [entry.name for entry in tmp_path.iterdir()] == ["study.toml"]
