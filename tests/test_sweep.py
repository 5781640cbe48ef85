"""`telespring sweep`: its numbers are those of single rehearsals and verdicts, and nothing disturbs them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import telespring as ts
from resuming import interrupted_after, left_in, written
from short_sweep import OVER, command, guarded, loaded
from telespring.analysis import measure
from telespring.sweeps.draws import drawn_robots
from telespring.sweeps.measures import trial_row, trial_variables
from telespring.sweeps.over import read_over
from telespring.sweeps.plan import plan_sweep


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


def test_law_draws_depend_on_their_number_only(study: ts.Study, tmp_path: Path) -> None:
    found = ts.sweep(study, tmp_path / "a", {"network.loss": [0.0, 0.1]}, draws=3, trials=False)
    more = ts.sweep(study, tmp_path / "b", draws=5, trials=False)
    assert (found.robot_mass.isel({"network.loss": 0}) == more.robot_mass.isel(draw=slice(3))).all()
    assert (found.robot_mass.isel({"network.loss": 0}) == found.robot_mass.isel({"network.loss": 1})).all()
    assert np.ptp(more.robot_mass.sel(robot=1, axis="x").values) > 0.0
    assert np.ptp(more.robot_mass.sel(robot=2, axis="x").values) == 0.0  # known exactly
    other = ts.sweep(study, tmp_path / "c", draws=5, seed=2, trials=False)
    assert not (other.robot_mass.sel(robot=1) == more.robot_mass.sel(robot=1)).any()


def test_ref_draws_have_the_moments_of_the_uncertainty(study: ts.Study) -> None:
    """Bounds of five standard errors; the correlation is that of a bivariate normal."""
    uncertain = study.replace(robot1={"mass_damping_correlation": [0.6, -0.3]})
    drawn = [drawn_robots(uncertain, 1, draw)["robot1"] for draw in range(4000)]
    mass, damping = (np.array([each[key] for each in drawn]) for key in ("mass", "damping"))
    for axis, (m, b, m_sd, b_sd, correlation) in enumerate(
        zip((0.8334, 1.0649), (7.7257, 10.1168), (0.01, 0.02), (0.2, 0.3), (0.6, -0.3), strict=True)
    ):
        assert mass[:, axis].mean() == pytest.approx(m, abs=5 * m_sd / 4000**0.5)
        assert damping[:, axis].mean() == pytest.approx(b, abs=5 * b_sd / 4000**0.5)
        assert mass[:, axis].std() == pytest.approx(m_sd, rel=5 / 8000**0.5)
        assert damping[:, axis].std() == pytest.approx(b_sd, rel=5 / 8000**0.5)
        found = np.corrcoef(mass[:, axis], damping[:, axis])[0, 1]
        assert found == pytest.approx(correlation, abs=5 / 4000**0.5)


def test_law_the_guard_keeps_its_law_and_a_bare_spring_would_not(whole: xr.Dataset) -> None:
    assert float(whole.guard_spare.min()) >= 0.0
    # the private measure itself: a bare spring that runs away, measured as if it were guarded
    spring = guarded().replace(protocol={"duration": 10.0}, session=None)
    experiment = spring.experiment
    assert experiment is not None
    laboratory = experiment.laboratory_on((None, None))
    recording = laboratory.run(150.0, 0.084, 1, 10.0, 100.0)
    assert recording.status == "completed"
    row = trial_row(recording, experiment, guarded())
    assert [each.name for each in trial_variables()].index("guard_spare") == 2
    assert row[2] < -1.0


def test_law_zarr_holds_the_same(study: ts.Study, whole: xr.Dataset, tmp_path: Path) -> None:
    pytest.importorskip("zarr", reason="zarr is not installed: sweeps as Zarr are not tested")
    found = ts.sweep(study, tmp_path, OVER, as_zarr=True)
    assert left_in(tmp_path)[0] == "sweep.zarr"
    assert found.load().identical(whole)
    assert ts.sweep(study, tmp_path, OVER, as_zarr=True).load().identical(whole)


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
    ],
)
def test_law_what_cannot_be_swept_is_refused(
    study: ts.Study, over: dict[str, list[float]] | list[str], said: str, tmp_path: Path
) -> None:
    with pytest.raises(ts.InvalidInput, match=said.replace("(", r"\(")):
        ts.sweep(study, tmp_path, over)


def test_law_draws_need_an_uncertainty(tmp_path: Path) -> None:
    with pytest.raises(ts.InvalidInput, match="mass_sd"):
        ts.sweep(ts.Study.paper(), tmp_path, draws=3)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("network.loss=0:0.3:4", [0.0, 0.1, 0.2, 0.3]),
        ("robot1.damping=log:1:100:3", [1.0, 10.0, 100.0]),
        ("session.strategy=spring, guard", ["spring", "guard"]),
        ("network.playout_buffer=true,false", [True, False]),
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


def test_law_the_command_says_what_the_dataset_has(study: ts.Study, folder: Path, tmp_path: Path) -> None:
    file = written(tmp_path, study.to_toml())
    options = ("--over", "network.loss=0,0.1", "--over", "stiffness=30,150", "--out", folder)
    done = command("sweep", file, *options)
    assert done.exit_code == 0, done.output
    assert "4 points, 24 trials, already complete" in done.output
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
