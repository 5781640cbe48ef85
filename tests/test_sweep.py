"""`telespring sweep`: its numbers are those of single rehearsals and verdicts, and nothing disturbs them."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import telespring as ts
from resuming import interrupted_after, left_in, written
from short_sweep import OVER, command, guarded, loaded
from telespring.analysis import measure
from telespring.show.screens.sweep import _percent
from telespring.sweeps.over import read_over, read_overs
from telespring.sweeps.plan import plan_sweep
from telespring.sweeps.rows import RowFile

#: The stiffness is said for the trials only, as in the tutorial.
NO_SPRING_OF_ITS_OWN = """
[robot1]
mass = [1.2, 1.4]
damping = [6.0, 8.0]
[robot2]
mass = [2.0, 2.0]
damping = [9.0, 9.0]
[protocol]
stiffness = [60.0]
delay = [0.0]
trials = 1
unconnected = false
"""


@pytest.fixture(scope="module")
def study() -> ts.Study:
    return guarded()


@pytest.fixture(scope="module")
def folder(study: ts.Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole")
    ts.sweep(study, folder, OVER)
    return folder


@pytest.fixture(scope="module")
def whole(folder: Path) -> xr.Dataset:
    return loaded(folder)


def test_cross_a_point_is_a_rehearsal(study: ts.Study, whole: xr.Dataset, tmp_path: Path) -> None:
    point = study.replace(
        network={"loss": 0.1}, coupling={"stiffness": 150.0}, protocol={"stiffness": [150.0]}
    )
    rehearsed = ts.rehearse(point, tmp_path)
    here = whole.sel({"network.loss": 0.1, "stiffness": 150.0})
    for name in ("limited_share", "given_out", "age_high", "coupling_energy_minimum", "ended_at", "lost"):
        np.testing.assert_array_equal(here[name].values, rehearsed[name].values, err_msg=name)
    assert (here.status == rehearsed.status).all()
    measured = measure(rehearsed)
    # the rehearsal stores positions to 1 nm and forces to 1 µN
    for name, step in (
        ("tracking_error", 1e-9),
        ("interaction_force_rms", 1e-6),
        ("interaction_force_peak", 1e-6),
    ):
        np.testing.assert_allclose(here[name].values, measured[name].values, rtol=0.0, atol=2.0 * step)
    assert here.condition_delay.values[1:].tolist() == [0.0, 0.084]


def test_cross_a_point_is_judged_as_by_decide(study: ts.Study, tmp_path: Path) -> None:
    over = {"stiffness": [30.0, 60.0, 120.0], "delay": [0.05, 0.2]}
    found = ts.sweep(study, tmp_path, over, trials=False).squeeze("condition")
    for k in over["stiffness"]:
        for delay in over["delay"]:
            here = found.sel(stiffness=k, delay=delay)
            answer = ts.verdicts(study.dyad, k, ts.Network(delay))
            assert bool(here.stable) == answer.tier("constant delay").satisfied
            assert float(here.stiffness_bound.sel(tier="any constant delay")) == pytest.approx(
                answer.tier("any constant delay").stiffness_bound
            )
            assert (float(here.condition_stiffness), float(here.condition_delay)) == (k, delay)
    assert set(np.unique(found.stable)) == {0.0, 1.0}


def test_law_trials_of_one_number_are_alike_at_every_point(study: ts.Study, tmp_path: Path) -> None:
    """A key without effect on the trials: the coupling's own stiffness is for the verdicts."""
    found = ts.sweep(study, tmp_path, {"coupling.stiffness": [30.0, 60.0]})
    one, other = found.isel({"coupling.stiffness": 0}), found.isel({"coupling.stiffness": 1})
    assert one.drop_vars("coupling.stiffness").identical(other.drop_vars("coupling.stiffness"))
    assert np.ptp(one.tracking_error.sel(condition="UM", robot=2).values) > 0.0


