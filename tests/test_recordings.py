"""Recordings of live sessions: read, merged on one time base, and measured as a rehearsal is."""

from __future__ import annotations

import json
import re
import struct
import subprocess
import sys
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import telespring as ts
from made_recording import FIELDS, STUDY, MadeSession, SiteFile, message
from telespring.cli import app

# Recordings make it of what the sites know of each other's clock; here the true clocks are known.
from telespring.recording.common_time import MAX_DRIFT, ClockEstimates, common_time

# One home for the words of a rehearsal's dataset, with which a session's must agree.
from telespring.recording.reports import SIDE_REPORTS
from telespring.recording.signals import SIGNALS, TARGET
from telespring.rehearsal import encoding

if TYPE_CHECKING:
    from pathlib import Path

#: Two conditions with two trials each, marked at site 1.
MARKS = [
    (0.2, 1, "participant P1"),
    (0.2, 1, "condition soft"),
    (0.3, 1, "trial 1"),
    (0.8, 1, "trial 2"),
    (1.3, 1, "trial end"),
    (1.4, 1, "condition hard"),
    (1.5, 1, "trial 3"),
    (2.0, 1, "trial 4"),
    (2.5, 1, "trial end"),
]


@pytest.fixture(scope="module")
def made() -> MadeSession:
    return MadeSession(seconds=3.0, marks=MARKS, loss=0.02)


