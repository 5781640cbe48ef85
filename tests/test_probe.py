"""`telespring probe`, with a stand-in for the live program: what it found is judged and shown."""

from __future__ import annotations

import json
import stat
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

import telespring as ts
from telespring import cli

#: Says its version, and otherwise what a probe says; writes the trace that it is asked for.
PROGRAM = """#!{python}
import json, sys
from pathlib import Path
if "--version" in sys.argv:
    print("telespring-link {version}")
    sys.exit()
found = json.loads(Path({found!r}).read_text())
trace = found.pop("trips")
print(json.dumps({{"type": "status", "stage": "waiting", "sent": 0, "packets": 9}}))
print(json.dumps({{"type": "status", "stage": "measuring", "sent": 5, "packets": 9}}))
if trace is not None:
    Path(sys.argv[sys.argv.index("--trace") + 1]).write_text(json.dumps({{"round_trips": trace}}))
if "end" in found:
    print(json.dumps({{"type": "summary", "trace": None, **found}}))
else:
    print("Nobody answered.", file=sys.stderr)
sys.exit({status})
"""
STUDY = """
robot1 = {axes = ["x", "y"], mass = [0.8334, 1.0649], damping = [7.7257, 10.1168]}
robot2 = {axes = ["x", "y"], mass = [0.7776, 1.3407], damping = [7.4208, 9.3496]}
coupling.stiffness = 100
network.delay = 0.05
"""
AGE = {
    "smallest": 0.02,
    "median": 0.02,
    "quantile_90": 0.02,
    "quantile_99": 0.021,
    "quantile_999": 0.03,
    "largest": 0.04,
}


def way(received: int, sent: int) -> dict[str, Any]:
    return {
        "sent": sent,
        "received": received,
        "lost_share": 1 - received / sent,
        "bursts": {"count": 1, "mean": 2.0, "longest": sent - received},
        "overtaken": 0,
        "age": AGE,
        "jitter": 0.001,
        "silences": 1,
        "longest_silence": 0.2,
    }


def trips(count: int, there: float, here: float) -> list[dict[str, Any]]:
    """Return what IRTT would write: every tenth packet got lost on the way back."""
    return [
        {
            "seqno": n,
            "lost": "true_down" if n % 10 == 9 else "false",
            "timestamps": {"client": {"send": {"monotonic": n * 10_000_000}}},
            "delay": {"send": int(there * 1e9)} | ({} if n % 10 == 9 else {"receive": int(here * 1e9)}),
        }
        for n in range(count)
    ]


def probe(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    found: dict[str, Any],
    *options: str | Path,
    status: int = 0,
) -> Result:
    (folder / "found.json").write_text(json.dumps(found))
    program = folder / "program"
    text = PROGRAM.format(
        python=sys.executable, version=ts.__version__, found=str(folder / "found.json"), status=status
    )
    program.write_text(text)
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("TELESPRING_LINK", str(program))
    runner = CliRunner(env={"COLUMNS": "100", "NO_COLOR": "1"})
    return runner.invoke(cli.app, ["probe", "site.toml", *map(str, options)])


def found(side: int, count: int = 3000) -> dict[str, Any]:
    return {
        "schema": 1,
        "end": "complete",
        "side": side,
        "study": STUDY,
        "seconds": count / 100,
        "rate": 100.0,
        "round_trip": {**AGE, "median": 0.05},
        "clock_error": 0.025,
        "towards_here": way(count - count // 10, count),
        "towards_partner": way(count, count),
        "strange": 0,
        "partner_runs_session": False,
        "paths": [{"time": 1.0, "event": "path-relayed"}],
        "trips": trips(count, 0.02, 0.04),
    }


def test_law_a_probe_is_judged_as_its_trace_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    trace = tmp_path / "path.json"
    for side in (1, 2):
        done = probe(tmp_path, monkeypatch, found(side), "--trace", trace, "--json")
        assert done.exit_code == 0, done.output
        said = json.loads(done.stdout)
        ways = (ts.read_trace(trace), ts.read_trace(trace, backward=True))
        assert (len(ways[0]), ways[0].lost.sum(), ways[1].lost.sum()) == (3000, 0, 300)
        # robot 1 is at this site, or at the partner's
        forward, backward = ways if side == 1 else ways[::-1]
        expected = ts.assess_trace((forward, backward), ts.Study.from_toml(STUDY))
        assert said["assessment"]["recommended"]["delay"] == expected.recommended.delay
        medians = [each["statistics"]["median"] for each in said["assessment"]["ways"]]
        assert medians == pytest.approx([0.02, 0.04] if side == 1 else [0.04, 0.02])
        assert said["trace"] == str(trace)
        assert said["why_no_assessment"] is None


def test_law_the_screen_says_both_ways_and_what_to_use(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    study = tmp_path / "study.toml"
    done = probe(tmp_path, monkeypatch, found(1), "--trace", tmp_path / "path.json", "--out-study", study)
    assert done.exit_code == 0, done.output
    text = " ".join(done.stdout.split())
    for part in (
        "3000 packets each way",
        "to the partner",
        "10 %",
        "Recommended: play-out",
        "path-relayed",
        "25 ms only",
    ):
        assert part in text, text
    assert max(map(len, done.stdout.splitlines())) <= 100
    assert ts.Study.read(study).has_stiffness
    assert ts.rehearse is not None


def test_law_what_is_not_known_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    one_way = found(1) | {"towards_partner": None, "end": "partner-silent", "trips": None}
    done = probe(tmp_path, monkeypatch, one_way, status=1)
    assert done.exit_code == 1
    assert "not known" in done.stdout
    assert "partner-silent" in done.stdout
    # too short to prove anything, but measured
    short = probe(tmp_path, monkeypatch, found(1, 200), "--json")
    assert short.exit_code == 0
    said = json.loads(short.stdout)
    assert said["assessment"] is None
    assert "at least 299 packets" in said["why_no_assessment"]
    assert said["towards_partner"]["received"] == 200


def test_law_refusals_name_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    nobody = probe(tmp_path, monkeypatch, {"trips": None}, status=1)
    assert nobody.exit_code == 1
    assert "Nobody answered." in nobody.stderr
    asked = probe(tmp_path, monkeypatch, found(1), "--out-study", tmp_path / "study.toml")
    assert asked.exit_code == 2
    assert "--trace" in asked.stderr
