"""Networks of a study as Python sees them: old places of keys, and recorded traces in a rehearsal."""

from __future__ import annotations

from pathlib import Path

import pytest

import telespring as ts
from telespring.rehearsal.run import run_protocol

STUDY = """
name = "recorded"
robot1 = {mass = [0.8, 1.0], damping = 7.7}
robot2 = {mass = [0.8, 1.0], damping = 7.7}
coupling.stiffness = 40
network = {delay = 0.05, trace = {file = "ping.csv", round_trip = true}}
protocol = {unconnected = false, stiffness = [40], delay = [0.05], trials = 1, duration = 2.0, discard = 0.5}
"""


def test_law_a_key_at_its_old_place_warns_and_says_the_same() -> None:
    plain = ts.Study.paper()
    with pytest.warns(FutureWarning, match=r"laboratory\.loss is now network\.loss"):
        old = plain.replace(laboratory={"loss": 0.1})
    assert old == plain.replace(network={"loss": 0.1})
    with pytest.warns(FutureWarning, match=r"laboratory\.jitter is now network\.jitter"):
        read = ts.Study.from_toml(
            "laboratory.jitter = 0.01\n" + plain.to_toml().replace("jitter = 0.0  # s\n", "")
        )
    assert read == plain.replace(network={"jitter": 0.01})
    assert read.experiment is not None
    assert read.experiment.settings.jitter == 0.01
    assert read.network is not None
    assert read.network.jitter == 0.01


def test_law_a_rehearsal_plays_the_recorded_trace_and_remembers_it(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(STUDY)
    with pytest.raises(FileNotFoundError, match="ping"):
        run_protocol(file, tmp_path / "out")
    trace = tmp_path / "ping.csv"
    trace.write_text("time_s,delay_ms\n0,20\n1,20\n")
    punctual = ts.rehearse(file, tmp_path / "punctual").position.values
    # half of 90 ms is in time for 50 ms, too; half of 400 ms is not, wherever in the trace a trial begins
    trace.write_text("time_s,delay_ms\n0,20\n1,90\n")
    assert (ts.rehearse(file, tmp_path / "in time").position.values == punctual).all()
    trace.write_text("time_s,delay_ms\n0,20\n1,400\n")
    late = ts.rehearse(file, tmp_path / "late").position.values
    assert (late != punctual).any(axis=(2, 3, 4)).all()
    # the same folder is not continued on another trace
    trace.write_text("time_s,delay_ms\n0,20\n1,20\n")
    with pytest.raises(ts.InvalidInput, match="another"):
        ts.rehearse(file, tmp_path / "late")
    trace.write_text("time_s,delay\n0,20\n1,20\n")
    with pytest.raises(ts.InvalidInput, match="unit of delay"):
        ts.rehearse(file, tmp_path / "other")