def test_law_what_is_finished_is_not_run_again(study: ts.Study, whole: xr.Dataset, tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        ts.sweep(study, tmp_path, OVER, progress=interrupted_after(9), workers=1)
    told: list[int] = []
    ts.sweep(study, tmp_path, OVER, progress=lambda done, _: told.append(done))
    assert told[:2] == [4, 9]
    assert told[-1] == 28
    assert loaded(tmp_path).identical(whole)
    assert left_in(tmp_path) == ["sweep.nc"]


@pytest.mark.parametrize("damage", ["torn", "one bit", "of another sweep", "emptied"])
def test_law_damaged_rows_are_run_again(
    study: ts.Study, whole: xr.Dataset, tmp_path: Path, damage: str
) -> None:
    with pytest.raises(KeyboardInterrupt):
        ts.sweep(study, tmp_path, OVER, progress=interrupted_after(9), workers=1)
    file = tmp_path / "trials.rows"
    data = bytearray(file.read_bytes())
    if damage == "torn":
        del data[-7:]
    elif damage == "one bit":
        data[-60] ^= 1
    elif damage == "emptied":
        data.clear()
    else:
        elsewhere = tmp_path / "elsewhere"
        other = study.replace(protocol={"seed": 5})
        with pytest.raises(KeyboardInterrupt):
            ts.sweep(other, elsewhere, OVER, progress=interrupted_after(9), workers=1)
        data = bytearray((elsewhere / "trials.rows").read_bytes())
    file.write_bytes(data)
    told: list[int] = []
    ts.sweep(study, tmp_path, OVER, progress=lambda done, _: told.append(done))
    assert told[1] == {"torn": 8, "one bit": 8}.get(damage, 4)
    assert loaded(tmp_path).identical(whole)


def test_law_an_agent_that_failed_at_once_may_be_corrected(study: ts.Study, tmp_path: Path) -> None:
    """Only points have been judged; with a finished trial another agent is another sweep."""
    agent = tmp_path / "mine.py"
    program = (
        "class Pull:\n"
        "    def __init__(self, seed): pass\n"
        "    def __call__(self, time, position, velocity, target): return {}\n"
    )
    agent.write_text(program.format("None"))
    mine = {"kind": "python", "class": "mine:Pull"}
    file = written(tmp_path, study.replace(agent1=mine, protocol={"trials": 1}).to_toml())
    for result, status in (("None", 2), ("(0.0, 0.0)", 0), ("(1.0, 0.0)", 2)):
        agent.write_text(program.format(result))
        done = command("sweep", file, "--over", "network.loss=0,0.1", "--out", tmp_path / "out")
        assert done.exit_code == status, done.output
    assert "another version of a Python file" in " ".join(done.output.split())


def test_law_all_is_said_only_where_it_is_all() -> None:
    said = [_percent(share) for share in (0.0, 0.99949, 0.9996, 1.0)]
    assert said == ["0 %", "99.9 %", "> 99.9 %", "100 %"]


@pytest.mark.skipif(sys.platform == "win32", reason="a limit stands for a full disk")
def test_law_a_full_disk_is_an_error_and_loses_nothing(tmp_path: Path) -> None:
    code = (
        "import resource, sys, numpy as np\n"
        "from pathlib import Path\n"
        "from telespring.sweeps.rows import RowFile\n"
        "rows = RowFile(Path(sys.argv[1]), 3, 'some sweep')\n"
        "rows.begin()\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100, resource.RLIM_INFINITY))\n"
        "try:\n"
        "    for place in range(3):\n"
        "        rows.append([place], np.full((1, 3), float(place)))\n"
        "except OSError:\n"
        "    sys.exit(7)"
    )
    file = tmp_path / "some.rows"
    assert subprocess.run([sys.executable, "-c", code, str(file)], check=False).returncode == 7
    rows = RowFile(file, 3, "some sweep")
    assert rows.begin().tolist() == [0, 1]
    rows.append([2], np.full((1, 3), 2.0))
    assert rows.read()[1][:, 0].tolist() == [0.0, 1.0, 2.0]


def test_law_zarr_holds_the_same(study: ts.Study, whole: xr.Dataset, tmp_path: Path) -> None:
    pytest.importorskip("zarr", reason="zarr is not installed: sweeps as Zarr are not tested")
    found = ts.sweep(study, tmp_path, OVER, as_zarr=True)
    assert left_in(tmp_path)[0] == "sweep.zarr"
    assert found.load().identical(whole)
    assert ts.sweep(study, tmp_path, OVER, as_zarr=True).load().identical(whole)


@pytest.mark.parametrize("as_zarr", [True, False])
def test_law_the_other_format_is_written_without_running_anything_again(
    study: ts.Study,
    whole: xr.Dataset,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    as_zarr: bool,
) -> None:
    pytest.importorskip("zarr", reason="zarr is not installed: sweeps as Zarr are not tested")
    ts.sweep(study, tmp_path, OVER, as_zarr=not as_zarr)
    monkeypatch.setattr("telespring.sweeps.run.run_tasks", None)
    assert ts.sweep(study, tmp_path, OVER, as_zarr=as_zarr).load().identical(whole)


@pytest.mark.parametrize(
    ("over", "said"),
    [
        ([], "something to sweep over"),
        (["loss"], "a key of the study, =, and its values"),
        (["loss=1"], "a key of the study with its section"),
        (["network.loss=0:1:0"], "1 to"),
        (["network.loss=log:0:1:3"], "above 0"),
        (["network.loss=[1, }"], "TOML"),
        (["network.loss=0", "network.loss=1"], "swept once"),
        (["network.loss=0,7"], "network.loss"),
        (["network.lost=0.1"], "network.lost"),
        (["protocol.trials=1,2"], "as many as the first"),
        ({"network.loss": []}, "at least one value"),
        ({"network.loss": [float("nan")]}, "finite"),
        (["network.loss=0,nan"], "finite"),
        (["stiffness=30,60", "coupling.stiffness=40,50"], "both of these set coupling.stiffness"),
        (["protocol.delay=0", "delay=0.1"], "both of these set protocol.delay"),
        (["network.loss=0,0.1,0.0"], "given once"),
        (["network.loss=0.1:0.1:2"], "given once"),
        (["network.loss=0,,0.1"], "before and after each comma"),
        (["network.loss=0.1,"], "before and after each comma"),
        (["robot1.damping=1:20"], "from:to:how many"),
        (["robot1.damping=1:20:9.5"], "from:to:how many"),
        (["network.loss=0.1;0.2"], "from:to:how many"),
        (['session.strategy=spring,{kind="guard",share=0.5}'], "as one list in TOML"),
        (["session.strategy.share=0.1,0.2"], "session.strategy=[{…, share = …}"),
        ({"session.strategy": "guard"}, "a list of values"),
        ({"network.loss": 0.1}, "a list of values"),
        ({"network.loss": np.array(0.1)}, "a list of values"),
    ],
)
def test_law_what_cannot_be_swept_is_refused(
    study: ts.Study, over: dict[str, list[float]] | list[str], said: str, tmp_path: Path
) -> None:
    with pytest.raises(ts.InvalidInput, match=re.escape(said)):
        ts.sweep(study, tmp_path, over)


def test_law_one_text_is_one_key() -> None:
    assert read_overs("network.loss=0,0.1") == read_overs(["network.loss=0,0.1"])


def test_law_a_key_that_changes_nothing_is_said(study: ts.Study, tmp_path: Path) -> None:
    file = written(tmp_path, study.to_toml())
    over = ("--over", "coupling.stiffness=30,60", "--over", "network.loss=0,0.1")
    done = command("sweep", file, *over, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    said = " ".join(done.output.split())
    assert "coupling.stiffness changes nothing" in said
    assert "stiffness=… sets both" in said
    assert "network.loss changes nothing" not in said


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("network.loss=0:0.3:4", [0.0, 0.1, 0.2, 0.3]),
        ("robot1.damping=log:1:100:3", [1.0, 10.0, 100.0]),
        ("session.strategy=spring, guard", ["spring", "guard"]),
        ("network.playout_buffer=true,false", [True, False]),
        ("network.playout_buffer=True,False", [True, False]),
        ("network.trace=2024-11-03.csv, ../b.csv", ["2024-11-03.csv", "../b.csv"]),
        ('session.strategy=[{kind = "guard", share = 0.5}]', [{"kind": "guard", "share": 0.5}]),
    ],
)
def test_ref_values_are_read_as_written(text: str, values: list[object]) -> None:
    over = read_over(text)
    assert [over.value(place) for place in range(len(over.values))] == values


