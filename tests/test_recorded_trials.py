"""Recorded trials: written files are read back, and misleading ones are refused with a remedy."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import telespring as ts
from made_trials import figure_eight, offsets, small
from telespring.analysis import measure, read_recorded, write_recorded, write_template
from telespring.analysis.recordings.layout import (
    INDEX_OPTIONAL,
    INDEX_REQUIRED,
    TARGET,
    TIME,
    recorded_columns,
)

TASK = {"kind": "figure-eight", "amplitude": [0.05, 0.1], "angular_frequency": 2.59}


def change(path: Path, edit: Callable[[pd.DataFrame], pd.DataFrame]) -> None:
    edit(pd.read_csv(path, keep_default_na=False)).to_csv(path, index=False)


def test_law_a_rehearsal_comes_back_identical(tmp_path: Path) -> None:
    """Every number and label, with a trial that diverged, one that is absent, and seeds above 2**63."""
    trials = small()
    trials.attrs["study"] = 'name = "a study"\n'
    index = write_recorded(trials, tmp_path / "lab")
    again = read_recorded(tmp_path / "lab")
    assert again.identical(read_recorded(index))
    again = again.drop_vars("file")
    assert again.identical(trials), (again, trials)
    assert measure(again).identical(measure(trials))
    again.to_netcdf(tmp_path / "again.nc", engine="h5netcdf")


def test_law_a_target_of_each_trial_comes_back_identical(tmp_path: Path) -> None:
    trials = offsets(np.full((2, 2, 2), 0.01), [(np.nan, 0.0), (71.0, 0.084)])
    factor = np.array([[1.0, 1.1], [0.9, 1.0]])[:, :, None, None]
    goals = factor * np.asarray(trials["target"])
    trials["target"] = ("condition", "trial", "time", "axis"), goals, {"units": "m"}
    trials["status"] = ("condition", "trial"), np.full((2, 2), "completed")
    write_recorded(trials, tmp_path)
    assert read_recorded(tmp_path).drop_vars("file").identical(trials)


def test_law_conditions_of_one_name_stay_apart(tmp_path: Path) -> None:
    errors = np.array([[[0.01, 0.01]], [[0.02, 0.02]]])
    write_recorded(offsets(errors, [(35.6, 0.1), (36.2, 0.1)]), tmp_path)
    found = read_recorded(tmp_path)
    assert found["condition"].values.tolist() == ["CM-35.6-100", "CM-36.2-100"]
    assert np.asarray(measure(found)["tracking_error"])[:, 0, 0] == pytest.approx([0.01, 0.02])


def test_law_the_list_says_which_trial_is_which_in_any_order(tmp_path: Path) -> None:
    errors = np.linspace(0.001, 0.008, 8).reshape(2, 2, 2)
    write_recorded(offsets(errors, [(np.nan, 0.0), (36.0, 0.0)]), tmp_path)
    change(tmp_path / "trials.csv", lambda table: table.iloc[[1, 0, 3, 2]].assign(trial=[40, 7, 9, 8]))
    found = np.asarray(measure(read_recorded(tmp_path))["tracking_error"])
    assert found == pytest.approx(errors)


def test_law_shorter_trials_are_whole_trials(tmp_path: Path) -> None:
    write_recorded(offsets(np.full((1, 2, 2), 0.01), [(np.nan, 0.0)]), tmp_path)
    change(tmp_path / "UM-01-002.csv", lambda table: table.iloc[:120])
    found = read_recorded(tmp_path)
    assert found["samples"].values.tolist() == [[201, 120]]
    assert np.asarray(measure(found)["tracking_error"]) == pytest.approx(0.01, rel=1e-12)


def test_ref_a_missing_target_is_computed_from_the_task(tmp_path: Path) -> None:
    write_recorded(offsets(np.full((1, 2, 2), 0.01), [(np.nan, 0.0)]), tmp_path)
    for file in tmp_path.glob("UM*.csv"):
        change(file, lambda table: table.drop(columns=["target_x_m", "target_y_m"]))
    with pytest.raises(ts.InvalidInput, match="--study"):
        read_recorded(tmp_path)
    found = read_recorded(tmp_path, TASK)
    # Eq. 12, written out in the helper
    assert np.asarray(found["target"]) == pytest.approx(figure_eight(np.asarray(found["time"])), abs=1e-15)
    assert np.asarray(measure(found)["tracking_error"]) == pytest.approx(0.01, rel=1e-12)
    with pytest.raises(ts.InvalidInput, match="Record the target itself"):
        read_recorded(tmp_path, {"kind": "python", "function": "mine:circle"})


def test_law_a_clock_that_jitters_is_put_on_a_grid_and_said_so(tmp_path: Path) -> None:
    write_recorded(offsets(np.full((1, 3, 2), 0.01), [(np.nan, 0.0)]), tmp_path)
    rng = np.random.default_rng(8)
    for file in sorted(tmp_path.glob("UM*.csv"))[1:]:
        time = np.arange(201) / 100.0 + rng.uniform(0.0, 0.003, 201)
        turning = 0.01 * np.stack([np.cos(7.0 * time), np.sin(7.0 * time)], axis=-1)
        target = figure_eight(time)
        values = np.column_stack([time, target, target + turning, target + turning])
        pd.DataFrame(values, columns=pd.read_csv(file).columns).to_csv(file, index=False)
    found = read_recorded(tmp_path)
    assert found.attrs["resampled_to"] == pytest.approx(0.01, rel=0.02)
    # straight lines over 10 ms cut a circle of 7 rad/s short by 1 - cos(0.035) = 0.06 %
    assert np.asarray(measure(found)["tracking_error"]) == pytest.approx(0.01, rel=1e-3)


def test_law_the_example_for_a_lab_says_what_it_is(tmp_path: Path) -> None:
    found = read_recorded(write_template(tmp_path))
    measured = measure(found)
    # not whole periods, so that the best shift's neighbours are not alike
    assert np.asarray(measured["lag"])[:, 0] == pytest.approx(
        np.array([[0.06, 0.12], [0.07, 0.11]]), abs=3e-5
    )
    assert found.attrs["discard"] == 1.0
    with pytest.raises(ts.InvalidInput, match=r"a folder without trials\.csv"):
        write_template(tmp_path)


def lab(folder: Path) -> Path:
    write_recorded(small(), folder)
    return folder


FIRST = "UM-01-001.csv"


def in_index(edit: Callable[[pd.DataFrame], pd.DataFrame]) -> Callable[[Path], None]:
    return lambda folder: change(folder / "trials.csv", edit)


def in_first(edit: Callable[[pd.DataFrame], pd.DataFrame]) -> Callable[[Path], None]:
    return lambda folder: change(folder / FIRST, edit)


def first_is(content: str | bytes) -> Callable[[Path], None]:
    def spoil(folder: Path) -> None:
        (folder / FIRST).write_bytes(content.encode() if isinstance(content, str) else content)

    return spoil


def replaced(column: str, line: int, value: object) -> Callable[[pd.DataFrame], pd.DataFrame]:
    def edit(table: pd.DataFrame) -> pd.DataFrame:
        values = table[column].tolist()
        values[line] = value
        return table.assign(**{column: values})

    return edit


def first_is_renamed(folder: Path) -> None:
    (folder / FIRST).rename(folder / f"x{FIRST}")


MM = {"position_robot1_x_m": "position_robot1_x_mm"}
REFUSED: dict[str, tuple[Callable[[Path], None], list[str]]] = {
    "no column": (
        in_first(lambda table: table.drop(columns="position_robot2_y_m")),
        [f"{FIRST}: position_robot2_y_m", "missing", "the column position_robot2_y_m is required"],
    ),
    "named in mm": (
        in_first(lambda table: table.rename(columns=MM)),
        ["missing; position_robot1_x_mm is there instead"],
    ),
    "given in mm": (
        in_first(
            lambda table: table.assign(**{name: 1e3 * table[name] for name in recorded_columns("position")})
        ),
        [f"{FIRST}: position", "no robot reaches 5 m", "Divide by 1000 if they are in mm"],
    ),
    "force without unit": (
        in_first(lambda table: table.rename(columns={"agent_force_robot1_x_N": "agent_force_robot1_x"})),
        ["agent_force_robot1_x_N", "agent_force_robot1_x is there instead"],
    ),
    "quantity in some": (
        in_first(lambda table: table.drop(columns=list(recorded_columns("velocity")))),
        [f"{FIRST}: velocity = missing", "all trials must have the same columns"],
    ),
    "trial twice": (
        in_index(lambda table: table.assign(trial=[1, 1, 2, 1, 2, 1, 2, 3])),
        ["trials.csv, line 3: trial = 1", "line 2 lists this one"],
    ),
    "file twice": (in_index(replaced("file", 1, FIRST)), ["line 3: file", "line 2 lists this one"]),
    "time back": (
        in_first(replaced("time_s", 10, 0.05)),
        [f"{FIRST}, line 12: time_s = 0.05 after 0.09", "time must increase"],
    ),
    "time twice": (in_first(replaced("time_s", 10, 0.09)), ["0.09 after 0.09"]),
    "time in ms": (
        in_first(lambda table: table.assign(time_s=1e3 * table["time_s"])),
        ["a sample every 10 s", "Divide by 1000 if the times are in ms"],
    ),
    "time of the day": (
        in_first(lambda table: table.assign(time_s=table["time_s"] + 1.7e9)),
        ["begins at 1700000000 s", "count from the start of the trial"],
    ),
    "gap": (
        in_first(lambda table: table.drop(index=range(20, 40))),
        [f"{FIRST}, line 22", "210 ms without a sample"],
    ),
    "empty field": (in_first(replaced("target_x_m", 3, "")), [f"{FIRST}, line 5: target_x_m = empty"]),
    "word": (
        in_first(replaced("target_x_m", 3, "lost")),
        ["line 5: target_x_m = lost", "a number is required"],
    ),
    "infinite": (in_first(replaced("target_x_m", 3, "inf")), ["line 5: target_x_m = inf"]),
    "no samples": (in_first(lambda table: table.iloc[:1]), ["1 sample:", "at least two"]),
    "ragged": (
        first_is("time_s,target_x_m\n1,2\n1,2,3\n"),
        [f"{FIRST}, line 3 = 3 fields", "2 fields, as many as names in line 1"],
    ),
    "one field more": (
        first_is("time_s,target_x_m\n1,2,3\n2,3,4\n"),
        [f"{FIRST}, line 2 = 3 fields", "Give every column a name"],
    ),
    "cut off": (
        first_is("time_s,target_x_m\n0,2\n0.1,2\n0.2"),
        [f"{FIRST}, line 4 = 1 fields", "cut off"],
    ),
    "no names": (first_is("0,2\n0.1,2\n0.2,3\n"), [f"{FIRST} = no column names"]),
    "name twice": (first_is("time_s,time_s\n0,2\n0.1,2\n"), [f"{FIRST}: time_s = twice"]),
    "empty": (
        first_is(""),
        [f"{FIRST} = empty"],
    ),
    "not text": (first_is(b"\xff\xfe\x00"), ["a text file is required"]),
    "delay in ms": (in_index(replaced("delay_s", 4, 167)), ["line 6: delay_s = 167", "167 ms is 0.167"]),
    "no stiffness": (
        in_index(replaced("stiffness_N_per_m", 4, 0)),
        ["Leave it empty in the unconnected mode"],
    ),
    "stiffness unnamed": (
        in_index(lambda table: table.rename(columns={"stiffness_N_per_m": "stiffness"})),
        ["trials.csv: stiffness_N_per_m = missing; stiffness is there instead"],
    ),
    "misspelt": (in_index(lambda table: table.rename(columns={"status": "staus"})), ["trials.csv: staus"]),
    "half a trial": (in_index(replaced("trial", 0, "1.5")), ["line 2: trial = 1.5", "a whole number"]),
    "two discards": (in_index(replaced("discard_s", 0, "1.0")), ["discard_s", "one value for all trials"]),
    "status nearly": (
        in_index(replaced("status", 0, "compleet")),
        ["line 2: status = compleet", "one of completed, stopped", "Write completed."],
    ),
    "status unknown": (
        in_index(replaced("status", 0, "ok")),
        ["line 2: status = ok", "one of completed, stopped"],
    ),
    "seed empty": (
        in_index(replaced("seed", 0, "")),
        ["trials.csv, line 2: seed = empty", "Remove the column seed from trials.csv"],
    ),
    "a header only": (
        in_first(lambda table: table.iloc[:0]),
        [f"{FIRST} = only a header", "a line per sample"],
    ),
    "no trials": (in_index(lambda table: table.iloc[:0]), ["a line per trial is required"]),
    "no file": (
        first_is_renamed,
        ["trials.csv, line 2: file = ", f"Did you mean x{FIRST}? Otherwise copy it there"],
    ),
    "no two files": (
        in_index(lambda table: table.assign(file=[*table["file"][:-2], "a.csv", "b.csv"])),
        ["file = a.csv", "not in the folder", "and 1 more of the list are missing"],
    ),
    "file unnamed": (in_index(replaced("file", 0, "")), ["trials.csv, line 2: file = empty"]),
    "file is a folder": (in_index(replaced("file", 0, ".")), ["trials.csv, line 2: file = .", "no file"]),
    "empty cell": (
        in_first(lambda table: table.assign(target_x_m=[*table["target_x_m"][:-1], ""])),
        [f"{FIRST}, line ", "target_x_m = empty", "Remove such lines (1 of "],
    ),
    "empty column": (
        in_first(lambda table: table.assign(target_x_m="")),
        [f"{FIRST}, line 2: target_x_m = empty", "The whole column is so"],
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_law_what_would_mislead_is_refused_where_it_stands(what: str, tmp_path: Path) -> None:
    spoil, words = REFUSED[what]
    folder = lab(tmp_path)
    spoil(folder)
    with pytest.raises(ts.InvalidInput) as refused:
        read_recorded(folder)
    for word in words:
        assert word in str(refused.value)


def test_law_a_status_is_one_whatever_its_case(tmp_path: Path) -> None:
    folder = lab(tmp_path)
    expected = read_recorded(folder)
    change(folder / "trials.csv", lambda table: table.assign(status=table["status"].str.title()))
    assert read_recorded(folder).identical(expected)


def test_law_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    folder = lab(tmp_path)
    (folder / FIRST).unlink()
    with pytest.raises(ts.InvalidInput, match=rf"trials\.csv, line 2: file = {re.escape(FIRST)}"):
        read_recorded(folder)


def test_law_what_is_written_is_a_csv_that_others_read(tmp_path: Path) -> None:
    """Round numbers stay as they are, unconnected trials have no stiffness, nothing follows an early end."""
    folder = lab(tmp_path)
    index = pd.read_csv(folder / "trials.csv")
    assert index["stiffness_N_per_m"].isna().tolist() == [True] * 3 + [False] * 5
    assert index["status"].tolist() == ["completed"] * 6 + ["diverged", "completed"]
    assert len(pd.read_csv(folder / index["file"][6])) == 124
    assert (
        (folder / FIRST)
        .read_text(encoding="utf-8")
        .splitlines()[0]
        .startswith("time_s,target_x_m,target_y_m,")
    )
    assert isinstance(read_recorded(folder), xr.Dataset)


def test_law_the_document_names_every_column(root: Path) -> None:
    text = (root / "docs" / "recorded-trials.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([A-Za-z0-9_]+)`", text))
    assert {*INDEX_REQUIRED, *INDEX_OPTIONAL, TIME, *TARGET, *recorded_columns("position")} <= named
    for quantity in ("coupling_force", "agent_force", "velocity"):
        assert f"`{recorded_columns(quantity)[0]}`" in text