@pytest.fixture(scope="module")
def files(made: MadeSession, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return made.write(tmp_path_factory.mktemp("session"))


# One site


def test_law_a_recording_has_what_the_loop_saw(made: MadeSession, files: tuple[Path, Path]) -> None:
    recording = ts.read_recording(files[0])
    assert recording.status == "complete"
    assert recording.missed == 0
    [side] = recording.sides.values()
    times = np.arange(3000) * made.period
    assert np.array_equal(side.time, made.clock(1, times))
    columns = side.ticks.columns
    own = np.column_stack([columns["own.position.x"], columns["own.position.y"]])
    assert np.array_equal(own, made.position(1, times))
    force = np.column_stack([columns["commanded_force.x"], columns["commanded_force.y"]])
    assert np.array_equal(force, made.force(1, times))
    # What is not known is not zero.
    assert np.isnan(columns["age"][:40]).all()
    assert not side.ticks.present["age"][:40].any()
    assert np.array_equal(columns["age"][40:], np.full(2960, made.delay[1]))
    # Packets as they came, bit by bit: lost ones are not there.
    packets = side.packets
    sent = packets["sequence"].astype(int)
    assert 2800 < len(packets) < 2960
    assert np.array_equal(packets["motion"][:, :2], made.position(2, times)[sent])
    assert np.array_equal(packets["sent"], made.clock(2, times)[sent])
    assert side.partner_sessions == ("0x0000000000002222",)


def test_law_made_recordings_have_the_fields_of_the_page(root: Path) -> None:
    page = (root / "docs" / "recording.md").read_text(encoding="utf-8")
    for full, text in FIELDS.items():
        section = page.split(f"### `/siteSIDE/{full.split('.')[0]}`\n", 1)[1].split("\n###", 1)[0]
        kinds = "uint64|sint64|double|bool|string|bytes|Pair|HandleMotion"
        cells = re.findall(rf"^\| (`[^|]*) \| (?:{kinds}) \|", section, re.MULTILINE)
        named = [name for cell in cells for name in re.findall(r"`(\w+)`", cell)]
        assert sorted(named) == sorted(field.partition(":")[0].rstrip("?") for field in text.split())


def test_law_a_session_has_the_words_of_a_rehearsal(files: tuple[Path, Path]) -> None:
    known = {signal.name: signal for signal in (*encoding.SIGNALS, encoding.ACCOUNT, encoding.AGE)}
    for signal in SIGNALS:
        if signal.name in known:
            other = known.pop(signal.name)
            assert (signal.units, signal.long_name, signal.has_axes) == (
                other.units,
                other.long_name,
                other.has_axes,
            )
    # What a person means to do is not recorded live.
    assert set(known) == {"agent_force"}
    assert (TARGET.units, TARGET.long_name) == (encoding.TARGET.units, encoding.TARGET.long_name)
    reports = {report.name: report for report in encoding.SIDE_REPORTS}
    for report in SIDE_REPORTS:
        assert (report.units, report.long_name) == (
            reports[report.name].units,
            reports[report.name].long_name,
        )
    trials = ts.merge_recordings(*files).trials()
    assert trials["position"].dims == ("condition", "trial", "time", "robot", "axis")
    assert trials["target"].dims[-2:] == ("time", "axis")
    assert trials["age_mean"].dims == ("condition", "trial", "robot")


def test_law_what_one_site_does_not_know_is_not_invented(made: MadeSession, files: tuple[Path, Path]) -> None:
    session = ts.read_recording(files[0]).dataset()
    assert session["source"].values.tolist() == ["recorded", "received"]
    other = session.sel(robot=2)
    for name in ("coupling_force", "account", "age", "round_trip", "own_target"):
        assert np.isnan(other[name]).all(), name
    assert (other["phase"] == -1).all()
    # Its motion is that of the packets, wrong by what the clock was: 2 ms, at some 0.1 m/s.
    inside = session.sel(time=slice(0.1, 2.9))
    error = inside["position"].sel(robot=2).values - made.position(2, inside["time"].values)
    assert 1e-5 < np.abs(error).max() < 0.11 * 0.0021
    found = ts.analyse_recording(files[0])
    assert found["session"]["robot2"]["tracking_error"] is None
    assert found["session"]["robot2"]["interaction_force_rms"] is None
    assert found["session"]["robot1"]["tracking_error"] == pytest.approx(made.beside)
    assert found["experiment"] is None
    assert any("Only site 1" in warning for warning in found["warnings"])


def end_of_first_chunk(raw: bytes) -> int:
    place = 8
    while True:
        opcode, length = struct.unpack_from("<BQ", raw, place)
        place += 9 + length
        if opcode == 6:
            return int(place)


def test_law_a_recording_cut_anywhere_says_until_when_it_is_whole(
    made: MadeSession, files: tuple[Path, Path], tmp_path: Path
) -> None:
    raw = files[1].read_bytes()
    whole = ts.read_recording(files[1])
    path = tmp_path / "cut.mcap"
    seen = set()
    first = end_of_first_chunk(raw)
    for length in np.linspace(60, len(raw) - 1, 60).astype(int).tolist():
        path.write_bytes(raw[:length])
        if length < first:
            with pytest.raises(ts.InvalidInput, match=r"no tick|an MCAP file of"):
                ts.read_recording(path)
            continue
        recording = ts.read_recording(path)
        ticks = len(recording.first.ticks)
        seen.add(ticks)
        assert recording.status == "truncated"
        assert ticks % 500 == 0
        assert recording.whole_until == pytest.approx((ticks - 1) * made.period, rel=1e-3)
        assert recording.first.summary is None
        assert np.array_equal(recording.first.time, whole.first.time[:ticks])
    assert seen == {500 * count for count in range(1, 7)}
    found = ts.analyse_recording(path)
    assert "did not end its recording" in found["warnings"][0]
    killed = made.write_site(tmp_path, 2, end=False)
    assert ts.read_recording(killed).status == "truncated"


@pytest.mark.parametrize("seed", range(15))
def test_law_any_damage_is_read_or_refused(seed: int, tmp_path: Path) -> None:
    made = MadeSession(seconds=0.1, delay=(0.01, 0.01), marks=[(0.02, 1, "trial 1")], is_checked=False)
    path = made.write_site(tmp_path, 1)
    raw = np.frombuffer(path.read_bytes(), dtype=np.uint8).copy()
    rng = np.random.default_rng(seed)
    if seed % 3 == 0:
        begin = int(rng.integers(raw.size))
        raw[begin : begin + int(rng.choice([1, 8, 100]))] = rng.choice([0, 255])
    else:
        places = rng.integers(raw.size, size=int(rng.choice([1, 5, 30])))
        raw[places] = rng.integers(256, size=places.size)
    path.write_bytes(raw.tobytes())
    try:
        recording = ts.read_recording(path)
        json.dumps(ts.analyse_recording(recording), allow_nan=False)
    except ts.InvalidInput:
        return
    assert recording.first.side == 1


def test_law_missed_items_are_counted(tmp_path: Path) -> None:
    made = MadeSession(seconds=0.2)
    path = made.write_site(tmp_path, 1)
    file = SiteFile(tmp_path / "missed.mcap", 1, period=made.period, zero=0)
    tick, event = (message(full)[1] for full in ("tick.Tick", "event.Event"))
    for number in (0, 1, 2, 6, 7):
        made_tick = tick(
            tick=number, time=10**9 + number * 10**6, phase="running", unrecorded_arrivals=number
        )
        made_tick.commanded_force.x = made_tick.own.position.x = 0.0
        file.write("tick.Tick", made_tick)
    file.write("event.Event", event(time=10**9, event="recording-missed", cause="4"))
    file.flush()
    file.stream.close()
    side = ts.read_recording(tmp_path / "missed.mcap").first
    assert (side.missing_ticks, side.missed) == (3, 4 + 7)
    assert ts.read_recording(path).missed == 0


@pytest.mark.parametrize(
    ("change", "value"),
    [
        ({"format_version": "2", "program_version": "9.9.9"}, "format version 2"),
        ({"format_version": "one"}, "format version 'one'"),
        ({"side": "2"}, "site 1 of a recording of site 2"),
    ],
)
def test_law_another_version_or_site_is_refused(change: dict[str, str], value: str, tmp_path: Path) -> None:
    made = MadeSession(seconds=0.1, metadata={1: change})
    with pytest.raises(ts.InvalidInput) as refused:
        ts.read_recording(made.write_site(tmp_path, 1))
    assert value in refused.value.value
    if "program_version" in change:
        assert "9.9.9" in refused.value.remedy


def test_law_the_files_of_other_programs_are_refused(tmp_path: Path) -> None:
    from mcap.writer import Writer

    path = tmp_path / "other.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2", "rosbag")
        writer.finish()
    with pytest.raises(ts.InvalidInput, match="rosbag"):
        ts.read_recording(path)
    with pytest.raises(OSError, match=r"absent\.mcap"):
        ts.read_recording(tmp_path / "absent.mcap")
    with pytest.raises(ts.InvalidInput, match="path"):
        ts.read_recording(3)  # type: ignore[arg-type]


