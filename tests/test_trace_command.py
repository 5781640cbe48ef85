"""The command `telespring trace`: its screen, its files and its refusals."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import telespring as ts
from telespring import cli
from telespring.show.drawings.trace import draw_trace
from telespring.show.screens.trace import study_lines

ROBOTS = """
robot1 = {mass = [0.8334, 1.0649], damping = [7.7257, 10.1168]}
robot2 = {mass = [0.8334, 1.0649], damping = [7.7257, 10.1168]}
"""


def run(*arguments: str | Path) -> Result:
    runner = CliRunner(env={"COLUMNS": "80", "NO_COLOR": "1"})
    return runner.invoke(cli.app, ["trace", *map(str, arguments)])


@pytest.fixture
def ragged(tmp_path: Path) -> Path:
    """Write round trips like those of 5G: correlated, with missing rows, a pause and a burst of delay."""
    random = np.random.default_rng(11)
    lines = ["pub_time(ms) sub_time(ms) delay(ms) sinr(db)"]
    time, level = 1_721_636_168_156, 0.0
    for n in range(3000):
        time += 16 if random.random() > 0.03 else 16 * int(random.integers(2, 6))
        time += 40_000 if n == 1500 else 0
        level = 0.9 * level + random.gamma(1.0, 0.8)
        delay = round(14 + level + (200 - 15 * (n - 900) if 900 <= n < 913 else 0))
        lines.append(f"{time} {time + delay} {delay} 15")
    file = tmp_path / "ragged.txt"
    file.write_text("\n".join(lines) + "\n")
    return file


def test_law_the_screen_is_short_and_says_what_to_use(ragged: Path) -> None:
    shown = run(ragged, "--round-trip")
    assert shown.exit_code == 0, shown.output
    lines = shown.stdout.splitlines()
    assert len(lines) <= 30
    assert lines[0] == "ragged.txt: half of each round trip, for both ways"
    text = " ".join(shown.stdout.split())
    assert "taken as lost, 1 step of up to 40 s as a pause of the sender (--longest-loss)." in text
    assert "Successive delays are correlated" in text
    assert "Recommended: play-out" in text
    assert "If no packet without a row was lost" in text
    assert "write them with --out TRACE.csv" in text


def test_law_what_is_printed_for_a_study_is_a_study_that_decide_calls_stable(
    ragged: Path, tmp_path: Path
) -> None:
    out = tmp_path / "oneway.csv"
    robots = tmp_path / "robots.toml"
    robots.write_text(ROBOTS)
    shown = run(ragged, "--round-trip", "--study", robots, "--out", out)
    assert shown.exit_code == 0, shown.output
    lines = re.search(r"\[network\]\n(?:.*\n)*?playout.*\n", shown.stdout)
    assert lines is not None
    assert 'trace = "oneway.csv"' in lines[0]
    stiffness = re.search(r"spring up to ([\d.]+) N/m", shown.stdout)
    assert stiffness is not None
    study = tmp_path / "study.toml"
    study.write_text(f"{ROBOTS}coupling.stiffness = {stiffness[1]}\n{lines[0]}")
    assert ts.decide(ts.Study.read(study)).is_stable
    answer = json.loads(run(ragged, "--round-trip", "--study", robots, "--json").stdout)
    session = ts.Study.read(study).session
    assert session.playout == "fixed"
    assert session.playout_delay == answer["recommended"]["delay"]
    # the trace written is the one judged: it gives the same answer, and the laboratory takes it
    again = json.loads(run(out, "--study", robots, "--json").stdout)
    assert again["playouts"] == answer["playouts"]
    assert again["ways"][0]["missing_rows"] is None
    experiment = ts.Study.read(study).experiment
    assert experiment is not None
    assert experiment.laboratory_on((out.read_text(), out.read_text())) is not None


def test_ref_half_a_round_trip_is_half_the_delay(ragged: Path) -> None:
    half = json.loads(run(ragged, "--round-trip", "--json").stdout)["ways"][0]["statistics"]
    whole = json.loads(run(ragged, "--json").stdout)["ways"][0]["statistics"]
    for key in ("median", "quantile_99", "maximum"):
        assert whole[key] == pytest.approx(2.0 * half[key], rel=1e-12)
    recorded = np.loadtxt(ragged, skiprows=1)[:, 2]
    assert whole["median"] == pytest.approx(1e-3 * float(np.median(recorded)))


def test_law_an_outage_names_the_guard(tmp_path: Path) -> None:
    time = 0.05 * np.arange(2000)
    delay = np.where((time > 40.0) & (time < 44.0), 44.0 - time + 0.03, 0.03)
    file = tmp_path / "outage.csv"
    file.write_text(ts.Trace(time, delay, losses_recorded=True).to_csv())
    shown = run(file)
    assert shown.exit_code == 0
    assert len(shown.stdout.splitlines()) <= 30
    text = " ".join(shown.stdout.split())
    assert "Recommended: play-out 30 ms, with the guard, at any stiffness up to 77760 N/m." in text
    assert "only what holds on any network is proven" in text
    assert 'strategy = "guard"' in text
    assert "allow_unusual = true" in text


def test_law_both_ways_of_irtt_are_judged(tmp_path: Path) -> None:
    trips = [
        {
            "lost": "false" if n % 50 else "true",
            "timestamps": {"client": {"send": {"wall": 0, "monotonic": 10_000_000 * n}}},
            "delay": {"rtt": 60_000_000, "send": 20_000_000, "receive": 40_000_000},
        }
        for n in range(1, 400)
    ]
    file = tmp_path / "irtt.json"
    file.write_text(json.dumps({"round_trips": trips}))
    both = json.loads(run(file, "--json").stdout)
    assert [way["statistics"]["median"] for way in both["ways"]] == [0.02, 0.04]
    half = json.loads(run(file, "--json", "--round-trip").stdout)
    assert [way["statistics"]["median"] for way in half["ways"]] == [0.03]
    shown = run(file)
    assert "Forward: 399 packets" in shown.stdout
    assert "Backward: 399 packets" in shown.stdout
    refused = run(file, "--out", tmp_path / "o.csv")
    assert refused.exit_code == 2
    assert "this file has both" in " ".join(refused.stderr.split())


def test_law_lines_for_a_study_name_what_was_judged() -> None:
    settings = ts.assess_trace(ts.Trace([0.01 * n for n in range(99)], [0.04] * 99)).settings()
    lines = study_lines(settings, "a.csv", is_round_trip=True, is_completed=False)
    assert lines == [
        "[network]",
        "delay = 0.04",
        'trace = {file = "a.csv", round_trip = true}',
        "[session]",
        'playout = {kind = "fixed", delay = 0.04}',
    ]


def test_law_refusals_name_what_to_do(ragged: Path, tmp_path: Path) -> None:
    table = tmp_path / "a.csv"
    for text, words in {
        "time,delay_ms\n0,1\n1,1\n": "Name the column time_s",
        "when,delay_ms\n0,1\n": "the first line names the columns",
        "time_s,rtt_ms\n0,1\n1,1\n": "--round-trip",
        "time_s,delay_s\n0,9\n1,9\n": "Record for longer",
        "": "the first line names the columns",
    }.items():
        table.write_text(text)
        refused = run(table)
        assert refused.exit_code == 2, text
        assert words in " ".join(refused.stderr.split()), text
    assert run(tmp_path / "none.csv").exit_code == 2
    assert run(tmp_path).exit_code == 2
    assert run(ragged, "--out", ragged).exit_code == 2
    assert run(ragged, "--figure", tmp_path / "a.txt").exit_code == 2
    assert run(ragged, "--longest-loss", "-1").exit_code == 2
    # a remedy that works
    table.write_text("time_s,rtt_ms\n" + "".join(f"{0.01 * n},20\n" for n in range(99)))
    assert run(table, "--round-trip").exit_code == 0


@pytest.mark.parametrize("ways", [1, 2])
def test_law_the_figure_has_all_curves_and_no_cut_text(ways: int, tmp_path: Path) -> None:
    random = np.random.default_rng(2)
    delay = 0.02 + random.gamma(2.0, 0.002, 500)
    delay[50:53] = math.nan
    one = ts.Trace(0.01 * np.arange(500), delay)
    found = ts.assess_trace(one if ways == 1 else (one, one.halved()))
    figure = draw_trace(found)
    figure.savefig(tmp_path / "trace.png")
    over_time, distribution, stiffness = figure.axes
    assert over_time.get_ylabel() == "Delay, ms"
    labels = [line.get_label() for line in distribution.get_lines()]
    assert labels[0] == "recorded"
    assert len(labels) == 1 + len(found.ways[0].fit.jitter)
    drawn = {str(line.get_label()) for line in stiffness.get_lines()}
    assert {"age in a range", "bounded varying delay", "any network", "recommended"} <= drawn
    box = figure.bbox
    for axes in figure.axes:
        drawn_box = axes.get_tightbbox()
        assert drawn_box is not None
        assert box.contains(*drawn_box.min)
        assert box.contains(*drawn_box.max)