def test_law_a_quick_sweep_is_small(study: ts.Study) -> None:
    plan = plan_sweep(study, ["network.loss=0:0.2:101"], draws=100, quick=True)
    assert plan.shape == (3, 3)
    assert plan.over[0].coordinate().tolist() == [0.0, 0.1, 0.2]


def test_law_another_sweep_in_the_folder_is_refused(study: ts.Study, folder: Path) -> None:
    with pytest.raises(ts.InvalidInput, match="other keys, values or draws"):
        ts.sweep(study, folder, {"network.loss": [0.0]})
    with pytest.raises(ts.InvalidInput, match="another study"):
        ts.sweep(ts.Study.paper(), folder, OVER)


def test_law_a_sweep_that_finished_nothing_leaves_the_folder_to_another(tmp_path: Path) -> None:
    unjudged = ts.Study.read(written(tmp_path, NO_SPRING_OF_ITS_OWN))
    folder = tmp_path / "sweep"
    with pytest.raises(ts.InvalidInput, match="coupling\\.stiffness"):
        ts.sweep(unjudged, folder, {"delay": [0.0]}, trials=False)
    found = ts.sweep(unjudged, folder, {"stiffness": [30.0, 60.0], "delay": [0.0]}, trials=False)
    assert found.sizes["stiffness"] == 2


