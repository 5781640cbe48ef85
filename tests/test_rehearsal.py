"""A rehearsal: one dataset, the same however it came about, and a folder that is never torn."""

from __future__ import annotations

import json
import os
import random
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner, Result

import telespring as ts
from telespring import _core, cli
from telespring.rehearsal import run_protocol, trial_file
from telespring.rehearsal.encoding import SIGNALS
from telespring.rehearsal.schedule import schedule_trials
from telespring.rehearsal.store import LOCK_FILE, lock_folder
from telespring.study.conditions import condition_labels

# Short trials of the paper's robots; 1500 N/m over 0.1 s is so unstable that it diverges within 2 s.
STUDY = """
name = "{name}"
robot1 = {{mass = [0.8334, 1.0649], damping = [7.7257, 10.1168]}}
robot2 = {{mass = [0.7776, 1.3407], damping = [7.4208, 9.3496]}}
coupling = {{stiffness = 35.6, damping = 1.0}}
network.delay = 0.05
{more}
[protocol]
conditions = [{{stiffness = 35.6, delay = 0.05}}, {{stiffness = 1500.0, delay = 0.1}}]
trials = {trials}
duration = {duration}
discard = 0.5
record_rate = 100.0
seed = 3
order = "shuffled"
"""


def study_text(name: str = "short", more: str = "", trials: int = 3, duration: float = 2.0) -> str:
    return STUDY.format(name=name, more=more, trials=trials, duration=duration)


def written(folder: Path, text: str) -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / "study.toml"
    path.write_text(text, encoding="utf-8")
    return path


def command(*arguments: str | Path) -> Result:
    return CliRunner(env={"COLUMNS": "100", "NO_COLOR": "1"}).invoke(
        cli.app, ["rehearse", *map(str, arguments)]
    )


def loaded(folder: Path) -> xr.Dataset:
    return xr.load_dataset(folder / "rehearsal.nc", engine="h5netcdf")


def left_in(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.name != LOCK_FILE)


@pytest.fixture(scope="module")
def short() -> ts.Study:
    return ts.Study.from_toml(study_text())


