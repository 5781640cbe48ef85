"""Motion-BIDS datasets: what the specification asks, and what two people recorded together need."""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import telespring as ts
from made_recording import MadeSession
from telespring.cli import app

VALIDATOR = shutil.which(
    "bids-validator-deno", path=os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
)
needs_validator = pytest.mark.skipif(
    VALIDATOR is None, reason="bids-validator-deno is not installed: make oracles installs it"
)
MARKS = [
    (0.2, 1, "participant P-1"),
    (0.2, 2, "participant P2"),
    (0.2, 1, "condition soft"),
    (0.3, 1, "trial 1"),
    (0.8, 1, "trial end"),
    (1.0, 1, "trial 2"),
    (1.4, 1, "trial end"),
]


@pytest.fixture(scope="module")
def made() -> MadeSession:
    return MadeSession(seconds=1.6, marks=MARKS)


@pytest.fixture(scope="module")
def recording(made: MadeSession, tmp_path_factory: pytest.TempPathFactory) -> ts.SessionRecording:
    return ts.merge_recordings(*made.write(tmp_path_factory.mktemp("session")))


@pytest.fixture(scope="module")
def dataset(
    recording: ts.SessionRecording, root: Path, tmp_path_factory: pytest.TempPathFactory
) -> ts.BidsExport:
    """Return the export of a session to a dataset that has recorded trials, too."""
    folder = tmp_path_factory.mktemp("bids") / "dataset"
    export = ts.export_bids(recording, folder)
    ts.export_bids(root / "examples" / "trials", folder, session="02", participants=["P1", "P3"])
    return export


