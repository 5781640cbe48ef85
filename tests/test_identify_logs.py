"""Logs that can be used, logs that cannot, and in which files."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from telespring import InvalidInput
from telespring.identification import identify, paper_excitation, read_log, robot_toml
from two_axis_log import TRUTH, frame, run, written


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


def test_law_an_axis_that_hardly_moves_is_said_to() -> None:
    table, random = frame(), np.random.default_rng(5)
    for movement in (0.0, 1e-3):
        still = movement * table["position_y"] + random.normal(0.0, 5e-6, len(table))
        refused = refusal(table.assign(position_y=still, force_y=random.normal(0.0, 0.1, len(table))))
        assert refused.field == "position (y)"
        assert "moves too little" in str(refused)


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


# ---- files


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
