"""Shares of a rehearsal, a comparison and a sweep: put together they are what one machine makes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

import telespring as ts
from held_trials import arm, begun_trials, held_agent, kill_the_held
from resuming import interrupted_after, started, wait_for, written
from short_rehearsal import study_text
from short_sweep import OVER, command, guarded
from telespring.rehearsal.shards import Shard, read_shard
from telespring.sweeps.merging import _plan_of, share_progress
from telespring.sweeps.plan import plan_sweep
from telespring.sweeps.work import identify_sweep

COMPARED = {"stiffness": [71.2], "delay": [0.084], "trials": 2, "duration": 3.0, "discard": 1.0}


def _rehearse(folder: Path, shard: Shard | None) -> Any:
    study = ts.Study.from_toml(study_text())
    return ts.rehearse(study, folder) if shard is None else ts.rehearse(study, folder, shard=shard)


def _sweep(folder: Path, shard: Shard | None) -> Any:
    draws: Any = {"draws": 2, "quick": True}
    study = guarded()
    return (
        ts.sweep(study, folder, OVER, **draws)
        if shard is None
        else ts.sweep(study, folder, OVER, shard=shard, **draws)
    )


def _compare(folder: Path, shard: Shard | None) -> Any:
    study = ts.Study.paper().replace(protocol=COMPARED)
    if shard is None:
        return ts.compare(study, folder, quick=True)
    return ts.compare(study, folder, quick=True, shard=shard)


WORK: list[Any] = [
    pytest.param(_rehearse, 3, "rehearsal.nc", id="rehearse"),
    pytest.param(_sweep, 2, "sweep.nc", id="sweep"),
    pytest.param(_compare, 2, "comparison.nc", id="compare"),
]


@pytest.mark.parametrize(("run", "count", "name"), WORK)
def test_law_shares_put_together_are_the_bytes_of_one_machine(
    run: Callable[[Path, Shard | None], Any], count: int, name: str, tmp_path: Path
) -> None:
    whole, shared = tmp_path / "whole", tmp_path / "shared"
    expected = run(whole, None)
    # the last one first, and its folder moved as from another machine
    for index in range(count, 0, -1):
        run(shared, Shard(index, count))
    away = tmp_path / "away"
    (shared / f"shard-1-of-{count}").rename(away)
    told: list[tuple[int, int]] = []
    found = ts.merge_shards([shared, away], shared, progress=lambda *done: told.append(done))
    assert len({total for _, total in told}) == 1
    assert told == sorted(told)
    assert told[-1][0] == told[-1][1]
    if isinstance(expected, ts.Comparison):
        assert isinstance(found, ts.Comparison)
        assert found.dataset.identical(expected.dataset)
        assert found.recommended == expected.recommended
    else:
        assert not isinstance(found, ts.Comparison)
        assert found.identical(expected)
    assert (shared / name).read_bytes() == (whole / name).read_bytes()
    # once more: it is complete
    assert ts.merge_shards([shared, away], shared) is not None


def test_law_what_a_merge_reads_of_a_sweep_is_what_ran() -> None:
    """Whole numbers stay whole: `protocol.seed` takes no others."""
    plan = plan_sweep(guarded(), {"protocol.seed": [1, 2], "network.loss": [0.0, 0.1]}, draws=2)
    assert _plan_of(identify_sweep(plan, None)) == plan


@pytest.mark.parametrize(("run", "count", "name"), WORK)
def test_law_a_missing_share_is_named(
    run: Callable[[Path, Shard | None], Any], count: int, name: str, tmp_path: Path
) -> None:
    run(tmp_path, Shard(1, count))
    with pytest.raises(ts.InvalidInput, match=f"shard = .*{count}/{count}.* are missing"):
        ts.merge_shards(tmp_path)
    assert not (tmp_path / name).exists()


def test_law_a_share_of_another_study_is_refused(tmp_path: Path) -> None:
    _rehearse(tmp_path, Shard(1, 2))
    other = ts.Study.from_toml(study_text().replace("seed = 3", "seed = 4"))
    ts.rehearse(other, tmp_path, shard=(2, 2))
    with pytest.raises(ts.InvalidInput, match="shares of one study"):
        ts.merge_shards(tmp_path)


def test_law_a_merge_that_came_too_early_leaves_nothing_behind(tmp_path: Path) -> None:
    """So shares that are run again over other values can be merged there."""
    for index, over in ((1, [0.0, 0.1]), (1, [0.0, 0.2]), (2, [0.0, 0.2])):
        ts.sweep(guarded(), tmp_path, {"network.loss": over}, trials=False, shard=(index, 2), fresh=True)
        if index == 1:
            with pytest.raises(ts.InvalidInput, match="are missing"):
                ts.merge_shards(tmp_path)
    found = ts.merge_shards(tmp_path)
    assert isinstance(found, xr.Dataset)
    assert found["network.loss"].values.tolist() == [0.0, 0.2]


@pytest.mark.parametrize(("run", "count", "name"), WORK)
def test_law_merging_over_another_result_says_what_helps(
    run: Callable[[Path, Shard | None], Any], count: int, name: str, tmp_path: Path
) -> None:
    run(tmp_path, Shard(1, count))
    (tmp_path / name).write_text("somebody's")
    with pytest.raises(ts.InvalidInput) as refused:
        ts.merge_shards(tmp_path)
    assert "--out" in refused.value.remedy
    assert "--fresh" not in refused.value.remedy


def test_law_a_share_goes_on_where_it_was_stopped(tmp_path: Path) -> None:
    study = ts.Study.from_toml(study_text())
    with pytest.raises(KeyboardInterrupt):
        ts.rehearse(study, tmp_path, interrupted_after(2), workers=1, shard="1/2")
    [there] = share_progress([tmp_path])
    assert (there.finished, there.facts.trials) == (2, 5)
    told: list[int] = []
    ts.rehearse(study, tmp_path, lambda done, _: told.append(done), shard="1/2")
    assert told == [2, 3, 4, 5]


@pytest.mark.skipif(sys.platform == "win32", reason="a share is killed by a signal")
def test_law_of_a_killed_share_only_the_running_trial_runs_again(tmp_path: Path) -> None:
    study = written(tmp_path, guarded(agent1=held_agent(tmp_path)).to_toml())
    asked = ("sweep", study, "--over", "network.loss=0,0.1", "--out", tmp_path / "out", "--shard", "1/2")
    arm(tmp_path)
    share = started(*asked, until=lambda _: any(tmp_path.glob("held-*")))
    # one of two points, and two of six trials
    wait_for(lambda: share_progress([tmp_path / "out"])[0].finished == 3)
    assert kill_the_held(tmp_path) == share.pid
    share.communicate()
    assert "3 of 7" in command("merge", tmp_path / "out", "--progress").output
    done = command(*asked)
    assert done.exit_code == 0, done.output
    assert len(begun_trials(tmp_path)) == 6 + 1


def test_law_the_progress_of_a_share_is_seen_without_its_files(tmp_path: Path) -> None:
    """As on the machine that collects the shares: neither agents nor targets are there."""
    there = tmp_path / "there"
    study = written(there, guarded(agent1=held_agent(there)).to_toml())
    ts.sweep(study, tmp_path / "out", {"network.loss": [0.0, 0.1]}, shard=(1, 2))
    there.rename(tmp_path / "elsewhere")
    [share] = share_progress([tmp_path / "out"])
    assert share.finished == share.facts.trials == 7


def test_law_shares_with_files_beside_the_study_are_merged_where_they_ran(tmp_path: Path) -> None:
    study = written(tmp_path, guarded(agent1=held_agent(tmp_path)).to_toml())
    over = {"network.loss": [0.0, 0.1]}
    for index in (1, 2):
        ts.sweep(study, tmp_path / "out", over, shard=(index, 2))
    merged = ts.merge_shards(tmp_path / "out")
    assert not isinstance(merged, ts.Comparison)
    assert merged.identical(ts.sweep(study, tmp_path / "alone", over))


def test_law_shares_are_the_whole_without_overlap() -> None:
    items = list(range(17))
    for count in (1, 2, 5, 17, 30):
        shares = [Shard(index + 1, count).select(items) for index in range(count)]
        assert sorted(item for share in shares for item in share) == items
        assert max(map(len, shares)) - min(map(len, shares)) <= 1


@pytest.mark.parametrize("value", ["0/2", "3/2", "1", "a/b", (0, 1), (2, 1), (1, 2, 3), "1/1000000"])
def test_law_a_share_that_is_none_is_refused(value: Any) -> None:
    with pytest.raises(ts.InvalidInput, match="number of this share"):
        read_shard(value)


def test_law_merge_looks_at_what_it_is_given(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(study_text(), encoding="utf-8")
    out = tmp_path / "out"
    for index in (1, 2):
        done = command("rehearse", file, "--out", out, "--shard", f"{index}/2")
        assert done.exit_code == 0, done.output
        assert f"telespring merge {out}" in done.output.replace("\n", "")
        if index == 1:
            said = command("merge", out, "--progress").output
            assert "5 of 5" in said
            assert "Not begun: 2/2" in said
            one, other = json.loads(command("merge", out, "--progress", "--json").stdout)
            assert one == {"shard": "1/2", "finished": 5, "all": 5}
            assert other == {"shard": "2/2", "finished": 0, "all": None}
    found = json.loads(command("merge", out, "--progress", "--json").stdout)
    assert [each["finished"] for each in found] == [5, 4]
    assert f"All are finished: telespring merge {out}" in command("merge", out, "--progress").output.replace(
        "\n", ""
    )
    done = command("merge", out)
    assert done.exit_code == 0, done.output
    assert "9 results put together" in done.output
    assert (out / "rehearsal.nc").exists()


@pytest.mark.parametrize("arguments", [("only.mcap",), ("a.mcap", "b.mcap")])
def test_law_merge_without_what_it_needs_is_refused(arguments: tuple[str, ...], tmp_path: Path) -> None:
    done = command("merge", *(tmp_path / each for each in arguments))
    assert done.exit_code == 2
    assert "Traceback" not in done.output


def test_law_merge_refuses_a_folder_without_shares(tmp_path: Path) -> None:
    done = command("merge", tmp_path)
    assert done.exit_code == 2
    assert "shard.json" in done.output


@pytest.mark.skipif(sys.platform == "win32", reason="the script is for bash")
def test_law_the_slurm_script_of_the_documentation_runs(root: Path, tmp_path: Path) -> None:
    """As written, but for fewer values, two shares and another folder."""
    text = (root / "docs" / "scale.md").read_text(encoding="utf-8")
    script = text.split("<!-- not run: needs SLURM -->\n```bash\n")[1].split("```")[0]
    assert "#SBATCH --array=1-" in script  # shares are counted from 1
    for written_there, here in (
        ("20:200:50", "20:200:2"),
        ("0:0.3:31", "0:0.3:2"),
        ("/scratch/sweep", "out"),
    ):
        assert written_there in script
        script = script.replace(written_there, here)
    written(tmp_path, guarded().to_toml())
    shim = written(tmp_path / "bin", "").with_name("telespring")
    shim.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m telespring "$@"\n', encoding="utf-8")
    shim.chmod(0o755)
    for index in ("1", "2"):
        slurm = {"SLURM_ARRAY_TASK_ID": index, "SLURM_ARRAY_TASK_COUNT": "2", "SLURM_CPUS_PER_TASK": "1"}
        environment = os.environ | slurm | {"PATH": f"{shim.parent}:{os.environ['PATH']}"}
        done = subprocess.run(
            ["bash", "-e"],
            input=script,
            text=True,
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr
    done_merging = command("merge", tmp_path / "out")
    assert done_merging.exit_code == 0, done_merging.output
    assert "4 points, 16 trials, complete" in done_merging.output
