"""The same log in the layouts that instruments and programs write is read as the same numbers."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from telespring import InvalidInput, cli
from telespring._tables import read_text_table
from telespring.identification import Log, paper_excitation, read_log

NAMES = ("time", "position_x", "position_y", "force_x", "force_y")
NUMBERED: dict[str, Any] = {"time": "1", "position": ("2", "3"), "force": ("4", "5")}
NANOSECONDS = {"s": 1_000_000_000, "ms": 1_000_000, "us": 1_000, "ns": 1}
#: 2024-03-31T00:59:59.9873 UTC, 13 ms before clocks in Europe go forward.
BEGIN = 1_711_846_799_987_300_000
SAMPLES = 40


def table() -> list[list[float]]:
    """Rows of time, positions and forces: decimals that are exact as written."""
    random = np.random.default_rng(20)
    return [
        [
            i / 1000,
            *(random.integers(-99_999, 99_999, 2) / 1e6).tolist(),
            *(random.integers(-9_999, 9_999, 2) / 1e3).tolist(),
        ]
        for i in range(SAMPLES)
    ]


def text(
    separator: str = ",",
    *,
    decimal: str = ".",
    names: str | None = ",".join(NAMES),
    above: str = "",
    end: str = "\n",
    trailing: str = "",
    form: Callable[[float], str] = repr,
    stamp: Callable[[int], str] | None = None,
) -> str:
    """Write the table as text; `stamp` writes the time of a sample by its number."""
    lines = [] if names is None else [separator.join(names.split(",")) if "," in names else names]
    for i, row in enumerate(table()):
        fields = [form(value).replace(".", decimal) for value in row]
        if stamp is not None:
            fields[0] = stamp(i)
        lines.append(separator.join(fields) + trailing)
    return above + end.join(lines) + end


def fortran(value: float) -> str:
    return f"{value:.12E}".replace("E", "D")


def quoted(value: float) -> str:
    return f'"{value!r}"'


def as_fixed_width() -> str:
    return "\n".join("".join(f"{value:16.7f}" for value in row) for row in table()) + "\n"


def saved_by_numpy(**options: Any) -> str:
    file = io.StringIO()
    np.savetxt(file, np.array(table()), **options)
    return file.getvalue()


def saved_by_pandas(**options: Any) -> str:
    return str(pd.DataFrame(table(), columns=list(NAMES)).to_csv(**options))


SAME_NAMES: dict[str, Any] = {}
TEXTS: dict[str, tuple[str | bytes, dict[str, Any]]] = {
    "plain": (text(), SAME_NAMES),
    "blank after the comma": (text(", "), SAME_NAMES),
    "semicolons": (text(";"), SAME_NAMES),
    "semicolons, decimal commas": (text(";", decimal=","), SAME_NAMES),
    "semicolons, decimal commas, blanks": (text(" ; ", decimal=","), SAME_NAMES),
    "tabs": (text("\t"), SAME_NAMES),
    "tabs, decimal commas": (text("\t", decimal=","), SAME_NAMES),
    "bars": (text("|"), SAME_NAMES),
    "blanks": (text(" "), SAME_NAMES),
    "blanks, decimal commas": (text("  ", decimal=","), SAME_NAMES),
    "fixed width": (as_fixed_width(), NUMBERED),
    "no names": (text(names=None), NUMBERED),
    "no names, tabs": (text("\t", names=None), NUMBERED),
    "no names, semicolons, decimal commas": (text(";", names=None, decimal=","), NUMBERED),
    "names by number": (text(), NUMBERED),
    "other names": (
        text(names="t / s,x / m,y / m,F_x / N,F_y / N"),
        {"time": "t / s", "position": ("x / m", "y / m"), "force": ("F_x / N", "F_y / N")},
    ),
    "names with umlauts in Windows' code page": (
        text(names="Zeit,Länge x,Länge y,Kraft x,Kraft y").encode("cp1252"),
        {"time": "Zeit", "position": ("Länge x", "Länge y"), "force": ("Kraft x", "Kraft y")},
    ),
    "two columns of one name, by number": (text(names="time,position,position,force,force"), NUMBERED),
    "names in capitals": (text(names="Time,POSITION_X,Position_Y,Force_x,FORCE_Y"), SAME_NAMES),
    "quoted names": (text(names='"time","position_x","position_y","force_x","force_y"'), SAME_NAMES),
    "quoted numbers": (text(form=quoted), SAME_NAMES),
    "quoted decimal commas": (text(form=quoted, decimal=","), SAME_NAMES),
    "byte order mark": (text().encode("utf-8-sig"), SAME_NAMES),
    "Unicode text of Excel": (text("\t", decimal=",", end="\r\n").encode("utf-16"), SAME_NAMES),
    "UTF-16 without a mark": (text("\t", end="\r\n").encode("utf-16-le"), SAME_NAMES),
    "Excel's line of the separator": (text(";", decimal=",", above="sep=;\n"), SAME_NAMES),
    "lines of Windows": (text(end="\r\n"), SAME_NAMES),
    "lines of an old Macintosh": (text(end="\r"), SAME_NAMES),
    "no end of the last line": (text().rstrip("\n"), SAME_NAMES),
    "empty lines": (text(end="\n\n"), SAME_NAMES),
    "comments above": (text(above="# robot A\n# 2024-03-31, 1 kHz\n"), SAME_NAMES),
    "comments above with other commas": (text(";", above="% made by us, all, of us\n"), SAME_NAMES),
    "comments below": (text() + "# end of the log\n", SAME_NAMES),
    "names in a comment": (text(names="# time,position_x,position_y,force_x,force_y"), SAME_NAMES),
    "numpy's savetxt": (saved_by_numpy(), NUMBERED),
    "numpy's savetxt with names": (saved_by_numpy(header=" ".join(NAMES)), SAME_NAMES),
    "numpy's savetxt with names and commas": (
        saved_by_numpy(header=",".join(NAMES), delimiter=","),
        SAME_NAMES,
    ),
    "pandas with an index": (saved_by_pandas(), SAME_NAMES),
    "pandas without names": (saved_by_pandas(header=False, index=False), NUMBERED),
    "pandas' numbers for names": (saved_by_pandas(header=[str(i) for i in range(5)], index=False), NUMBERED),
    "exponents of Fortran": (text("  ", names=None, form=fortran), NUMBERED),
    "exponents of Fortran, small": (text(form=lambda value: fortran(value).lower()), SAME_NAMES),
    "exponents": (text(form=lambda value: f"{value:.9e}"), SAME_NAMES),
    "separators at the end": (text(trailing=","), SAME_NAMES),
    "separators at all ends": (text(names=",".join(NAMES) + ",", trailing=","), SAME_NAMES),
    "separator at the end of the names": (text(names=",".join(NAMES) + ","), SAME_NAMES),
    "many separators at the end": (text(";", trailing=";;;"), SAME_NAMES),
    "a head of the instrument": (
        text(above="Recorder: RX-5, No. 7\nSample rate [Hz], 1000\nOperator: K. M.\n\n"),
        SAME_NAMES,
    ),
    "units": (text(names="\n".join([",".join(NAMES), "s,m,m,N,N"])), SAME_NAMES),
    "units in brackets": (text(names="\n".join([",".join(NAMES), "[s],[m],[m],[N],[N]"])), SAME_NAMES),
    "a column of words": (
        "\n".join(
            f"{line},{'state' if i == 0 else 'moving' if i % 2 else 'at rest'}"
            for i, line in enumerate(text().splitlines())
        ),
        SAME_NAMES,
    ),
    "names again": (text() + text(names=",".join(NAMES)).split("\n", 1)[0] + "\n", SAME_NAMES),
    "milliseconds": (text(form=repr, stamp=lambda i: str(i)), {"time_scale": 0.001}),
}


def read(path: Path, content: str | bytes, **options: Any) -> Log:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_log(path, **options)


def assert_is_the_table(log: Log, *, tolerance: float = 0.0) -> None:
    expected = np.array(table())
    np.testing.assert_allclose(log.time - log.time[0], expected[:, 0], rtol=0.0, atol=tolerance or 1e-17)
    np.testing.assert_array_equal(log.position, expected[:, 1:3])
    np.testing.assert_array_equal(log.force, expected[:, 3:])


def test_law_there_are_many_layouts() -> None:
    assert len(TEXTS) >= 40


@pytest.mark.parametrize("layout", TEXTS)
def test_law_a_layout_of_text_gives_the_same_numbers(layout: str, tmp_path: Path) -> None:
    content, options = TEXTS[layout]
    assert_is_the_table(read(tmp_path / "log.csv", content, **options))


@pytest.mark.parametrize("name", ["LOG.CSV", "log.txt", "log.tsv", "Log.Dat"])
def test_law_endings_are_read_in_upper_and_lower_case(name: str, tmp_path: Path) -> None:
    assert_is_the_table(read(tmp_path / name, text("\t")))


def random_text(random: np.random.Generator) -> tuple[str, list[list[str]], list[str] | None]:
    """Write a random table: its text in a random layout, its fields with points for decimals, its names."""
    columns, rows = int(random.integers(2, 8)), int(random.choice([3, 20, 60]))
    separator = str(random.choice([",", ";", "\t", "|", " ", "  ", ", ", " ; "]))
    decimal = str(random.choice([".", "," if separator.strip() != "," else "."]))
    kinds = ["float", *random.choice(["float", "whole", "exponent", "word"], columns - 1)]
    random.shuffle(kinds)

    def field(kind: str) -> str:
        if kind == "word":
            return str(random.choice(["on", "off", "A1", "run"]))
        if kind == "whole":
            return str(random.integers(-500, 500))
        number = random.uniform(-10.0, 10.0)
        return f"{number:.3e}" if kind == "exponent" else f"{number:.{random.integers(1, 7)}f}"

    fields = [[field(kind) for kind in kinds] for _ in range(rows)]
    names = [f"column{i}" for i in range(columns)] if random.random() < 0.7 else None
    rows_of_text = [[part.replace(".", decimal) for part in row] for row in fields]
    lines = [separator.join(row) for row in [*([names] if names else []), *rows_of_text]]
    return "\n".join(lines), fields, names


def assert_random_tables_are_read(seed: int, count: int, folder: Path) -> None:
    random = np.random.default_rng(seed)
    for _ in range(count):
        content, fields, names = random_text(random)
        (folder / "log.csv").write_text(content, encoding="utf-8")
        found = read_text_table(folder / "log.csv", "log.csv")
        assert found.has_names == (names is not None), content
        assert names is None or list(found.names) == names, content
        expected = pd.DataFrame(fields).apply(pd.to_numeric, errors="coerce").to_numpy(dtype=float)
        np.testing.assert_array_equal(
            np.column_stack([found.numbers(i) for i in range(len(fields[0]))]), expected, err_msg=content
        )


def test_law_random_tables_in_random_layouts_are_read(tmp_path: Path) -> None:
    assert_random_tables_are_read(1, 200, tmp_path)


@pytest.mark.verify
def test_law_many_random_tables_in_random_layouts_are_read(tmp_path: Path) -> None:
    assert_random_tables_are_read(2, 3_000, tmp_path)


# ---- time stamps


def nanoseconds(i: int) -> int:
    return BEGIN + i * 1_000_000


def date(i: int, form: str, digits: int = 6, fraction: str = ".") -> str:
    whole, rest = divmod(nanoseconds(i), 1_000_000_000)
    day = datetime(1970, 1, 1, tzinfo=UTC) + timedelta(seconds=whole)
    return day.strftime(form).replace("%", fraction + f"{rest:09d}"[:digits])


STAMPS: dict[str, tuple[Callable[[int], str], str]] = {
    "since 1970 in s": (lambda i: f"{nanoseconds(i) // 10**9}.{nanoseconds(i) % 10**9:09d}", "epoch in s"),
    "since 1970 in ms": (lambda i: f"{nanoseconds(i) / 1e6:.1f}", "epoch in ms"),
    "since 1970 in µs": (lambda i: str(nanoseconds(i) // 1000), "epoch in µs"),
    "since 1970 in ns": (lambda i: str(nanoseconds(i)), "epoch in ns"),
    "ISO": (lambda i: date(i, "%Y-%m-%dT%H:%M:%S%%"), "date"),
    "ISO in ns": (lambda i: date(i, "%Y-%m-%dT%H:%M:%S%%Z", 9), "date"),
    "ISO with a blank": (lambda i: date(i, "%Y-%m-%d %H:%M:%S%%", 4), "date"),
    "ISO with a zone": (lambda i: date(i, "%Y-%m-%dT%H:%M:%S%%+01:00"), "date"),
    "German": (lambda i: date(i, "%d.%m.%Y %H:%M:%S%%", 4), "date"),
    "American": (lambda i: date(i, "%m/%d/%Y %I:%M:%S%% %p", 4), "date"),
    "MATLAB's": (lambda i: date(i, "%d-%b-%Y %H:%M:%S%%", 4), "date"),
    "time of the day": (lambda i: date(i, "%H:%M:%S%%"), "time of the day"),
    "minutes of Excel, over the hour": (lambda i: date(i, "%M:%S%%", 4), "time of the day"),
}


@pytest.mark.parametrize("decimal", [".", ","])
@pytest.mark.parametrize("stamps", STAMPS)
def test_law_stamps_of_any_kind_keep_their_resolution(stamps: str, decimal: str, tmp_path: Path) -> None:
    """1 ms between stamps of nineteen digits, to a nanosecond; a double of the time since 1970 has 238 ns."""
    write, form = STAMPS[stamps]

    def stamp(i: int) -> str:
        written = write(i)
        return (
            written if "zone" in stamps else written.replace(".", decimal) if stamps != "German" else written
        )

    log = read(tmp_path / "log.csv", text(";", decimal=decimal, stamp=stamp))
    assert log.time_form == form
    assert log.time[0] == 0.0
    assert_is_the_table(log, tolerance=1e-9)
    if form != "time of the day":
        assert log.first_time is not None
        assert log.first_time.startswith("2024-03-3")


def test_law_a_recording_over_midnight_goes_on(tmp_path: Path) -> None:
    def stamp(i: int) -> str:
        begin = datetime(2024, 1, 1, 23, 59, 59, 980_000, tzinfo=UTC)
        return (begin + timedelta(milliseconds=i)).strftime("%H:%M:%S.%f")

    assert_is_the_table(read(tmp_path / "log.csv", text(stamp=stamp)), tolerance=1e-12)


def test_law_counts_of_a_device_are_no_dates(tmp_path: Path) -> None:
    """25 minutes in µs are 1.5e9 like a time since 1970 in s, and then the step is a thousand seconds."""
    content = text(stamp=lambda i: str(1_500_000_000 + 1000 * i))
    assert read(tmp_path / "log.csv", content).time_form == "s"
    scaled = read(tmp_path / "log.csv", content, time_scale=1e-6)
    assert scaled.time[0] == 1500.0
    assert_is_the_table(scaled, tolerance=1e-12)


def test_law_what_is_no_time_is_refused_with_the_rate_as_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="--rate") as refused:
        read(tmp_path / "log.csv", text(stamp=lambda i: f"sample {i}"))
    assert refused.value.value == "sample 0"
    with pytest.raises(InvalidInput, match="only numbers have a scale"):
        read(tmp_path / "log.csv", text(stamp=STAMPS["ISO"][0]), time_scale=0.001)


def test_law_a_rate_replaces_the_times(tmp_path: Path) -> None:
    content = text(names="index,position_x,position_y,force_x,force_y", stamp=str)
    with pytest.raises(InvalidInput, match="sample rate with --rate"):
        read(tmp_path / "log.csv", content)
    log = read(tmp_path / "log.csv", content, rate=1000.0)
    assert log.time_form == "sample rate"
    assert_is_the_table(log)
    assert "time" not in log.columns
    for rate in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(InvalidInput, match="samples per second"):
            read(tmp_path / "log.csv", content, rate=rate)


# ---- Parquet


def frame() -> pd.DataFrame:
    return pd.DataFrame(table(), columns=list(NAMES))


@pytest.mark.parametrize("unit", ["ms", "us", "ns"])
@pytest.mark.parametrize("zone", [None, "Europe/Berlin"])
@pytest.mark.parametrize("place", ["column", "index", "index without a name"])
def test_law_dates_in_parquet_are_read(unit: str, zone: str | None, place: str, tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    stamps = pd.to_datetime([BEGIN + 700_000 + i * 1_000_000 for i in range(SAMPLES)]).as_unit(unit)  # type: ignore[arg-type]
    content = frame()
    if zone is not None:
        stamps = stamps.tz_localize("UTC").tz_convert(zone)
    if place == "column":
        content["time"] = stamps
    else:
        content = content.drop(columns="time").set_index(stamps)
        content.index.name = "time" if place == "index" else None
    content.to_parquet(tmp_path / "log.parquet")
    log = read_log(tmp_path / "log.parquet")
    assert log.time_form == "date"
    assert_is_the_table(log, tolerance=1e-12)


def test_law_numbers_missing_in_parquet_are_lost_samples(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    content = frame().astype("Float64")
    content.loc[3, "force_x"] = pd.NA
    content["time"] = pd.array([BEGIN // 1000 + 1000 * i for i in range(SAMPLES)], dtype="Int64")
    content.to_parquet(tmp_path / "log.PARQUET")
    log = read_log(tmp_path / "log.PARQUET")
    assert log.time_form == "epoch in µs"
    assert np.flatnonzero(np.isnan(log.force[:, 0])).tolist() == [3]
    np.testing.assert_allclose(log.time, np.arange(SAMPLES) / 1000, rtol=0.0, atol=1e-12)


def test_law_an_index_of_numbers_is_a_column(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    frame().set_index("time").to_parquet(tmp_path / "log.parquet")
    assert_is_the_table(read_log(tmp_path / "log.parquet"))
    frame().set_index(["time", "force_x"]).to_parquet(tmp_path / "log.parquet")
    assert_is_the_table(read_log(tmp_path / "log.parquet"))


# ---- several runs


def several_runs() -> list[list[float]]:
    """Three runs of different lengths, each from time 0."""
    return [row for length in (20, 30, 40) for row in table()[:length]]


def test_law_times_that_start_again_are_runs(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    pd.DataFrame(several_runs(), columns=list(NAMES)).to_csv(path, index=False)
    log = read_log(path)
    assert log.runs == ("1", "2", "3")
    assert [len(run.time) for run in log.split()] == [20, 30, 40]
    for run in log.split():
        np.testing.assert_array_equal(run.position, np.array(table())[: len(run.time), 1:3])
    second = read_log(path, run=2)
    np.testing.assert_array_equal(second.time, log.split()[1].time)
    assert second.runs == ("2",)
    with pytest.raises(InvalidInput, match="the log has the runs 1, 2, 3"):
        read_log(path, run="4")


@pytest.mark.parametrize(
    ("labels", "names"), [((7.0, 3.0, 12.0), ("7", "3", "12")), (("a", "b", "c"), "abc")]
)
def test_law_a_column_tells_runs_and_their_names(labels: tuple[Any, ...], names: Any, tmp_path: Path) -> None:
    """Also where the time goes on, or the runs take turns."""
    path = tmp_path / "log.csv"
    content = pd.DataFrame(several_runs(), columns=list(NAMES))
    content["trial"] = np.repeat(np.array(labels), (20, 30, 40))
    content.iloc[np.random.default_rng(1).permutation(90)].sort_index(kind="stable").to_csv(path, index=False)
    log = read_log(path, run_column="trial")
    assert log.runs == tuple(names)
    assert [len(run.time) for run in log.split()] == [20, 30, 40]
    chosen = read_log(path, run_column="trial", run=names[1])
    np.testing.assert_array_equal(chosen.force, np.array(table())[:30, 3:])


def test_law_a_time_that_steps_back_is_no_run(tmp_path: Path) -> None:
    rows = table()
    rows[20][0] = rows[18][0] + 5e-4
    path = tmp_path / "log.csv"
    pd.DataFrame(rows, columns=list(NAMES)).to_csv(path, index=False)
    assert read_log(path).runs == ("1",)


# ---- lines that do not fit


@pytest.mark.parametrize(
    ("content", "place", "words"),
    [
        (text(trailing=",7"), "log.csv, line 2 = 6 fields", "row.names = FALSE"),
        (text().replace("\n0.003,", "\n0.003,9,", 1), "log.csv, line 5 = 6 fields", "Correct this line"),
        (text().replace("\n0.003,", "\n", 1), "log.csv, line 5 = 4 fields", "Correct this line"),
        (text().rsplit(",", 1)[0], "log.csv, line 41 = 4 fields", "cut off"),
        (text(decimal=","), "log.csv, line 2 = ", "separate the columns with semicolons"),
        (
            text(above="# one\n\n# two\n", trailing=",7"),
            "log.csv, line 5 = 6 fields",
            "every line must have 5",
        ),
    ],
)
def test_law_a_line_of_another_length_is_refused_by_its_number(
    content: str, place: str, words: str, tmp_path: Path
) -> None:
    with pytest.raises(InvalidInput) as refused:
        read(tmp_path / "log.csv", content)
    assert place in str(refused.value)
    assert words in str(refused.value)


def test_law_a_name_of_two_columns_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="several columns of this name"):
        read(tmp_path / "log.csv", text(names="time,position_x,position_x,force_x,force_y"))


def test_law_columns_without_names_ask_for_numbers(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="--time 1 --position 2,3 --force 4,5"):
        read(tmp_path / "log.csv", text(names=None))
    with pytest.raises(InvalidInput, match="does not name its 5 columns"):
        read(tmp_path / "log.csv", text(names=None), time="1", position=("2", "6"), force=("4", "5"))


@pytest.mark.parametrize(
    ("units", "words"),
    [
        ("ms,m,m,N,N", "--time-scale 0.001"),
        ("s,mm,mm,N,N", "--position-scale 0.001"),
        ("s,m,m,mN,mN", "--force-scale 0.001"),
        ("s,m,m,V,V", "Give --force-scale the force in SI units per V"),
    ],
)
def test_law_units_in_the_file_are_not_ignored(units: str, words: str, tmp_path: Path) -> None:
    content = text(names=",".join(NAMES) + "\n" + units)
    with pytest.raises(InvalidInput) as refused:
        read(tmp_path / "log.csv", content)
    assert words in refused.value.remedy
    # with the scale the file is read
    option = words.removeprefix("Give ").split("-")[2]
    scale = {f"{option}_scale": 0.001}
    log = read(tmp_path / "log.csv", content, **scale)
    assert len(log.time) == SAMPLES


@pytest.mark.parametrize(
    ("names", "words"),
    [
        ("t [ms],x [m],y [m],F [N],G [N]", "--time-scale 0.001"),
        ("t (s),x / mm,y / mm,F / N,G / N", "--position-scale 0.001"),
        ("t (s),x (cm),y (cm),F (N),G (N)", "--position-scale 0.01"),
        ("t,x,y,F [kN],G [kN]", "--force-scale 1000"),
    ],
)
def test_law_units_in_names_are_not_ignored(names: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput) as refused:
        read(tmp_path / "log.csv", text(names=names), **NUMBERED)
    assert words in refused.value.remedy
    for right in ("t [s],x [m],y [m],F [N],G [N]", "t / s,x / m,y (raw),F,G [mean]"):
        assert_is_the_table(read(tmp_path / "log.csv", text(names=right), **NUMBERED))


def test_law_words_and_repeated_rows_are_told(tmp_path: Path) -> None:
    lines = text().splitlines()
    lines[8] = ",".join([*lines[8].split(",")[:4], "ERR"])
    lines.insert(12, lines[11])
    log = read(tmp_path / "log.csv", "\n".join(lines))
    assert np.flatnonzero(np.isnan(log.force[:, 1])).tolist() == [7]
    assert len(log.time) == SAMPLES
    assert any('force_y that are no numbers: 1, the first "ERR"' in note for note in log.notes)
    assert any("Repeated samples: 1." in note for note in log.notes)


# ---- the command


def test_law_the_command_reads_a_log_without_names_and_times(tmp_path: Path) -> None:
    """The plain log, the bare numbers with decimal commas, and the numbers with a rate give one robot."""
    time = np.arange(12_000) / 1000.0
    command, random = paper_excitation(), np.random.default_rng(1)
    position = np.round(command.position(time) / 2e-5) * 2e-5
    force = (
        0.8 * command.acceleration(time) + 7.0 * command.velocity(time) + random.normal(0.0, 0.1, time.size)
    )
    plain = pd.DataFrame({"time": time, "position_x": position, "force_x": force})

    def mass(path: Path, *options: str) -> float:
        done = CliRunner().invoke(cli.app, ["identify", str(path), *options, "--json"])
        assert done.exit_code == 0, done.stderr
        return float(json.loads(done.stdout)["axes"][0]["mass"])

    plain.to_csv(tmp_path / "plain.csv", index=False)
    expected = mass(tmp_path / "plain.csv", "--position", "position_x", "--force", "force_x")
    plain.to_csv(tmp_path / "bare.csv", index=False, header=False, sep=";", decimal=",")
    assert mass(tmp_path / "bare.csv", "--time", "1", "--position", "2", "--force", "3") == expected
    plain.drop(columns="time").to_csv(tmp_path / "untimed.csv", index=False, header=False, sep="\t")
    untimed = mass(tmp_path / "untimed.csv", "--rate", "1000", "--position", "1", "--force", "2")
    assert untimed == pytest.approx(expected, rel=1e-9)
    other = plain.assign(run=1, force_x=force + random.normal(0.0, 0.02, time.size))
    twice = pd.concat([other, plain.assign(run=2)])
    twice.to_csv(tmp_path / "twice.csv", index=False)
    options = ["--position", "position_x", "--force", "force_x", "--run", "2"]
    assert mass(tmp_path / "twice.csv", *options) == expected
    assert mass(tmp_path / "twice.csv", *options, "--run-column", "run") == expected
    # without a choice, runs are taken together like several logs
    together = CliRunner().invoke(cli.app, ["identify", str(tmp_path / "twice.csv"), *options[:4], "--json"])
    assert together.exit_code == 0, together.stderr
    assert json.loads(together.stdout)["logs"] == 2
