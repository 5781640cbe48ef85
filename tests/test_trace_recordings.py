"""What a recording can prove, the files that are read, and the study that is written from it."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import telespring as ts
from telespring import cli
from telespring.rehearsal.preflight import TraceWarning, preflight_warnings
from telespring.rehearsal.traces import read_traces
from telespring.show.screens.rehearsal import preflight_sentence
from telespring.traces.silences import find_silences

ONE_AXIS = """
robot1 = {mass = [1.2], damping = [6.0], axes = ["x"]}
robot2 = {mass = [1.2], damping = [6.0], axes = ["x"]}
"""


def run(command: str, *arguments: str | Path) -> Result:
    runner = CliRunner(env={"COLUMNS": "80", "NO_COLOR": "1"})
    return runner.invoke(cli.app, [command, *map(str, arguments)])


def refusal(result: Result) -> str:
    assert result.exit_code == 2, result.output
    return " ".join(result.stderr.split())


def table(delays: list[float], *, period: float = 0.01, header: str = "time_s,delay_s") -> str:
    return header + "\n" + "".join(f"{period * n:.6f},{delay:.6f}\n" for n, delay in enumerate(delays))


def ping_log(count: int, *, interval: float = 0.02, lost: range = range(0), stamped: bool = True) -> str:
    """Write what `ping -D -O` would: round trips of 40 and 44 ms in turn, and nothing for some numbers."""
    lines = ["PING host (10.0.0.2) 56(84) bytes of data."]
    for number in range(1, count + 1):
        trip = 40 + 4 * (number % 2)
        time = 1_700_000_000.5 + interval * (number - 1)
        if number in lost:
            lines.append(f"[{time + interval:.6f}] no answer yet for icmp_seq={number}")
            continue
        stamp = f"[{time + 1e-3 * trip:.6f}] " if stamped else ""
        lines.append(f"{stamp}64 bytes from 10.0.0.2: icmp_seq={number} ttl=64 time={trip}.0 ms")
    lines += ["", "--- host ping statistics ---"]
    lines.append(f"{count} packets transmitted, {count - len(lost)} received, 1% packet loss, time 29980ms")
    return "\n".join(lines) + "\n"


def test_ref_the_least_number_of_packets_meets_what_befalls_one_in_a_hundred() -> None:
    # Wilks: the longest of n delays exceeds the quantile p with the probability 1 - p**n
    assert 0.99**299 < 0.05 < 0.99**298
    assert 0.999**2995 < 0.05 < 0.999**2994
    for packets, period, refused in (
        (298, 0.1, True),
        (299, 0.1, False),
        (999, 0.01, True),
        (1000, 0.01, False),
    ):
        trace = ts.Trace(period * np.arange(packets), np.full(packets, 0.03))
        if refused:
            with pytest.raises(ts.InvalidInput, match="at least 299 packets in 10 s"):
                ts.assess_trace(trace)
        else:
            assert "short" in ts.assess_trace(trace).ways[0].evidence.doubts


def test_cross_a_recording_misses_what_it_is_said_to_miss_once_in_twenty_times() -> None:
    evidence = ts.assess_trace(ts.Trace(0.05 * np.arange(3000), np.full(3000, 0.03))).ways[0].evidence
    assert evidence.doubts == ()
    assert evidence.packets == 3000
    assert evidence.duration == pytest.approx(150.0)
    random = np.random.default_rng(5)
    draws = 20_000
    hit = random.binomial(evidence.packets, evidence.missed_share, draws) == 0
    outages = random.poisson(evidence.duration / evidence.missed_every, draws) == 0
    for missed in (hit, outages):
        # four standard errors
        assert missed.mean() == pytest.approx(0.05, abs=4.0 * math.sqrt(0.05 * 0.95 / draws))
    assert evidence.missed_share == pytest.approx(3.0 / 3000, rel=0.002)


def test_law_a_short_or_slow_recording_is_named_on_the_screen_and_in_json(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text(table([0.03] * 400, period=0.2))
    answer = json.loads(run("trace", file, "--json").stdout)
    assert answer["ways"][0]["evidence"]["doubts"] == ["short", "slow"]
    assert answer["ways"][0]["evidence"]["missed_every"] == pytest.approx(80.0 / 2.9957, rel=1e-4)
    text = " ".join(run("trace", file).stdout.split())
    assert "correlated" not in text
    assert "It may miss an outage every 27 s, or 1 packet in 130 (risk 5 %): record longer." in text
    assert "Slow: what happens between two packets is unknown." in text
    file.write_text(table([0.0003] * 3000, period=0.05))
    assert "name it delay_s" in " ".join(run("trace", file).stdout.split())


def test_law_units_that_no_network_has_are_refused_and_the_remedy_works(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    right = [20.0, 22.0] * 600
    rows = [(20.0 * n, delay) for n, delay in enumerate(right)]

    def written(header: str, time: float = 1.0, delay: float = 1.0) -> Path:
        file.write_text(header + "\n" + "".join(f"{t * time},{d * delay}\n" for t, d in rows))
        return file

    remedied = json.loads(run("trace", written("time_ms,delay_ms"), "--json").stdout)
    best = remedied["recommended"]["delay"]
    assert best == pytest.approx(0.022)
    # ms in a column of s, both ways, and the same since 1970
    said = refusal(run("trace", written("time_ms,delay_s")))
    assert "name it delay_ms" in said
    assert "name it time_ms" in refusal(run("trace", written("time_s,delay_ms")))
    file.write_text("time_s,delay_ms\n" + "".join(f"{1.7e12 + t:.0f},{d}\n" for t, d in rows))
    assert "name it time_ms" in refusal(run("trace", file))
    file.write_text(file.read_text().replace("time_s", "time_ms"))
    assert json.loads(run("trace", file, "--json").stdout)["recommended"]["delay"] == best
    assert "name it time_us" in refusal(run("trace", written("time_s,delay_ms", time=1e3)))
    # s in a column of ms: the recording is short, or its delays are
    assert "name the column time_s" in refusal(run("trace", written("time_ms,delay_ms", time=1e-3)))
    short = run("trace", written("time_ms,delay_ms", delay=1e-3))
    assert "If the column is in s, name it delay_s." in " ".join(short.stdout.split())
    remedied = json.loads(run("trace", written("time_ms,delay_s", delay=1e-3), "--json").stdout)
    assert remedied["recommended"]["delay"] == best
    # what is right all the same
    assert run("trace", written("time_ms,delay_s", delay=0.15), "--allow-unusual").exit_code == 0
    # 250 s are beyond all that can be computed
    assert "such as delay_ms" in refusal(run("trace", written("time_ms,delay_s", delay=10.0)))
    assert "--round-trip" in refusal(run("trace", written("time_ms,delay_ms", delay=-1.0)))
    file.write_text("time_s,delay_ms\n12:00:01,20\n12:00:02,20\n")
    assert "in s since any moment" in refusal(run("trace", file))
    file.write_text("0.0,20\n0.1,20\n")
    assert "such as time_s,delay_ms" in refusal(run("trace", file))
    file.write_text("time_s,rtt\n0.0,20\n0.1,20\n")
    assert "rtt_ms" in refusal(run("trace", file, "--round-trip"))


def test_law_a_ping_is_read_as_a_round_trip_with_its_losses(tmp_path: Path) -> None:
    file = tmp_path / "ping.log"
    file.write_text(ping_log(1500, lost=range(700, 720)))
    shown = run("trace", file)
    assert shown.exit_code == 0, shown.output
    assert shown.stdout.startswith("ping.log: half of each round trip, for both ways")
    [way] = json.loads(run("trace", file, "--json").stdout)["ways"]
    # the last three were on their way: 44 ms are three intervals
    assert way["evidence"]["packets"] in (1498, 1499, 1500)
    assert way["missing_rows"] is None
    assert way["statistics"]["loss"] == pytest.approx(20 / 1500, rel=1e-2)
    assert (way["statistics"]["minimum"], way["statistics"]["maximum"]) == (0.02, 0.022)
    assert way["statistics"]["interval"] == pytest.approx(0.02, abs=1e-5)
    trace = ts.read_trace(file)
    assert ts.read_trace(file, round_trip=True) == trace
    lost = np.flatnonzero(trace.lost)
    assert (lost[0], lost[-1], lost.size) == (699, 718, 20)
    # without -D nothing says how often it was sent
    file.write_text(ping_log(1500, stamped=False))
    assert "ping -D -i 0.01 HOST" in refusal(run("trace", file))


def test_law_a_study_that_is_written_is_whole(tmp_path: Path) -> None:
    log, study = tmp_path / "net" / "ping.log", tmp_path / "study.toml"
    log.parent.mkdir()
    log.write_text(ping_log(1500, lost=range(700, 703)))
    shown = run("trace", log, "--robot", "1.2,6/1.4,7", "--robot", "2,9/2,9", "--out-study", study)
    assert shown.exit_code == 0, shown.output
    text = " ".join(shown.stdout.split())
    assert "telespring decide" in text
    assert "telespring rehearse" in text
    answer = json.loads(run("trace", log, "--robot", "1.2,6/1.4,7", "--robot", "2,9/2,9", "--json").stdout)[
        "recommended"
    ]
    written = ts.Study.read(study)
    assert written.dyad.robots[0].mass.tolist() == [1.2, 1.4]
    assert written.stiffness == answer["stiffness"] <= answer["recommended_stiffness"]
    assert written.session.playout_delay == answer["delay"]
    assert written.network.sample_period == 0.001
    decided = run("decide", study)
    assert decided.exit_code == 0, decided.output
    short = written.replace(protocol={"trials": 1, "duration": 4.0, "discard": 0.5})
    study.write_text(short.to_toml())
    assert preflight_warnings(short, tmp_path) == []
    trials = ts.rehearse(study, tmp_path / "out")
    assert (trials.status == 0).all()
    connected = trials.sel(condition=trials.condition != "UM")
    assert float(connected.age_mean.mean()) == pytest.approx(answer["delay"], abs=2e-3)


def test_law_with_the_guard_the_stiffness_of_the_study_stays() -> None:
    time = 0.02 * np.arange(1500)
    delay = np.where((time > 10.0) & (time < 14.0), 14.0 - time + 0.03, 0.03)
    trace = ts.Trace(time, delay)
    own = ts.Study.paper().replace(coupling={"stiffness": 300.0})
    found = ts.assess_trace(trace, own)
    assert found.needs_guard
    written = found.recommended_study("a.csv")
    assert (written.stiffness, written.session.strategy) == (300.0, "guard")
    assert written.experiment is not None
    assert [k for k, _ in written.experiment.conditions] == [None, 300.0]
    # without one it is what is proven
    free = ts.assess_trace(trace)
    assert free.recommended_study("a.csv").stiffness == free.stiffness
    # a bare spring gets what is proven for it, whatever the study says
    steady = ts.assess_trace(ts.Trace(time, np.full(1500, 0.03)), own)
    assert steady.recommended_study("a.csv").stiffness == steady.stiffness != 300.0


def test_law_a_study_needs_a_trace_that_records_its_losses(tmp_path: Path) -> None:
    file, out, study = tmp_path / "a.csv", tmp_path / "oneway.csv", tmp_path / "study.toml"
    rows = table([0.02] * 1500).splitlines()
    file.write_text("\n".join(rows[:400] + rows[405:]) + "\n")
    assert "Add --out TRACE.csv" in refusal(run("trace", file, "--out-study", study))
    assert not study.exists()
    assert run("trace", file, "--out-study", study, "--out", out).exit_code == 0
    experiment = ts.Study.read(study).experiment
    assert experiment is not None
    assert experiment.trace_files == ("oneway.csv", "oneway.csv")
    assert run("trace", file, "--out-study", file).exit_code == 2


def test_law_a_study_of_round_trips_says_so(tmp_path: Path) -> None:
    file, study = tmp_path / "rtt.csv", tmp_path / "study.toml"
    file.write_text(table([0.044] * 1500, header="time_s,rtt_s"))
    assert run("trace", file, "--round-trip", "--out-study", study).exit_code == 0
    written = ts.Study.read(study)
    assert written.delay == (0.022, 0.022)
    assert 'trace = {file = "rtt.csv", round_trip = true}' in study.read_text()
    experiment = written.experiment
    assert experiment is not None
    # without it the file is refused
    assert read_traces(experiment, tmp_path).laboratory(experiment) is not None
    # the way that was written by the command is one way
    assert (
        run("trace", file, "--round-trip", "--out-study", study, "--out", tmp_path / "a.csv").exit_code == 0
    )
    assert 'trace = {file = "a.csv", round_trip = false}' in study.read_text()


def test_law_robots_with_one_axis_are_judged(tmp_path: Path) -> None:
    file, robots, study = tmp_path / "a.csv", tmp_path / "robots.toml", tmp_path / "study.toml"
    file.write_text(table([0.02] * 1500))
    robots.write_text(ONE_AXIS)
    shown = run("trace", file, "--study", robots, "--out-study", study)
    assert shown.exit_code == 0, shown.output
    assert "telespring rehearse" not in shown.stdout
    assert "such as --robot 1.2,6/1.4,7" in shown.stdout
    lines = run("trace", file, "--robot", "1.2,6", "--robot", "2,9").stdout
    assert "such as --robot 1.2,6/1.4,7" in lines
    assert "[session]" not in lines
    found = ts.assess_trace(ts.read_trace(file), ts.Study.read(robots))
    written = ts.Study.read(study)
    assert written.stiffness == found.stiffness
    assert ts.decide(ts.Study.read(robots), 0.99 * found.recommended.usable_stiffness, 0.02).is_stable


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252"])
def test_law_a_study_reads_a_trace_in_every_encoding_that_the_command_reads(
    encoding: str, tmp_path: Path
) -> None:
    text = "time (µs);delay_ms\r\n0;20,5\r\n20000;21\r\n"
    (tmp_path / "a.csv").write_bytes(text.encode(encoding))
    study = ts.Study.paper().replace(network={"trace": "a.csv"})
    experiment = study.experiment
    assert experiment is not None
    read = read_traces(experiment, tmp_path)
    assert read.laboratory(experiment) is not None
    assert ts.read_trace(tmp_path / "a.csv").time.tolist() == [0.0, 0.02]
    (tmp_path / "a.csv").write_bytes(b"\x00\x01\x02\xff" * 20)
    for reader in (lambda: read_traces(experiment, tmp_path), lambda: ts.read_trace(tmp_path / "a.csv")):
        with pytest.raises(ts.InvalidInput, match="a text file is required"):
            reader()


def test_law_delays_of_conditions_beside_a_trace_are_warned_of() -> None:
    study = ts.Study.paper().replace(
        network={"trace": "a.csv"}, protocol={"stiffness": [40.0], "delay": [0.05, 0.08]}
    )
    for session, use, words in (
        ({}, "play-out", "(50 ms, 80 ms) say only when a motion is played"),
        ({"playout": {"kind": "fixed", "delay": 0.05}}, "none", "change nothing"),
        ({"playout": "adaptive"}, "none", "change nothing"),
    ):
        [warning] = preflight_warnings(study.replace(session=session))
        assert warning == TraceWarning((0.05, 0.08), use)  # type: ignore[arg-type]
        assert words in preflight_sentence(warning)
    one = study.replace(protocol={"delay": [0.05]})
    assert preflight_warnings(one) == []
    assert preflight_warnings(one.replace(session={"playout": {"kind": "fixed", "delay": 0.05}})) == []
    assert len(preflight_warnings(one.replace(session={"playout": {"kind": "fixed", "delay": 0.04}}))) == 1


def test_law_silences_are_those_of_a_session_over_the_recording() -> None:
    time = np.arange(3000) / 100
    delay = np.full(3000, 0.02)
    delay[1000:1020] = math.nan  # 0.2 s and a step without a packet
    delay[2000] = 0.5  # overtaken: no silence
    way = ts.assess_trace(ts.Trace(time, delay)).ways[0]
    assert (way.silences.count, way.silences.limit) == (1, 0.15)
    assert way.silences.longest == pytest.approx(0.201, abs=1e-9)
    assert way.silences.share == pytest.approx(0.051 / 30.0, rel=1e-9)
    # a step of the sender that is a pause tells nothing of the network
    paused = ts.Trace(np.concatenate([time[:1500], time[1500:] + 20.0]), np.full(3000, 0.02))
    assert ts.assess_trace(paused).ways[0].silences.count == 0


def test_law_a_network_that_is_gone_at_an_end_of_the_recording_is_silent_there() -> None:
    time = 0.01 * np.arange(2000)
    # every packet takes 0.3 s: those that came before 15 s keep the first silence shorter
    for gone, longest in ((time >= 15.0, 4.7), (time < 2.0, 2.0), (time < 0.0, 0.01)):
        found = find_silences(ts.Trace(time, np.where(gone, np.nan, 0.3)), 0.01)
        assert found.count == (longest > 0.15)
        assert found.longest == pytest.approx(longest, abs=0.02)
        assert found.share == pytest.approx(max(0.0, longest - 0.15) / 20.0, abs=0.001)


def test_law_a_recorded_silence_is_on_the_screen_and_in_json(tmp_path: Path) -> None:
    path = tmp_path / "trace.csv"
    rows = [f"{n / 100},{'' if 1000 <= n < 1040 else 0.02}" for n in range(3000)]
    path.write_text("time_s,delay_s\n" + "\n".join(rows))
    shown = run("trace", str(path)).stdout
    assert "Nothing comes for 150 ms or more once, 401 ms at the longest" in " ".join(shown.split())
    silences = json.loads(run("trace", str(path), "--json").stdout)["ways"][0]["silences"]
    assert silences["count"] == 1
