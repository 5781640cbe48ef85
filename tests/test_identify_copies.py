"""A log that is given twice, or repeats, is one measurement: it narrows no interval, and it is told."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner, Result

from made_logs import made_log
from telespring import cli
from telespring.identification import Identification, identify, identify_logs, read_log
from telespring.identification.copies import find_copies

NAMES = ["time", "position_x", "position_y", "force_x", "force_y"]


def table(seed: int = 1, seconds: float = 20.0) -> pd.DataFrame:
    time, position, force = made_log(np.random.default_rng(seed), rate=500.0, seconds=seconds)
    return pd.DataFrame(np.column_stack([time, position, force]), columns=NAMES).round(6)


def written(folder: Path, name: str, rows: pd.DataFrame) -> Path:
    path = folder / name
    rows.to_csv(path, index=False)
    return path


def run(*paths: Path) -> Result:
    return CliRunner().invoke(cli.app, ["identify", *map(str, paths)], env={"COLUMNS": "100"})


def intervals(found: Identification) -> list[tuple[float, float]]:
    return [axis.estimates[name].interval for axis in found.axes for name in ("mass", "damping")]


def test_law_a_log_that_is_given_twice_counts_once(tmp_path: Path) -> None:
    """By its name, as a copy of the bytes, with other time stamps, and in another format."""
    rows = table()
    path = written(tmp_path, "log.csv", rows)
    copy = Path(shutil.copy(path, tmp_path / "copy.csv"))
    later = written(tmp_path, "later.csv", rows.assign(time=rows["time"] + 100.0))
    tabs = tmp_path / "tabs.txt"
    rows.to_csv(tabs, index=False, sep="\t")
    once = identify_logs([read_log(path)])
    for other, words in (
        (path, "log.csv was given more than once. It counts once."),
        (copy, "copy.csv has the same samples as log.csv"),
        (later, "later.csv has the same samples as log.csv"),
        (tabs, "tabs.txt has the same samples as log.csv"),
    ):
        both = identify_logs([read_log(path), read_log(other)])
        assert intervals(both) == intervals(once)
        assert both.log_count == 1
        assert any(words in warning for warning in both.warnings)
    shown = run(path, copy)
    assert shown.exit_code == 0
    assert "copy.csv has the same samples as log.csv" in " ".join(shown.stdout.split())


def test_law_a_copy_among_several_logs_narrows_nothing(tmp_path: Path) -> None:
    logs = [read_log(written(tmp_path, f"{i}.csv", table(i))) for i in range(3)]
    three, four = identify_logs(logs), identify_logs([*logs, logs[1]])
    assert intervals(four) == intervals(three)
    assert four.log_count == three.log_count == 3


def test_law_a_log_that_repeats_counts_once(tmp_path: Path) -> None:
    """A part that was appended again, with stamps that go on; and a part of another log."""
    rows = table()
    again = pd.concat([rows, rows[3000:]], ignore_index=True)
    again["time"] = np.arange(len(again)) / 500.0
    time, position, force = (rows[[n for n in NAMES if kind in n]] for kind in ("time", "position", "force"))
    once = identify(time["time"], position, force)
    found = identify_logs([read_log(written(tmp_path, "again.csv", again))])
    np.testing.assert_allclose(intervals(found), intervals(once), rtol=1e-9)
    [warning] = [warning for warning in found.warnings if "count once" in warning]
    assert warning.startswith("The samples from 20 s (sample 10001, line 10002) on repeat those from 6 s ")
    assert "(sample 3001, line 3002) on, to the last digit (7000 in all)" in warning
    part = identify_logs(
        [read_log(written(tmp_path, "log.csv", rows)), read_log(written(tmp_path, "part.csv", again[8000:]))]
    )
    assert part.log_count == 1
    assert any("part.csv has the same samples as log.csv" in warning for warning in part.warnings)


def test_law_the_runs_of_a_file_that_repeat_count_once(tmp_path: Path) -> None:
    rows = table()
    found = identify_logs([read_log(written(tmp_path, "runs.csv", pd.concat([rows, rows])))])
    assert found.log_count == 1
    assert any("runs.csv, run 2 has the same samples as runs.csv, run 1" in each for each in found.warnings)


@pytest.mark.parametrize("repeats", [1, 5])
def test_law_measurements_of_one_movement_are_no_copies(repeats: int) -> None:
    """Also of a coarse sensor, at rest, and one that is read less often than it is logged."""
    logs = []
    for seed in range(3):
        rows = table(seed)[NAMES[1:]].to_numpy().copy()
        rows[:, 2:] = np.round(rows[:, 2:], 1)
        rows[1000:2000] = rows[1000]
        logs.append(np.repeat(rows[::repeats], repeats, axis=0))
    assert not any(copies.repeated.any() for copies in find_copies(logs))


def test_cross_copies_are_found_where_a_search_of_all_pairs_finds_them() -> None:
    random = np.random.default_rng(3)
    rows = random.integers(0, 50, size=(400, 2)).astype(float)
    rows[250:340] = rows[30:120]
    [found] = find_copies([rows])
    expected = np.zeros(400, dtype=bool)
    for start in range(400 - 64):
        for before in range(start):
            if np.array_equal(rows[start : start + 64], rows[before : before + 64]):
                expected[start : start + 64] = True
                break
    np.testing.assert_array_equal(found.repeated, expected)
    assert (found.first, found.sample) == (250, 30)