@pytest.fixture(scope="module")
def undisturbed(short: ts.Study, tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    return ts.rehearse(short, tmp_path_factory.mktemp("undisturbed"), workers=1)


def test_law_the_dataset_holds_what_the_laboratory_gave(short: ts.Study, undisturbed: xr.Dataset) -> None:
    """Each trial, run again by hand, is in its place to the stated resolution; every value has a unit."""
    experiment = short.experiment
    assert experiment is not None
    assert undisturbed.position.dims == ("condition", "trial", "time", "robot", "axis")
    assert undisturbed.condition.values.tolist() == ["UM", "CM-36-50", "CM-1500-100"]
    assert undisturbed.robot.values.tolist() == [1, 2]
    assert undisturbed.axis.values.tolist() == ["x", "y"]
    np.testing.assert_array_equal(undisturbed.stiffness, [np.nan, 35.6, 1500.0])
    np.testing.assert_array_equal(undisturbed.delay, [0.0, 0.05, 0.1])
    for condition, (stiffness, delay) in enumerate(experiment.conditions):
        for trial in range(experiment.trials):
            here = undisturbed.isel(condition=condition, trial=trial)
            seed = _core.trial_seed(experiment.seed, condition, trial)
            assert int(here.seed) == seed
            truth = experiment.laboratory.run(
                stiffness,
                delay,
                seed,
                experiment.duration,
                experiment.record_rate,
                coupling_damping=1.0,
            )
            rows = slice(0, len(truth.time))
            np.testing.assert_array_equal(undisturbed.time[rows], truth.time)
            # rounding is off by half a step at most
            np.testing.assert_allclose(undisturbed.target[rows], truth.target, rtol=0, atol=2.0**-31)
            for kept in SIGNALS:
                signals = here[kept.name]
                step = signals.attrs["resolution"]
                assert step <= 1e-6
                np.testing.assert_allclose(signals[rows], getattr(truth, kept.name), rtol=0, atol=0.5 * step)
    for name, variable in undisturbed.variables.items():
        assert variable.attrs["units"], name
        assert variable.attrs["long_name"], name
    assert undisturbed.position.dtype == np.float64
    assert undisturbed.attrs["study"] == short.to_toml()
    assert undisturbed.attrs["schema"] == "telespring rehearsal 1"
    assert undisturbed.attrs["discard"] == 0.5
    assert undisturbed.attrs["sample_period"] == experiment.sample_period
    assert json.loads(undisturbed.attrs["agents"]) == [agent.to_dict() for agent in experiment.agents]
    assert json.loads(undisturbed.attrs["robots"])[0]["mass"] == [0.8334, 1.0649]


def test_law_the_document_names_all_that_is_in_the_dataset(root: Path, undisturbed: xr.Dataset) -> None:
    text = (root / "docs" / "rehearse.md").read_text(encoding="utf-8")
    for name in [*undisturbed.variables, *undisturbed.attrs]:
        assert f"`{name}`" in text, name
    for link in re.findall(r"\]\(([^)]+)\)", text):
        assert (root / "docs" / link).exists(), link


def test_law_the_dataset_does_not_depend_on_the_number_of_threads(
    short: ts.Study, undisturbed: xr.Dataset, tmp_path: Path
) -> None:
    found = ts.rehearse(short, tmp_path, workers=2)
    assert found.identical(undisturbed)
    assert loaded(tmp_path).identical(found)
    assert left_in(tmp_path) == ["rehearsal.nc"]


def test_law_progress_is_told_from_the_first_to_the_last_trial(short: ts.Study, tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    run_protocol(short, tmp_path, lambda done, total: told.append((done, total)), workers=2)
    assert told == [(done, 9) for done in range(10)]


@pytest.mark.parametrize("seed", [1, 2])
def test_law_killed_at_any_moment_it_ends_with_the_same_dataset(seed: int, tmp_path: Path) -> None:
    """SIGKILL after random times until it comes through; each start goes on where the last was."""
    study = written(tmp_path, study_text(trials=15, duration=12.0))
    disturbed, calm = tmp_path / "disturbed", tmp_path / "calm"
    process = _started(study, calm)
    begin = time.perf_counter()
    process.communicate()
    whole = time.perf_counter() - begin
    moments, killed, at_work = random.Random(seed), 0, 0
    for attempt in range(100):
        process = _started(study, disturbed)
        try:
            # later on the whole, so that every part is met and yet it comes through
            process.wait(moments.expovariate(1.0 / (whole * 0.1 * (1 + attempt))))
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
        output, _ = process.communicate()
        if process.returncode == 0:
            break
        assert process.returncode == -signal.SIGKILL, output.decode()
        killed += 1
        finished = list(disturbed.rglob("[!.]*.trial"))
        at_work += bool(finished)
        # never an unfinished trial under a finished one's name
        assert all(trial_file.read_trial_file(file) is not None for file in finished)
    else:
        pytest.fail("it never came through")
    assert at_work, f"of {killed} kills none met a rehearsal with finished trials: this shows nothing"
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
    code = (
        "import os, signal, sys, unittest.mock, telespring as ts, telespring.rehearsal.dataset\n"
        "kill = lambda *_, **__: os.kill(os.getpid(), signal.SIGKILL)\n"
        "with unittest.mock.patch(sys.argv[1], kill):\n"
        "    ts.rehearse(ts.Study.from_toml(sys.argv[2]), sys.argv[3])"
    )
    call = [sys.executable, "-c", code, place, short.to_toml(), str(tmp_path)]
    assert subprocess.run(call, check=False).returncode == -signal.SIGKILL
    assert ts.rehearse(short, tmp_path).identical(undisturbed)
    assert left_in(tmp_path) == ["rehearsal.nc"]


def _started(study: Path, out: Path) -> subprocess.Popen[bytes]:
    """Start the command and wait until it works in the folder, or has ended already."""
    call = [sys.executable, "-m", "telespring", "rehearse", str(study), "--workers", "2", "--out", str(out)]
    process = subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def at_work() -> bool:
        lock = out / LOCK_FILE
        return lock.exists() and lock.read_text() == f"{process.pid}\n"

    _wait_for(lambda: at_work() or process.poll() is not None)
    return process


def _wait_for(condition: Callable[[], bool]) -> None:
    for _ in range(3000):
        if condition():
            return
        time.sleep(0.01)
    pytest.fail("waited half a minute in vain")


def interrupted_after(trials: int) -> Callable[[int, int], None]:
    def progress(done: int, _total: int) -> None:
        if done == trials:
            raise KeyboardInterrupt

    return progress


@pytest.fixture
def begun(short: ts.Study, tmp_path: Path) -> Path:
    """Return a folder in which four of nine trials are finished."""
    with pytest.raises(KeyboardInterrupt):
        ts.rehearse(short, tmp_path, interrupted_after(4), workers=2)
    assert len(list(tmp_path.rglob("*.trial"))) == 4
    return tmp_path


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


@pytest.mark.parametrize("state", ["begun", "complete"])
def test_law_the_folder_of_another_study_is_refused_and_left_alone(
    begun: Path, short: ts.Study, state: str
) -> None:
    if state == "complete":
        ts.rehearse(short, begun)
    before = left_in(begun)
    for other, said in (
        (study_text(name="another"), "another study, 'short'"),
        (study_text(duration=2.5), "the same name, 'short', with different contents"),
    ):
        with pytest.raises(ts.InvalidInput, match=said) as refused:
            ts.rehearse(ts.Study.from_toml(other), begun)
        assert refused.value.field == "out"
        assert "--fresh" in refused.value.remedy
    assert left_in(begun) == before


def test_law_fresh_starts_anew_and_leaves_files_of_others_alone(begun: Path) -> None:
    (begun / "notes.txt").write_text("mine")
    (begun / "trials" / "notes.txt").write_text("mine")
    other = ts.Study.from_toml(study_text(name="another"))
    assert ts.rehearse(other, begun, fresh=True).attrs["name"] == "another"
    assert left_in(begun) == ["notes.txt", "rehearsal.nc", "trials", "trials/notes.txt"]
    again = ts.Study.from_toml(study_text())
    assert ts.rehearse(again, begun, fresh=True).attrs["name"] == "short"


def test_law_a_file_of_the_datasets_name_that_is_none_is_refused(short: ts.Study, tmp_path: Path) -> None:
    (tmp_path / "rehearsal.nc").write_text("my notes")
    with pytest.raises(ts.InvalidInput, match="not from one"):
        ts.rehearse(short, tmp_path)
    assert (tmp_path / "rehearsal.nc").read_text() == "my notes"


def test_law_a_second_process_is_refused_until_the_first_is_dead(short: ts.Study, tmp_path: Path) -> None:
    code = (
        "import sys, time, pathlib; from telespring.rehearsal.store import lock_folder\n"
        "with lock_folder(pathlib.Path(sys.argv[1])):\n    print('locked', flush=True); time.sleep(60)"
    )
    owner = subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], stdout=subprocess.PIPE)
    try:
        assert owner.stdout is not None
        assert owner.stdout.readline() == b"locked\n"
        with pytest.raises(ts.InvalidInput, match=f"process {owner.pid} is using"):
            ts.rehearse(short, tmp_path)
    finally:
        owner.kill()
        owner.communicate()
    ts.rehearse(short, tmp_path)