def test_law_the_stiffness_of_the_protocol_is_enough_for_a_sweep_of_trials(tmp_path: Path) -> None:
    found = ts.sweep(
        written(tmp_path, NO_SPRING_OF_ITS_OWN), tmp_path / "sweep", {"network.loss": [0.0, 0.1]}
    )
    assert found.condition_stiffness.values.tolist() == [[60.0], [60.0]]
    assert found.stable.values.tolist() == [[1.0], [1.0]]


def test_law_the_command_says_what_the_dataset_has(study: ts.Study, folder: Path, tmp_path: Path) -> None:
    file = written(tmp_path, study.to_toml())
    options = ("--over", "network.loss=0,0.1", "--over", "stiffness=30,150", "--out", folder)
    done = command("sweep", file, *options)
    assert done.exit_code == 0, done.output
    assert "4 points, 24 trials, complete" in done.output
    assert "The guards kept their law" in done.output
    found = json.loads(command("sweep", file, *options, "--json").stdout)
    whole = loaded(folder)
    assert found["points"] == 4
    assert found["all"]["stable_share"] == pytest.approx(float(whole.stable.mean()))
    row = found["keys"]["network.loss"][1]
    here = whole.sel({"network.loss": 0.1})
    assert row["value"] == 0.1
    assert row["tracking_error"] == pytest.approx(float(here.tracking_error.mean()))
    assert row["early_ends"] == {}
    assert row["guard_broken"] == 0


def test_law_the_command_refuses_in_words(tmp_path: Path) -> None:
    done = command("sweep", "--over", "network.loss", "--out", tmp_path)
    assert done.exit_code == 2
    assert "Traceback" not in done.output


def test_law_finished_points_of_another_trace_are_kept(tmp_path: Path, root: Path) -> None:
    rows = (root / "examples" / "round-trips.csv").read_text(encoding="utf-8")
    trace = tmp_path / "ping.csv"
    trace.write_text(rows, encoding="utf-8")
    network = 'network = {delay = 0.02, trace = {file = "ping.csv", round_trip = true}}\n'
    robots = "".join(f"robot{i} = {{mass = 1.0, damping = 5.0}}\n" for i in (1, 2))
    file = written(tmp_path, f"{robots}coupling.stiffness = 40\n{network}")
    over = {"coupling.stiffness": [20, 30]}
    ts.sweep(file, tmp_path / "out", over, trials=False, shard=(1, 2))
    trace.write_text(rows.replace("34.2", "54.2"), encoding="utf-8")
    assert trace.read_text(encoding="utf-8") != rows
    with pytest.raises(ts.InvalidInput, match="another version of a Python file or a recorded trace"):
        ts.sweep(file, tmp_path / "out", over, trials=False, shard=(1, 2))


@pytest.mark.parametrize(
    ("over", "key"),
    [
        ({"protocol.duration": [2.5, 3.0], "protocol.trials": [2, 3]}, "protocol.trials"),
        ({"protocol.seed": [1, 2], "protocol.delay": [[0.1], [0.1, 0.2]]}, "protocol.delay"),
    ],
)
def test_law_the_key_that_changes_the_size_of_a_protocol_is_named(
    tmp_path: Path, over: dict[str, list[object]], key: str
) -> None:
    with pytest.raises(ts.InvalidInput, match=f"rather than over {key}"):
        ts.sweep(guarded(), tmp_path, over)
