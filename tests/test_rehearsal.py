"""A rehearsal: one dataset, the same however it came about."""

from __future__ import annotations

import json
import re
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

import telespring as ts
from resuming import left_in, written
from short_rehearsal import ARM, command, loaded, study_text
from telespring import _core
from telespring.rehearsal import run_protocol
from telespring.rehearsal.encoding import SIGNALS
from telespring.rehearsal.schedule import schedule_trials
from telespring.study.conditions import condition_labels


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


def test_law_the_ages_over_time_are_those_of_the_report(tmp_path: Path) -> None:
    """Recorded at every tick: across lost samples, too, the age is that of the oldest sample in use."""
    study = ts.Study.from_toml(study_text(trials=2).replace("100.0", "1000.0"))
    lossy = study.replace(
        network={"loss": 0.3},
        protocol={"unconnected": False},
        session={"playout": {"kind": "fixed", "delay": 0.06}},
    )
    found = ts.rehearse(lossy, tmp_path).sel(condition="CM-36-50")
    assert found.age.max("time").values == pytest.approx(found.age_high.values, abs=2e-9)
    # 10 ms after a sample comes it is played, together with the one before it, whichever that is.
    assert (found.age_high > 0.063).all()
    assert found.age_mean.values == pytest.approx(0.06, abs=1e-6)
    assert (found.age.mean("time") > 0.0602).all()


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


def test_law_the_command_says_where_the_dataset_is_and_then_that_it_is_complete(tmp_path: Path) -> None:
    study, out = written(tmp_path, study_text()), tmp_path / "out"
    first = command(study, "--out", out, "--workers", "1")
    assert first.exit_code == 0, first.output
    assert "3 conditions × 3 trials of 2 s; 9 run in" in first.stdout
    assert str(out / "rehearsal.nc") in first.stdout.replace("\n", "")
    again = command(study, "--out", out)
    assert again.exit_code == 0
    assert "already complete" in again.stdout


def test_law_the_target_is_whole_where_every_trial_ended_early(tmp_path: Path) -> None:
    text = study_text().replace("{stiffness = 35.6, delay = 0.05}, ", "")
    text = text.replace("trials = 3", "trials = 1\nunconnected = false")
    found = ts.rehearse(ts.Study.from_toml(text), tmp_path / "out")
    assert (found.status == 1).all()
    assert np.isfinite(found.target).all()
    truth = _core.Laboratory.paper().target(2.0, 100.0)
    np.testing.assert_allclose(found.target, truth, rtol=0, atol=2.0**-31)


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
