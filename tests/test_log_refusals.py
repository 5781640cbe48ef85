"""What a refusal of a log names: file, column, the log's own time, and the sample in the file."""

from __future__ import annotations

import re
import shlex
import string
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from made_logs import made_log
from telespring import InvalidInput, cli
from telespring.identification import Log, identify_logs, read_log

# every sentence of a warning, to fill them
from telespring.identification.warning_messages import _MESSAGES, diagnostic

COLUMNS: dict[str, Any] = {"time": "t", "position": ["q_x", "q_y"], "force": ["F_x", "F_y"]}
OPTIONS = shlex.split("--time t --position q_x --position q_y --force F_x --force F_y")


def walk(seconds: float = 20.0) -> pd.DataFrame:
    time, position, force = made_log(np.random.default_rng(4), rate=500.0, seconds=seconds)
    columns = np.column_stack([time, position, force])
    return pd.DataFrame(columns, columns=["t", "q_x", "q_y", "F_x", "F_y"]).round(6)


def written(folder: Path, table: pd.DataFrame) -> Path:
    path = folder / "walk.csv"
    table.to_csv(path, index=False)
    return path


def logged(folder: Path, table: pd.DataFrame) -> Log:
    return read_log(written(folder, table), **COLUMNS)


def dead(column: str = "q_x") -> pd.DataFrame:
    """A lost stretch, and then a sensor that stays where it is for 0.8 s."""
    table = walk()
    values = table[column].to_numpy().copy()
    values[4200:4600] = values[4200]
    return table.assign(**{column: values}).drop(index=range(2000, 2200))


@pytest.mark.parametrize("stamps", ["s", "ms", "date"])
def test_law_a_dead_sensor_is_named_by_file_column_stamp_sample_and_line(tmp_path: Path, stamps: str) -> None:
    """Of the samples of the file: the lost ones have no line."""
    table, scale, shown = dead(), 1.0, "8.4 s"
    if stamps == "ms":
        table, scale, shown = table.assign(t=(1000 * table["t"]).round().astype(int)), 1e-3, "8400"
    elif stamps == "date":
        moments = pd.Timestamp("2026-11-28 09:00") + pd.to_timedelta(table["t"], unit="s")
        table, shown = (
            table.assign(t=moments.dt.strftime("%Y-%m-%dT%H:%M:%S.%f")),
            "2026-11-28T09:00:08.400000",
        )
    path = written(tmp_path, table)
    with pytest.raises(InvalidInput) as refused:
        identify_logs([read_log(path, time_scale=scale, **COLUMNS)])
    assert refused.value.field == "walk.csv, column q_x"
    assert f"from {shown} (sample 4001, line 4002) on" in refused.value.value
    text = path.read_text().splitlines()
    # that line and the next 399 have one position, and the line before and the one after others
    column = table.columns.get_loc("q_x")
    values = [line.split(",")[column] for line in text[4000:4402]]
    assert len(set(values[1:401])) == 1
    assert values[0] != values[1]
    assert values[401] != values[400]


def test_law_what_the_refusal_of_a_dead_sensor_advises_helps(tmp_path: Path) -> None:
    path = written(tmp_path, dead("q_y"))
    refused = CliRunner().invoke(cli.app, ["identify", str(path), *OPTIONS])
    assert refused.exit_code == 2
    assert "walk.csv, column q_y" in refused.stderr
    assert "--end 8.4 or --start 9.2" in " ".join(refused.stderr.split())
    for option in (["--end", "8.4"], ["--start", "9.2"]):
        found = CliRunner().invoke(cli.app, ["identify", str(path), *OPTIONS, *option])
        assert found.exit_code == 0, found.stderr


def doubled(table: pd.DataFrame) -> pd.DataFrame:
    again = table[5000:5001].assign(q_x=0.0)
    return pd.concat([table[:5001], again, table[5001:]])


