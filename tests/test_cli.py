"""The commands: what they answer, with which exit status, and what they leave behind."""

import csv
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from paper_study import PaperStudy
from questions import flat, run
from telespring import cli
from telespring.paper import Analysis
from test_decide_command import UNDAMPED, written

UNKNOWN_KEY = """
robot1 = {mass = 1.0, damping = 5.0}
robot2 = {mass = 1.0, damping = 5.0}
coupling.stifness = 20.0
network.delay = 0.05
"""


def test_law_a_comma_in_an_axis_name_stays_in_its_column(tmp_path: Path) -> None:
    text = UNDAMPED.replace("{mass = 1.0, damping = 0.0}", '{mass = 1.0, damping = 5.0, axes = ["a,b"]}')
    out = tmp_path / "run.csv"
    found = run("simulate", written(tmp_path, text), "--duration", "0.1", "--out", str(out))
    assert found.exit_code == 0, found.output
    with out.open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    assert rows[0][1] == "position_robot1_a,b_m"
    assert {len(row) for row in rows} == {5}


def test_law_a_file_that_cannot_be_written_is_named_as_it_was_asked_for(tmp_path: Path) -> None:
    for name in ("taken.nc", "taken.csv"):
        (tmp_path / name).mkdir()
        found = run("simulate", "--duration", "0.1", "--out", str(tmp_path / name))
        assert found.exit_code == 2
        assert name in found.stderr.replace("\n", "")
        assert "unfinished" not in found.stderr


def test_law_a_diverged_simulation_is_told_in_words(tmp_path: Path) -> None:
    out = str(tmp_path / "run.csv")
    found = run("simulate", "--stiffness", "2000", "--delay", "0.3", "--duration", "60", "--out", out)
    assert found.exit_code == 0, found.output
    said = flat(found.stdout)
    assert re.search(r"Diverged at [0-9.]+ s: a position exceeded 1e12 m", said)
    assert "axis x: unstable, the robots drift apart without limit" in said
    assert not re.search(r"e\+[0-9]+ mm", said)


def as_process(
    *arguments: str, code: str | None = None, **environment: str
) -> subprocess.CompletedProcess[bytes]:
    start = ["-m", "telespring"] if code is None else ["-c", code]
    return subprocess.run(
        [sys.executable, *start, *arguments],
        capture_output=True,
        check=False,
        timeout=60,
        env={**os.environ, **environment},
    )


def test_law_a_terminal_without_greek_gets_its_answer() -> None:
    screen = as_process("decide", "--stiffness", "71.2", "--delay", "0.1", PYTHONIOENCODING="ascii")
    assert screen.returncode == 0, screen.stderr
    assert b"STABLE" in screen.stdout
    answer = as_process("decide", "--json", "--stiffness", "71.2", "--delay", "0.1", PYTHONIOENCODING="ascii")
    assert answer.returncode == 0, answer.stderr
    assert "≤" in json.loads(answer.stdout)["verdicts"]["any_network"]["rule"]


@pytest.mark.parametrize("module", ["typer", "telespring.decision.decide"])
def test_law_ctrl_c_while_loading_ends_quietly(module: str) -> None:
    found = as_process(
        "decide",
        "--stiffness",
        "71.2",
        "--delay",
        "0.1",
        code=INTERRUPTED_WHILE_LOADING.replace("MODULE", module),
    )
    assert found.returncode == 130
    assert b"Traceback" not in found.stderr


