"""MATLAB files of trials and sessions, read back, and plotted by the example where Octave is installed."""

from __future__ import annotations

import csv
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import io
from typer.testing import CliRunner

import telespring as ts
from telespring.cli import app

OCTAVE = shutil.which("octave-cli")
needs_octave = pytest.mark.skipif(OCTAVE is None, reason="octave-cli is not installed: apt install octave")


@pytest.fixture(scope="module")
def trials(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("mat") / "trials.mat"
    return ts.export_mat(root / "examples" / "trials", file)


@pytest.fixture(scope="module")
def session(folder_with_a_session: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("mat") / "session.mat"
    done = CliRunner().invoke(
        app, ["export", str(folder_with_a_session / "session.mcap"), "--mat", str(file)]
    )
    assert done.exit_code == 0, done.output
    return file


def test_law_trials_are_an_array_of_structs(root: Path, trials: Path) -> None:
    content = io.loadmat(trials, simplify_cells=True)
    with (root / "examples" / "trials" / "trials.csv").open(encoding="utf-8", newline="") as file:
        listed = list(csv.DictReader(file))
    assert len(content["trial"]) == len(listed)
    for row in listed:
        stiffness = float(row["stiffness_N_per_m"] or "nan")
        [found] = [
            trial
            for trial in content["trial"]
            if str(trial["number"]) == row["trial"]
            and np.array_equal(trial["stiffness"], stiffness, equal_nan=True)
            and trial["delay"] == float(row["delay_s"])
        ]
        values = np.genfromtxt(root / "examples" / "trials" / row["file"], delimiter=",", names=True)
        assert np.array_equal(found["time"], values["time_s"])
        for number, robot in enumerate(found["robot"], 1):
            for i, axis in enumerate("xy"):
                column = values[f"position_robot{number}_{axis}_m"]
                assert np.array_equal(robot["position"][:, i], column)
        assert found["target"].shape == (len(values), 2)
    assert content["units"]["position"] == "m"
    assert content["units"]["stiffness"] == "N/m"
    assert "handle" not in content["units"]
    assert content["about"]["format"] == "telespring mat 1"


def test_law_a_session_has_everything_over_time(folder_with_a_session: Path, session: Path) -> None:
    content = io.loadmat(session, simplify_cells=True)
    recording = ts.read_recording(folder_with_a_session / "session.mcap")
    data = recording.dataset()
    found = content["session"]
    assert np.array_equal(found["time"], data["time"])
    for robot in (1, 2):
        for name in ("position", "velocity", "coupling_force"):
            there = found["robot"][robot - 1][name]
            assert np.array_equal(there, data[name].sel(robot=robot), equal_nan=True), name
    assert [event["name"] for event in found["event"]] == [event.event for event in recording.events]
    assert [event["time"] for event in found["event"]] == [event.time for event in recording.events]
    assert found["clock_uncertainty"] == recording.clock.uncertainty if recording.clock else False
    # The trial is a part of it.
    trial: dict[str, Any] = content["trial"] if isinstance(content["trial"], dict) else content["trial"][0]
    first = int(np.argmin(np.abs(found["time"] - trial["begin"])))
    part = found["robot"][0]["position"][first : first + len(trial["time"])]
    assert np.array_equal(part, trial["robot"][0]["position"])
    # Codes are explained where they are not numbers of something.
    assert "running" in content["meaning"]["phase"]
    assert set(found["robot"][0]) <= set(content["units"])


def test_law_equal_trials_give_equal_bytes(root: Path, trials: Path, tmp_path: Path) -> None:
    again = ts.export_mat(root / "examples" / "trials", tmp_path / "again.mat")
    assert again.read_bytes() == trials.read_bytes()


def test_law_fewer_samples_on_request(root: Path, folder_with_a_session: Path, tmp_path: Path) -> None:
    file = ts.export_mat(folder_with_a_session / "session.mcap", tmp_path / "slow.mat", rate=50.0)
    time = io.loadmat(file, simplify_cells=True)["session"]["time"]
    assert np.diff(time) == pytest.approx(0.02)
    with pytest.raises(ts.InvalidInput, match="only the samples of a live session"):
        ts.export_mat(root / "examples" / "trials", tmp_path / "slow.mat", rate=50.0)


def test_law_no_input_is_overwritten_and_names_are_checked(root: Path, tmp_path: Path) -> None:
    with pytest.raises(ts.InvalidInput, match=r"ends in \.mat"):
        ts.export_mat(root / "examples" / "trials", tmp_path / "trials.m")
    with pytest.raises(ts.InvalidInput, match="a dataset of trials"):
        ts.export_mat(7, tmp_path / "trials.mat")  # type: ignore[arg-type]


def octave(code: str) -> subprocess.CompletedProcess[str]:
    assert OCTAVE is not None
    command = [OCTAVE, "--norc", "--eval", code]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=110)


@needs_octave
@pytest.mark.parametrize("kind", ["trials", "session"])
def test_cross_octave_reads_the_file(request: pytest.FixtureRequest, kind: str) -> None:
    file = request.getfixturevalue(kind)
    done = octave(
        f"s = load('{file}'); t = s.trial(1); printf('%d %d %.17g %s', numel(s.trial), "
        "rows(t.robot(2).position), t.robot(2).position(end, 2), s.units.stiffness);"
    )
    assert done.returncode == 0, done.stderr
    count, rows, last, unit = done.stdout.split()[-4:]
    listed = trials_of(file)
    position = listed[0]["robot"][1]["position"]
    assert (int(count), int(rows)) == (len(listed), len(position))
    assert float(last) == position[-1, 1]
    assert unit == "N/m"


@needs_octave
@pytest.mark.parametrize("kind", ["trials", "session"])
def test_cross_octave_plots_the_file(
    root: Path, request: pytest.FixtureRequest, tmp_path: Path, kind: str
) -> None:
    first, picture = tmp_path / "first.svg", tmp_path / "picture.svg"
    able = octave(f"f = figure('Visible', 'off'); plot(1:2); title('a'); print(f, '{first}');")
    if able.returncode != 0:
        pytest.skip("this Octave cannot draw: apt install gnuplot-nox fonts-freefont-otf")
    file = request.getfixturevalue(kind)
    done = octave(
        f"addpath('{root / 'examples'}'); e = plot_trials('{file}', 1, '{picture}'); printf('%.17g', e(2));"
    )
    assert done.returncode == 0, done.stderr
    trial = trials_of(file)[0]
    apart = trial["robot"][1]["position"] - trial["target"]
    assert float(done.stdout.split()[-1]) == pytest.approx(np.nanmean(np.hypot(*apart.T)), rel=1e-12)
    assert picture.stat().st_size > first.stat().st_size
    assert "robot 2" in picture.read_text(encoding="utf-8")


def trials_of(file: Path) -> list[dict[str, Any]]:
    content = io.loadmat(file, simplify_cells=True)["trial"]
    return [content] if isinstance(content, dict) else list(content)