def test_law_two_threads_of_one_process_cannot_both_hold_a_folder(tmp_path: Path) -> None:
    with (
        lock_folder(tmp_path),
        pytest.raises(ts.InvalidInput, match="is using this one"),
        lock_folder(tmp_path),
    ):
        pass
    with lock_folder(tmp_path):
        pass


def test_law_a_trial_that_ends_early_is_a_result(undisturbed: xr.Dataset, tmp_path: Path) -> None:
    """1500 N/m over 0.1 s each way diverges (K_x is 35.6 N/m): NaN from there on, and a status."""
    flags = dict(
        zip(
            undisturbed.status.attrs["flag_values"].tolist(),
            undisturbed.status.attrs["flag_meanings"].split(),
            strict=True,
        )
    )
    assert flags == {0: "completed", 1: "diverged", 2: "out_of_reach", 3: "too_stiff"}
    assert undisturbed.status.dtype == np.int8
    assert (undisturbed.status == [[0] * 3, [0] * 3, [1] * 3]).all()
    calm = undisturbed.isel(condition=slice(0, 2))
    assert np.isnan(calm.ended_at).all()
    wild = undisturbed.sel(condition="CM-1500-100")
    assert ((wild.ended_at > 0.5) & (wild.ended_at < 2.0)).all()
    for kept in SIGNALS:
        assert not np.isnan(calm[kept.name]).any()
        # the row at the very time of the end is not kept
        ended = (wild.time >= wild.ended_at).broadcast_like(wild[kept.name])
        np.testing.assert_array_equal(np.isnan(wild[kept.name]), ended.transpose(*wild[kept.name].dims))
    assert not np.isnan(undisturbed.target).any()
    told = command(written(tmp_path, study_text()), "--out", tmp_path / "out")
    assert told.exit_code == 0
    assert "3 of 9 ended early: diverged" in told.stdout


