"""Recorded trials in the layouts that laboratories' programs write are read as the same trials."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from typer.testing import CliRunner

import telespring as ts
from made_trials import small
from telespring import cli
from telespring.analysis import read_recorded, write_recorded
from telespring.analysis.sources import open_trials
from telespring.study.robot_file import robot_record

Rewrite = Callable[[str], str | bytes]


def separated(separator: str, decimal: str = ".", *, quoted: bool = False) -> Callable[[str], str]:
    """Write a comma-separated text with other separators and decimal marks."""

    def rewrite(content: str) -> str:
        lines = []
        for i, line in enumerate(content.splitlines()):
            fields = line.split(",")
            if i:
                fields = [field if ".csv" in field else field.replace(".", decimal) for field in fields]
            lines.append(separator.join(f'"{field}"' if quoted else field for field in fields))
        return "\n".join(lines) + "\n"

    return rewrite


def fortran(content: str) -> str:
    """Write every decimal with an exponent of Fortran."""
    head, *lines = content.splitlines()
    rewritten = []
    for line in lines:
        fields = line.split(",")
        if ".csv" not in fields[0]:
            fields = [f"{float(field):.16E}".replace("E", "D") for field in fields]
        rewritten.append(",".join(fields))
    return "\n".join([head, *rewritten]) + "\n"


LAYOUTS: dict[str, Rewrite] = {
    "as written": str,
    "semicolons": separated(";"),
    "semicolons, decimal commas": separated(";", ","),
    "tabs, decimal commas": separated("\t", ","),
    "bars": separated("|"),
    "quotation marks": separated(",", quoted=True),
    "quoted decimal commas": separated(",", ",", quoted=True),
    "blanks after commas": separated(", "),
    "byte order mark": lambda content: content.encode("utf-8-sig"),
    "Unicode text of Excel": lambda content: (
        separated("\t", ",")(content).replace("\n", "\r\n").encode("utf-16")
    ),
    "Excel's line of the separator": lambda content: "sep=;\n" + separated(";", ",")(content),
    "lines of Windows": lambda content: content.replace("\n", "\r\n"),
    "separators at the end": lambda content: content.replace("\n", ",\n"),
    "separators at the end of rows": lambda content: content.replace("\n", ",\n").replace(",\n", "\n", 1),
    "comments": lambda content: "# laboratory 3\n# Monday\n" + content,
    "a head": lambda content: "Laboratory 3\n\n" + content,
    "empty lines": lambda content: content.replace("\n", "\n\n"),
    "no end of the last line": lambda content: content.rstrip("\n"),
    "exponents of Fortran": fortran,
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_law_trials_in_another_layout_are_the_same(layout: str, tmp_path: Path) -> None:
    trials = small()
    write_recorded(trials, tmp_path)
    for file in tmp_path.glob("*.csv"):
        rewritten = LAYOUTS[layout](file.read_text(encoding="utf-8"))
        file.write_bytes(rewritten.encode() if isinstance(rewritten, str) else rewritten)
    assert read_recorded(tmp_path).drop_vars("file").identical(trials)


def test_law_a_line_of_units_must_say_what_the_names_say(tmp_path: Path) -> None:
    trials = small()
    write_recorded(trials, tmp_path)
    file = tmp_path / "UM-01-001.csv"
    names, *rows = file.read_text(encoding="utf-8").splitlines()
    units = ["s" if name == "time_s" else "m/s" if "_per_" in name else name[-1] for name in names.split(",")]
    file.write_text("\n".join([names, ",".join(units), *rows]), encoding="utf-8")
    assert read_recorded(tmp_path).drop_vars("file").identical(trials)
    for place, unit in ((0, "ms"), (1, "mm"), (3, "[cm]")):
        wrong = [*units[:place], unit, *units[place + 1 :]]
        file.write_text("\n".join([names, ",".join(wrong), *rows]), encoding="utf-8")
        with pytest.raises(ts.InvalidInput, match="units are not converted"):
            read_recorded(tmp_path)


def test_law_whole_numbers_of_a_table_may_have_a_point(tmp_path: Path) -> None:
    """A column with an empty field somewhere becomes 1.0, 2.0 where a program stores numbers only."""
    trials = small()
    write_recorded(trials, tmp_path)
    index = tmp_path / "trials.csv"
    table = pd.read_csv(index, keep_default_na=False)
    for form in ("{}.0", "{}.00"):
        table.assign(trial=[form.format(trial) for trial in table["trial"]]).to_csv(index, index=False)
        assert read_recorded(tmp_path).drop_vars("file").identical(trials)
    for wrong in ("1.5", "1.", "one", "-1.0", "1.01"):
        table.assign(trial=[wrong, *table["trial"][1:]]).to_csv(index, index=False)
        with pytest.raises(ts.InvalidInput, match=r"trials\.csv, line 2: trial"):
            read_recorded(tmp_path)


def test_law_names_of_files_are_found_in_upper_and_lower_case(tmp_path: Path) -> None:
    """Windows writes TRIALS.CSV and Trial1.CSV for what the list calls trial1.csv."""
    trials = small()
    trials.attrs["study"] = 'name = "a study"\n'
    write_recorded(trials, tmp_path)
    for file in list(tmp_path.glob("*")):
        file.rename(file.with_name(file.name.upper()))
    assert open_trials(tmp_path).drop_vars("file").identical(trials)
    assert open_trials(tmp_path / "TRIALS.CSV").drop_vars("file").identical(trials)


def test_law_folders_in_the_list_may_be_written_as_in_windows(tmp_path: Path) -> None:
    trials = small()
    write_recorded(trials, tmp_path)
    index = tmp_path / "trials.csv"
    table = pd.read_csv(index, keep_default_na=False)
    (tmp_path / "data").mkdir()
    for file in table["file"]:
        (tmp_path / file).rename(tmp_path / "data" / file)
    table.assign(file="data\\" + table["file"]).to_csv(index, index=False)
    assert read_recorded(tmp_path).drop_vars("file").identical(trials)


def test_law_a_rehearsal_and_a_simulation_are_known_by_endings_in_capitals(tmp_path: Path) -> None:
    trials = small()
    trials.to_netcdf(tmp_path / "REHEARSAL.NC", engine="h5netcdf")
    assert open_trials(tmp_path / "REHEARSAL.NC")["position"].identical(trials["position"])
    asked = ["simulate", "--stiffness", "20", "--delay", "0.1", "--duration", "1", "--out"]
    for name in ("response.CSV", "response.NC"):
        done = CliRunner().invoke(cli.app, [*asked, str(tmp_path / name)])
        assert done.exit_code == 0, done.stderr
        assert (tmp_path / name).stat().st_size > 100


def test_law_a_byte_order_mark_in_front_of_a_study_or_robot_changes_nothing(tmp_path: Path) -> None:
    """Windows' Notepad writes it."""
    study, robot = tmp_path / "study.toml", tmp_path / "robot.toml"
    text = ts.Study.paper().to_toml()
    study.write_bytes(text.replace("\n", "\r\n").encode("utf-8-sig"))
    assert ts.Study.read(study).to_toml() == text
    content = "[robot]\nmass = [0.84, 1.07]\ndamping = 7.7\n[identification]\naxes_independent = false\n"
    robot.write_bytes(content.encode("utf-8-sig"))
    assert robot_record(robot) == robot_record(content)
    assert ts.Study.paper().with_robot(1, robot).dyad == ts.Study.paper().with_robot(1, content).dyad
