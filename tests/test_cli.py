"""The commands: what they answer, with which exit status, and what they leave behind."""

import csv
import json
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from telespring import cli

UNKNOWN_KEY = """
robot1 = {mass = 1.0, damping = 5.0}
robot2 = {mass = 1.0, damping = 5.0}
coupling.stifness = 20.0
network.delay = 0.05
"""


def run(*arguments: str) -> Result:
    return CliRunner(env={"COLUMNS": "100", "NO_COLOR": "1"}).invoke(cli.app, list(arguments))


def test_ref_decide_answers_in_json_for_the_papers_case() -> None:
    """The case of the issue, 71.2 N/m over 167 ms; K from Table III's parameters by Eq. 5."""
    found = run("decide", "--json", "--stiffness", "71.2", "--delay", "0.167")
    assert found.exit_code == 0
    answer = json.loads(found.stdout)
    x, y = answer["axes"]
    assert (x["axis"], y["axis"]) == ("x", "y")
    assert x["critical_stiffness"] == pytest.approx(35.615988, rel=1e-8)
    assert x["critical_stiffness_paper"] == pytest.approx(35.615988, rel=1e-8)
    assert y["critical_stiffness"] == pytest.approx(39.442273, rel=1e-8)
    # at 71.2 N/m, slightly below 2K, both last a little longer than at 2K
    assert 0.16718632424 < x["maximum_delay"] < 0.1675
    assert x["stable_delays"][0] == [0.0, x["maximum_delay"]]
    assert x["stable"]
    assert answer["stable"]
    assert x["spectral_abscissa"] < 0
    assert set(answer["verdicts"]) == {
        "constant_delay",
        "any_constant_delay",
        "bounded_varying_delay",
        "any_network",
        "paper",
    }
    assert answer["verdicts"]["constant_delay"]["satisfied"]
    assert answer["allowing_verdict"] == "constant delay"
    bound = answer["verdicts"]["constant_delay"]["stiffness_allowed"]
    assert answer["stiffness_allowed"] == bound == pytest.approx(71.28, abs=0.005)
    assert not answer["verdicts"]["any_constant_delay"]["satisfied"]


def test_law_no_limit_is_valid_json_with_a_flag() -> None:
    found = run("decide", "--json", "--stiffness", "20", "--delay", "0")
    assert "Infinity" not in found.stdout
    assert "NaN" not in found.stdout
    axis = json.loads(found.stdout)["axes"][0]
    assert axis["maximum_delay"] is None
    assert axis["maximum_delay_unbounded"]
    assert axis["maximum_stiffness_unbounded"]


def test_law_an_unstable_answer_is_an_answer_and_says_what_to_change() -> None:
    found = run("decide", "--json", "--stiffness", "71.2", "--delay", "0.3")
    assert found.exit_code == 0
    answer = json.loads(found.stdout)
    assert not answer["stable"]
    softer = run(
        "decide", "--json", "--stiffness", str(0.999 * answer["remedies"]["stiffness"]), "--delay", "0.3"
    )
    nearer = run(
        "decide", "--json", "--stiffness", "71.2", "--delay", str(0.999 * answer["remedies"]["delay"])
    )
    assert json.loads(softer.stdout)["stable"]
    assert json.loads(nearer.stdout)["stable"]
    assert answer["remedies"]["added_damping"] > 0


def test_law_the_screen_says_the_answer_in_words_and_ms() -> None:
    stable, unstable = (run("decide", "--stiffness", "71.2", "--delay", delay) for delay in ("0.1", "0.2"))
    assert "STABLE at this constant delay" in stable.stdout
    assert "UNSTABLE on axis x" in unstable.stdout
    assert "To be stable at a constant delay, one of:" in unstable.stdout
    for name in ("constant delay", "any constant delay", "bounded varying delay", "any network", "paper"):
        assert name in stable.stdout
    assert "167.3 ms" in stable.stdout
    # one screen
    assert len(stable.stdout.splitlines()) <= 30


def test_law_unequal_delays_act_by_their_sum() -> None:
    one = json.loads(
        run("decide", "--json", "--stiffness", "71.2", "--delay", "0.2", "--backward", "0.1").stdout
    )
    other = json.loads(run("decide", "--json", "--stiffness", "71.2", "--delay", "0.15").stdout)
    assert one["delay"] == {"forward": 0.2, "backward": 0.1, "mean": pytest.approx(0.15)}
    for left, right in zip(one["axes"], other["axes"], strict=True):
        # 1e-9: two roundings of one root
        assert left["spectral_abscissa"] == pytest.approx(right["spectral_abscissa"], rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["decide", "--delay", "167"], ["delay", "167", "0 to 100 s", "0.167"]),
        (["decide", "--stiffness", "-3"], ["stiffness", "-3", "N/m"]),
        (["decide", "--stiffness", "nan"], ["stiffness", "number"]),
        (["decide", "--horizon", "0"], ["horizon", "0"]),
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
    for command in ("decide", "simulate", "study"):
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
        [sys.executable, "-m", "telespring", "decide", "--json", "--stiffness", "71.2", "--delay", "0.167"],
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
    # Whole files or none: where the study was quicker than the signal, both stand.
    left = sorted(each.name for each in out.iterdir()) if out.exists() else []
    if process.returncode == 130:
        assert left == []
    else:
        assert process.returncode == 0
        assert left == ["report.html", "study.json"]


WAITS_FOR_ITS_FIRST_STEP = """
import sys
from telespring import cli, study
whole = study._nyquist
def told(*arguments):
    sys.stdout.write("begun\\n")
    sys.stdout.flush()
    return whole(*arguments)
study._nyquist = told
cli.app(["study", "--out", sys.argv[1]])
"""


def test_law_study_writes_two_whole_files_and_tells_the_answer(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "study"
    found = run("study", "--out", str(out))
    assert found.exit_code == 0, found.stderr
    assert sorted(each.name for each in out.iterdir()) == ["report.html", "study.json"]
    assert "Over 100 ms each way" in found.stdout
    assert "any constant delay" in found.stdout
    text = (out / "study.json").read_text(encoding="utf-8")
    assert json.loads(text)["schema"] == "telespring study 1"


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