@pytest.mark.parametrize(("order", "sorted_alike"), [("blocks", True), ("shuffled", False)])
def test_law_every_trial_has_one_place_in_the_order_of_running(order: str, sorted_alike: bool) -> None:
    experiment = ts.Study.from_toml(study_text(trials=20).replace("shuffled", order)).experiment
    assert experiment is not None
    trials = schedule_trials(experiment)
    assert [trial.order for trial in trials] == list(range(60))
    places = [(trial.condition, trial.trial) for trial in trials]
    assert sorted(places) == [(c, t) for c in range(3) for t in range(20)]
    assert (places == sorted(places)) is sorted_alike
    assert len({trial.seed for trial in trials}) == 60


def test_law_labels_tell_every_condition_apart() -> None:
    close = [(None, 0.0), (35.6, 0.1671), (35.6, 0.1674)]
    assert condition_labels(close) == ["UM", "CM-35.6-167.1", "CM-35.6-167.4"]
    tiny = [(1e-9, 0.0), (2e-9, 0.0)]
    assert condition_labels(tiny) == ["CM-0.000000001-0", "CM-0.000000002-0"]
    assert condition_labels([(1.0, 0.0), (1.0, 0.0)]) == ["CM-1-0", "CM-1-0 (2)"]


def test_law_the_file_is_plain_netcdf_with_hdf5s_own_filters(short: ts.Study, tmp_path: Path) -> None:
    """The chunks are deflated here, not by HDF5: another program must read them all the same."""
    ts.rehearse(short, tmp_path)
    with h5py.File(tmp_path / "rehearsal.nc") as file:
        variable = file["position"]
        assert (variable.compression, variable.shuffle, variable.chunks) == ("gzip", True, (1, 1, 201, 2, 2))
        assert all(dimension.keys() for dimension in variable.dims)


# The command


def test_law_the_command_says_where_the_dataset_is_and_then_that_it_is_complete(tmp_path: Path) -> None:
    study, out = written(tmp_path, study_text()), tmp_path / "out"
    first = command(study, "--out", out, "--workers", "1")
    assert first.exit_code == 0, first.output
    assert "3 conditions × 3 trials of 2 s; 9 run in" in first.stdout
    assert str(out / "rehearsal.nc") in first.stdout.replace("\n", "")
    again = command(study, "--out", out)
    assert again.exit_code == 0
    assert "already complete" in again.stdout


def test_law_a_robot_from_a_file_of_its_own_takes_part(tmp_path: Path) -> None:
    (tmp_path / "robot.toml").write_text("[robot]\nmass = [2.0, 3.0]\ndamping = [7.0, 8.0]\n")
    study = written(tmp_path, study_text(more=TARGET.format(name="still")))
    (tmp_path / "mine.py").write_text(MINE)
    done = command(study, "--out", tmp_path / "out", "--robot2", tmp_path / "robot.toml")
    assert done.exit_code == 0, done.output
    robots = json.loads(loaded(tmp_path / "out").attrs["robots"])
    assert [robot["mass"] for robot in robots] == [[0.8334, 1.0649], [2.0, 3.0]]


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
    call = [sys.executable, "-m", "telespring", "rehearse", str(study), "--out", str(out)]
    process = subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    _wait_for(lambda: any(out.rglob("*.trial")))
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=30)
    assert process.returncode == 130
    assert re.search(rb"Stopped\. \d+ of 12000 trials are kept", output), output.decode()
    assert b"Traceback" not in output


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


