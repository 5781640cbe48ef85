"""The command `identify` and its robot file: what it says, leaves behind, and hands on to `decide`."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import telespring as ts
from telespring import InvalidInput, cli
from telespring.identification import identify, paper_excitation, robot_toml, write_robot
from telespring.study.robot_file import robot_record
from two_axis_log import TRUTH, frame, run, written


def test_law_a_number_of_reweightings_is_for_the_papers_method(tmp_path: Path) -> None:
    log = written(frame(), tmp_path / "log.csv")
    found = run(log, "--iterations", "3")
    assert found.exit_code == 2
    assert "only the paper's method has reweightings" in " ".join(found.stderr.split())
    assert run(log, "--iterations", "3", "--method", "paper").exit_code == 0


def test_law_a_log_without_noise_is_written_with_six_digits(tmp_path: Path) -> None:
    table = frame()
    command, time = paper_excitation(), table["time"].to_numpy()
    for lag, (axis, (mass, damping)) in zip((0.0, 1.25), TRUTH.items(), strict=True):
        t = time - lag
        table[f"position_{axis}"] = command.position(t)
        table[f"force_{axis}"] = mass * command.acceleration(t) + damping * command.velocity(t)
    path = written(table, tmp_path / "log.csv")
    narrow = CliRunner(env={"COLUMNS": "80", "NO_COLOR": "1"}).invoke(cli.app, ["identify", str(path)])
    lines = narrow.stdout.splitlines()
    assert any(line.startswith(("x ", "x:")) for line in lines)
    assert any(line.startswith(("y ", "y:")) for line in lines)
    assert re.search(r"0\.83340\d kg", narrow.stdout)
    assert not re.search(r"\d\.\d{7}", narrow.stdout)


@pytest.mark.parametrize("option", ["--start", "--end"])
def test_law_a_start_or_end_that_is_no_number_is_refused(tmp_path: Path, option: str) -> None:
    found = run(written(frame(), tmp_path / "log.csv"), option, "nan")
    assert found.exit_code == 2
    assert f"{option[2:]} = nan" in found.stderr


def test_law_a_missing_file_is_told_by_its_name(tmp_path: Path) -> None:
    found = run(tmp_path / "gone.csv")
    assert found.exit_code == 2
    assert "gone.csv" in found.stderr


def test_law_the_command_prints_per_axis_values_with_intervals(tmp_path: Path) -> None:
    found = run(written(frame(), tmp_path / "log.csv"), "--json", "--coulomb", "--offset")
    assert found.exit_code == 0
    answer = json.loads(found.stdout)
    assert [axis["axis"] for axis in answer["axes"]] == ["x", "y"]
    for axis in answer["axes"]:
        mass, damping = TRUTH[axis["axis"]]
        # 12 s of noise: 0.002 kg and 0.03 N·s/m beside friction
        assert axis["mass"] == pytest.approx(mass, abs=0.02)
        assert axis["damping"] == pytest.approx(damping, abs=0.3)
        for name in ("mass", "damping", "coulomb", "offset"):
            low, high = axis[f"{name}_interval"]
            assert low < axis[name] < high
        assert axis["condition_number"] > 1
        assert 0.9 < axis["r_squared"] <= 1
    assert answer["axes_independent"] is True
    assert answer["cutoff"] > 1


def test_law_columns_axes_and_scales_are_named_by_options(tmp_path: Path) -> None:
    table = frame().rename(columns={"time": "t_ms", "position_y": "p_mm", "force_y": "f_mN"})
    table["t_ms"] *= 1000
    table["p_mm"] *= 1000
    table["f_mN"] *= 1000
    options = ["--time", "t_ms", "--position", "p_mm", "--force", "f_mN", "--axis", "up"]
    scales = ["--time-scale", "0.001", "--position-scale", "0.001", "--force-scale", "0.001"]
    found = run(written(table, tmp_path / "log.csv"), *options, *scales, "--json")
    assert found.exit_code == 0, found.stderr
    [axis] = json.loads(found.stdout)["axes"]
    assert axis["axis"] == "up"
    assert axis["mass"] == pytest.approx(TRUTH["y"][0], abs=0.01)


def test_law_the_robot_file_is_read_by_decide_with_its_uncertainty(tmp_path: Path) -> None:
    log, robot, figure = written(frame(), tmp_path / "log.csv"), tmp_path / "robot.toml", tmp_path / "fit.svg"
    screen = run(log, "--out", robot, "--figure", figure, "--name", "mine")
    assert screen.exit_code == 0, screen.stderr
    assert "The axes are independent" in screen.stdout
    assert figure.read_text(encoding="utf-8").startswith("<?xml")
    written_robot = tomllib.loads(robot.read_text(encoding="utf-8"))
    assert written_robot["robot"]["name"] == "mine"
    assert written_robot["identification"]["log"] == "log.csv"
    study = ts.Study.paper().with_robot(2, robot)
    known = study.uncertainty[1]
    assert known is not None
    assert robot_record(robot).logs == 1
    np.testing.assert_array_equal(known.mass_sd, written_robot["robot"]["mass_sd"])
    found = CliRunner().invoke(
        cli.app,
        [
            "decide",
            "--robot1",
            str(robot),
            "--robot2",
            "hman2",
            "--stiffness",
            "71.2",
            "--delay",
            "0.1",
            "--json",
        ],
    )
    answer = json.loads(found.stdout)
    assert answer["uncertainty"]["stable_probability"]["value"] == 1.0
    low, high = answer["uncertainty"]["axes"][0]["critical_stiffness_interval"]
    assert low < answer["axes"][0]["critical_stiffness"] < high
    text = CliRunner(env={"COLUMNS": "100", "NO_COLOR": "1"}).invoke(
        cli.app,
        ["decide", "--robot1", str(robot), "--robot2", "hman2", "--stiffness", "71.2", "--delay", "0.15"],
    )
    assert "stable at this constant delay with probability above 99.995 % (20000 draws)" in " ".join(
        text.stdout.split()
    )
    # certain robots: nothing is said
    certain = CliRunner().invoke(cli.app, ["decide", "--stiffness", "71.2", "--delay", "0.1", "--json"])
    assert json.loads(certain.stdout)["uncertainty"] is None


def test_law_a_spring_in_the_robot_file_holds_the_robot_and_adds_to_a_grip() -> None:
    text = "[robot]\nmass = [0.84, 1.07]\ndamping = 7.7\n[identification]\nstiffness = [3.0, 2.5]\nlogs = 2"
    free = ts.Study.paper().with_robot(2, text)
    np.testing.assert_array_equal(free.dyad.operators[1].stiffness, [3.0, 2.5])
    np.testing.assert_array_equal(free.dyad.operators[0].stiffness, [0.0, 0.0])
    gripped = ts.Study.paper().replace(operator2={"stiffness": {"min": 0, "max": 300}})
    assert gripped.operator_ranges is not None
    held = gripped.with_robot(2, text).operator_ranges
    assert held is not None
    np.testing.assert_array_equal(held[1].low.stiffness, [3.0, 2.5])
    np.testing.assert_array_equal(held[1].high.stiffness, [303.0, 302.5])
    assert robot_record(text).logs == 2
    with pytest.raises(InvalidInput, match="one value per axis"):
        ts.Study.paper().with_robot(2, text.replace("[3.0, 2.5]", "[3.0]"))
    for spoilt in ("logs = 0", 'logs = "two"', "stiffness = [-1.0, 2.0]", "stiffness = 3.0"):
        with pytest.raises(InvalidInput, match=r"identification\."):
            robot_record(f"[robot]\nmass = 1.0\ndamping = 1.0\n[identification]\n{spoilt}")


def coupled(table: pd.DataFrame) -> pd.DataFrame:
    """Let each axis feel 0.1 kg of the other's acceleration."""
    command, time = paper_excitation(), table["time"].to_numpy()
    return table.assign(
        force_x=table["force_x"] + 0.1 * command.acceleration(time - 1.25),
        force_y=table["force_y"] + 0.1 * command.acceleration(time),
    )