def test_law_a_dataset_is_as_dense_as_one_asks(files: tuple[Path, Path]) -> None:
    recording = ts.read_recording(files[0])
    dense, thin = recording.dataset(), recording.dataset(rate=100.0)
    assert len(thin["time"]) == 300
    xr.testing.assert_allclose(thin["position"], dense["position"].isel(time=slice(0, None, 10)))
    with pytest.raises(ts.InvalidInput, match="rate"):
        recording.dataset(rate=5000.0)


# Both sites


@pytest.mark.parametrize("drift", [-1e-4, 0.0, 5e-5])
def test_law_the_common_time_is_wrong_by_no_more_than_it_says(drift: float, tmp_path: Path) -> None:
    made = MadeSession(seconds=1.0, drift=drift)
    recording = ts.merge_recordings(*made.write(tmp_path))
    assert recording.clock is not None
    times = np.arange(1000) * made.period
    error = recording.common_times(2, made.clock(2, times)) - made.clock(1, times)
    assert np.abs(error).max() * 1e-9 <= recording.clock.uncertainty + 1e-8
    assert recording.clock.uncertainty <= 0.0051
    assert recording.clock.disagreement == 0.0
    assert (np.diff(recording.common_times(2, made.clock(2, times))) > 0).all()


def estimates(seconds: float, drift: float, noise: float, seed: int) -> tuple[Any, Any, Any, Any]:
    """Return what two sites know of each other: bounds that hold, about `noise` s wide."""
    rng = np.random.default_rng(seed)
    first = 10**12 + np.arange(0.0, seconds, 0.02) * 1e9
    difference = 5e15 + drift * (first - first[0])
    both = []
    for sign in (1.0, -1.0):
        error = noise * 1e9 * rng.uniform(0.5, 1.0, first.size)
        offset = sign * difference + rng.uniform(-1.0, 1.0, first.size) * error
        time = first if sign > 0.0 else first + difference
        both.append(
            ClockEstimates(*(np.rint(each).astype(np.int64) for each in (time, offset, np.ceil(error) + 2)))
        )
    return *both, first, first + difference


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("drift", [-1.5e-4, 2e-5])
def test_law_the_drift_is_found_and_the_bound_holds_over_a_long_session(drift: float, seed: int) -> None:
    one, other, first, second = estimates(300.0, drift, 0.004, seed)
    clock = common_time(one, other)
    assert clock is not None
    assert clock.drift == pytest.approx(drift, abs=5e-6)
    error = clock.to_first(np.rint(second).astype(np.int64)) - first
    assert np.abs(error).max() * 1e-9 <= clock.uncertainty
    # Better than one site alone would know.
    assert clock.uncertainty < 0.004
    assert clock.disagreement == 0.0


