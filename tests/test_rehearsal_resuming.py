"""A rehearsal that is killed, interrupted or out of disk: it goes on, and ends the same."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import xarray as xr

import telespring as ts
from resuming import interrupted_after, killed_at, killed_until_it_comes_through, left_in, started, written
from short_rehearsal import ARM, begin, command, loaded, study_text
from telespring.rehearsal import run_protocol, trial_file
from telespring.rehearsal.store import LOCK_FILE


@pytest.fixture(scope="module")
def short() -> ts.Study:
    return ts.Study.from_toml(study_text())


@pytest.fixture(scope="module")
def undisturbed(short: ts.Study, tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    return ts.rehearse(short, tmp_path_factory.mktemp("undisturbed"), workers=1)


@pytest.fixture
def begun(short: ts.Study, tmp_path: Path) -> Path:
    return begin(short, tmp_path)


def _at_work(study: Path, out: Path) -> subprocess.Popen[bytes]:
    """Start the command and wait until it works in the folder, or has ended already."""
    lock = out / LOCK_FILE
    return started(
        *("rehearse", study, "--workers", "2", "--out", out),
        until=lambda process: lock.exists() and lock.read_text() == f"{process}\n",
    )


@pytest.mark.timeout(400)
@pytest.mark.parametrize("seed", [1, 2])
def test_law_killed_at_any_moment_it_ends_with_the_same_dataset(seed: int, tmp_path: Path) -> None:
    """SIGKILL after random times until it comes through; each start goes on where the last was."""
    study = written(tmp_path, study_text(trials=15, duration=12.0))
    disturbed, calm = tmp_path / "disturbed", tmp_path / "calm"
    process = _at_work(study, calm)
    begin = time.perf_counter()
    process.communicate()
    whole = time.perf_counter() - begin
    killed_until_it_comes_through(lambda: _at_work(study, disturbed), disturbed, mean=whole * 0.1, seed=seed)
    assert loaded(disturbed).identical(loaded(calm))
    assert left_in(disturbed) == ["rehearsal.nc"]


@pytest.mark.parametrize(
    "place",
    [
        "telespring.rehearsal.store.write_whole",
        "telespring.rehearsal.dataset._declare_dataset_signals",
        "telespring.rehearsal.store.RehearsalStore.flush_folder",
        "telespring.rehearsal.store.RehearsalStore.remove_trials",
    ],
)
def test_law_killed_at_a_delicate_moment_it_ends_with_the_same_dataset(
    place: str, short: ts.Study, undisturbed: xr.Dataset, tmp_path: Path
) -> None:
    """Before the plan is written, inside the dataset's file, after its renaming, before the trials go."""
    killed_at(place, "rehearse", short.to_toml(), tmp_path)
    assert ts.rehearse(short, tmp_path).identical(undisturbed)
    assert left_in(tmp_path) == ["rehearsal.nc"]


def test_law_what_is_finished_is_not_run_again(short: ts.Study, undisturbed: xr.Dataset, begun: Path) -> None:
    told: list[int] = []
    outcome = run_protocol(short, begun, lambda done, _: told.append(done))
    assert (outcome.resumed, outcome.trials) == (4, 9)
    assert told == [4, 5, 6, 7, 8, 9]
    assert loaded(begun).identical(undisturbed)


