"""Robots that a sweep draws, and the law of the guard in its trials."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import telespring as ts
from resuming import written
from short_sweep import OVER, command, guarded
from telespring._core import Recording, trial_seed
from telespring._types import FloatArray
from telespring.rehearsal.encoding import REPORTS
from telespring.sweeps.draws import drawn_robots
from telespring.sweeps.measures import trial_row, trial_variables


@pytest.fixture(scope="module")
def study() -> ts.Study:
    return guarded()


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


def test_law_the_guard_keeps_its_law_and_a_bare_spring_would_not(study: ts.Study, tmp_path: Path) -> None:
    whole = ts.sweep(study, tmp_path, OVER)
    assert float(whole.guard_spare.min()) >= 0.0
    # the private measure itself: a bare spring that runs away, measured as if it were guarded
    spring = guarded().replace(protocol={"duration": 10.0}, session=None)
    experiment = spring.experiment
    assert experiment is not None
    laboratory = experiment.laboratory_on((None, None))
    recording = laboratory.run(150.0, 0.084, 1, 10.0, 100.0)
    assert recording.status == "completed"
    row = trial_row(recording, 1, 150.0, experiment, guarded())
    assert [each.name for each in trial_variables()].index("guard_spare") == 2
    assert row[2] < -1.0


def _stiff_and_light(record_rate: float) -> ts.Study:
    """Return a guarded pair that swings faster than 50 Hz; the overdraft is proven to be small."""
    light = {"mass": 0.1, "damping": 1.0, "mass_sd": None, "damping_sd": None}
    protocol = {"stiffness": [5000.0], "delay": [0.15], "duration": 6.0, "record_rate": record_rate}
    return guarded().replace(robot1=light, robot2=light, protocol=protocol)


def test_law_the_law_of_the_guard_is_judged_alike_however_few_samples_are_recorded(tmp_path: Path) -> None:
    found = ts.sweep(_stiff_and_light(100.0), tmp_path, {"protocol.record_rate": [1, 100, 1000]})
    spare = found.guard_spare.isel(condition=1).values
    assert (spare > 0.0).all()
    assert (spare == spare[0]).all()


def test_law_a_slow_guard_may_overdraw_its_account_as_far_as_is_proven(tmp_path: Path) -> None:
    """At 100 Hz a force is held long enough to give out some millijoules that no account had."""
    slow = guarded().replace(
        robot1={"mass": 1.86177, "damping": 0.708966, "mass_sd": None, "damping_sd": None},
        robot2={"mass": 0.65474, "damping": 3.239938},
        controller={"sample_period": 0.01},
        protocol={"stiffness": [648.2], "delay": [0.0, 0.1, 0.3], "trials": 3, "duration": 6.0},
    )
    assert slow.guard_overdraft(648.2).is_proven
    found = ts.sweep(slow, tmp_path, {"network.loss": [0.0]})
    assert float(found.guard_spare.min()) >= 0.0


def test_law_a_guard_whose_robots_run_away_is_judged_too() -> None:
    """The private measure: a bare spring that flings its robots apart, measured as if it were guarded."""
    spring = guarded().replace(protocol={"duration": 10.0}, session=None)
    experiment = spring.experiment
    assert experiment is not None
    recording = experiment.laboratory.run(500.0, 0.2, 1, 10.0, 1000.0)
    assert recording.status == "diverged"
    assert trial_row(recording, 10, 500.0, experiment, guarded())[2] < -100.0


def test_law_controllers_count_on_the_identified_robots_not_on_the_drawn(
    study: ts.Study, tmp_path: Path
) -> None:
    found = ts.sweep(study, tmp_path, draws=4, quick=False)
    known = study.dyad.robots[0].damping - 1.959963984540054 * np.array([0.2, 0.3])
    for draw in found.draw:
        here = found.sel(draw=draw)
        np.testing.assert_allclose(here.counted_damping.sel(robot=1), known, rtol=1e-12)
        # the protocol, too, is that of the identified robots
        np.testing.assert_array_equal(here.condition_stiffness, found.condition_stiffness[0])
    assert np.ptp(found.robot_damping.sel(robot=1, axis="x").values) > 0.0
    # the drawn robots are the ones that move
    errors = found.tracking_error.sel(condition="UM", trial=1, robot=1)
    assert len(set(errors.values.tolist())) == 4


def test_cross_a_drawn_robot_moves_as_one_that_is_known(study: ts.Study, tmp_path: Path) -> None:
    """With the bare spring the controllers count on nothing."""
    spring = study.replace(session=None)
    found = ts.sweep(spring, tmp_path, draws=2, trials=True).isel(draw=1)
    known = spring.replace(
        robot1={
            "mass": found.robot_mass.sel(robot=1).values.tolist(),
            "damping": found.robot_damping.sel(robot=1).values.tolist(),
        }
    )
    experiment = known.experiment
    assert experiment is not None
    stiffness, delay = experiment.conditions[2]
    seed = trial_seed(experiment.seed, 2, 0)
    recording = experiment.laboratory.run(stiffness, delay, seed, experiment.duration, experiment.record_rate)
    row = trial_row(recording, 1, stiffness, experiment, known)
    here = found.isel(condition=2, trial=0)
    place = 3 + len(REPORTS)
    np.testing.assert_array_equal(row[place : place + 2], here.tracking_error.values)


def test_law_the_guard_of_a_trial_counts_on_the_identified_robot(study: ts.Study, tmp_path: Path) -> None:
    stiff = study.replace(protocol={"stiffness": [150.0], "trials": 1}, robot1={"damping_sd": [2.0, 3.0]})
    found = ts.sweep(stiff, tmp_path, draws=2).isel(draw=1, condition=2, trial=0)
    drawn = stiff.replace(
        robot1={name: found[f"robot_{name}"].sel(robot=1).values.tolist() for name in ("mass", "damping")}
    )
    seed = trial_seed(1, 2, 0)
    given = []
    for counted in (stiff, drawn):
        experiment = counted.experiment
        assert experiment is not None
        laboratory = experiment.laboratory.with_robots(drawn.dyad)
        given.append(laboratory.run(150.0, 0.084, seed, 3.0, experiment.record_rate).given_out)
    assert found.given_out.values.tolist() == given[0].tolist()
    assert given[0].tolist() != given[1].tolist()


def test_law_a_robot_with_less_damping_than_the_guard_counts_on_breaks_the_law(study: ts.Study) -> None:
    """So the law tests something: 10 N·s/m are counted on, and 5 N·s/m are there."""
    axes = ["x", "y"]
    counted, true = (ts.Robot([0.8, 1.0], [damping] * 2, axes=axes) for damping in (10.0, 5.0))
    parts = {"mass": [0.8, 1.0], "damping": [10.0, 10.0], "mass_sd": None, "damping_sd": None}
    known = study.replace(robot1=parts, robot2=parts, protocol={"duration": 4.0})
    experiment = known.experiment
    assert experiment is not None
    spare = []
    for robot in (counted, true):
        dyad = ts.Dyad(robot, robot)
        laboratory = pickle.loads(pickle.dumps(experiment.laboratory.with_robots(dyad)))
        recording = laboratory.run(150.0, 0.084, 1, 4.0, 100.0)
        drawn = known.replace(**{name: {"damping": [robot.damping[0]] * 2} for name in ("robot1", "robot2")})
        spare.append(trial_row(recording, 1, 150.0, experiment, drawn)[2])
    assert spare[0] >= 0.0
    assert spare[1] < -1.0


@pytest.mark.parametrize(
    ("less", "status", "said"),
    [(False, 1, "broke their law in 2 trials"), (True, 0, "In 2 trials a drawn robot has less")],
)
def test_law_a_broken_law_of_the_guard_is_the_commands_status(
    study: ts.Study,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    less: bool,
    status: int,
    said: str,
) -> None:
    """The private measure gives out too much in two trials; no guard does."""
    honest = trial_row

    def lying(
        recording: Recording, stride: int, k: float | None, experiment: ts.Experiment, drawn: ts.Study
    ) -> FloatArray:
        row = honest(recording, stride, k, experiment, drawn)
        row[2] = -0.5 if np.isfinite(row[2]) and recording.coupling_energy != 0.0 else row[2]
        return row

    monkeypatch.setattr("telespring.sweeps.work.trial_row", lying)
    file = written(tmp_path, study.replace(protocol={"delay": [0.084]}).to_toml())
    options = ["--draws", "1"] if less else ["--over", "network.loss=0"]
    if less:
        monkeypatch.setattr(
            "telespring.sweeps.plan.drawn_robots", lambda *_: {"robot1": {"damping": [5.0, 5.0]}}
        )
    done = command("sweep", file, *options, "--out", tmp_path / "out")
    assert done.exit_code == status, done.output
    assert said in " ".join(done.output.split())


def test_law_draws_need_an_uncertainty(tmp_path: Path) -> None:
    with pytest.raises(ts.InvalidInput, match="mass_sd"):
        ts.sweep(ts.Study.paper(), tmp_path, draws=3)


def test_law_a_draw_may_be_lighter_than_robots_usually_are(tmp_path: Path) -> None:
    light = guarded().replace(robot1={"mass": 0.02, "damping": 1.0, "mass_sd": 0.006})
    found = ts.sweep(light, tmp_path, draws=50, trials=False)
    assert 1e-4 < float(found.robot_mass.min()) < 0.01


def test_law_an_uncertainty_may_be_swept_from_none_on(tmp_path: Path) -> None:
    known = guarded().replace(robot1={"mass_sd": None, "damping_sd": None})
    found = ts.sweep(known, tmp_path, {"robot1.mass_sd": [0.0, 0.05]}, draws=3, trials=False)
    spread = np.ptp(found.robot_mass.sel(robot=1, axis="x").values, axis=-1)
    assert spread[0] == 0.0 < spread[1]