def test_law_a_clock_that_was_set_is_said(tmp_path: Path) -> None:
    # Site 2 believes in an offset 30 ms from that of site 1, and each in an error of 5 ms at most.
    made = MadeSession(seconds=1.0, believed=(0, 30_000_000))
    recording = ts.merge_recordings(*made.write(tmp_path))
    assert recording.clock is not None
    assert recording.clock.disagreement == pytest.approx(20e6, rel=0.01)
    found = ts.analyse_recording(recording)
    assert found["clock"]["disagreement"] == pytest.approx(0.02, rel=0.01)
    assert any("contradict" in warning for warning in found["warnings"])


def test_law_bounds_that_drift_apart_faster_than_clocks_do_contradict_each_other() -> None:
    one, other, _, _ = estimates(100.0, 5.0 * MAX_DRIFT, 0.004, 1)
    clock = common_time(one, other)
    assert clock is not None
    assert clock.disagreement > 0.0


def test_law_a_merged_file_is_both_files(files: tuple[Path, Path], tmp_path: Path) -> None:
    out = tmp_path / "session.mcap"
    merged = ts.merge_recordings(files[1], files[0], out)
    again = ts.read_recording(out)
    assert sorted(again.sides) == [1, 2]
    for side in (1, 2):
        one, other = merged.sides[side], again.sides[side]
        for kind in ("ticks", "arrivals", "events"):
            before, after = getattr(one, kind), getattr(other, kind)
            for name, values in before.columns.items():
                np.testing.assert_array_equal(values, after.columns[name], err_msg=name)
                np.testing.assert_array_equal(before.present[name], after.present[name])
        assert one.metadata == other.metadata
        assert one.study == other.study == STUDY
    xr.testing.assert_identical(merged.dataset(), again.dataset())
    # A viewer sees both on the common clock: the same instant of both within the uncertainty.
    assert merged.clock is not None
    shown = [again.sides[side].ticks.log_time.astype(np.int64) for side in (1, 2)]
    assert np.abs(shown[0] - shown[1]).max() <= merged.clock.uncertainty * 1e9 + 2
    with pytest.raises(ts.InvalidInput, match="merged file has both"):
        ts.merge_recordings(out, files[0])
    with pytest.raises(ts.InvalidInput, match="MCAP"):
        ts.merge_recordings(*files, tmp_path / "session.nc")


def test_cross_a_merged_file_is_what_another_reader_expects(files: tuple[Path, Path], tmp_path: Path) -> None:
    import zstandard
    from mcap.reader import make_reader
    from mcap.records import Chunk, MessageIndex
    from mcap.stream_reader import StreamReader

    out = tmp_path / "session.mcap"
    merged = ts.merge_recordings(*files, out)
    with out.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        topics = {channel.topic for channel in summary.channels.values()}
        assert topics == {f"/site{side}/{kind}" for side in (1, 2) for kind in ("tick", "arrival", "event")}
        # By the index of the chunks and of the messages, in the order of time: both sites alternate.
        stamps = []
        for _, channel, found in reader.iter_messages(topics=["/site1/tick", "/site2/tick"]):
            stamps.append((found.log_time, channel.topic))
        assert stamps == sorted(stamps, key=lambda stamp: stamp[0])
        assert len(stamps) == 6000
        assert {name for _, name in stamps[1000:1010]} == {"/site1/tick", "/site2/tick"}
        total = sum(
            len(getattr(side, kind))
            for side in merged.sides.values()
            for kind in ("ticks", "arrivals", "events")
        )
        assert summary.statistics.message_count == total
        assert {attachment.name for attachment in reader.iter_attachments()} == {
            "site1/study.toml",
            "site2/study.toml",
        }
        assert {metadata.name for metadata in reader.iter_metadata()} >= {"site1/telespring", "common time"}
    with out.open("rb") as stream:
        records = list(StreamReader(stream, validate_crcs=True).records)
    assert sum(type(record).__name__ == "Message" for record in records) == total
    # What the indices point to is that message.
    indexed, content = 0, b""
    with out.open("rb") as stream:
        for record in StreamReader(stream, emit_chunks=True).records:
            if isinstance(record, Chunk):
                content = zstandard.decompress(record.data, record.uncompressed_size)
            elif isinstance(record, MessageIndex):
                for log_time, place in record.records:
                    opcode, _, channel, _, stamp = struct.unpack_from("<BQHIQ", content, place)
                    assert (opcode, channel, stamp) == (5, record.channel_id, log_time)
                indexed += len(record.records)
    assert indexed == total