def table(path: Path) -> list[dict[str, str]]:
    """Read a table with a reader that shares no code with the writer."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def samples(motion: Path) -> dict[str, np.ndarray[Any, Any]]:
    names = [row["name"] for row in table(Path(str(motion).replace("_motion.tsv", "_channels.tsv")))]
    values = np.genfromtxt(motion, delimiter="\t", missing_values="n/a")
    assert values.shape[1] == len(names)
    return dict(zip(names, values.T, strict=True))


def issues(folder: Path) -> list[dict[str, Any]]:
    """Return what the validator says of all lines; it brings the rules with it and needs no network."""
    assert VALIDATOR is not None
    done = subprocess.run(
        [VALIDATOR, "--format", "json", "--max-rows", "-1", str(folder)],
        capture_output=True,
        text=True,
        check=False,
        timeout=110,
    )
    found: list[dict[str, Any]] = json.loads(done.stdout)["issues"]["issues"]
    return found


#: What only who recorded knows, and what does not apply; docs/how-to/recordings-to-bids.md says which.
ONLY_RECOMMENDED = {
    ("NO_AUTHORS", "Authors"),
    ("TOO_FEW_AUTHORS", None),
    ("JSON_KEY_RECOMMENDED", "License"),
    ("JSON_KEY_RECOMMENDED", "HEDVersion"),
    ("JSON_KEY_RECOMMENDED", "SourceDatasets"),
    ("SIDECAR_KEY_RECOMMENDED", "Manufacturer"),
    ("SIDECAR_KEY_RECOMMENDED", "ManufacturersModelName"),
    ("SIDECAR_KEY_RECOMMENDED", "DeviceSerialNumber"),
    ("SIDECAR_KEY_RECOMMENDED", "InstitutionName"),
    ("SIDECAR_KEY_RECOMMENDED", "InstitutionAddress"),
    ("SIDECAR_KEY_RECOMMENDED", "InstitutionalDepartmentName"),
    ("SIDECAR_KEY_RECOMMENDED", "Instructions"),
    ("SIDECAR_KEY_RECOMMENDED", "StimulusPresentation"),
}


def check_valid(folder: Path) -> None:
    """Check that the validator finds no error, and that its warnings are those of the how-to."""
    found = issues(folder)
    assert [issue for issue in found if issue["severity"] == "error"] == []
    assert {(issue["code"], issue.get("subCode")) for issue in found} == ONLY_RECOMMENDED


@needs_validator
def test_cross_the_validator_of_bids_finds_no_error(dataset: ts.BidsExport) -> None:
    check_valid(dataset.folder)


@needs_validator
def test_cross_what_the_how_to_says_ends_the_warnings(dataset: ts.BidsExport, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(dataset.folder, copy)
    keys = {key for code, key in ONLY_RECOMMENDED if code == "SIDECAR_KEY_RECOMMENDED" and key}
    told = dict.fromkeys(keys - {"StimulusPresentation"}, "as it was")
    (copy / "task-coupled_motion.json").write_text(json.dumps(told), "utf-8")
    program = {"SoftwareName": "the task", "SoftwareVersion": "1"}
    (copy / "task-coupled_events.json").write_text(json.dumps({"StimulusPresentation": program}), "utf-8")
    file = copy / "dataset_description.json"
    described = json.loads(file.read_text("utf-8")) | {"Authors": ["A. One", "B. Two"], "License": "CC0"}
    file.write_text(json.dumps(described), "utf-8")
    left = {issue.get("subCode") for issue in issues(copy)}
    assert left == {"SourceDatasets", "HEDVersion"}


@needs_validator
def test_cross_the_validator_takes_uneven_times_and_other_devices(
    recording: ts.SessionRecording, tmp_path: Path
) -> None:
    check_valid(ts.export_bids(uneven_trial(tmp_path)[0], tmp_path / "uneven").folder)
    with_other_devices(tmp_path / "bids")
    ts.export_bids(recording, tmp_path / "bids")
    errors = [issue for issue in issues(tmp_path / "bids") if issue["severity"] == "error"]
    # The made recording of the other device is no whole one; what telespring wrote beside it is right.
    assert [issue for issue in errors if "eeg" not in issue["location"]] == []


def test_law_the_how_to_judges_every_warning(root: Path) -> None:
    text = (root / "docs" / "how-to" / "recordings-to-bids.md").read_text("utf-8")
    missing = [key for code, key in ONLY_RECOMMENDED if f"`{key or code}`" not in text]
    assert missing == []


@needs_validator
def test_law_the_validator_would_find_a_fault(dataset: ts.BidsExport, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(dataset.folder, copy)
    [channels, *_] = sorted(copy.rglob("*_channels.tsv"))
    channels.write_text(channels.read_text("utf-8").replace("POS", "POSITION"), encoding="utf-8")
    assert any(issue["severity"] == "error" for issue in issues(copy))


def test_law_both_people_have_the_same_instants(made: MadeSession, dataset: ts.BidsExport) -> None:
    assert [file.name for file in dataset.files] == [
        f"sub-{code}_ses-01_task-coupled_tracksys-robot_run-01_motion.tsv" for code in ("P1", "P2")
    ]
    first, second = (samples(file) for file in dataset.files)
    count = len(first["position_x"])
    assert count == len(second["position_x"])
    # What each robot did at the same true time, to what the clocks leave uncertain.
    time = np.arange(count) * made.period
    [row] = table(dataset.folder / "sub-P2" / "ses-01" / "sub-P2_ses-01_scans.tsv")
    fastest = 2.0
    error = float(row["clock_uncertainty"]) * fastest
    assert 0.0 < error < 0.02
    for number, one in ((1, first), (2, second)):
        expected = made.position(number, time)
        for axis in range(2):
            values = one[f"position_{'xy'[axis]}"]
            known = np.isfinite(values)
            assert known.mean() > 0.98
            assert np.abs(values - expected[:, axis])[known].max() < error + 1e-4


def test_law_both_people_point_at_each_other(recording: ts.SessionRecording, dataset: ts.BidsExport) -> None:
    rows = {}
    for code in dataset.people:
        [rows[code]] = table(dataset.folder / f"sub-{code}" / "ses-01" / f"sub-{code}_ses-01_scans.tsv")
    for code, other in (("P1", "P2"), ("P2", "P1")):
        row = rows[code]
        prefix, partner = row["concurrent_with"].split("::")
        assert prefix == "bids"
        assert (dataset.folder / partner).is_file()
        assert partner == f"sub-{other}/ses-01/{rows[other]['filename']}"
        assert row["dyad"] == "P1+P2"
        assert row["robot"] == code[1]
        for name in ("acq_time", "duration", "dyad", "clock_uncertainty"):
            assert row[name] == rows[other][name]
    assert recording.clock is not None
    assert float(rows["P1"]["clock_uncertainty"]) == pytest.approx(recording.clock.uncertainty)


def test_law_trials_are_events_of_the_one_run(dataset: ts.BidsExport) -> None:
    for motion in dataset.files:
        events = table(Path(str(motion).replace("_motion.tsv", "_events.tsv")))
        trials = [event for event in events if event["trial_type"] == "trial"]
        assert [event["value"] for event in trials] == ["1", "2"]
        assert [float(event["onset"]) for event in trials] == pytest.approx([0.3, 1.0], abs=0.01)
        assert [float(event["duration"]) for event in trials] == pytest.approx([0.5, 0.4], abs=0.01)
        assert {event["condition"] for event in trials} == {"soft"}
        assert {float(event["stiffness"]) for event in trials} == {100.0}
        assert [float(event["onset"]) for event in events] == sorted(float(e["onset"]) for e in events)


def test_law_sidecars_count_what_is_there(dataset: ts.BidsExport) -> None:
    for motion in dataset.folder.rglob("*_motion.tsv"):
        sidecar = json.loads(motion.with_suffix(".json").read_text("utf-8"))
        rows = table(Path(str(motion).replace("_motion.tsv", "_channels.tsv")))
        for kind in ("POS", "VEL", "MISC"):
            assert sidecar[f"{kind}ChannelCount"] == sum(row["type"] == kind for row in rows)
        lines = motion.read_text("utf-8").splitlines()
        assert sidecar["RecordingDuration"] == pytest.approx(len(lines) / sidecar["SamplingFrequency"])
        assert all(row["name"] != "name" for row in rows)


def uneven_trial(folder: Path) -> tuple[Path, np.ndarray[Any, Any]]:
    """Write a trial whose clock was uneven, and return its folder and its times."""
    random = np.random.default_rng(1)
    time = np.cumsum(0.01 * (1.0 + 0.8 * random.uniform(-1.0, 1.0, 400)))
    time = np.round(time - time[0], 6)
    motion = 0.05 * np.sin(2.0 * time)
    place = folder / "uneven-trial"
    place.mkdir()
    names = [f"position_robot{robot}_{axis}_m" for robot in (1, 2) for axis in "xy"]
    header = ",".join(["time_s", *names, "target_x_m", "target_y_m"])
    np.savetxt(
        place / "one.csv", np.column_stack([time, *6 * [motion]]), "%.9f", ",", header=header, comments=""
    )
    (place / "trials.csv").write_text("file,stiffness_N_per_m,delay_s,trial\none.csv,50,0.1,1\n", "utf-8")
    return place, time


def test_law_each_sample_has_its_time(made: MadeSession, tmp_path: Path) -> None:
    folder, time = uneven_trial(tmp_path)
    for motion in ts.export_bids(folder, tmp_path / "uneven").files:
        found = samples(motion)
        # The number of a line does not say its time here, so that the times stand beside.
        assert found["latency"] == pytest.approx(time, abs=1e-9)
        assert found["position_x"] == pytest.approx(0.05 * np.sin(2.0 * time), abs=1e-8)
        sidecar = json.loads(motion.with_suffix(".json").read_text("utf-8"))
        assert sidecar["LATENCYChannelCount"] == 1
        mean = (len(time) - 1) / time[-1]
        assert sidecar["SamplingFrequencyEffective"] == pytest.approx(mean, rel=1e-9)
    # Elsewhere line n is at n periods by both frequencies, whatever a site's clock did.
    recording = ts.merge_recordings(*made.write(tmp_path))
    for rate in (None, 100.0):
        for motion in ts.export_bids(recording, tmp_path / f"at{rate}", rate=rate).files:
            sidecar = json.loads(motion.with_suffix(".json").read_text("utf-8"))
            assert sidecar["SamplingFrequency"] == sidecar["SamplingFrequencyEffective"] == (rate or 1000.0)
            assert sidecar["TickFrequency"] == pytest.approx(1000.0, rel=1e-3)
            assert "latency" not in samples(motion)


def test_law_a_trial_of_its_own_is_a_run(root: Path, dataset: ts.BidsExport) -> None:
    listed = table_of_trials(root)
    there = sorted((dataset.folder / "sub-P3" / "ses-02" / "motion").glob("*_motion.tsv"))
    assert len(there) == len(listed)
    first = listed[0]
    values = np.genfromtxt(root / "examples" / "trials" / first["file"], delimiter=",", names=True)
    motion = there_of(dataset.folder, "P1", first)
    assert samples(motion)["position_x"] == pytest.approx(values["position_robot1_x_m"], rel=1e-9)


def table_of_trials(root: Path) -> list[dict[str, str]]:
    with (root / "examples" / "trials" / "trials.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def there_of(folder: Path, code: str, row: dict[str, str]) -> Path:
    """Find the run of a trial by what its events say."""
    for events in sorted((folder / f"sub-{code}" / "ses-02" / "motion").glob("*_events.tsv")):
        [event] = table(events)
        stiffness = row["stiffness_N_per_m"] or "n/a"
        same = event["stiffness"] == stiffness or (
            "n/a" not in (event["stiffness"], stiffness) and float(event["stiffness"]) == float(stiffness)
        )
        if same and event["value"] == row["trial"] and float(event["delay"]) == float(row["delay_s"]):
            return Path(str(events).replace("_events.tsv", "_motion.tsv"))
    raise AssertionError(row)


def test_law_nothing_that_is_there_is_replaced(recording: ts.SessionRecording, tmp_path: Path) -> None:
    first = ts.export_bids(recording, tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(ts.InvalidInput, match="has motion of this session already"):
        ts.export_bids(recording, tmp_path)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
    (tmp_path / "participants.tsv").write_text("participant_id\tage\nsub-P1\t44\nsub-P2\tn/a\n", "utf-8")
    ts.export_bids(recording, tmp_path, session="02", participants=["P1", "P9"])
    people = table(tmp_path / "participants.tsv")
    assert people[0] == {"participant_id": "sub-P1", "age": "44"}
    assert [row["participant_id"] for row in people] == ["sub-P1", "sub-P2", "sub-P9"]
    assert all(path.read_bytes() == before[path] for path in first.files)
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".unfinished")]
    other = tmp_path.parent / "other"
    other.mkdir()
    (other / "thesis.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(ts.InvalidInput, match="an empty or new folder"):
        ts.export_bids(recording, other)


def with_other_devices(folder: Path) -> None:
    """Make a dataset that another program began: somebody else's and P1's EEG."""
    for label in ("P1", "P8"):
        (folder / f"sub-{label}" / "ses-01" / "eeg").mkdir(parents=True)
    (folder / "sub-P1" / "ses-01" / "eeg" / "sub-P1_ses-01_task-coupled_eeg.edf").write_bytes(b"EEG")
    (folder / "dataset_description.json").write_text('{"Name": "EEG", "BIDSVersion": "1.9.0"}', "utf-8")
    scans = folder / "sub-P1" / "ses-01" / "sub-P1_ses-01_scans.tsv"
    scans.write_text("filename\tquality\neeg/sub-P1_ses-01_task-coupled_eeg.edf\tgood\n", "utf-8")
    scans.with_suffix(".json").write_text('{"quality": {"Description": "as seen"}}', "utf-8")


def test_law_motion_goes_beside_what_other_devices_recorded(
    recording: ts.SessionRecording, tmp_path: Path
) -> None:
    with_other_devices(tmp_path)
    export = ts.export_bids(recording, tmp_path)
    inside = tmp_path / "sub-P1" / "ses-01"
    assert (inside / "eeg" / "sub-P1_ses-01_task-coupled_eeg.edf").read_bytes() == b"EEG"
    [eeg, motion] = table(inside / "sub-P1_ses-01_scans.tsv")
    assert (eeg["quality"], eeg["acq_time"], eeg["robot"]) == ("good", "n/a", "n/a")
    assert tmp_path / "sub-P1" / "ses-01" / motion["filename"] == export.files[0]
    assert (motion["quality"], motion["robot"]) == ("n/a", "1")
    described = json.loads((inside / "sub-P1_ses-01_scans.json").read_text("utf-8"))
    assert set(described) == set(eeg)
    # The first list of people has all of them, as BIDS asks.
    people = [row["participant_id"] for row in table(tmp_path / "participants.tsv")]
    assert people == ["sub-P1", "sub-P2", "sub-P8"]
    assert json.loads((tmp_path / "dataset_description.json").read_text("utf-8"))["Name"] == "EEG"


@pytest.mark.parametrize("file", ["participants.tsv", "sub-P1/ses-01/sub-P1_ses-01_scans.json"])
def test_law_lists_that_cannot_be_read_are_refused(
    recording: ts.SessionRecording, tmp_path: Path, file: str
) -> None:
    with_other_devices(tmp_path)
    (tmp_path / file).write_bytes("participant_id\tplace\nsub-P8\tZürich\n".encode("latin-1"))
    with pytest.raises(ts.InvalidInput, match="as BIDS asks"):
        ts.export_bids(recording, tmp_path)
    assert not list(tmp_path.rglob("motion"))


def test_law_a_date_can_be_hidden(made: MadeSession, tmp_path: Path) -> None:
    recording = ts.merge_recordings(*made.write(tmp_path))
    texts = []
    for hide in (False, True):
        export = ts.export_bids(recording, tmp_path / str(hide), hide_date=hide)
        [row] = table(export.folder / "sub-P1" / "ses-01" / "sub-P1_ses-01_scans.tsv")
        texts.append(row["acq_time"])
    assert texts[1].startswith("1900-01-01T")
    assert texts[0][10:] == texts[1][10:]
    assert texts[0][:4] != "1900"


def test_law_one_site_is_one_subject(made: MadeSession, tmp_path: Path) -> None:
    first = made.write_site(tmp_path, 1)
    done = CliRunner().invoke(app, ["export", str(first), "--bids", str(tmp_path / "bids")])
    assert done.exit_code == 0, done.output
    assert "Robot 2 has no file" in " ".join(done.stdout.split())
    [scan] = table(tmp_path / "bids" / "sub-P1" / "ses-01" / "sub-P1_ses-01_scans.tsv")
    assert scan["concurrent_with"] == "n/a"
    assert not (tmp_path / "bids" / "sub-robot2").exists()


def test_law_another_pair_is_another_run(tmp_path: Path) -> None:
    marks = [
        *MARKS[:5],
        (1.5, 1, "participant P3"),
        (1.5, 2, "participant P4"),
        (1.6, 1, "trial 2"),
        (2.0, 1, "trial end"),
    ]
    recording = ts.merge_recordings(*MadeSession(seconds=2.2, marks=marks).write(tmp_path))
    export = ts.export_bids(recording, tmp_path / "bids")
    assert export.people == ("P1", "P2", "P3", "P4")
    durations = [
        float(table(export.folder / f"sub-{code}" / "ses-01" / f"sub-{code}_ses-01_scans.tsv")[0]["duration"])
        for code in export.people
    ]
    assert durations == pytest.approx([0.5, 0.5, 0.4, 0.4], abs=0.01)
    # Nothing of one pair is with the other.
    [event] = [
        row
        for row in table(Path(str(export.files[2]).replace("_motion.tsv", "_events.tsv")))
        if row["trial_type"] == "trial"
    ]
    assert event["value"] == "2"
    assert float(event["onset"]) == pytest.approx(0.0, abs=0.01)


def test_law_nothing_of_somebody_else_goes_to_the_pair(tmp_path: Path) -> None:
    later = (1.2, 1, "participant P3")
    marks = [*MARKS[:5], later]
    recording = ts.merge_recordings(*MadeSession(seconds=1.6, marks=marks).write(tmp_path))
    export = ts.export_bids(recording, tmp_path / "bids")
    assert export.people == ("P1", "P2")
    # P3 came after the only trial: the run of P1 ends with that.
    [row] = table(export.folder / "sub-P1" / "ses-01" / "sub-P1_ses-01_scans.tsv")
    assert float(row["duration"]) == pytest.approx(0.5, abs=0.01)
    # Without any trial nobody knows; and who asks for two people gets all of it as theirs.
    unknown = ts.merge_recordings(*MadeSession(seconds=1.6, marks=[*MARKS[:2], later]).write(tmp_path))
    with pytest.raises(ts.InvalidInput, match="P-1 and P3 at robot 1"):
        ts.export_bids(unknown, tmp_path / "other")
    assert not (tmp_path / "other").exists()
    [first, _] = ts.export_bids(unknown, tmp_path / "other", participants=["P1", "P2"]).files
    assert len(samples(first)["position_x"]) == 1601


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--participants", "P1"], "two labels are required"),
        (["--participants", "P1,p1"], "two people are required"),
        (["--participants", "P1,+"], "letters a to z or digits"),
        (["--session", "--"], "letters a to z or digits"),
        (["--rate", "0"], "up to"),
    ],
)
def test_law_what_bids_cannot_say_is_refused(
    folder_with_a_session: Path, tmp_path: Path, options: list[str], said: str
) -> None:
    command = [
        "export",
        str(folder_with_a_session / "session.mcap"),
        "--bids",
        str(tmp_path / "bids"),
        *options,
    ]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 2
    assert said in " ".join(done.output.split())
    assert not (tmp_path / "bids").exists()


def test_law_an_export_of_nothing_is_refused(folder_with_a_session: Path) -> None:
    done = CliRunner().invoke(app, ["export", str(folder_with_a_session / "session.mcap")])
    assert done.exit_code == 2
    assert "--bids" in done.output