@pytest.mark.parametrize("place", ["file", "file/below"])
def test_law_a_file_in_the_folders_place_is_told(tmp_path: Path, place: str) -> None:
    (tmp_path / "file").write_text("mine")
    refused = command(written(tmp_path, study_text()), "--out", tmp_path / place)
    assert refused.exit_code == 2
    assert "a folder is required" in refused.output


def test_law_input_that_cannot_be_rehearsed_is_refused(tmp_path: Path) -> None:
    lonely = """
robot1 = {mass = 1.0, damping = 5.0}
robot2 = {mass = 1.0, damping = 5.0}
coupling.stiffness = 20.0
network.delay = 0.05
"""
    with pytest.raises(ts.InvalidInput, match="exactly two axes"):
        ts.rehearse(ts.Study.from_toml(lonely), tmp_path)
    with pytest.raises(ts.InvalidInput, match="workers"):
        ts.rehearse(ts.Study.from_toml(study_text()), tmp_path, workers=0)
    refused = command(tmp_path / "missing.toml", "--out", tmp_path)
    assert refused.exit_code == 2
    assert "missing.toml" in refused.output
    assert left_in(tmp_path) == []


# Agents and targets in Python

TARGET = '[task]\nkind = "python"\nfunction = "mine:{name}"'
SPRING = '[agent1]\nkind = "python"\nclass = "mine:{name}"\noptions = {options}'
MINE = """
class Spring:
    def __init__(self, seed, stiffness=120.0):
        self.seed, self.stiffness = seed, stiffness

    def __call__(self, time, position, velocity, target):
        return self.stiffness * (target - position)


class Late(Spring):
    def __call__(self, time, position, velocity, target):
        if time > 1.0:
            return 1.0 / 0.0
        return super().__call__(time, position, velocity, target)


class Leaving(Spring):
    def __call__(self, time, position, velocity, target):
        import sys
        sys.exit(0)


class Refusing(Spring):
    def __init__(self, seed):
        raise SystemExit


class Wrong(Spring):
    def __call__(self, time, position, velocity, target):
        return target[:1]


def leaving(times):
    raise SystemExit(0)


def still(times):
    return [[0.1, 0.2]] * len(times)


def millimetres(times):
    return [[50.0 * t, 100.0 * t] for t in times]


def jumping(times):
    return [[0.0 if t < 0.5005 else 0.1, 0.0] for t in times]


def one_axis(times):
    return times


def undefined(times):
    return [[float("nan"), 0.0]] * len(times)
"""


@pytest.fixture
def mine(tmp_path: Path) -> Iterator[Callable[[str], Path]]:
    def write(more: str) -> Path:
        (tmp_path / "mine.py").write_text(MINE, encoding="utf-8")
        return written(tmp_path, study_text(more=more))

    yield write
    assert "mine" not in sys.modules
    assert str(tmp_path) not in sys.path


def test_cross_an_agent_in_python_moves_as_the_laboratorys_own(
    mine: Callable[[str], Path], tmp_path: Path
) -> None:
    """A spring in Python and the laboratory's skilled agent are the same law, so the same motion."""
    found = ts.rehearse(mine(SPRING.format(name="Spring", options="{stiffness = 120.0}")), tmp_path / "out")
    own = ts.rehearse(ts.Study.from_toml(study_text()), tmp_path / "own")
    for kept in SIGNALS:
        # rounding to the resolution may fall on either side
        np.testing.assert_allclose(found[kept.name], own[kept.name], rtol=0, atol=2 * 2.0**-kept.bits)
    np.testing.assert_array_equal(found.seed, own.seed)
    programs = json.loads(found.attrs["programs"])
    assert programs["agent1"]["name"] == "mine:Spring"
    assert len(programs["agent1"]["sha256"]) == 64


