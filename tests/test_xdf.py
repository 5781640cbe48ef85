"""Recordings of Lab Streaming Layer: the streams of a session, with the clock offsets of both."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import loadmat
from typer.testing import CliRunner

import telespring as ts
from drivers.lsl.bridge import CHANNELS
from drivers.telemetry import PHASES, WATCHDOGS
from made_xdf import MadeStream, write_xdf
from telespring.cli import app

# The words of the codes have one home in the stream and one in its reader.
from telespring.recording import xdf_file

pyxdf = pytest.importorskip("pyxdf", reason="pyxdf is not installed: make test installs it")

LABELS = [name for name, _ in CHANNELS]
PERIOD, SECONDS = 0.004, 12.0
#: What the clock of each site reads when the recorder's reads 0, s, and by how much it is faster.
CLOCKS = {1: (1000.0, 0.0), 2: (-350.0, 4e-5)}


def position(side: int, time: Any) -> Any:
    return 0.05 * np.stack([np.sin(2.0 * time + side), np.cos(time)], axis=-1)


def site_time(side: int, time: Any) -> Any:
    zero, drift = CLOCKS[side]
    return zero + time * (1.0 + drift)


def stream(side: int, *, scatter: float = 0.0, host: str = "", offsets: bool = True) -> MadeStream:
    """Return the stream of a site, with what a recorder measured of its clock every 2 s."""
    time = np.arange(0.0, SECONDS, PERIOD) + 0.001 * side
    values = np.full((len(time), len(LABELS)), math.nan)
    column = {label: i for i, label in enumerate(LABELS)}
    values[:, column["phase"]] = PHASES.index("running")
    values[:100, column["phase"]] = PHASES.index("consenting")
    values[:, column["watchdog"]] = WATCHDOGS.index("engaged")
    values[:, column["measured"]] = 1.0
    for i, axis in enumerate("xy"):
        values[:, column[f"position {axis}"]] = position(side, time)[:, i]
        values[:, column[f"velocity {axis}"]] = 0.0
        values[:, column[f"target position {axis}"]] = position(0, time)[:, i]
        values[:, column[f"force {axis}"]] = 100.0 * (position(3 - side, time) - position(side, time))[:, i]
    values[:, column["stiffness wanted"]] = 100.0
    values[:, column["stiffness in use"]] = 100.0
    values[:, column["interval"]] = PERIOD
    values[:, column["missed"]] = 3.0
    values[:, column["age"]] = 0.03
    rng = np.random.default_rng(side)
    measured = []
    for when in np.arange(0.0, SECONDS, 2.0) if offsets else ():
        own = site_time(side, when)
        measured.append((own, when - own + scatter * rng.uniform(-1.0, 1.0)))
    return MadeStream(
        f"telespring-{side}",
        site_time(side, time),
        values,
        LABELS,
        measured,
        host or f"host{side}",
        1.0 / PERIOD,
    )


def events(side: int) -> MadeStream:
    texts = ["session", "phase running", "mark condition soft", "mark trial 1", "mark trial end"]
    when = np.array([0.0, 0.4, 0.5, 1.0, 9.0])
    return MadeStream(f"telespring-{side}-events", site_time(side, when), texts)


def other() -> MadeStream:
    """Return a stream of something else, as EEG beside it would be."""
    return MadeStream("amplifier", np.arange(10.0), np.zeros((10, 2)), ["Cz", "Pz"])


def test_law_the_words_are_those_of_the_stream() -> None:
    assert xdf_file.PHASES == PHASES
    assert xdf_file.WATCHDOGS == WATCHDOGS


def test_law_both_sites_come_onto_one_clock(tmp_path: Path) -> None:
    path = write_xdf(tmp_path / "session.xdf", [other(), stream(1), events(1), stream(2)])
    recording = ts.read_recording(path)
    session = recording.dataset()
    assert [str(word) for word in session["source"].values] == ["recorded", "recorded"]
    # The dataset begins with site 1's first sample, at 1 ms of the recorder's clock.
    time = np.asarray(session["time"]) + 0.001
    for side in (1, 2):
        values = np.asarray(session["position"].sel(robot=side))
        known = np.isfinite(values).all(axis=1)
        assert known.mean() > 0.99
        assert np.abs(values - position(side, time))[known].max() < 2e-6
    assert recording.missed == 6
    # Each site's times stay those of its own clock.
    assert recording.sides[2].time[0] == round(1e9 * site_time(2, 0.002))


def test_cross_pyxdf_itself_puts_the_samples_at_the_same_times(tmp_path: Path) -> None:
    path = write_xdf(tmp_path / "session.xdf", [stream(1, scatter=1e-4), stream(2, scatter=1e-4)])
    recording = ts.read_recording(path)
    streams, _ = pyxdf.load_xdf(str(path), dejitter_timestamps=False)
    stamps = {int(each["info"]["name"][0][-1]): each["time_stamps"] for each in streams}
    ours = {side: recording.common_times(side, recording.sides[side].time) * 1e-9 for side in (1, 2)}
    apart = (ours[2] - ours[1]) - (stamps[2] - stamps[1])
    # Both fit a line to offsets that scatter by 0.1 ms; theirs is robust in another way.
    assert np.abs(apart).max() < 2e-4


def test_law_the_offsets_of_both_streams_are_kept(tmp_path: Path) -> None:
    path = write_xdf(tmp_path / "session.xdf", [stream(1), stream(2, scatter=2e-4), events(1)])
    done = CliRunner().invoke(
        app, ["analyse", str(path), "--out", str(tmp_path / "out"), "--no-figures", "--json"]
    )
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert [each["name"] for each in found["streams"]] == ["telespring-1", "telespring-2"]
    for each in found["streams"]:
        made = stream(each["side"], scatter=2e-4 if each["side"] == 2 else 0.0).offsets
        assert [(pair["time"], pair["offset"]) for pair in each["clock_offsets"]] == list(made)
        assert each["clock_offset"] == pytest.approx(-CLOCKS[each["side"]][0], abs=5e-4)
        assert each["host"] == f"host{each['side']}"
    assert found["streams"][0]["clock_scatter"] < 1e-9 < 1e-5 < found["streams"][1]["clock_scatter"]
    assert found["clock"]["uncertainty"] == pytest.approx(
        sum(each["clock_scatter"] for each in found["streams"])
    )
    assert found["clock"]["drift"] == pytest.approx(4e-5, abs=5e-5)
    assert any("states no bound" in warning for warning in found["warnings"])
    [trial] = found["trials"]
    assert (trial["label"], trial["condition"]) == ("1", "soft")
    assert trial["begin"] == pytest.approx(0.999, abs=0.01)
    assert trial["duration"] == pytest.approx(8.0, abs=0.02)
    assert trial["robot1"]["stiffness_mean"] == 100.0
    expected = np.hypot(*(position(1, np.arange(1.0, 9.0, 1e-3)) - position(0, np.arange(1.0, 9.0, 1e-3))).T)
    assert trial["robot1"]["tracking_error"] == pytest.approx(expected.mean(), rel=1e-3)


def test_law_an_offset_that_is_far_off_moves_nothing(tmp_path: Path) -> None:
    held_up = stream(2)
    offsets = list(held_up.offsets)
    offsets[3] = offsets[3][0], offsets[3][1] + 0.5
    held_up.offsets = offsets
    recording = ts.read_recording(write_xdf(tmp_path / "session.xdf", [stream(1), held_up]))
    session = recording.dataset()
    time = np.asarray(session["time"]) + 0.001
    values = np.asarray(session["position"].sel(robot=2))
    known = np.isfinite(values).all(axis=1)
    assert np.abs(values - position(2, time))[known].max() < 1e-5


def test_law_one_stream_is_one_site(tmp_path: Path) -> None:
    recording = ts.read_recording(write_xdf(tmp_path / "session.xdf", [stream(2, offsets=False)]))
    assert sorted(recording.sides) == [2]
    assert recording.clock is None
    assert recording.streams[2].clock.time.size == 0
    export = ts.export_bids(recording, tmp_path / "bids")
    assert export.missing == (1,)


def test_law_one_machine_needs_no_offsets(tmp_path: Path) -> None:
    both = [stream(side, offsets=False, host="one") for side in (1, 2)]
    both[1].stamps = both[1].stamps - site_time(2, 0.002) + site_time(1, 0.002)
    recording = ts.read_recording(write_xdf(tmp_path / "session.xdf", both))
    assert recording.clock is not None
    assert recording.clock.uncertainty == 0.0
    with pytest.raises(ts.InvalidInput, match="without clock offsets"):
        ts.read_recording(
            write_xdf(tmp_path / "two.xdf", [stream(1, offsets=False), stream(2, offsets=False)])
        )


def test_law_samples_left_out_are_counted(tmp_path: Path) -> None:
    thinned = stream(1)
    assert isinstance(thinned.samples, np.ndarray)
    kept = np.r_[0:200, 210:1000]
    thinned.stamps, thinned.samples = thinned.stamps[kept], thinned.samples[kept]
    recording = ts.read_recording(write_xdf(tmp_path / "session.xdf", [thinned]))
    assert recording.sides[1].missing_ticks == 10


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "no XDF file"),
        (b"XDF:", "no stream"),
        (b"XDF:" + b"\x01\xff\x02\x00garbage", "required"),
    ],
)
def test_law_what_is_no_recording_is_refused(tmp_path: Path, content: bytes, said: str) -> None:
    path = tmp_path / "session.xdf"
    path.write_bytes(content)
    with pytest.raises(ts.InvalidInput, match=said):
        ts.read_recording(path)


def test_law_streams_of_others_are_named(tmp_path: Path) -> None:
    path = write_xdf(tmp_path / "eeg.xdf", [other()])
    done = CliRunner().invoke(app, ["analyse", str(path), "--out", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert "amplifier" in done.output
    unlabelled = stream(1)
    unlabelled.labels = ["a"] * len(LABELS)
    with pytest.raises(ts.InvalidInput, match="telespring-1 without phase"):
        ts.read_recording(write_xdf(tmp_path / "bad.xdf", [unlabelled]))


def test_law_cut_files_never_crash(tmp_path: Path) -> None:
    whole = write_xdf(tmp_path / "session.xdf", [stream(1), events(1)]).read_bytes()
    path = tmp_path / "cut.xdf"
    for length in (5, 20, 300, 4000, len(whole) // 2, len(whole) - 3):
        path.write_bytes(whole[:length])
        try:
            recording = ts.read_recording(path)
        except ts.InvalidInput:
            continue
        assert len(recording.sides[1].time) > 0


def test_law_merge_and_replay_say_what_they_lack(tmp_path: Path) -> None:
    path = write_xdf(tmp_path / "session.xdf", [stream(1), stream(2)])
    with pytest.raises(ts.InvalidInput, match="two recordings of telespring-link"):
        ts.merge_recordings(path, path)
    with pytest.raises(ts.InvalidInput, match="needs the packets"):
        ts.replay(path)


def test_law_an_export_claims_no_bound(tmp_path: Path) -> None:
    path = write_xdf(tmp_path / "session.xdf", [stream(1), stream(2, scatter=2e-4)])
    recording = ts.read_recording(path)
    assert recording.clock is not None
    export = ts.export_bids(recording, tmp_path / "bids")
    [scans] = sorted(export.folder.glob("sub-robot1/ses-01/*_scans.tsv"))
    names, values = (line.split("\t") for line in scans.read_text("utf-8").splitlines())
    row = dict(zip(names, values, strict=True))
    assert row["clock_uncertainty"] == "n/a"
    assert float(row["clock_scatter"]) == pytest.approx(recording.clock.uncertainty)
    session = loadmat(ts.export_mat(recording, tmp_path / "s.mat"), simplify_cells=True)["session"]
    assert math.isnan(session["clock_uncertainty"])
    assert session["clock_scatter"] == pytest.approx(recording.clock.uncertainty)