def test_law_decide_passes_on_that_axes_are_not_independent(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    assert run(written(coupled(frame()), tmp_path / "log.csv"), "--out", robot).exit_code == 0
    asked = ["decide", "--robot1", str(robot), "--robot2", "hman2", "--stiffness", "20", "--delay", "0.1"]
    answer = json.loads(CliRunner().invoke(cli.app, [*asked, "--json"]).stdout)
    assert answer["axes_independent"] is False
    assert answer["uncertainty"] is None
    assert any("axes of robot 1 are NOT independent" in warning for warning in answer["warnings"])
    assert any("kg" in warning and "acceleration on y" in warning for warning in answer["warnings"])
    screen = CliRunner(env={"COLUMNS": "100", "NO_COLOR": "1"}).invoke(cli.app, asked).stdout
    text = " ".join(screen.split())
    assert "STABLE AXIS BY AXIS ONLY" in text
    assert "Warning: The axes of robot 1 are NOT independent" in text
    assert "no probability of stability is given" in text
    assert "with probability" not in text
    # the limits rest on the same robots: asked without a stiffness, without a delay, without both
    for options in (["--delay", "0.1"], ["--stiffness", "20"], []):
        asked = ["decide", "--robot1", str(robot), "--robot2", "hman2", *options]
        limits = json.loads(CliRunner().invoke(cli.app, [*asked, "--json"]).stdout)
        assert limits["question"] == "limits"
        assert limits["warnings"] == answer["warnings"]
        screen = CliRunner(env={"COLUMNS": "100", "NO_COLOR": "1"}).invoke(cli.app, asked).stdout
        shown = " ".join(screen.split())
        for warning in answer["warnings"]:
            assert f"Warning: {' '.join(warning.split())}" in shown
        firsts = "You may", "The delay may", "Any constant delay", "What each delay"
        assert shown.index("Warning: ") < min(shown.index(word) for word in firsts if word in shown)


def test_law_decide_passes_on_warnings_and_tells_of_a_robot_without_errors(tmp_path: Path) -> None:
    table = frame().rename(columns={"force_x": "volt_x"})
    robot = tmp_path / "robot.toml"
    options = [
        "--force",
        "volt_x",
        "--position",
        "position_x",
        "--force",
        "force_y",
        "--position",
        "position_y",
    ]
    assert run(written(table, tmp_path / "log.csv"), *options, "--out", robot).exit_code == 0
    asked = [
        "decide",
        "--robot1",
        "hman1",
        "--robot2",
        str(robot),
        "--stiffness",
        "20",
        "--delay",
        "0.1",
        "--json",
    ]
    answer = json.loads(CliRunner().invoke(cli.app, asked).stdout)
    assert answer["axes_independent"] is None
    [identified, exact] = answer["warnings"]
    assert "Robot 2, from its identification" in identified
    assert "volt_x" in identified
    assert "Robot 1 has no standard deviations" in exact
    both = json.loads(CliRunner().invoke(cli.app, [*asked, "--robot1", str(robot)]).stdout)
    assert both["axes_independent"] is True
    assert not any("no errors" in warning for warning in both["warnings"])
    # a robot file that somebody spoilt
    robot.write_text(
        robot.read_text(encoding="utf-8").replace("axes_independent = true", "axes_independent = 1")
    )
    refused = CliRunner().invoke(cli.app, asked)
    assert refused.exit_code == 2
    assert "axes_independent" in refused.stderr


def test_law_no_robot_file_is_written_of_what_is_no_robot(tmp_path: Path) -> None:
    table = frame()
    found = identify(table["time"], table[["position_x"]], -table[["force_x"]])
    with pytest.raises(InvalidInput, match="--force-scale"):
        write_robot(found, tmp_path / "robot.toml")
    assert list(tmp_path.iterdir()) == []


def test_law_the_papers_method_gives_a_robot_file_without_deviations() -> None:
    table = frame()
    found = identify(table["time"], table[["position_x"]], table[["force_x"]], method="paper")
    robot = tomllib.loads(robot_toml(found, "mine"))["robot"]
    assert "mass_sd" not in robot
    assert robot["mass"] == [found.axes[0].mass.value]


@pytest.mark.parametrize("columns", [60, 80, 120])
def test_law_the_screen_cuts_no_number(columns: int, root: Path) -> None:
    log = root / "examples" / "log.csv"
    shown = CliRunner(env={"COLUMNS": str(columns), "NO_COLOR": "1"}).invoke(cli.app, ["identify", str(log)])
    found = json.loads(CliRunner().invoke(cli.app, ["identify", str(log), "--json"]).stdout)
    assert "…" not in shown.stdout
    assert all(len(line) <= columns for line in shown.stdout.splitlines())
    for axis in found["axes"]:
        assert f"{axis['r_squared']:.5f}" in shown.stdout


@pytest.mark.parametrize("option", ["--out", "--figure"])
def test_law_no_log_is_overwritten(tmp_path: Path, option: str) -> None:
    # TOML or PNG in name only: a log is known by its content to nobody but its owner
    log = tmp_path / ("log.toml" if option == "--out" else "log.png")
    log.write_text("mine")
    (tmp_path / "folder").mkdir()
    link = tmp_path / f"link{log.suffix}"
    link.hardlink_to(log)
    for spelt in (log, tmp_path / "folder" / ".." / log.name, link):
        refused = run(log, option, spelt)
        assert refused.exit_code == 2
        assert "is an input" in " ".join(refused.stderr.split())
    assert log.read_text() == "mine"


@pytest.mark.parametrize("name", ["log.csv", "robot.json"])
def test_law_a_robot_file_has_a_name_in_toml(tmp_path: Path, name: str) -> None:
    log = written(frame(), tmp_path / "log.csv")
    before = log.read_bytes()
    refused = run(log, "--out", tmp_path / name)
    assert refused.exit_code == 2
    assert ".toml" in refused.stderr
    assert log.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["log.csv"]