def test_law_a_target_in_python_is_followed(mine: Callable[[str], Path], tmp_path: Path) -> None:
    found = ts.rehearse(mine(TARGET.format(name="still")), tmp_path / "out")
    np.testing.assert_allclose(found.target, np.tile([0.1, 0.2], (201, 1)), rtol=0, atol=2.0**-30)
    # the skilled agent of robot 1 is held at the target's place by nobody in the unconnected mode
    apart = found.position.sel(condition="UM", robot=1) - found.target
    np.testing.assert_allclose(apart, np.zeros(apart.shape), rtol=0, atol=2.0**-29)


@pytest.mark.parametrize(
    ("more", "field", "said"),
    [
        (
            SPRING.format(name="Late", options="{}"),
            "agent1.class",
            r"ZeroDivisionError: .* \(mine.py, line 13, in __call__\) at t = 1.001 s, in trial \d of \w+",
        ),
        (SPRING.format(name="Leaving", options="{}"), "agent1.class", r"raised SystemExit: 0 .* at t = 0 s"),
        (SPRING.format(name="Refusing", options="{}"), "agent1.class", "accept seed by name, .* SystemExit"),
        (TARGET.format(name="leaving"), "task.function", "must not raise exceptions, .* SystemExit: 0"),
        (SPRING.format(name="Wrong", options="{}"), "agent1.class", "two finite numbers .* at t = 0 s"),
        (
            SPRING.format(name="Spring", options="{weight = 1.0}"),
            "agent1.class",
            "accept seed, weight by name",
        ),
        (SPRING.format(name="Sprung", options="{}"), "agent1.class", "named Sprung"),
        (SPRING.format(name="still", options="{}"), "agent1.class", "a class is required"),
        (
            SPRING.format(name="x", options="{}").replace("mine", "nowhere"),
            "agent1.class",
            "in the folder of the study file .* or on Python's module path",
        ),
        # the call itself fails: no line of the user's file, and none of ours
        (
            TARGET.format(name="still") + "\noptions = {radius = 1.0}",
            "task.function",
            r"TypeError: .*radius'\. Correct it in mine\.py\. A target is called",
        ),
        (TARGET.format(name="millimetres"), "task.function", "within 10 m, .* millimetres"),
        (TARGET.format(name="jumping"), "task.function", "at 100 m/s at t = 0.5 s"),
        (
            TARGET.format(name="one_axis"),
            "task.function",
            r"shape \(2001, 2\), but it returned \(2001,\)",
        ),
        (TARGET.format(name="undefined"), "task.function", "must be finite"),
    ],
)
def test_law_what_a_program_does_wrong_is_told_with_its_place(
    mine: Callable[[str], Path], tmp_path: Path, more: str, field: str, said: str
) -> None:
    with pytest.raises(ts.InvalidInput, match=said) as refused:
        ts.rehearse(mine(more), tmp_path / "out")
    assert refused.value.field == field
    told = command(mine(more), "--out", tmp_path / "out")
    assert told.exit_code == 2
    assert "Traceback" not in told.output


def test_law_after_a_programs_failure_finished_trials_stay(tmp_path: Path) -> None:
    """The agent fails once four trials are kept, as by something outside of it, and later does not."""
    (tmp_path / "mine.py").write_text(
        MINE
        + """
import pathlib

class Moody(Spring):
    def __init__(self, seed):
        super().__init__(seed)
        kept = list((pathlib.Path(__file__).parent / "out" / "trials").glob("*.trial"))
        if len(kept) >= 4 and (pathlib.Path(__file__).parent / "mood").exists():
            raise OSError("no mood")
"""
    )
    (tmp_path / "mood").write_text("bad")
    study = written(tmp_path, study_text(more=SPRING.format(name="Moody", options="{}")))
    with pytest.raises(ts.InvalidInput, match="no mood") as refused:
        ts.rehearse(study, tmp_path / "out")
    assert "Finished trials are kept" in refused.value.remedy
    (tmp_path / "mood").unlink()
    assert run_protocol(study, tmp_path / "out").resumed >= 4