INTERRUPTED_WHILE_LOADING = """
import runpy, sys
class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == "MODULE":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupting())
runpy.run_module("telespring", run_name="__main__", alter_sys=True)
"""


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["decide", "--delay", "167"], ["--delay", "167", "0 to 100 s", "0.167"]),
        (["decide", "--stiffness", "-3"], ["stiffness", "-3", "N/m"]),
        (["decide", "--stiffness", "nan"], ["stiffness", "number"]),
        (["decide", "--stiffness", "5", "--delay", "0.1", "--horizon", "0"], ["--horizon", "0"]),
        (["decide", "no-such-file.toml"], ["no-such-file.toml"]),
        (["simulate", "--out", "x.txt"], ["out", ".nc or .csv"]),
        (["simulate", "--force", "1"], ["force", "4"]),
        (["simulate", "--duration", "-1", "--out", "x.csv"], ["duration"]),
    ],
)
def test_law_bad_input_is_refused_on_one_screen(
    arguments: list[str], said: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    found = run(*arguments)
    assert found.exit_code == 2
    assert found.stdout == ""
    for word in said:
        assert word in found.stderr
    assert "Traceback" not in found.stderr
    assert len(found.stderr.splitlines()) < 24
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", ["robot1 = {", UNKNOWN_KEY, ""])
def test_law_a_bad_study_is_refused(text: str, tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(text)
    for command in ("decide", "simulate", "reproduce", "study"):
        found = run(command, str(file))
        assert found.exit_code == 2
        assert "Refused" in found.stderr
        assert "Traceback" not in found.stderr


def test_law_simulate_writes_the_same_numbers_as_netcdf_and_csv(tmp_path: Path) -> None:
    import xarray

    common = ["simulate", "--stiffness", "36", "--delay", "0.1", "--duration", "2", "--rate", "100"]
    for name in ("run.nc", "run.csv"):
        found = run(*common, "--out", str(tmp_path / name))
        assert found.exit_code == 0, found.stderr
        assert "axis x" in found.stdout
    assert sorted(each.name for each in tmp_path.iterdir()) == ["run.csv", "run.nc"]
    with xarray.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as stored:
        position = np.asarray(stored["position"])
        assert stored["position"].attrs["units"] == "m"
    with (tmp_path / "run.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(position) == 201
    assert [float(row["position_robot1_x_m"]) for row in rows] == position[:, 0, 0].tolist()
    assert [float(row["position_robot2_y_m"]) for row in rows] == position[:, 1, 1].tolist()


def test_law_the_program_runs_as_a_process() -> None:
    found = subprocess.run(
        [sys.executable, "-m", "telespring", "decide", "--json", "--stiffness", "71.2", "--delay", "0.1"],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert found.returncode == 0, found.stderr
    assert json.loads(found.stdout)["stable"]


def test_law_ctrl_c_leaves_no_half_written_file(tmp_path: Path) -> None:
    out = tmp_path / "study"
    process = subprocess.Popen(
        [sys.executable, "-c", WAITS_FOR_ITS_FIRST_STEP, str(out)], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "begun\n"
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == 130
    assert not out.exists()


WAITS_FOR_ITS_FIRST_STEP = """
import sys, time
from telespring import cli
from dataclasses import replace
from telespring.paper import reproduce
def waits(scene):
    sys.stdout.write("begun\\n")
    sys.stdout.flush()
    time.sleep(60)
reproduce.PARTS = (reproduce.PARTS[0], replace(reproduce.PARTS[1], step="waits", find=waits))
reproduce.STEPS = cli_steps = (*(section.step for section in reproduce.PARTS), "report")
import telespring.paper
telespring.paper.STEPS = cli_steps
cli.app(["reproduce", "--out", sys.argv[1]])
"""


def test_law_study_writes_whole_files_and_tells_the_answer(paper_study: PaperStudy) -> None:
    found, out = paper_study.result, paper_study.folder
    assert found.exit_code == 0, found.stderr
    written = sorted(each.name for each in out.iterdir() if not each.name.startswith("."))
    assert written == ["rehearsal.nc", "report.html", "study.json"]
    assert "Over 167 ms each way" in found.stdout
    assert "any constant delay" in found.stdout
    for name in written:
        assert str(out / name) in found.stdout.replace("\n", "")
    text = (out / "study.json").read_text(encoding="utf-8")
    assert json.loads(text)["schema"] == "telespring study 2"


def test_law_the_earlier_name_of_reproduce_works_and_names_the_new_one(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(UNKNOWN_KEY)
    former, present = run("study", str(file)), run("reproduce", str(file))
    notice, *refusal = former.stderr.splitlines()
    assert notice == "`telespring study` is now `telespring reproduce`."
    assert refusal == present.stderr.splitlines()
    assert former.exit_code == present.exit_code == 2
    commands = run("--help").stdout
    assert re.search(r"^. reproduce ", commands, re.MULTILINE)
    assert not re.search(r"^. study ", commands, re.MULTILINE)


def test_law_help_names_every_option_with_its_unit() -> None:
    text = run("decide", "--help").stdout
    for option in (
        "--stiffness",
        "--delay",
        "--backward",
        "--jitter",
        "--max-gap",
        "--sample-period",
        "--json",
    ):
        assert option in text
    assert "N/m" in text


def test_law_a_missing_value_is_named_with_its_unit(tmp_path: Path) -> None:
    study = tmp_path / "study.toml"
    study.write_text(
        "robot1 = {mass = 1, damping = 5}\nrobot2 = {mass = 1, damping = 5}\nnetwork.delay = 0.05\n"
    )
    result = run("simulate", str(study))
    assert result.exit_code == 2
    assert result.stderr.splitlines() == [
        "Refused: Missing coupling.stiffness (N/m).",
        "  Add a section [coupling] with stiffness = 20.0.",
    ]


def test_law_a_quick_reproduction_has_the_same_numbers_but_no_experiment(
    tmp_path: Path, analysis: Analysis
) -> None:
    done = CliRunner().invoke(cli.app, ["reproduce", "--quick", "--out", str(tmp_path / "quick")])
    assert done.exit_code == 0, done.output
    assert "Left out: the experiment" in done.output
    assert sorted(path.name for path in (tmp_path / "quick").iterdir()) == ["report.html", "study.json"]
    numbers = json.loads((tmp_path / "quick" / "study.json").read_text(encoding="utf-8"))
    assert "experiment" not in numbers
    assert {"table3", "summary", "stability_map"} <= set(numbers)
    assert all(analysis.numbers[key] == value for key, value in numbers.items())
    page = (tmp_path / "quick" / "report.html").read_text(encoding="utf-8")
    anchors = set(re.findall(r'id="([^"]+)"', page))
    assert set(re.findall(r'href="#([^"]+)"', page)) <= anchors
