"""A rehearsal that is refused: folders in use or of others, and input that cannot be rehearsed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import telespring as ts
from resuming import left_in, written
from short_rehearsal import begin, command, study_text
from telespring.rehearsal.store import lock_folder


@pytest.fixture(scope="module")
def short() -> ts.Study:
    return ts.Study.from_toml(study_text())


@pytest.fixture
def begun(short: ts.Study, tmp_path: Path) -> Path:
    return begin(short, tmp_path)


@pytest.mark.parametrize("state", ["begun", "complete"])
def test_law_the_folder_of_another_study_is_refused_and_left_alone(
    begun: Path, short: ts.Study, state: str
) -> None:
    if state == "complete":
        ts.rehearse(short, begun)
    before = left_in(begun)
    for other, said in (
        (study_text(name="another"), "another study, 'short'"),
        (study_text(duration=2.5), "the same name, 'short', with different contents"),
    ):
        with pytest.raises(ts.InvalidInput, match=said) as refused:
            ts.rehearse(ts.Study.from_toml(other), begun)
        assert refused.value.field == "out"
        assert "--fresh" in refused.value.remedy
    assert left_in(begun) == before


def test_law_a_file_of_the_datasets_name_that_is_none_is_refused(short: ts.Study, tmp_path: Path) -> None:
    (tmp_path / "rehearsal.nc").write_text("my notes")
    with pytest.raises(ts.InvalidInput, match="not from one"):
        ts.rehearse(short, tmp_path)
    assert (tmp_path / "rehearsal.nc").read_text() == "my notes"


def test_law_a_second_process_is_refused_until_the_first_is_dead(short: ts.Study, tmp_path: Path) -> None:
    code = (
        "import sys, time, pathlib; from telespring.rehearsal.store import lock_folder\n"
        "with lock_folder(pathlib.Path(sys.argv[1])):\n    print('locked', flush=True); time.sleep(60)"
    )
    owner = subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], stdout=subprocess.PIPE)
    try:
        assert owner.stdout is not None
        assert owner.stdout.readline() == b"locked\n"
        with pytest.raises(ts.InvalidInput, match=f"process {owner.pid} is using"):
            ts.rehearse(short, tmp_path)
    finally:
        owner.kill()
        owner.communicate()
    ts.rehearse(short, tmp_path)


def test_law_two_threads_of_one_process_cannot_both_hold_a_folder(tmp_path: Path) -> None:
    with (
        lock_folder(tmp_path),
        pytest.raises(ts.InvalidInput, match="is using this one"),
        lock_folder(tmp_path),
    ):
        pass
    with lock_folder(tmp_path):
        pass


@pytest.mark.parametrize("place", ["file", "file/below"])
def test_law_a_file_in_the_folders_place_is_told(tmp_path: Path, place: str) -> None:
    (tmp_path / "file").write_text("mine")
    refused = command(written(tmp_path, study_text()), "--out", tmp_path / place)
    assert refused.exit_code == 2
    assert "a folder is required" in refused.output


def test_law_input_that_cannot_be_rehearsed_is_refused(tmp_path: Path) -> None:
    lonely = """
robot1 = {mass = 1.0, damping = 5.0}
robot2 = {mass = 1.0, damping = 5.0}
coupling.stiffness = 20.0
network.delay = 0.05
"""
    with pytest.raises(ts.InvalidInput, match="exactly two axes"):
        ts.rehearse(ts.Study.from_toml(lonely), tmp_path)
    with pytest.raises(ts.InvalidInput, match="workers"):
        ts.rehearse(ts.Study.from_toml(study_text()), tmp_path, workers=0)
    refused = command(tmp_path / "missing.toml", "--out", tmp_path)
    assert refused.exit_code == 2
    assert "missing.toml" in refused.output
    assert left_in(tmp_path) == []