def test_law_trials_of_two_versions_of_a_program_are_not_mixed(
    mine: Callable[[str], Path], tmp_path: Path
) -> None:
    study = mine(SPRING.format(name="Spring", options="{}"))
    with pytest.raises(KeyboardInterrupt):
        ts.rehearse(study, tmp_path / "out", interrupted_after(4))
    (tmp_path / "mine.py").write_text(MINE.replace("120.0", "60.0"))
    with pytest.raises(ts.InvalidInput, match="another version of the Python file of agent1"):
        ts.rehearse(study, tmp_path / "out")
    ts.rehearse(study, tmp_path / "out", fresh=True)


def test_law_a_program_that_fails_at_once_may_be_mended(mine: Callable[[str], Path], tmp_path: Path) -> None:
    study = mine(SPRING.format(name="Wrong", options="{}"))
    with pytest.raises(ts.InvalidInput, match="two finite numbers"):
        ts.rehearse(study, tmp_path / "out")
    (tmp_path / "mine.py").write_text(MINE.replace("target[:1]", "target"))
    assert (ts.rehearse(study, tmp_path / "out").status[:2] == 0).all()


def test_law_the_example_with_agents_in_python_runs(root: Path, tmp_path: Path) -> None:
    done = command(root / "examples" / "tremor.toml", "--out", tmp_path)
    assert done.exit_code == 0, done.output
    found = loaded(tmp_path)
    assert (found.status == 0).all()
    radius = np.hypot(found.target.sel(axis="x"), found.target.sel(axis="y"))
    np.testing.assert_allclose(radius, 0.08, rtol=0, atol=2.0**-29)
    # both hands tremble by themselves at 6 Hz only on robot 2, and its seeds differ from trial to trial
    force = found.agent_force.sel(condition="UM").isel(time=slice(400, None))
    power = np.abs(np.fft.rfft(force, axis=1)) ** 2
    frequency = np.fft.rfftfreq(force.sizes["time"], 1 / found.attrs["record_rate"])
    trembling = power[:, (frequency > 5) & (frequency < 7)].sum(axis=1)
    assert (trembling[:, 1] > 100 * trembling[:, 0]).all()
    assert len(np.unique(trembling[:, 1])) == trembling[:, 1].size


def test_law_a_module_that_leaves_is_told(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("raise SystemExit(0)")
    study = written(tmp_path, study_text(more=SPRING.format(name="Spring", options="{}")))
    told = command(study, "--out", tmp_path / "out")
    assert told.exit_code == 2
    assert "SystemExit" in told.output


# Disk, stiffness, interruption


def test_law_the_target_is_whole_where_every_trial_ended_early(tmp_path: Path) -> None:
    text = study_text().replace("{stiffness = 35.6, delay = 0.05}, ", "")
    text = text.replace("trials = 3", "trials = 1\nunconnected = false")
    found = ts.rehearse(ts.Study.from_toml(text), tmp_path / "out")
    assert (found.status == 1).all()
    assert np.isfinite(found.target).all()
    truth = _core.Laboratory.paper().target(2.0, 100.0)
    np.testing.assert_allclose(found.target, truth, rtol=0, atol=2.0**-31)


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


ARM = """
[arm{n}]
kind = "two-link"
base = [0.0, -0.45]
elbow = "right"
link_length = 0.325
link_mass = 0.0
link_centre = 0.0
link_inertia = 0.0
"""


def stiff_text() -> str:
    text = study_text(more=ARM.format(n=1) + ARM.format(n=2), duration=30.0)
    return re.sub(r"robot(\d) = .*", r"robot\1 = {axes = ['x', 'y'], mass = 1e-4, damping = 1e6}", text)


def test_law_a_study_too_stiff_to_follow_ends_and_says_so(tmp_path: Path) -> None:
    found = ts.rehearse(ts.Study.from_toml(stiff_text(), allow_unusual=True), tmp_path / "out")
    meanings = dict(
        zip(
            found.status.attrs["flag_values"].tolist(),
            found.status.attrs["flag_meanings"].split(),
            strict=True,
        )
    )
    assert {meanings[int(each)] for each in found.status.values.ravel()} == {"too_stiff"}
    assert np.isfinite(found.ended_at).all()


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
