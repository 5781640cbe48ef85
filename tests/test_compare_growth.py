"""Which trials ran away."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from made_trials import experiment, figure_eight
from telespring._types import FloatArray
from telespring.analysis.trials import Trials
from telespring.comparison.growth import have_run_away, quarter_errors

DURATION, DISCARD = 24.0, 4.0


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
    runs_away = have_run_away(np.array(["completed"]), quarters, alone)
    assert runs_away.tolist() == [np.exp(15.0 * rate) > 2.0]


def test_law_a_steady_error_however_large_does_not_run_away() -> None:
    quarters = quarters_of(exponential(0.0, start=0.5))
    assert not have_run_away(np.array(["completed"]), quarters, np.full((1, 2, 2), 0.02)).any()


def test_law_a_target_that_becomes_harder_for_everybody_is_no_instability() -> None:
    quarters = quarters_of(exponential(0.1))
    alone = quarters_of(exponential(0.1, start=0.02))
    assert not have_run_away(np.array(["completed"]), quarters, alone).any()


def test_law_what_ended_as_diverged_ran_away_and_what_ended_otherwise_did_not() -> None:
    nothing = np.full((3, 2, 2), np.nan)
    status = np.array(["diverged", "out of reach", "completed"])
    nothing[2] = 0.03
    for alone in (np.full((1, 2, 2), 0.02), np.full((1, 2, 2), np.nan)):
        assert have_run_away(status, nothing, alone).tolist() == [True, False, False]


def test_law_one_person_is_enough() -> None:
    distance = exponential(0.0)
    distance[..., 1] = exponential(0.2)[..., 1]
    assert have_run_away(np.array(["completed"]), quarters_of(distance), np.full((1, 2, 2), 0.02)).all()