def test_law_files_of_two_sessions_are_refused(files: tuple[Path, Path], tmp_path: Path) -> None:
    made = MadeSession(seconds=0.3)
    other = made.write_site(tmp_path, 2)
    with pytest.raises(ts.InvalidInput, match="both of robot 2"):
        ts.merge_recordings(files[1], other)
    made.metadata = {2: {"session": "0x0000000000009999"}}
    stranger = made.write_site(tmp_path, 2)
    with pytest.raises(ts.InvalidInput) as refused:
        ts.merge_recordings(files[0], stranger)
    assert "0x0000000000009999" in refused.value.value
    assert "0x0000000000002222" in refused.value.value


def test_law_sites_of_two_studies_are_refused(
    files: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("made_recording.STUDY", STUDY + "# another\n")
    other = MadeSession(seconds=0.3, metadata={2: {"study": "second.toml"}}).write_site(tmp_path, 2)
    with pytest.raises(ts.InvalidInput) as refused:
        ts.merge_recordings(files[0], other)
    assert refused.value.field == "study"
    assert "second.toml" in refused.value.value


def test_law_sites_that_never_met_have_no_common_time(tmp_path: Path) -> None:
    made = MadeSession(seconds=0.3, delay=(5.0, 5.0))
    with pytest.raises(ts.InvalidInput, match="heard"):
        ts.merge_recordings(*made.write(tmp_path))


# What people did


def test_law_what_both_sites_are_told_counts_once(tmp_path: Path) -> None:
    """An order without a number goes to both sites, which hear it within milliseconds of each other."""
    marks = [(0.2 + 0.02 * side, side, f"participant P{side}") for side in (1, 2)]
    marks += [(0.21 + 0.02 * side, side, "trial 1") for side in (1, 2)]
    marks += [(0.6 + 0.02 * side, side, "trial end") for side in (1, 2)]
    found = ts.analyse_recording(ts.merge_recordings(*MadeSession(seconds=0.9, marks=marks).write(tmp_path)))
    assert [(trial["label"], trial["dyad"]) for trial in found["trials"]] == [("1", "P1 and P2")]


def test_law_a_session_is_measured_as_its_trials_are(made: MadeSession, files: tuple[Path, Path]) -> None:
    found = ts.analyse_recording(ts.merge_recordings(*files))
    assert [trial["label"] for trial in found["trials"]] == ["1", "2", "3", "4"]
    assert [trial["condition"] for trial in found["trials"]] == ["soft", "soft", "hard", "hard"]
    assert [trial["dyad"] for trial in found["trials"]] == ["P1"] * 4
    for trial in (found["session"], *found["trials"]):
        for robot, error, age in ((1, made.beside, made.delay[1]), (2, 2.0 * made.beside, made.delay[0])):
            values = trial[f"robot{robot}"]
            # Each against the target that its own person saw, so the clocks do not matter.
            assert values["tracking_error"] == pytest.approx(error, rel=1e-3)
            assert values["age_mean"] == pytest.approx(age)
            assert values["limited_share"] == pytest.approx(0.25, abs=0.01)
            assert values["stiffness_mean"] == pytest.approx(made.stiffness)
            begin = trial["begin"]
            times = np.arange(begin, begin + trial["duration"], made.period)
            force = np.linalg.norm(made.force(robot, times), axis=1)
            assert values["interaction_force_rms"] == pytest.approx(np.sqrt(np.mean(force**2)), rel=0.02)
            assert values["interaction_force_peak"] == pytest.approx(force.max(), rel=0.02)
    # The rehearsal's own tests of the conditions.
    rows = found["experiment"]["table1"]
    assert [row["condition"] for row in rows] == ["soft", "hard"]
    assert rows[0]["te1_mean"] == pytest.approx(1e3 * made.beside, rel=1e-3)
    assert found["session"]["network"]["robot1"]["loss"]["share"] == pytest.approx(made.loss, abs=0.01)
    assert json.loads(json.dumps(found, allow_nan=False)) == found


def test_law_a_trial_that_was_paused_counts_as_stopped(tmp_path: Path) -> None:
    made = MadeSession(
        seconds=2.0,
        marks=[(0.2, 1, "trial 1"), (1.0, 1, "trial 2"), (1.8, 1, "trial end")],
        paused=(0.5, 0.7),
    )
    recording = ts.merge_recordings(*made.write(tmp_path))
    found = ts.analyse_recording(recording)
    assert [trial["status"] for trial in found["trials"]] == ["stopped", "completed"]
    assert found["trials"][0]["robot1"]["tracking_error"] is None
    assert float(recording.trials()["ended_at"].values[0, 0]) == pytest.approx(0.3, abs=0.02)
    # The session as a whole has what there is: all but the pause.
    assert found["session"]["analysed"] == pytest.approx(1.4, abs=0.02)


def test_law_without_markers_a_session_is_one_trial(tmp_path: Path) -> None:
    found = ts.analyse_recording(ts.merge_recordings(*MadeSession(seconds=0.5).write(tmp_path)))
    assert found["trials"] == []
    assert found["experiment"] is None
    assert found["session"]["duration"] == pytest.approx(0.5, abs=0.01)


def test_law_a_session_whose_spring_never_acted_is_refused(tmp_path: Path) -> None:
    made = MadeSession(seconds=0.3, paused=(0.0, 1.0))
    with pytest.raises(ts.InvalidInput, match="spring"):
        ts.analyse_recording(made.write_site(tmp_path, 1))


# The commands


def run(*arguments: object) -> Any:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_law_the_commands_merge_and_analyse(files: tuple[Path, Path], tmp_path: Path) -> None:
    out = tmp_path / "session.mcap"
    merged = run("merge", *files, "--out", out)
    assert merged.exit_code == 0, merged.output
    assert "Common time" in merged.output
    result = run("analyse", out, "--out", tmp_path / "results")
    assert result.exit_code == 0, result.output
    for shown in ("tracking error", "Trials", "Conditions", "What happened", "Sites 1 and 2"):
        assert shown in result.output
    names = sorted(path.name for path in (tmp_path / "results").iterdir())
    assert names == ["analysis.json", "session.nc", "session.png", "session.svg", "table1.csv"]
    answered = run("analyse", out, "--out", tmp_path / "results", "--json", "--no-figures")
    written = json.loads((tmp_path / "results/analysis.json").read_text())
    assert json.loads(answered.output) == written
    # The dataset is one that the analysis of rehearsals reads.
    again = run(
        "analyse", tmp_path / "results/session.nc", "--out", tmp_path / "again", "--json", "--no-figures"
    )
    assert again.exit_code == 0, again.output
    te1 = [row["te1_mean"] for row in json.loads(again.output)["table1"]]
    assert te1 == pytest.approx([row["te1_mean"] for row in written["experiment"]["table1"]], rel=1e-3)


def test_law_the_commands_refuse_what_they_cannot_do(files: tuple[Path, Path], tmp_path: Path) -> None:
    for arguments in (
        ("merge", files[0], files[0], "--out", tmp_path / "x.mcap"),
        ("merge", *files, "--out", files[0]),
        ("merge", *files, "--out", tmp_path / "x.txt"),
        ("analyse", files[0], "--export", tmp_path / "x"),
        ("analyse", tmp_path / "absent.mcap"),
    ):
        result = run(*arguments)
        assert result.exit_code == 2, result.output
        assert not (tmp_path / "x.mcap").exists()


def test_law_texts_of_a_file_reach_no_terminal_as_they_are(tmp_path: Path) -> None:
    made = MadeSession(seconds=0.2, marks=[(0.1, 1, "note \x1b[2J[bold]gone[/bold]\x07")])
    result = run("analyse", made.write_site(tmp_path, 1), "--out", tmp_path / "o", "--no-figures")
    assert result.exit_code == 0, result.output
    assert "\x1b[2J" not in result.output
    assert "\x07" not in result.output
    assert "[bold]gone" in result.output


def test_law_recordings_load_only_when_they_are_asked_for() -> None:
    heavy = ("mcap", "google.protobuf", "lz4")
    code = f"import sys, telespring; sys.exit(any(name in sys.modules for name in {heavy}))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