@pytest.mark.parametrize("damage", ["cut short", "one bit", "emptied", "of another rehearsal"])
def test_law_a_damaged_trial_is_run_again(
    short: ts.Study,
    undisturbed: xr.Dataset,
    begun: Path,
    tmp_path_factory: pytest.TempPathFactory,
    damage: str,
) -> None:
    file = sorted(begun.rglob("*.trial"))[0]
    text = bytearray(file.read_bytes())
    if damage == "cut short":
        text = text[: len(text) // 2]
    elif damage == "one bit":
        text[len(text) // 2] ^= 1
    elif damage == "emptied":
        text.clear()
    else:
        elsewhere = tmp_path_factory.mktemp("elsewhere")
        other = ts.Study.from_toml(study_text().replace("seed = 3", "seed = 4"))
        with pytest.raises(KeyboardInterrupt):
            ts.rehearse(other, elsewhere, interrupted_after(9), workers=1)
        text = bytearray((elsewhere / "trials" / file.name).read_bytes())
    file.write_bytes(text)
    assert run_protocol(short, begun).resumed == 3
    assert loaded(begun).identical(undisturbed)


def test_law_what_a_killed_process_left_half_written_goes_away(short: ts.Study, begun: Path) -> None:
    for place in (begun / ".unfinished-0123.nc", begun / "trials" / ".unfinished-0-0.trial"):
        place.write_bytes(b"half")
    ts.rehearse(short, begun)
    assert left_in(begun) == ["rehearsal.nc"]


def test_law_trials_left_beside_a_finished_dataset_go_away(short: ts.Study, begun: Path) -> None:
    """As after a kill between the dataset's renaming and the removal of the trials."""
    before = {path: path.read_bytes() for path in begun.rglob("*") if path.is_file()}
    ts.rehearse(short, begun)
    (begun / "trials").mkdir()
    for path, text in before.items():
        path.write_bytes(text)
    assert run_protocol(short, begun).resumed == 9
    assert left_in(begun) == ["rehearsal.nc"]


def test_law_fresh_starts_anew_and_leaves_files_of_others_alone(begun: Path) -> None:
    (begun / "notes.txt").write_text("mine")
    (begun / "trials" / "notes.txt").write_text("mine")
    other = ts.Study.from_toml(study_text(name="another"))
    assert ts.rehearse(other, begun, fresh=True).attrs["name"] == "another"
    assert left_in(begun) == ["notes.txt", "rehearsal.nc", "trials", "trials/notes.txt"]
    again = ts.Study.from_toml(study_text())
    assert ts.rehearse(again, begun, fresh=True).attrs["name"] == "short"


def test_law_ctrl_c_keeps_what_is_finished_and_says_how_to_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    study, out = written(tmp_path, study_text()), tmp_path / "out"
    write = trial_file.write_trial_file

    def interrupted(path: Path, record: trial_file.TrialRecord) -> None:
        if len(list(path.parent.glob("*.trial"))) == 3:
            signal.raise_signal(signal.SIGINT)
        write(path, record)

    monkeypatch.setattr("telespring.rehearsal.store.write_trial_file", interrupted)
    stopped = command(study, "--out", out)
    assert stopped.exit_code == 130
    assert "3 of 9 trials are kept; run the same command again to resume." in stopped.output
    monkeypatch.undo()
    done = command(study, "--out", out)
    assert done.exit_code == 0
    assert "6 run in" in done.stdout
    assert "3 kept from before" in done.stdout


def test_law_ctrl_c_stops_the_real_program_soon(tmp_path: Path) -> None:
    study, out = written(tmp_path, study_text(trials=4000, duration=12.0)), tmp_path / "out"
    process = started("rehearse", study, "--out", out, until=lambda _: any(out.rglob("*.trial")))
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=30)
    assert process.returncode == 130
    assert re.search(rb"Stopped\. \d+ of 12000 trials are kept", output), output.decode()
    assert b"Traceback" not in output


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_law_ctrl_c_gets_through_a_long_trial(tmp_path: Path) -> None:
    """A trial of 9e7 ticks with two-link arms takes far longer than the test waits."""
    arms = (ARM.format(n=1) + ARM.format(n=2)).replace("link_mass = 0.0", "link_mass = 1.0")
    text = study_text(more=arms + "[laboratory]\nsample_period = 1e-5", duration=900.0)
    study = written(tmp_path, text)
    process = subprocess.Popen(
        [sys.executable, "-m", "telespring", "rehearse", str(study), "--out", str(tmp_path / "out")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    deadline = time.monotonic() + 30.0
    while not (tmp_path / "out" / "rehearsal.json").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=20.0)
    assert process.returncode == 130, told
    assert b"Traceback" not in told


def test_law_a_full_disk_is_told_and_loses_nothing(tmp_path: Path) -> None:
    """A limit on the file size simulates a full disk: the trials fit, the dataset does not."""
    study, out = written(tmp_path, study_text(trials=20)), tmp_path / "out"
    code = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000)); "
        "from telespring.cli import main; main()"
    )
    call = [sys.executable, "-c", code, "rehearse", str(study), "--out", str(out)]
    done = subprocess.run(
        call, capture_output=True, text=True, check=False, env={**os.environ, "COLUMNS": "200"}
    )
    assert done.returncode == 2, done.stdout + done.stderr
    assert "Refused: out" in done.stderr
    assert "rehearsal.nc" in done.stderr
    assert "60 of 60 trials are kept" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (out / "rehearsal.nc").exists()
    assert command(study, "--out", out).exit_code == 0


@pytest.mark.skipif(sys.platform == "win32", reason="no limits of file size there")
def test_law_a_file_too_large_for_the_disk_is_told(tmp_path: Path) -> None:
    """Each trial fits under the limit of 500 blocks of 1 KiB, the dataset of all does not."""
    text = study_text(trials=2, duration=30.0).replace("1500.0, delay = 0.1", "20.0, delay = 0.05")
    study = written(tmp_path, text)
    command_line = (
        f"ulimit -f 500; exec {sys.executable} -m telespring rehearse {study} --out {tmp_path / 'out'}"
    )
    ended = subprocess.run(
        ["bash", "-c", command_line],
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, "COLUMNS": "200"},
    )
    assert ended.returncode == 2, ended.stderr
    told = ended.stdout + ended.stderr
    assert "Traceback" not in told
    assert "File too large" in told
    assert "rehearsal.nc" in told
    assert not (tmp_path / "out" / "rehearsal.nc").exists()
    assert not list((tmp_path / "out").glob(".unfinished*"))
    whole = ts.rehearse(study, tmp_path / "out")
    assert (whole.status == 0).all()
