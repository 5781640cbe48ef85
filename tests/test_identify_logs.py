"""Logs that can be used, logs that cannot, and what the command says and leaves behind."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner, Result

import telespring as ts
from telespring import InvalidInput, cli
from telespring.identification import identify, paper_excitation, read_log, robot_toml, write_robot
from telespring.study.robot_file import robot_record

TRUTH = {"x": (0.8334, 7.7257), "y": (1.0649, 10.1168)}


def frame(seconds: float = 12.0, seed: int = 1) -> pd.DataFrame:
    """Make a clean log of two axes, y a quarter of a period after x."""
    time = np.arange(round(1000 * seconds)) / 1000.0
    random = np.random.default_rng(seed)
    command = paper_excitation()
    columns = {"time": time}
    for lag, (axis, (mass, damping)) in zip((0.0, 1.25), TRUTH.items(), strict=True):
        t = time - lag
        force = mass * command.acceleration(t) + damping * command.velocity(t)
        columns[f"position_{axis}"] = np.round(command.position(t) / 2e-5) * 2e-5
        columns[f"force_{axis}"] = force + random.normal(0.0, 0.1, time.size)
    return pd.DataFrame(columns)


def run(*arguments: str | Path) -> Result:
    return CliRunner(env={"COLUMNS": "160", "NO_COLOR": "1"}).invoke(
        cli.app, ["identify", *map(str, arguments)]
    )


def refusal(table: pd.DataFrame) -> InvalidInput:
    position, force = table[["position_x", "position_y"]], table[["force_x", "force_y"]]
    with pytest.raises(InvalidInput) as refused:
        identify(table["time"].to_numpy(), position.to_numpy(), force.to_numpy())
    return refused.value


def warned(table: pd.DataFrame) -> str:
    position, force = table[["position_x", "position_y"]], table[["force_x", "force_y"]]
    return " ".join(identify(table["time"].to_numpy(), position.to_numpy(), force.to_numpy()).warnings)


# ---- what is wrong with a log


def without_rows(table: pd.DataFrame) -> pd.DataFrame:
    return table.drop(index=range(4000, 4100))


def doubled(table: pd.DataFrame) -> pd.DataFrame:
    return pd.concat([table[:5000], table[4999:]])


def turned(table: pd.DataFrame) -> pd.DataFrame:
    return pd.concat([table[6000:], table[:6000]])


def missing(table: pd.DataFrame) -> pd.DataFrame:
    table.loc[700:720, "force_y"] = np.nan
    return table


def in_milliseconds(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(time=1000 * table["time"])


def in_minutes(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(time=table["time"] / 6e4)


def in_millimetres(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(position_x=1000 * table["position_x"])


def in_millinewtons(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(force_x=1e4 * table["force_x"])


def frozen(table: pd.DataFrame) -> pd.DataFrame:
    column = table["position_x"].to_numpy().copy()
    column[5000:5301] = column[5000]
    return table.assign(position_x=column)


def frozen_to_the_end(table: pd.DataFrame) -> pd.DataFrame:
    column = table["position_x"].to_numpy().copy()
    column[5000:] = column[5000]
    return table.assign(position_x=column)


def frozen_with_noise(table: pd.DataFrame) -> pd.DataFrame:
    """Stuck for good, 1 µm of noise on what no longer moves."""
    column = table["position_x"].to_numpy().copy()
    column[3000:] = column[3000] + np.random.default_rng(2).normal(0.0, 1e-6, len(column) - 3000)
    return table.assign(position_x=column)


def frozen_at_a_slow_moment(table: pd.DataFrame) -> pd.DataFrame:
    """Stuck for good where the robot turns round, so that nothing tells of it but how long it lasts."""
    column = table["position_x"].to_numpy().copy()
    turn = 3000 + int(np.argmax(column[3000:6000]))
    column[turn:] = column[turn]
    return table.assign(position_x=column)


def frozen_for_a_while_with_noise(table: pd.DataFrame) -> pd.DataFrame:
    column = table["position_y"].to_numpy().copy()
    column[5000:6200] = column[5000] + np.random.default_rng(2).normal(0.0, 5e-6, 1200)
    return table.assign(position_y=column)


def in_centimetres(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(position_x=100 * table["position_x"])


def unplugged(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(force_x=0.0)


def coarse(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(position_x=table["position_x"].round(2))


def short(table: pd.DataFrame) -> pd.DataFrame:
    return table[:900]


@pytest.mark.parametrize(
    ("spoil", "field", "remedy"),
    [
        (doubled, "time", "Remove duplicate samples"),
        (turned, "time", "one log at a time"),
        (in_milliseconds, "time", "--time-scale 0.001"),
        (in_minutes, "time", "--time-scale 60"),
        (in_millimetres, "position (x)", "--position-scale 0.001"),
        (in_millinewtons, "force (x)", "--force-scale"),
        (frozen, "position (x)", "stuck"),
        (frozen_to_the_end, "position (x)", "stuck"),
        (frozen_with_noise, "position (x)", "stuck"),
        (frozen_at_a_slow_moment, "position (x)", "stuck"),
        (frozen_for_a_while_with_noise, "position (y)", "stuck"),
        (in_centimetres, "position (x)", "in cm, 0.01"),
        (in_centimetres, "position (x)", "degrees or rad"),
        (unplugged, "force (x)", "connected"),
        (coarse, "position (x)", "Move the robot further"),
        (short, "time", "Record longer"),
    ],
)
def test_law_a_log_that_cannot_be_used_is_refused_with_the_remedy(
    spoil: Callable[[pd.DataFrame], pd.DataFrame], field: str, remedy: str
) -> None:
    refused = refusal(spoil(frame()))
    assert refused.field == field
    assert remedy in refused.remedy


def test_law_a_doubtful_log_is_used_with_a_warning() -> None:
    table = frame()
    assert warned(table) == ""
    turned_sign = table.assign(force_x=-table["force_x"])
    assert "--force-scale -1" in warned(turned_sign)
    saturated = table.assign(force_x=table["force_x"].clip(upper=1.0))
    assert "explains only" in warned(
        table.assign(force_x=table["force_x"].sample(frac=1.0, random_state=1).to_numpy())
    )
    saturated.loc[3000:3300, "force_x"] = 1.0
    assert "saturated" in warned(saturated)
    same = table.assign(position_y=table["position_x"])
    assert "named twice" in warned(same)


@pytest.mark.parametrize(("spoil", "words"), [(without_rows, "Long gaps: 1"), (missing, "Long gaps: 1")])
def test_law_a_log_with_gaps_is_estimated_from_its_stretches(
    spoil: Callable[[pd.DataFrame], pd.DataFrame], words: str
) -> None:
    table = spoil(frame(20.0))
    position, force = table[["position_x", "position_y"]], table[["force_x", "force_y"]]
    found = identify(table["time"].to_numpy(), position.to_numpy(), force.to_numpy())
    assert words in " ".join(found.warnings)
    assert set(found.signals.stretch) == {0, 1} if spoil is without_rows else {0}
    for axis in found.axes:
        mass, damping = TRUTH[axis.axis]
        assert abs(axis.mass.value - mass) < 4 * axis.mass.standard_error
        assert abs(axis.damping.value - damping) < 4 * axis.damping.standard_error


def test_law_units_that_no_such_robot_has_are_told() -> None:
    table = frame()
    minutes = warned(table.assign(time=table["time"] / 60))
    assert "--time-scale 60" in minutes
    assert "lighter than any robot" in minutes
    assert "--position-scale 0.001" in warned(table.assign(position_x=50 * table["position_x"]))
    assert "--force-scale" in warned(table.assign(force_x=table["force_x"] / 35))
    # half of the movement and of the force, in mN
    half = {f"position_{axis}": 0.5 * table[f"position_{axis}"] for axis in TRUTH}
    milli = warned(table.assign(**half, **{f"force_{axis}": 500 * table[f"force_{axis}"] for axis in TRUTH}))
    assert "heavier than any robot" in milli
    assert "--force-scale 0.001 for mN" in milli


def test_law_a_position_that_was_read_less_often_than_logged_is_told() -> None:
    table = frame()
    held = np.repeat(table["position_x"].to_numpy()[::5], 5)
    assert "repeats every value 5 times" in warned(table.assign(position_x=held))


def test_law_a_robot_that_rests_without_a_force_is_not_stuck() -> None:
    table, random = frame(), np.random.default_rng(3)
    still = pd.DataFrame({name: np.full(2000, table[name][0]) for name in table})
    for axis in TRUTH:
        still[f"force_{axis}"] = random.normal(0.0, 0.1, 2000)
    both = pd.concat([still, table], ignore_index=True)
    both["time"] = np.arange(len(both)) / 1000.0
    assert "mass" not in warned(both)


def test_law_jittering_stamps_are_interpolated_and_told() -> None:
    table = frame()
    random = np.random.default_rng(8)
    command = paper_excitation()
    time = table["time"].to_numpy() + random.uniform(-3e-4, 3e-4, len(table))
    position = command.position(time)
    force = 0.8 * command.acceleration(time) + 7.0 * command.velocity(time)
    found = identify(time, position, force + random.normal(0.0, 0.1, time.size))
    assert any("uneven" in warning for warning in found.warnings)
    [axis] = found.axes
    assert abs(axis.mass.value - 0.8) < 5 * axis.mass.standard_error


# ---- files


def written(table: pd.DataFrame, path: Path) -> Path:
    if path.suffix == ".csv":
        table.to_csv(path, index=False)
    elif path.suffix == ".parquet":
        table.to_parquet(path)
    else:
        from scipy import io

        io.savemat(path, {str(name): table[name].to_numpy()[:, None] for name in table})
    return path


@pytest.mark.parametrize("kind", [".csv", ".parquet", ".mat"])
def test_law_every_kind_of_file_gives_the_same_robot(tmp_path: Path, kind: str) -> None:
    if kind == ".parquet":
        pytest.importorskip("pyarrow")
    table = frame()
    log = read_log(written(table, tmp_path / f"log{kind}"))
    np.testing.assert_array_equal(log.time, table["time"])
    np.testing.assert_array_equal(log.force[:, 1], table["force_y"])
    assert log.axes == ("x", "y")


def test_law_parquet_without_pyarrow_says_what_to_install(tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    path.write_bytes(b"PAR1")
    code = (
        "import sys; sys.modules['pyarrow'] = None\n"
        "from telespring.identification import read_log\n"
        f"read_log({str(path)!r})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "pip install 'telespring[parquet]'" in done.stderr


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("log.xlsx", b"x", "must end in .csv, .txt, .tsv, .dat, .parquet or .mat"),
        ("log.csv", b"", "log.csv = empty"),
        ("log.csv", b"PK\x03\x04\x14\x00\x06\x00", "a text file is required"),
        ("log.csv", b"Dear all,\nhere is, as promised, a log.\n", "a table is required"),
        ("log.csv", b"Zeit,Weg,St\xe4rke\n0,1,2\n", "the columns of log.csv are: Zeit, Weg, Stärke"),
        ("log.csv", b"time,position_x\n0,1\n", "the columns of log.csv are: "),
        ("log.csv", b"time,position_x,position_y,force_x,force_y\n", "contains no samples"),
        ("log.mat", b"not matlab", "cannot be read as one"),
        (
            "log.csv",
            b"time,position_x,position_y,force_x,force_y\na,1,1,1,1\nb,1,2,1,1\n",
            "numbers, dates as in ISO 8601",
        ),
        (
            "log.csv",
            b"time,position_x,position_y,force_x,force_y\n1,1,1,a,1\n2,1,2,b,1\n",
            "this one contains none",
        ),
    ],
)
def test_law_a_file_that_is_no_log_is_refused(tmp_path: Path, name: str, content: bytes, words: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    found = run(path)
    assert found.exit_code == 2
    assert words in " ".join(found.stderr.split())


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


def test_law_an_axis_that_hardly_moves_is_said_to() -> None:
    table, random = frame(), np.random.default_rng(5)
    for movement in (0.0, 1e-3):
        still = movement * table["position_y"] + random.normal(0.0, 5e-6, len(table))
        refused = refusal(table.assign(position_y=still, force_y=random.normal(0.0, 0.1, len(table))))
        assert refused.field == "position (y)"
        assert "moves too little" in str(refused)


@pytest.mark.parametrize("option", ["--start", "--end"])
def test_law_a_start_or_end_that_is_no_number_is_refused(tmp_path: Path, option: str) -> None:
    found = run(written(frame(), tmp_path / "log.csv"), option, "nan")
    assert found.exit_code == 2
    assert f"{option[2:]} = nan" in found.stderr


def test_law_a_struct_of_matlab_is_read_by_its_fields(tmp_path: Path) -> None:
    from scipy import io

    table = frame()
    path = tmp_path / "log.mat"
    io.savemat(path, {"log": {str(name): table[name].to_numpy() for name in table} | {"rate": 1000.0}})
    missed = run(path)
    assert missed.exit_code == 2
    assert "log.time, log.position_x" in " ".join(missed.stderr.split())
    log = read_log(
        path,
        time="log.time",
        position=["log.position_x", "log.position_y"],
        force=["log.force_x", "log.force_y"],
    )
    np.testing.assert_array_equal(log.position[:, 1], table["position_y"])
    # a struct in a struct, or an array of them, is named
    io.savemat(path, {"deep": {"er": {"time": table["time"].to_numpy()}}})
    assert "deep" in " ".join(run(path).stderr.split())


def test_law_a_missing_file_is_told_by_its_name(tmp_path: Path) -> None:
    found = run(tmp_path / "gone.csv")
    assert found.exit_code == 2
    assert "gone.csv" in found.stderr


# ---- the command


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


def test_law_a_value_whose_sign_the_log_leaves_open_asks_for_more_movement() -> None:
    table, random = frame(), np.random.default_rng(6)
    # 4 mm of travel under 10 N of noise
    position = 0.02 * table["position_x"] + random.normal(0.0, 5e-6, len(table))
    found = identify(table["time"], position, random.normal(0.0, 10.0, len(table)))
    assert any("cannot show whether the force is late" in warning for warning in found.warnings)
    assert min(found.axes[0].mass.value, found.axes[0].damping.value) < 0.0
    with pytest.raises(InvalidInput) as refused:
        robot_toml(found, "open")
    assert "does not determine its sign" in str(refused.value)
    assert "Move this axis further" in refused.value.remedy


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


@pytest.mark.parametrize("rest", [0.0, -1.7])
@pytest.mark.parametrize("dead", [slice(6000, None), slice(3000, 5000), slice(0, 3000)])
def test_law_a_dead_force_sensor_is_named_with_the_part_to_leave_out(dead: slice, rest: float) -> None:
    table = frame()
    column = table["force_x"].to_numpy().copy()
    column[dead] = rest
    refused = refusal(table.assign(force_x=column))
    assert refused.field == "column force_x" or "force" in refused.field
    assert "although the robot moves as before" in str(refused)
    assert ("--end" in refused.remedy) == (dead.start > 0)
    assert ("--start" in refused.remedy) == (dead.stop is not None)


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