def unplugged(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(F_y=0.0)


def in_milliseconds(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(t=1000.0 * table["t"])


def in_centimetres(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(q_y=100.0 * table["q_y"])


def in_counts(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(F_x=1e4 * table["F_x"])


def at_rest(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(q_x=1e-3 * table["q_x"])


def at_one_frequency(table: pd.DataFrame) -> pd.DataFrame:
    angle = 2.0 * np.pi * table["t"]
    return table.assign(q_x=0.1 * np.sin(angle), F_x=np.cos(angle) - np.sin(angle))


def without_force(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(F_x="-")


def with_words(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(t="soon")


def short(table: pd.DataFrame) -> pd.DataFrame:
    return table[:400]


def in_crumbs(table: pd.DataFrame) -> pd.DataFrame:
    return table[np.arange(len(table)) % 17 < 9]


@pytest.mark.parametrize(
    ("spoil", "column", "words"),
    [
        (doubled, "t", "(sample 5002, line 5003)"),
        (unplugged, "F_y", "throughout"),
        (in_milliseconds, "t", "--time-scale 0.001"),
        (in_centimetres, "q_y", "in cm, 0.01"),
        (in_counts, "F_x", "--force-scale"),
        (at_rest, "q_x", "50"),
        (at_one_frequency, "q_x", "1 Hz"),
        (without_force, "F_x", "contains none"),
        (with_words, "t", "soon"),
        (short, "t", "Record longer"),
        (in_crumbs, "t", "gaps"),
    ],
)
def test_law_every_refusal_of_a_log_names_its_file_and_its_column(
    tmp_path: Path, spoil: Callable[[pd.DataFrame], pd.DataFrame], column: str, words: str
) -> None:
    path = written(tmp_path, spoil(walk()))
    with pytest.raises(InvalidInput) as refused:
        identify_logs([read_log(path, **COLUMNS)])
    assert refused.value.field.startswith("walk.csv, ")
    assert column in f"{refused.value.field} {refused.value.value}".replace(",", " ").split()
    assert words in str(refused.value)


@pytest.mark.parametrize(
    "options",
    [
        {"start": 1e6},
        {"run": "7"},
        {"run_column": "trial"},
        {"position": ["q_x", "q_z"]},
        {"time": "clock"},
        {"force": ["F_x", "99"]},
    ],
)
def test_law_every_refusal_of_an_option_names_the_file_it_was_tried_on(
    tmp_path: Path, options: dict[str, object]
) -> None:
    path = written(tmp_path, walk(2.0))
    with pytest.raises(InvalidInput, match=r"walk\.csv"):
        read_log(path, **(COLUMNS | options))


def test_law_a_refusal_of_arrays_names_no_file() -> None:
    table = in_centimetres(walk())
    with pytest.raises(InvalidInput) as refused:
        identify_logs([(table["t"], table[["q_x", "q_y"]], table[["F_x", "F_y"]])])
    assert refused.value.field == "position (y)"


def test_law_warnings_name_the_users_column_and_of_several_logs_the_one_that_has_the_fault(
    tmp_path: Path,
) -> None:
    paths = []
    for i in range(3):
        time, position, force = made_log(np.random.default_rng(i), rate=500.0)
        if i == 1:
            force[3000:3150, 1] = force[3000, 1]
            position[7000:, 0] += 0.05
        path = tmp_path / f"log-{i}.csv"
        table = np.column_stack([time, position, force])
        pd.DataFrame(table, columns=["t", "q_x", "q_y", "F_x", "F_y"]).to_csv(path, index=False)
        paths.append(path)
    logs: list[Log] = [read_log(path, **COLUMNS) for path in paths]
    messages = identify_logs(logs).warnings
    [stuck] = [message for message in messages if "stays at" in message]
    assert stuck.startswith("log-1.csv: The column F_y stays at")
    assert "from 6 s (sample 3001, line 3002) on" in stuck
    [jump] = [message for message in messages if "jumps by" in message]
    assert jump.startswith("log-1.csv: The column q_x jumps by 50")
    assert "after 13.998 s (sample 7000, line 7001)" in jump


@pytest.mark.parametrize(
    ("repeated", "words"), [([700], "1 wrong time stamp; the"), ([700, 900], "2 wrong time stamps; the")]
)
def test_law_one_of_something_is_in_the_singular(tmp_path: Path, repeated: list[int], words: str) -> None:
    table = walk()
    time = table["t"].to_numpy().copy()
    time[repeated] = time[np.array(repeated) - 1]
    with pytest.raises(InvalidInput) as refused:
        identify_logs([logged(tmp_path, table.assign(t=time))])
    assert refused.value.value.startswith(words)


def test_law_a_force_of_minus_zero_is_zero(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput) as refused:
        identify_logs([logged(tmp_path, walk().assign(F_x=-0.0))])
    assert refused.value.value == "0 N throughout"


@pytest.mark.parametrize(
    ("lost", "words"), [(650, "longest 1.3 s after"), (3000, "longest 6 s after"), (200, "longest 402 ms")]
)
def test_law_a_gap_of_a_second_or_more_is_in_seconds(tmp_path: Path, lost: int, words: str) -> None:
    table = walk(40.0).drop(index=range(9000, 9000 + lost))
    [told] = [
        each for each in identify_logs([logged(tmp_path, table)]).warnings if each.startswith("Long gaps: 1")
    ]
    assert words in told
    assert "(stretches: 2)" in told


@pytest.mark.parametrize("code", sorted(_MESSAGES))
@pytest.mark.parametrize("size", [2345.0, 1300.0, 6.0, 0.002, -0.0])
def test_law_no_warning_has_an_exponent_or_minus_zero(code: str, size: float) -> None:
    values: dict[str, Any] = {}
    for _, name, spec, _ in string.Formatter().parse(_MESSAGES[code]):
        if name is not None:
            values[name] = size if spec else name
    message = diagnostic(code, **values).message
    assert not re.search(r"\de[+-]\d|(?<!\d)-0(?![.\d])", message), message
    assert not re.search(r"\d{4} ms", message), message
