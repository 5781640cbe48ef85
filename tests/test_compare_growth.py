"""Which trials ran away."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import telespring as ts
from made_trials import experiment, figure_eight
from telespring._types import FloatArray
from telespring.analysis.trials import Trials
from telespring.comparison.growth import PAID, have_run_away, paid_shares, quarter_errors

DURATION, DISCARD = 24.0, 4.0
#: The coupling paid for the motion of one trial.
PAYS = np.array([1.0])


def trials_with(distance: FloatArray) -> xr.Dataset:
    """Make a condition of trials whose robots keep distances (trial, time, robot) from the target, m."""
    time = np.arange(distance.shape[1], dtype=np.float64) * 0.01
    turning = np.stack([np.cos(7.0 * time), np.sin(7.0 * time)], axis=-1)
    away = distance[..., None] * turning[:, None, :]
    return experiment((figure_eight(time)[:, None, :] + away)[None], [(71.2, 0.1)], discard=DISCARD)


def quarters_of(distance: FloatArray) -> FloatArray:
    quarters: FloatArray = quarter_errors(Trials.from_dataset(trials_with(distance)))[0]
    return quarters


def exponential(rate: float, start: float = 0.03) -> FloatArray:
    time = np.arange(0.0, DURATION + 0.005, 0.01)
    distance: FloatArray = np.exp(rate * (time - DISCARD)) * start
    return np.stack([distance[None], distance[None]], axis=-1)


@pytest.mark.parametrize("rate", [-0.1, 0.0, 0.03, 0.06, 0.3])
def test_ref_the_error_of_an_exponential_grows_by_the_time_between_the_quarters(rate: float) -> None:
    quarters = quarters_of(exponential(rate))
    # Between corresponding instants of both quarters lie 15 s and a sample, as 2001 is no fourfold.
    assert quarters[..., 1] / quarters[..., 0] == pytest.approx(np.exp(15.01 * rate), rel=1e-6)
    alone = np.full((1, 2, 2), 0.02)
    runs_away = have_run_away(np.array(["completed"]), quarters, alone, PAYS)
    assert runs_away.tolist() == [np.exp(15.0 * rate) > 2.0]


def test_law_a_steady_error_however_large_does_not_run_away() -> None:
    quarters = quarters_of(exponential(0.0, start=0.5))
    assert not have_run_away(np.array(["completed"]), quarters, np.full((1, 2, 2), 0.02), PAYS).any()


def test_law_a_target_that_becomes_harder_for_everybody_is_no_instability() -> None:
    quarters = quarters_of(exponential(0.1))
    alone = quarters_of(exponential(0.1, start=0.02))
    assert not have_run_away(np.array(["completed"]), quarters, alone, PAYS).any()


def test_law_what_ended_as_diverged_ran_away_and_what_ended_otherwise_did_not() -> None:
    nothing = np.full((3, 2, 2), np.nan)
    status = np.array(["diverged", "out of reach", "completed"])
    nothing[2] = 0.03
    for alone in (np.full((1, 2, 2), 0.02), np.full((1, 2, 2), np.nan)):
        assert have_run_away(status, nothing, alone, np.full(3, np.nan)).tolist() == [True, False, False]


def test_law_one_person_is_enough() -> None:
    distance = exponential(0.0)
    distance[..., 1] = exponential(0.2)[..., 1]
    assert have_run_away(np.array(["completed"]), quarters_of(distance), np.full((1, 2, 2), 0.02), PAYS).all()


@pytest.mark.parametrize(
    ("paid", "ran_away"), [(1.2, True), (PAID, True), (0.6, False), (-0.5, False), (np.nan, False)]
)
def test_law_a_growing_error_that_the_people_paid_for_is_no_instability(paid: float, ran_away: bool) -> None:
    """As where the network fails in the last quarter under a passive strategy."""
    grown = quarters_of(exponential(0.2))
    alone = np.full((1, 2, 2), 0.02)
    found = have_run_away(np.array(["completed"]), grown, alone, np.array([paid]))
    assert found.tolist() == [ran_away]


def test_ref_the_share_that_a_force_along_the_velocity_pays_is_known() -> None:
    """A force of c v pays c v²/(b v² + f |v|); before the end of the first quarter it does not count."""
    time = np.arange(0.0, DURATION + 0.005, 0.01)
    data = trials_with(np.full((1, len(time), 2), 0.03))
    speed = 0.4 * np.sign(np.sin(3.0 * time) + 2.0)
    velocity = np.zeros(data.position.shape)
    velocity[...] = speed[None, None, :, None, None]
    first = time < DISCARD + 0.25 * (DURATION - DISCARD) - 0.02
    force = 5.0 * velocity * np.where(first, -7.0, 1.0)[None, None, :, None, None]
    data = data.assign(velocity=(data.position.dims, velocity), coupling_force=(data.position.dims, force))
    found = paid_shares(Trials.from_dataset(data), np.full((2, 2), 8.0), np.full((2, 2), 0.8))
    assert found == pytest.approx(np.array([[5.0 / (8.0 + 0.8 / 0.4)]]), rel=2e-2)


def measured(study: ts.Study | Path, folder: Path) -> tuple[Any, Any]:
    """Rehearse a study; return which of its connected trials ran away, and the errors of which grew."""
    trials = Trials.from_dataset(ts.rehearse(study, folder))
    quarters = quarter_errors(trials)
    damping = np.array([robot.damping for robot in ts.Study.paper().dyad.robots])
    paid = paid_shares(trials, damping, np.zeros((2, 2)))
    assert trials.labels[0] == "UM"
    found = [
        have_run_away(trials.status, quarters, quarters[0], share)[1:]
        for share in (paid, np.full(paid.shape, np.inf))
    ]
    assert (trials.status == "completed").all()
    return found[0], found[1]


def test_law_an_outage_at_the_end_under_the_guard_is_no_instability(tmp_path: Path) -> None:
    """The queue of the network fills for 7 s, and the prediction goes far astray."""
    instants = np.arange(0.0, 40.0, 0.02)
    rows = [f"{t:.3f},{14.0 + 900.0 * max(0.0, t - 33.0):.3f}" for t in instants]
    (tmp_path / "late.csv").write_text("\n".join(["time_s,delay_ms", *rows]))
    study = ts.Study.paper().replace(
        protocol={
            "trials": 4,
            "stiffness": [142.5],
            "delay": [0.03],
            "duration": 12.0,
            "discard": 2.0,
            "seed": 3,
        },
        session={"strategy": "guard", "predictor": "linear"},
        network={"trace": "late.csv"},
    )
    (tmp_path / "study.toml").write_text(study.to_toml())
    ran_away, grown = measured(tmp_path / "study.toml", tmp_path / "out")
    assert grown.sum() >= 2, "no error grew: this shows nothing"
    assert not ran_away.any()


def test_law_the_slow_growth_of_an_unstable_bare_spring_is_found(tmp_path: Path) -> None:
    study = ts.Study.paper().replace(protocol={"trials": 2, "stiffness": [142.5], "delay": [0.0836]})
    ran_away, grown = measured(study, tmp_path)
    assert grown.all()
    assert ran_away.all()
