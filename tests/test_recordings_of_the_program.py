"""Recordings that the live program itself wrote, read and compared with its own summary."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import telespring as ts


@pytest.fixture(scope="module")
def demo(live_program: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], list[Path]]:
    """Return the summary of a demo of both sites, and its recordings."""
    folder = tmp_path_factory.mktemp("recordings")
    done = subprocess.run(
        [live_program, "demo", "--seconds", "4", "--delay", "0.03", "--record", str(folder)],
        capture_output=True,
        text=True,
        check=True,
        timeout=100,
    )
    return json.loads(done.stdout), sorted(folder.glob("*.mcap"))


def test_cross_recordings_say_what_the_program_says(demo: tuple[dict[str, Any], list[Path]]) -> None:
    summary, paths = demo
    recording = ts.merge_recordings(*paths)
    assert recording.status == "complete"
    found = ts.analyse_recording(recording)
    for said in summary["sites"]:
        side = recording.sides[said["side"]]
        values = found["session"][f"robot{said['side']}"]
        network = found["session"]["network"][f"robot{said['side']}"]
        assert side.missed == side.missing_ticks == 0
        assert len(side.ticks) == said["lateness"]["ticks"]
        columns = side.ticks.columns
        # The program measures while it leaves, too; on a busy machine a dataset bridges ticks left out.
        phases = np.isin(columns["phase"], ["running", "leaving", "ramping-in", "ramping-out"])
        own = np.column_stack([columns["own.position.x"], columns["own.position.y"]])[phases]
        target = np.column_stack([columns["target.position.x"], columns["target.position.y"]])[phases]
        assert np.nanmean(np.hypot(*(own - target).T)) == pytest.approx(said["te"], rel=0.02)
        assert values["tracking_error"] == pytest.approx(said["te"], rel=0.2)
        force = np.hypot(columns["commanded_force.x"], columns["commanded_force.y"])
        assert force.max() == pytest.approx(said["largest_force"], abs=1e-9)  # as the summary rounds
        assert columns["energy_given_out"][-1] == pytest.approx(said["energy"]["given_out"], abs=0.05)
        # The record has the age of the oldest sample in use, the summary that of the played instant.
        assert network["age"]["median"] == pytest.approx(said["age"]["median"], abs=0.003)
        assert side.summary is not None
        assert side.summary["side"] == said["side"]


def test_cross_two_sites_on_one_clock_have_one_time(demo: tuple[dict[str, Any], list[Path]]) -> None:
    """Both sites of a demo read the same clock: the common time must find that out."""
    recording = ts.merge_recordings(*demo[1])
    assert recording.clock is not None
    assert recording.clock.disagreement == 0.0
    time = recording.sides[2].time
    error = np.abs(recording.common_times(2, time) - time).max() * 1e-9
    assert error <= recording.clock.uncertainty
    assert recording.clock.uncertainty < 0.05


def test_cross_one_site_knows_where_the_other_was(demo: tuple[dict[str, Any], list[Path]]) -> None:
    """What the packets told of the other handle is where its own site saw it, but for the clocks' error."""
    both = ts.merge_recordings(*demo[1])
    alone = ts.read_recording(demo[1][0]).dataset()
    robot = 3 - both.first.side
    truth = both.sides[robot]
    own = np.column_stack([truth.ticks.columns["own.position.x"], truth.ticks.columns["own.position.y"]])
    seen = alone.sel(robot=robot)["position"].values
    # Both read one clock, which an interval of half a round trip lets be off by some 30 ms, at up to 0.5 m/s.
    times = both.first.time[0] * 1e-9 + alone["time"].values
    expected = np.column_stack([np.interp(times, truth.time * 1e-9, values) for values in own.T])
    known = np.isfinite(seen).all(axis=1)
    assert known.mean() > 0.5
    assert np.abs(seen - expected)[known].max() < 0.02


def test_cross_a_session_of_the_program_reproduces_itself(demo: tuple[dict[str, Any], list[Path]]) -> None:
    _, paths = demo
    if any(ts.read_recording(path).missed for path in paths):
        pytest.skip("this machine was too busy: the recording misses ticks")
    for files in (paths, paths[:1], paths[1:]):
        found = ts.replay(*files)
        assert found.is_reproduced
        for side in found.sides:
            assert side.is_coupled.sum() > 500
            assert side.numbers.force_rms > 0.1
            # the reader finds what the replay computes
            ticks = ts.read_recording(paths[side.side - 1]).sides[side.side].ticks
            # a simulated robot without a lag measures its force only where it let go by itself
            assert side.recording.has_measured_force == ticks.present["measured_force.x"].any()
            is_used = ticks.present["age"] & side.is_coupled
            assert np.array_equal(ticks.columns["age"][is_used], side.own.age[is_used])
            assert np.array_equal(ticks.columns["energy_given_out"], side.own.given_out)
            assert side.replayed.renewed == (len(side.recording.arrival_time) if len(files) == 2 else 0)
